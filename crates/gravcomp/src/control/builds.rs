//! The cycle, compiled once for any processor and once for those with AVX2 and FMA, as the kernels are.
//!
//! The law's own arithmetic is never fused: both builds round alike, and differ where their kernels do.

use super::feel::Weight;
use super::{Controller, Inputs};
use crate::base::{BaseMotion, Gravity};
use crate::constants::MAX_JOINTS;
use crate::entry;
use crate::robot::{Joints, Robot};

/// A cycle in one build, picked once: that of [`portable`], or where its instructions were detected, of [`avx2`].
#[derive(Clone, Copy, Debug)]
pub struct Kernels {
    /// As [`portable::cycle`].
    pub cycle: fn(&mut Controller, &Robot, &Inputs<'_>),
}

impl Kernels {
    /// The cycle that every processor runs.
    pub const PORTABLE: Self = Self { cycle: portable::cycle };
}

/// Functions of a build as the weight of an arm, and what acts beside it.
struct Held<S, M, B> {
    still: S,
    moving: M,
    beside: B,
}

impl<S, M, B> Weight for Held<S, M, B>
where
    S: Fn(&Joints, &Gravity) -> Joints,
    M: Fn(&Joints, &BaseMotion) -> Joints,
    B: Fn(&Joints, &Joints) -> Joints,
{
    #[inline(always)]
    fn at_rest(&self, q: &Joints, g: &Gravity) -> Joints {
        (self.still)(q, g)
    }

    #[inline(always)]
    fn on_base(&self, q: &Joints, base: &BaseMotion) -> Joints {
        (self.moving)(q, base)
    }

    #[inline(always)]
    fn beside(&self, q: &Joints, qd: &Joints) -> Joints {
        (self.beside)(q, qd)
    }
}

macro_rules! build {
    ($kernels:ident $(, $target:meta)?) => {
        /// One cycle of `law`: as [`Controller::step`], which calls the one that it was given.
        $(#[$target])?
        pub fn cycle(law: &mut Controller, robot: &Robot, inputs: &Inputs<'_>) {
            match (law.settings.coordinates, law.springs.is_some()) {
                (0..=4, false) => wide::<4, false>(law, robot, inputs),
                (5..=8, false) => wide::<8, false>(law, robot, inputs),
                (_, false) => wide::<MAX_JOINTS, false>(law, robot, inputs),
                (0..=4, true) => wide::<4, true>(law, robot, inputs),
                (5..=8, true) => wide::<8, true>(law, robot, inputs),
                (_, true) => wide::<MAX_JOINTS, true>(law, robot, inputs),
            }
        }

        /// The same of so many places, with springs or without: each stands by itself, so that an arm's own is all that a
        /// cold cycle fetches.
        $(#[$target])?
        #[inline(never)]
        fn wide<const N: usize, const SPRINGS: bool>(law: &mut Controller, robot: &Robot, inputs: &Inputs<'_>) {
            const STILL: &Joints = &Joints([0.0; MAX_JOINTS]);
            let weight = Held {
                still: |q: &Joints, g: &Gravity| entry::$kernels::gravity_torque(robot, q, g),
                moving: |q: &Joints, base: &BaseMotion| entry::$kernels::inverse_dynamics(robot, q, STILL, STILL, base),
                beside: |q: &Joints, qd: &Joints| match inputs.disturbances {
                    Some(elements) => entry::$kernels::disturbance_torque(robot, elements, q, qd),
                    None => *STILL,
                },
            };
            law.cycle::<N, SPRINGS>(inputs, &weight);
        }
    };
}

/// Compiled for every processor of the target.
pub mod portable {
    #![allow(clippy::wildcard_imports)] // one list of imports serves every build
    use super::*;
    build!(portable);
}

/// Compiled for x86-64 processors with AVX2 and FMA. Safe to call where those were detected.
#[cfg(target_arch = "x86_64")]
pub mod avx2 {
    #![allow(clippy::wildcard_imports, clippy::missing_safety_doc)] // the condition stands above
    use super::*;
    build!(avx2, target_feature(enable = "avx2,fma"));
}
