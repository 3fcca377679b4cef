//! How the base turns now, for those who move against it.

use super::chain::Accelerometer;
use super::clock::seconds;
use super::motion::bounded;
use super::state::State;
use core::f64::consts::{PI, SQRT_2};
use nalgebra::Vector3;

impl Accelerometer {
    /// The base's angular velocity so many seconds after the last step, rad/s, base axes; and whether a gyroscope that is
    /// trusted says so.
    ///
    /// What the output shows is older by the sample's age, and by what the filter delays everything well below its cut-off,
    /// √2/(2π f_c): over that time it is carried on by the angular acceleration. Without trust it goes to zero as the output
    /// does.
    #[must_use]
    pub fn turning(&self, ahead_s: f64) -> (Vector3<f64>, bool) {
        let base = self.output.base();
        let age = self.age_ns.unwrap_or_default().clamp(0, self.settings.max_age_ns);
        let delay = self.settings.cutoff_hz.map_or(0.0, |cutoff| SQRT_2 / (2.0 * PI * cutoff));
        // NaN is nothing ahead, as below zero is.
        let late = seconds(age) + delay + ahead_s.max(0.0).min(seconds(self.settings.max_age_ns));
        let w = base.angular_velocity + base.angular_acceleration * late;
        (bounded(w, 2.0 * self.settings.gyro_range), self.state == State::Live && self.run.turns())
    }
}
