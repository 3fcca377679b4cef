//! The output, which never jumps.

use super::clock::seconds;
use super::settings::Settings;
use crate::base::{BaseMotion, Gravity};
use nalgebra::{ComplexField, Vector3};

/// Longest time for which a step may move the output, ns: after a stall it does not make up for what it missed.
const LONGEST_STEP_NS: i64 = 10_000_000;

/// The base's motion on its way to where it should be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Output {
    base: BaseMotion,
    arrived: bool,
}

impl Output {
    /// At rest.
    pub(super) fn new(gravity: Vector3<f64>) -> Self {
        Self { base: BaseMotion::at_rest(Gravity(gravity)), arrived: true }
    }

    /// Moves towards `goal` for as long as `elapsed_ns`, no faster than the settings allow.
    #[inline]
    pub(super) fn follow(&mut self, goal: &BaseMotion, elapsed_ns: i64, settings: &Settings) {
        if is_same(&self.base, goal) {
            self.arrived = true;
        } else {
            self.travel(goal, elapsed_ns, settings);
        }
    }

    #[inline(never)]
    fn travel(&mut self, goal: &BaseMotion, elapsed_ns: i64, settings: &Settings) {
        let (dt, base) = (seconds(elapsed_ns.min(LONGEST_STEP_NS)), &mut self.base);
        base.specific_force.0 = toward(base.specific_force.0, goal.specific_force.0, settings.gravity_rate * dt);
        self.arrived |= base.specific_force == goal.specific_force;
        let (w, dw) = (&mut base.angular_velocity, &mut base.angular_acceleration);
        *w = toward(*w, goal.angular_velocity, settings.angular_acceleration * dt);
        *dw = toward(*dw, goal.angular_acceleration, settings.angular_jerk * dt);
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
        self.base.specific_force.into()
    }

    /// The same with the rates.
    pub(super) fn base(&self) -> BaseMotion {
        self.base
    }
}

/// The same numbers; all are looked at, as most of the time they are.
fn is_same(a: &BaseMotion, b: &BaseMotion) -> bool {
    let mut same = true;
    for k in 0..3 {
        same &= a.specific_force.0[k] == b.specific_force.0[k];
        same &= a.angular_velocity[k] == b.angular_velocity[k];
        same &= a.angular_acceleration[k] == b.angular_acceleration[k];
    }
    same
}

/// On the straight line from here to there, at most `step` further.
fn toward(here: Vector3<f64>, there: Vector3<f64>, step: f64) -> Vector3<f64> {
    let way = there - here;
    let square = way.norm_squared();
    if square <= step * step { there } else { here + way * (step / ComplexField::sqrt(square)) }
}
