//! Three real arms as literal tables, and random samples of their motion.

use gravcomp::spatial::{Inertia, Pose};
use gravcomp::{
    BaseMotion, DhRow, Frame, Gravity, Joint, Joints, ModelError, Placement, Robot, RobotBuilder, SpecificForce,
};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Samples per arm; a power of two.
pub const SAMPLES: usize = 256;

/// An arm and motions to compute with, made before anything is timed.
pub struct Arm {
    pub robot: Robot,
    pub samples: Vec<Sample>,
}

impl Arm {
    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.robot.coordinates()
    }
}

/// One cycle's inputs.
#[derive(Clone, Copy)]
pub struct Sample {
    pub q: Joints,
    pub qd: Joints,
    pub qdd: Joints,
    pub tau: Joints,
    pub g: Gravity,
    pub base: BaseMotion,
}

/// A link: joint, row, mass (kg), centre of mass (m), inertia about it (xx xy xz yy yz zz, kg·m²).
struct Link(Joint, DhRow, f64, [f64; 3], [f64; 6]);

/// The arms with 3, 6 and 7 joints.
pub fn all() -> Vec<Arm> {
    [raven, ur20, panda].map(|table| arm(table().expect("the tables below are valid"))).into()
}

fn arm(robot: Robot) -> Arm {
    Arm { samples: samples(robot.coordinates()), robot }
}

/// RAVEN II, gold arm: shoulder, elbow, insertion. DH: uw-biorobotics/raven2@d2307c5 src/raven/r2_kinematics.cpp:64-68;
/// masses: src/raven/grav_comp.cpp:59-76; inertias: slender rods.
fn raven() -> Result<Robot, ModelError> {
    let row = |alpha: f64, theta: f64| DhRow { alpha: alpha.to_radians(), a: 0.0, d: 0.0, theta: theta.to_radians() };
    let link = |joint, row, mass, com| Link(joint, row, mass, com, slender_rod(mass, com));
    let base = Pose::new(Matrix3::new(0., -1., 0., 0., 0., -1., 1., 0., 0.), Vector3::zeros(), "base")?;
    lowered(
        base,
        DhRow::modified,
        [
            link(Joint::Revolute, row(0.0, 205.0), 0.494, [0.0065, 0.09775, -0.13771]),
            link(Joint::Revolute, row(75.0, 180.0), 0.750, [-0.002, -0.18274, -0.23053]),
            link(Joint::Prismatic, row(128.0, 90.0), 0.231, [0.0, 0.0, 0.0]),
        ],
    )
}

/// Inertia of a rod from the origin to twice the centre of mass c: m/3 (c·c 1 − c cᵀ).
fn slender_rod(mass: f64, [x, y, z]: [f64; 3]) -> [f64; 6] {
    [y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y].map(|moment| mass / 3.0 * moment)
}

/// UR20: Universal Robots, "DH parameters for calculations of kinematics and dynamics" (kinematics, masses, inertias).
fn ur20() -> Result<Robot, ModelError> {
    let link =
        |a, d, alpha, mass, com, inertia| Link(Joint::Revolute, DhRow { alpha, a, d, theta: 0.0 }, mass, com, inertia);
    let elbow = [0.1467, 0.0002, -0.0516, 4.6659, 0.0, 4.6348];
    let forearm = [0.0261, -0.0001, -0.0290, 0.7576, 0.0, 0.7533];
    lowered(
        Pose::IDENTITY,
        DhRow::standard,
        [
            link(
                0.0,
                0.2363,
                FRAC_PI_2,
                16.343,
                [0.0, -0.0610, 0.0062],
                [0.0887, -0.0001, -0.0001, 0.0763, 0.0072, 0.0842],
            ),
            link(-0.8620, 0.0, 0.0, 29.632, [0.5226, 0.0, 0.2098], elbow),
            link(-0.7287, 0.0, 0.0, 7.879, [0.3234, 0.0, 0.0604], forearm),
            link(0.0, 0.2010, FRAC_PI_2, 3.054, [0.0, -0.0026, 0.0393], [0.0056, 0.0, 0.0, 0.0054, 0.0004, 0.0040]),
            link(0.0, 0.1593, -FRAC_PI_2, 3.126, [0.0, 0.0024, 0.0379], [0.0059, 0.0, 0.0, 0.0058, -0.0004, 0.0043]),
            link(0.0, 0.1543, 0.0, 0.846, [0.0, -0.0003, -0.0318], [0.0009, 0.0, 0.0, 0.0009, 0.0, 0.0012]),
        ],
    )
}

/// Franka Emika Panda: Gaz et al., IEEE RA-L 4(4), 2019, supplement Tables VIII and IX.
#[rustfmt::skip]
fn panda() -> Result<Robot, ModelError> {
    let link = |alpha, a, d, mass, com, inertia| {
        Link(Joint::Revolute, DhRow { alpha, a, d, theta: 0.0 }, mass, com, inertia)
    };
    let up = FRAC_PI_2;
    lowered(Pose::IDENTITY, DhRow::modified, [
        link(0.0, 0.0, 0.333, 4.970_684, [0.003_875, 0.002_081, 0.0], [0.703_37, -0.000_139, 0.006_772, 0.706_61, 0.019_169, 0.009_117]),
        link(-up, 0.0, 0.0, 0.646_926, [-0.003_141, -0.028_72, 0.003_495], [0.007_962, -0.003_925, 0.010_254, 0.028_11, 0.000_704, 0.025_995]),
        link(up, 0.0, 0.316, 3.228_604, [0.027_518, 0.039_252, -0.066_502], [0.037_242, -0.004_761, -0.011_396, 0.036_155, -0.012_805, 0.010_83]),
        link(up, 0.0825, 0.0, 3.587_895, [-0.053_17, 0.104_419, 0.027_454], [0.025_853, 0.007_796, -0.001_332, 0.019_552, 0.008_641, 0.028_323]),
        link(-up, -0.0825, 0.384, 1.225_946, [-0.011_953, 0.041_065, -0.038_437], [0.035_549, -0.002_117, -0.004_037, 0.029_474, 0.000_229, 0.008_627]),
        link(up, 0.0, 0.0, 1.666_555, [0.060_149, -0.014_117, -0.010_517], [0.001_964, 0.000_109, -0.001_158, 0.004_354, 0.000_341, 0.005_433]),
        link(up, 0.088, 0.0, 0.735_522, [0.010_517, -0.004_252, 0.061_597], [0.012_516, -0.000_428, -0.001_196, 0.010_027, -0.000_741, 0.004_815]),
    ])
}

/// The chain of these links; the tool frame is that of the last one.
fn lowered<const N: usize>(
    base: Pose,
    convention: impl Fn(&DhRow) -> Result<Placement, ModelError>,
    links: [Link; N],
) -> Result<Robot, ModelError> {
    let (mut builder, mut frame) = (RobotBuilder::new(), Frame::ROOT);
    for Link(joint, row, mass, com, inertia) in links {
        frame = builder.link(&frame, joint, &convention(&row)?, &Inertia::new(mass, com.into(), inertia)?)?;
    }
    builder.build(base, frame, None)
}

fn samples(n: usize) -> Vec<Sample> {
    let mut random = Random(0x5eed);
    (0..SAMPLES).map(|_| sample(n, &mut random)).collect()
}

fn sample(n: usize, random: &mut Random) -> Sample {
    let mut joints = |bound: f64| Joints::from_slice(&random.vector::<16>(bound)[..n]);
    let (q, qd, qdd, tau) = (joints(PI), joints(2.0), joints(5.0), joints(20.0));
    let tilt = Vector3::from(random.vector(3.0));
    let base = BaseMotion {
        specific_force: SpecificForce(tilt - Gravity::LEVEL.0),
        angular_velocity: random.vector(1.0).into(),
        angular_acceleration: random.vector(2.0).into(),
    };
    Sample { q, qd, qdd, tau, g: Gravity(Gravity::LEVEL.0 - tilt), base }
}

/// Numbers that look random and are the same every time (Vigna's `SplitMix64`).
struct Random(u64);

impl Random {
    /// Uniform in ±`bound`.
    fn number(&mut self, bound: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let top = u32::try_from((z ^ (z >> 31)) >> 32).unwrap_or(0);
        bound * (f64::from(top) / f64::from(1_u32 << 31) - 1.0)
    }

    fn vector<const N: usize>(&mut self, bound: f64) -> [f64; N] {
        [0.0; N].map(|_| self.number(bound))
    }
}
