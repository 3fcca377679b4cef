//! What the base does, from what the sensor feels: filter, mounting, lever arm.

use super::filter::{Butterworth, Swing};
use super::gate::Felt;
use super::settings::Settings;
use crate::base::{BaseMotion, ImuSample, SpecificForce};
use nalgebra::Vector3;

/// Cut-off of the gyroscope's derivative where none is declared, as a share of the sample rate.
const DERIVATIVE: f64 = 0.2;

/// Shortest time between two samples that the filter sees, s; keeps differences over it finite.
const SHORTEST: f64 = 1e-6;

/// Filters specific force and angular velocity alike, in the sensor's axes, so that they stay in step.
///
/// The filter is linear and the mounting is constant: filtering before the rotation is filtering after it. The angular
/// acceleration is the filter's own slope.
#[derive(Clone, Copy, Debug)]
pub(super) struct MotionFilter {
    cutoff_hz: f64,
    force: Butterworth,
    rate: Butterworth,
    /// Time since it began anew, s.
    settling: f64,
}

impl MotionFilter {
    pub(super) fn new(settings: &Settings) -> Self {
        let cutoff_hz = settings.cutoff_hz.unwrap_or(DERIVATIVE * settings.sample_rate_hz);
        Self { cutoff_hz, force: Butterworth::default(), rate: Butterworth::default(), settling: 0.0 }
    }

    /// The filter after a sample that comes `dt` seconds after the one before, or that begins anew. Where the one before had a
    /// gyroscope, so has one that is taken.
    pub(super) fn after(&self, felt: &Felt, dt: Option<f64>) -> Self {
        let (cutoff_hz, rate) = (self.cutoff_hz, felt.rate.unwrap_or_default());
        let Some(dt) = dt else {
            let (force, rate) = (Butterworth::resting(felt.force), Butterworth::resting(rate));
            return Self { cutoff_hz, force, rate, settling: 0.0 };
        };
        let swing = Swing::new(cutoff_hz, dt.max(SHORTEST));
        let (force, rate) = (self.force.after(felt.force, &swing), self.rate.after(rate, &swing));
        Self { cutoff_hz, force, rate, settling: self.settling + dt }
    }

    /// What it began with has swung out to a fiftieth: e^(−√2 π).
    pub(super) fn has_settled(&self) -> bool {
        self.settling * self.cutoff_hz >= 1.0
    }

    /// Motion of the base, by [`BaseMotion::from_imu`]: f₀ = R f − dω × r − ω × (ω × r), each within its bound.
    pub(super) fn base(&self, settings: &Settings) -> BaseMotion {
        let base = BaseMotion::from_imu(&self.felt(settings), &settings.mounting);
        BaseMotion { specific_force: SpecificForce(bounded(base.specific_force.0, settings.norm.1)), ..base }
    }

    /// What the lever arm takes off, dω × r + ω × (ω × r), m/s².
    pub(super) fn lever(&self, settings: &Settings) -> Vector3<f64> {
        let turning = ImuSample { specific_force: Vector3::zeros(), ..self.felt(settings) };
        -BaseMotion::from_imu(&turning, &settings.mounting).specific_force.0
    }

    /// The filtered sample, in the sensor's axes.
    fn felt(&self, settings: &Settings) -> ImuSample {
        let (force, rate) = match settings.cutoff_hz {
            Some(_) => (self.force.value(), self.rate.value()),
            None => (self.force.input(), self.rate.input()),
        };
        ImuSample {
            specific_force: force,
            angular_velocity: bounded(rate, 2.0 * settings.gyro_range),
            angular_acceleration: bounded(self.rate.slope(), settings.angular_acceleration),
        }
    }
}

/// The vector, or as much of it as is `limit` long.
pub(super) fn bounded(v: Vector3<f64>, limit: f64) -> Vector3<f64> {
    let length = v.norm();
    if length <= limit { v } else { v * (limit / length) }
}
