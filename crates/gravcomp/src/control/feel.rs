//! What the arm feels of its base: the last good motion, and the one that the arm was armed on.

use super::law::Law;
use super::places::all;
use super::status::{Event, Watch};
use crate::base::{BaseMotion, Gravity};
use crate::robot::Joints;

/// No base accelerates (m/s²) or turns (rad/s, rad/s²) faster; what does, is no motion.
const LARGEST: f64 = 1e6;

/// What holds an arm still at a position, in one build of the kernels.
pub(super) trait Weight {
    /// Against gravity.
    fn at_rest(&self, q: &Joints, g: &Gravity) -> Joints;
    /// On a base that moves: τ_g(q; f, ω, dω) = RNEA(q, 0, 0; f, ω, dω).
    fn on_base(&self, q: &Joints, base: &BaseMotion) -> Joints;
    /// Against its disturbance elements: no effort where it has none.
    fn beside(&self, q: &Joints, qd: &Joints) -> Joints;
}

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
    #[inline(always)]
    pub(super) fn follow(&mut self, base: &BaseMotion, watch: &mut Watch) {
        let (f, w, dw) = (&base.specific_force.0, &base.angular_velocity, &base.angular_acceleration);
        if all::<3>(|k| (f[k].abs() <= LARGEST) & (w[k].abs() <= LARGEST) & (dw[k].abs() <= LARGEST)) {
            self.now = *base;
        } else {
            watch.note(true, Event::BaseMotion);
        }
    }

    /// The arm is armed: static gravity is that of now.
    pub(super) fn arm(&mut self) {
        self.at_arming = self.now.specific_force.into();
    }

    /// Size of the gravity in that torque, m/s²; how the base turns is not counted.
    pub(super) fn field(&self, law: Law) -> f64 {
        let g = if law == Law::PdStaticGravity { &self.at_arming.0 } else { &self.now.specific_force.0 };
        g.norm()
    }

    /// The torque at the joints that holds the arm at `q`, as the law sees the base.
    #[inline(always)]
    pub(super) fn hold(&self, law: Law, weight: &impl Weight, q: &Joints) -> Joints {
        match law {
            Law::PdBaseMotion => weight.on_base(q, &self.now),
            Law::PdStaticGravity => weight.at_rest(q, &self.at_arming),
            _ => weight.at_rest(q, &self.now.specific_force.into()),
        }
    }
}
