//! Every entry point, in every build that this processor runs, handed to a visitor one by one.

use crate::arms::{Arm, Sample};
use gravcomp::resolved_rate::{Goal, Inputs, Settings};
use gravcomp::{GRAVITY_PARAMETERS, JacobianAxes, Joints, MAX_JOINTS, PARAMETERS, ResolvedRate};
use std::hint::black_box;

/// Configurations in one call of a batch kernel.
pub const WIDTH: usize = 8;

/// A set of instructions that the kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    Portable,
    Avx2,
    Avx512,
}

impl Level {
    pub const fn name(self) -> &'static str {
        ["portable", "avx2", "avx512"][self as usize]
    }

    /// Whether this processor has the instructions.
    pub fn available(self) -> bool {
        match self {
            Self::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                Self::Avx2.available()
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512dq")
            }
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => false,
        }
    }
}

/// What is done with each function: `call` computes once from a sample and keeps the result.
pub trait Visitor {
    fn cycle(&mut self, function: &'static str, level: Level, call: impl FnMut(&Sample));
    fn batch(&mut self, function: &'static str, level: Level, call: impl FnMut(&Block));
}

/// Inputs of one call of a batch kernel.
pub struct Block {
    pub q: [[f64; WIDTH]; MAX_JOINTS],
    pub g: [[f64; WIDTH]; 3],
}

impl Block {
    pub fn all(samples: &[Sample]) -> Vec<Self> {
        samples
            .as_chunks::<WIDTH>()
            .0
            .iter()
            .map(|lanes| Self {
                q: std::array::from_fn(|i| lanes.map(|sample| sample.q[i])),
                g: std::array::from_fn(|axis| lanes.map(|sample| sample.g.0[axis])),
            })
            .collect()
    }
}

/// Resolved-rate motion at each sample, so that what it tracks is that of a pose at which it has been before.
struct Moving {
    rates: Vec<ResolvedRate>,
    first: usize,
}

impl Moving {
    fn all(arm: &Arm) -> Self {
        let settings = Settings { qd_max: Joints([2.0; MAX_JOINTS]), ..Settings::of(arm.robot.coordinates()) };
        let rate = ResolvedRate::new(settings).expect("settings that make sense");
        Self { rates: vec![rate; arm.samples.len()], first: arm.samples.as_ptr().addr() }
    }

    fn at(&mut self, sample: &Sample) -> &mut ResolvedRate {
        let place = (std::ptr::from_ref(sample).addr() - self.first) / size_of::<Sample>();
        &mut self.rates[place]
    }
}

/// A twist that every arm can follow for a while.
fn inputs(sample: &Sample) -> Inputs<'_> {
    Inputs {
        q: &sample.q,
        goal: Goal::Move(&[0.05, -0.02, 0.03, 0.1, 0.05, -0.1]),
        base_twist: None,
        base_in_doubt: false,
        dt: 1e-3,
    }
}

macro_rules! cycle_functions {
    ($name:ident, $level:expr, $kernels:ident $(, $target:meta)?) => {
        $(#[$target])?
        fn $name(arm: &Arm, visitor: &mut impl Visitor) {
            use gravcomp::$kernels::*;
            const LEVEL: Level = $level;
            let tool = *arm.robot.tool();
            let robot = || black_box(&arm.robot);
            let (rows, bodies) = (arm.robot.coordinates(), arm.robot.bodies());
            visitor.cycle("gravity_torque", LEVEL, |s| { black_box(gravity_torque(robot(), &s.q, &s.g)); });
            visitor.cycle("forward_kinematics", LEVEL, |s| { black_box(forward_kinematics(robot(), &s.q, &tool)); });
            let mut moving = Moving::all(arm);
            visitor.cycle("resolved_rate", LEVEL, |s| {
                let rate = moving.at(s);
                resolved_rate(robot(), rate, &inputs(s));
                black_box(rate.output());
            });
            let mut out = vec![0.0; 6 * rows];
            visitor.cycle("jacobian", LEVEL, |s| {
                jacobian(robot(), &s.q, &tool, JacobianAxes::Base, &mut out);
                black_box(&mut out);
            });
            visitor.cycle("inverse_dynamics", LEVEL, |s| {
                black_box(inverse_dynamics(robot(), &s.q, &s.qd, &s.qdd, &s.base));
            });
            visitor.cycle("base_wrench", LEVEL, |s| { black_box(base_wrench(robot(), &s.q, &s.qd, &s.qdd, &s.base)); });
            let mut out = vec![0.0; rows * rows];
            visitor.cycle("mass_matrix", LEVEL, |s| {
                mass_matrix(robot(), &s.q, &mut out);
                black_box(&mut out);
            });
            visitor.cycle("forward_dynamics", LEVEL, |s| {
                black_box(forward_dynamics(robot(), &s.q, &s.qd, &s.tau, &s.base));
            });
            let mut out = vec![0.0; rows * GRAVITY_PARAMETERS * bodies];
            visitor.cycle("gravity_regressor", LEVEL, |s| {
                gravity_regressor(robot(), &s.q, &s.g, &mut out);
                black_box(&mut out);
            });
            let mut out = vec![0.0; rows * PARAMETERS * bodies];
            visitor.cycle("inverse_dynamics_regressor", LEVEL, |s| {
                inverse_dynamics_regressor(robot(), &s.q, &s.qd, &s.qdd, &s.base, &mut out);
                black_box(&mut out);
            });
            let mut out = vec![0.0; rows * rows];
            visitor.cycle("gravity_stiffness", LEVEL, |s| {
                gravity_stiffness(robot(), &s.q, &s.g, &mut out);
                black_box(&mut out);
            });
            visitor.cycle("potential_energy", LEVEL, |s| { black_box(potential_energy(robot(), &s.q, &s.g)); });
            visitor.cycle("center_of_mass", LEVEL, |s| { black_box(center_of_mass(robot(), &s.q)); });
        }
    };
}

macro_rules! batch_functions {
    ($name:ident, $level:expr, $kernels:ident $(, $target:meta)?) => {
        $(#[$target])?
        fn $name(arm: &Arm, visitor: &mut impl Visitor) {
            use gravcomp::$kernels::*;
            let mut tau = [[0.0; WIDTH]; MAX_JOINTS];
            visitor.batch("gravity_torques", $level, |b| {
                gravity_torques(black_box(&arm.robot), &b.q, &b.g, &mut tau);
                black_box(&mut tau);
            });
        }
    };
}

cycle_functions!(cycle_portable, Level::Portable, portable);
batch_functions!(batch_portable, Level::Portable, portable);
#[cfg(target_arch = "x86_64")]
cycle_functions!(cycle_avx2, Level::Avx2, avx2, target_feature(enable = "avx2,fma"));
#[cfg(target_arch = "x86_64")]
batch_functions!(batch_avx2, Level::Avx2, avx2, target_feature(enable = "avx2,fma"));
#[cfg(target_arch = "x86_64")]
batch_functions!(batch_avx512, Level::Avx512, avx512, target_feature(enable = "avx512f,avx512vl,avx512dq,avx2,fma"));

/// Shows the visitor every function of a cycle, then the batch kernels, in all builds that this processor runs.
pub fn visit(arm: &Arm, visitor: &mut impl Visitor) {
    cycle_portable(arm, visitor);
    batch_portable(arm, visitor);
    #[cfg(target_arch = "x86_64")]
    if Level::Avx2.available() {
        // SAFETY: AVX2 and FMA were detected.
        unsafe { cycle_avx2(arm, visitor) };
        // SAFETY: as above.
        unsafe { batch_avx2(arm, visitor) };
    }
    #[cfg(target_arch = "x86_64")]
    if Level::Avx512.available() {
        // SAFETY: AVX-512 F, VL and DQ were detected, with AVX2 and FMA.
        unsafe { batch_avx512(arm, visitor) };
    }
}
