//! How a sensor comes to be trusted, at the start and again.

use super::chain::Accelerometer;
use super::doubt::Doubt;
use super::fault::{Fault, Faults};
use super::state::{Event, State};
use super::tilt::is_within;
use super::unit::UnitWatch;
use crate::constants::STANDARD_GRAVITY;
use nalgebra::Vector3;

/// Samples in a row after which the direction of up is judged: enough against noise, few enough to alarm early.
const POSE_COUNT: u32 = 5;

/// Runs of the usual length for which a mean of the wrong size is waited on: a base that swings has it for a while.
const PATIENCE: u32 = 5;

/// Samples in a row that end a mere silence, if they agree with the last value.
const RETURN_COUNT: u32 = 3;

/// Cosine below which up is down: 120°.
const OPPOSITE: f64 = -0.5;

impl Accelerometer {
    /// The run is long enough and plausible; then the sensor is trusted.
    pub(super) fn qualifies(&mut self) -> bool {
        if self.state == State::Fault || !(self.returns() || self.is_plausible()) {
            return false;
        }
        if self.tilt_is_old() {
            let memory = f64::from(self.run.count()) * self.settings.period();
            self.tilt.seed(self.mean(), memory);
        }
        self.tilt_is_void = false;
        self.turning.trust();
        self.output.set_out();
        self.doubt = Doubt::default();
        self.unit = UnitWatch::default();
        self.status.alarms = Faults::NONE;
        self.happens(Event::Qualified);
        true
    }

    /// After a short silence the level is what it was.
    fn returns(&self) -> bool {
        let near = |anchor: Vector3<f64>| (self.run.mean() - anchor).norm() <= self.settings.jump(0.0);
        self.run.count() >= RETURN_COUNT.min(self.settings.start_count)
            && self.status.alarms.without(Faults::SILENCE).is_empty()
            && self.silent_ns <= self.settings.fault_after_ns
            && self.anchor.is_some_and(near)
    }

    /// Up is where it can be, gravity has its size, and neither contradicts the slow tilt estimate.
    fn is_plausible(&mut self) -> bool {
        let (mean, count) = (self.mean(), self.run.count());
        if count < POSE_COUNT.min(self.settings.start_count) {
            return false;
        }
        if !is_within(&mean, &self.up, self.pose_cosine) {
            let opposite = !is_within(&mean, &self.up, OPPOSITE);
            return self.refuse(if opposite { Fault::Sign } else { Fault::Axes });
        }
        if count < self.settings.start_count {
            return false;
        }
        if (mean.norm() / STANDARD_GRAVITY - 1.0).abs() > self.settings.norm_tolerance {
            count >= PATIENCE.saturating_mul(self.settings.start_count) && self.refuse(Fault::Units)
        } else if !self.tilt_is_old() && !is_within(&mean, &self.tilt.up(), self.tilt_cosine) {
            self.refuse(Fault::Tilt)
        } else {
            true
        }
    }

    /// There is no slow tilt estimate, it is what was found wrong, somebody said that the base stands otherwise, or nothing was
    /// heard for so long that it may: silence alone says nothing against the sensor. After any other alarm it has to agree.
    fn tilt_is_old(&self) -> bool {
        let alarms = self.status.alarms;
        let was_silent = alarms.without(Faults::SILENCE).is_empty() && self.silent_ns > self.settings.fault_after_ns;
        self.tilt_is_void || !self.tilt.is_known() || alarms.has(Fault::Drift) || was_silent
    }

    /// Not this run; perhaps the next one.
    pub(super) fn refuse(&mut self, fault: Fault) -> bool {
        self.alarm(Faults::only(fault));
        self.run.restart();
        false
    }

    /// Mean of the run in base axes, m/s².
    fn mean(&self) -> Vector3<f64> {
        self.settings.mounting.pose().rotation() * self.run.mean()
    }
}
