//! Which terms the torque has, and what computes them.

use crate::base::{BaseMotion, Gravity};
use crate::entry::portable;
use crate::robot::{Joints, Robot};

/// τ = Kp (q_d − q) + Kd (q̇_d − q̇) + τ_g(q; base): which of the terms, and which base.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Law {
    /// No gravity term.
    Pd,
    /// Gravity as it was when the arm was armed, whatever the base does afterwards.
    PdStaticGravity,
    /// The gravity of now, eqs (1)-(3) of Lewis & Hannaford.
    PdDynamicGravity,
    /// The base's full motion: f, ω and dω through the inverse dynamics of the arm at rest.
    PdBaseMotion,
    /// The gravity of now and nothing else: the arm stays where it is put.
    Passive,
}

impl Law {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Pd, Self::PdStaticGravity, Self::PdDynamicGravity, Self::PdBaseMotion, Self::Passive];

    /// Its name in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pd => "pd",
            Self::PdStaticGravity => "pd+sg",
            Self::PdDynamicGravity => "pd+dg",
            Self::PdBaseMotion => "pd+bm",
            Self::Passive => "passive",
        }
    }

    /// It has the terms with Kp and Kd.
    #[must_use]
    pub const fn has_pd(self) -> bool {
        !matches!(self, Self::Passive)
    }

    /// It has a gravity term.
    #[must_use]
    pub const fn has_gravity(self) -> bool {
        !matches!(self, Self::Pd)
    }
}

/// The functions of a cycle in one build, picked once: [`portable`](crate::portable), or where its instructions were
/// detected, `avx2`.
#[derive(Clone, Copy, Debug)]
pub struct Kernels {
    /// As [`portable::gravity_torque`](crate::portable::gravity_torque).
    pub gravity_torque: fn(&Robot, &Joints, &Gravity) -> Joints,
    /// As [`portable::inverse_dynamics`](crate::portable::inverse_dynamics).
    pub inverse_dynamics: fn(&Robot, &Joints, &Joints, &Joints, &BaseMotion) -> Joints,
}

impl Kernels {
    /// Those that every processor runs.
    pub const PORTABLE: Self =
        Self { gravity_torque: portable::gravity_torque, inverse_dynamics: portable::inverse_dynamics };
}
