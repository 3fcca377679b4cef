//! What the arm feels of its base: the last good motion, and the one that the arm was armed on.

use super::law::{Kernels, Law};
use super::status::{Event, Watch};
use crate::base::{BaseMotion, Gravity};
use crate::robot::{Joints, Robot};

/// No base accelerates (m/s²) or turns (rad/s, rad/s²) faster; what does, is no motion.
const LARGEST: f64 = 1e6;

/// The base's motion as far as it is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Feel {
    now: BaseMotion,
    at_arming: Gravity,
}

impl Feel {
    /// A level base at rest.
    pub(super) fn new() -> Self {
        Self { now: BaseMotion::at_rest(Gravity::LEVEL), at_arming: Gravity::LEVEL }
    }

    /// Takes the base's motion of this cycle if it is one, else stays at the last one.
    pub(super) fn follow(&mut self, base: &BaseMotion, watch: &mut Watch) {
        let vectors = [&base.specific_force.0, &base.angular_velocity, &base.angular_acceleration];
        if vectors.into_iter().flatten().all(|x| x.abs() <= LARGEST) {
            self.now = *base;
        } else {
            watch.note(true, Event::BaseMotion);
        }
    }

    /// The arm is armed: static gravity is that of now.
    pub(super) fn arm(&mut self) {
        self.at_arming = self.now.specific_force.into();
    }

    /// The torque at the joints that holds the arm at `q`, as the law sees the base.
    pub(super) fn hold(&self, law: Law, kernels: &Kernels, robot: &Robot, q: &Joints) -> Joints {
        let still = &Joints::default();
        match law {
            // τ_g(q; f, ω, dω) = RNEA(q, 0, 0; f, ω, dω)
            Law::PdBaseMotion => (kernels.inverse_dynamics)(robot, q, still, still, &self.now),
            Law::PdStaticGravity => (kernels.gravity_torque)(robot, q, &self.at_arming),
            _ => (kernels.gravity_torque)(robot, q, &self.now.specific_force.into()),
        }
    }
}
