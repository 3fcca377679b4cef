//! The output, which never jumps.

use super::clock::seconds;
use super::settings::Settings;
use crate::base::{BaseMotion, Gravity};
use nalgebra::{ComplexField, Vector3};

/// Longest time for which a step may move the output, ns: after a stall it does not make up for what it missed.
const LONGEST_STEP_NS: i64 = 10_000_000;

/// Gravity, angular velocity and angular acceleration on their way to where they should be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Output {
    gravity: Vector3<f64>,
    rate: Vector3<f64>,
    acceleration: Vector3<f64>,
    arrived: bool,
}

impl Output {
    /// At rest.
    pub(super) fn new(gravity: Vector3<f64>) -> Self {
        Self { gravity, rate: Vector3::zeros(), acceleration: Vector3::zeros(), arrived: true }
    }

    /// Moves towards `goal` for as long as `elapsed_ns`, no faster than the settings allow.
    pub(super) fn follow(&mut self, goal: &BaseMotion, elapsed_ns: i64, settings: &Settings) {
        let dt = seconds(elapsed_ns.min(LONGEST_STEP_NS));
        let gravity = -goal.specific_force.0;
        self.gravity = toward(self.gravity, gravity, settings.gravity_rate * dt);
        self.arrived |= self.gravity == gravity;
        self.rate = toward(self.rate, goal.angular_velocity, settings.angular_acceleration * dt);
        self.acceleration = toward(self.acceleration, goal.angular_acceleration, settings.angular_jerk * dt);
    }

    /// There is a new goal.
    pub(super) fn set_out(&mut self) {
        self.arrived = false;
    }

    /// Gravity has been where it should be since the output set out.
    pub(super) const fn has_arrived(&self) -> bool {
        self.arrived
    }

    /// Where it is now.
    pub(super) fn gravity(&self) -> Gravity {
        Gravity(self.gravity)
    }

    /// The same with the rates.
    pub(super) fn base(&self) -> BaseMotion {
        BaseMotion {
            specific_force: self.gravity().into(),
            angular_velocity: self.rate,
            angular_acceleration: self.acceleration,
        }
    }
}

/// On the straight line from here to there, at most `step` further.
fn toward(here: Vector3<f64>, there: Vector3<f64>, step: f64) -> Vector3<f64> {
    let way = there - here;
    let square = way.norm_squared();
    if square <= step * step { there } else { here + way * (step / ComplexField::sqrt(square)) }
}
