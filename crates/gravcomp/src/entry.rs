//! The functions, as they are called: each text once, compiled once for any processor and once for those with FMA.

use crate::base::{BaseMotion, Gravity};
use crate::constants::MAX_JOINTS;
use crate::dynamics::{Motion, Square, Wrench};
use crate::jacobian::{Column, JacobianAxes};
use crate::kinematics::Axes;
use crate::lanes::{Lanes, Vec3, splat3};
use crate::motion::{JointsNow, lanes, numbers, to_mechanism};
use crate::robot::{Frame, Joints, Robot};
use crate::{dynamics, energy, gravity, jacobian, kinematics, regressor};
use nalgebra::{Matrix4, Vector3, Vector6};

/// One column per coordinate: linear velocity of the frame's origin, then angular velocity.
pub type JacobianColumns = [Vector6<f64>; MAX_JOINTS];

/// A square matrix whose first rows and columns belong to the robot's coordinates.
pub type JointMatrix = [[f64; MAX_JOINTS]; MAX_JOINTS];

fn base_motion<const FUSED: bool>(base: &BaseMotion) -> Motion<1, FUSED> {
    Motion {
        w: splat3(&base.angular_velocity),
        dw: splat3(&base.angular_acceleration),
        f: splat3(&base.specific_force.0),
    }
}

#[inline(always)]
fn plain<const FUSED: bool>(v: &Vec3<1, FUSED>) -> Vector3<f64> {
    Vector3::new(v.x.0[0], v.y.0[0], v.z.0[0])
}

#[inline(always)]
fn homogeneous<const FUSED: bool>(axes: &Axes<1, FUSED>) -> Matrix4<f64> {
    let [x, y, z, o] = [&axes.x, &axes.y, &axes.z, &axes.origin].map(plain);
    Matrix4::from_columns(&[x.push(0.0), y.push(0.0), z.push(0.0), o.push(1.0)])
}

#[inline(always)]
fn columns<const FUSED: bool>(columns: &[Column<1, FUSED>; MAX_JOINTS]) -> JacobianColumns {
    columns.map(|c| {
        let (v, w) = (plain(&c.linear), plain(&c.angular));
        Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
    })
}

#[inline(always)]
fn matrix<const FUSED: bool>(matrix: &Square<1, FUSED>) -> JointMatrix {
    matrix.map(|row| row.map(|x| x.0[0]))
}

#[inline(always)]
fn force_then_moment<const FUSED: bool>(wrench: &Wrench<1, FUSED>) -> Vector6<f64> {
    let (f, m) = (plain(&wrench.force), plain(&wrench.moment));
    Vector6::new(f.x, f.y, f.z, m.x, m.y, m.z)
}

macro_rules! entry_points {
    ($fused:expr $(, $target:meta)?) => {
        const FUSED: bool = $fused;

        /// Efforts that hold the arm still (N·m, N): eqs (1)-(3) of Lewis & Hannaford, equal to +∂U/∂q.
        $(#[$target])?
        #[must_use]
        pub fn gravity_torque(robot: &Robot, q: &Joints, g: &Gravity) -> Joints {
            let mut now = JointsNow::<1, FUSED>::at(robot, lanes(q));
            now.turn_single(robot);
            numbers(&gravity::gravity_torque(robot, &now, splat3(&g.0)))
        }

        /// Efforts that hold the arm still for `W` configurations at once, one gravity vector each.
        $(#[$target])?
        #[must_use]
        pub fn gravity_torques<const W: usize>(
            robot: &Robot,
            q: &[[f64; W]; MAX_JOINTS],
            g: &[[f64; W]; 3],
        ) -> [[f64; W]; MAX_JOINTS] {
            let mut now = JointsNow::<W, FUSED>::at(robot, q.map(Lanes));
            now.turn_many(robot);
            gravity::gravity_torque(robot, &now, Vector3::from(g.map(Lanes))).map(|tau| tau.0)
        }

        /// The pose of `frame` in the base frame B as a homogeneous matrix.
        $(#[$target])?
        #[must_use]
        pub fn forward_kinematics(robot: &Robot, q: &Joints, frame: &Frame) -> Matrix4<f64> {
            let mut now = JointsNow::<1, FUSED>::at(robot, lanes(q));
            now.turn_single(robot);
            homogeneous(&kinematics::pose(robot, &now, frame))
        }

        /// The geometric Jacobian of `frame`, one column per coordinate, linear rows first.
        $(#[$target])?
        #[must_use]
        pub fn jacobian(robot: &Robot, q: &Joints, frame: &Frame, axes: JacobianAxes) -> JacobianColumns {
            let mut now = JointsNow::<1, FUSED>::at(robot, lanes(q));
            now.turn_single(robot);
            columns(&jacobian::jacobian(robot, &now, frame, axes))
        }

        /// Efforts for the motion (q, q̇, q̈) on a moving base.
        $(#[$target])?
        #[must_use]
        pub fn inverse_dynamics(robot: &Robot, q: &Joints, qd: &Joints, qdd: &Joints, base: &BaseMotion) -> Joints {
            let mut now = JointsNow::<1, FUSED>::at(robot, lanes(q));
            now.turn_single(robot);
            let (qd, qdd) = (to_mechanism(robot, lanes(qd), false), to_mechanism(robot, lanes(qdd), false));
            numbers(&dynamics::inverse_dynamics(robot, &now, &qd, &qdd, &base_motion(base)).0)
        }

        /// What the mount exerts on the arm and all that is fixed to the base: force (N), then moment about the base
        /// origin (N·m), in base axes.
        $(#[$target])?
        #[must_use]
        pub fn base_wrench(robot: &Robot, q: &Joints, qd: &Joints, qdd: &Joints, base: &BaseMotion) -> Vector6<f64> {
            let mut now = JointsNow::<1, FUSED>::at(robot, lanes(q));
            now.turn_single(robot);
            let (qd, qdd) = (to_mechanism(robot, lanes(qd), false), to_mechanism(robot, lanes(qdd), false));
            let base = base_motion(base);
            let (_, wrench) = dynamics::inverse_dynamics(robot, &now, &qd, &qdd, &base);
            force_then_moment(&dynamics::with_base_inertia(robot, &wrench, &base))
        }

        /// M(q), symmetric.
        $(#[$target])?
        #[must_use]
        pub fn mass_matrix(robot: &Robot, q: &Joints) -> JointMatrix {
            let mut now = JointsNow::<1, FUSED>::at(robot, lanes(q));
            now.turn_single(robot);
            matrix(&dynamics::mass_matrix(robot, &now))
        }

        /// q̈ under efforts τ on a moving base; NaN where M(q) is not positive definite (massless tips).
        $(#[$target])?
        #[must_use]
        pub fn forward_dynamics(robot: &Robot, q: &Joints, qd: &Joints, tau: &Joints, base: &BaseMotion) -> Joints {
            let mut now = JointsNow::<1, FUSED>::at(robot, lanes(q));
            now.turn_single(robot);
            let qd = to_mechanism(robot, lanes(qd), false);
            let (bias, _) = dynamics::inverse_dynamics(robot, &now, &qd, &[Lanes::ZERO; MAX_JOINTS], &base_motion(base));
            let applied = lanes::<FUSED>(tau);
            let net = core::array::from_fn(|j| applied[j] - bias[j]);
            numbers(&dynamics::solve(&dynamics::mass_matrix(robot, &now), &net, robot.coordinates()))
        }

        /// Writes the regressor of the gravity torque, coordinates × (4 bodies), row-major.
        $(#[$target])?
        pub fn gravity_regressor(robot: &Robot, q: &Joints, g: &Gravity, out: &mut [f64]) {
            let mut now = JointsNow::<1, FUSED>::at(robot, lanes(q));
            now.turn_single(robot);
            let still = [Lanes::ZERO; MAX_JOINTS];
            let base = base_motion(&BaseMotion::at_rest(*g));
            regressor::regressor::<{ regressor::GRAVITY_PARAMETERS }, FUSED>(robot, &now, &still, &still, &base, out);
        }

        /// Writes the regressor of the inverse dynamics, coordinates × (10 bodies), row-major.
        $(#[$target])?
        pub fn inverse_dynamics_regressor(
            robot: &Robot,
            q: &Joints,
            qd: &Joints,
            qdd: &Joints,
            base: &BaseMotion,
            out: &mut [f64],
        ) {
            let mut now = JointsNow::<1, FUSED>::at(robot, lanes(q));
            now.turn_single(robot);
            let (qd, qdd) = (to_mechanism(robot, lanes(qd), false), to_mechanism(robot, lanes(qdd), false));
            regressor::regressor::<{ regressor::PARAMETERS }, FUSED>(robot, &now, &qd, &qdd, &base_motion(base), out);
        }

        /// ∂τ_g/∂q, symmetric.
        $(#[$target])?
        #[must_use]
        pub fn gravity_stiffness(robot: &Robot, q: &Joints, g: &Gravity) -> JointMatrix {
            let mut now = JointsNow::<1, FUSED>::at(robot, lanes(q));
            now.turn_single(robot);
            matrix(&energy::gravity_stiffness(robot, &now, &splat3(&g.0)))
        }

        /// U = −Σ m g·p, J, zero at the base origin; what is fixed to the base is not counted.
        $(#[$target])?
        #[must_use]
        pub fn potential_energy(robot: &Robot, q: &Joints, g: &Gravity) -> f64 {
            let mut now = JointsNow::<1, FUSED>::at(robot, lanes(q));
            now.turn_single(robot);
            let (_, moment) = energy::moment(robot, &now);
            -plain(&moment).dot(&g.0)
        }

        /// Centre of mass of everything that moves, in B, m; NaN for a robot without mass.
        $(#[$target])?
        #[must_use]
        pub fn center_of_mass(robot: &Robot, q: &Joints) -> Vector3<f64> {
            let mut now = JointsNow::<1, FUSED>::at(robot, lanes(q));
            now.turn_single(robot);
            let (mass, moment) = energy::moment(robot, &now);
            plain(&moment) / mass
        }
    };
}

/// Compiled for every processor of the target; fused where all of them are.
pub mod portable {
    #![allow(clippy::wildcard_imports)] // one list of imports serves every build of the functions
    use super::*;
    entry_points!(cfg!(any(target_feature = "fma", target_arch = "aarch64")));
}

/// Compiled for x86-64 processors with AVX2 and FMA. Safe to call where those were detected.
#[cfg(target_arch = "x86_64")]
pub mod avx2 {
    #![allow(clippy::wildcard_imports, clippy::missing_safety_doc)] // the condition stands above
    use super::*;
    entry_points!(true, target_feature(enable = "avx2,fma"));
}

/// The batch kernel for x86-64 processors with AVX-512. Safe to call where it was detected.
#[cfg(target_arch = "x86_64")]
pub mod avx512 {
    #![allow(clippy::wildcard_imports, clippy::missing_safety_doc)] // the condition stands above
    use super::*;

    /// Efforts that hold the arm still for `W` configurations at once, one gravity vector each.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2,fma")]
    #[must_use]
    pub fn gravity_torques<const W: usize>(
        robot: &Robot,
        q: &[[f64; W]; MAX_JOINTS],
        g: &[[f64; W]; 3],
    ) -> [[f64; W]; MAX_JOINTS] {
        let mut now = JointsNow::<W, true>::at(robot, q.map(Lanes));
        now.turn_many(robot);
        gravity::gravity_torque(robot, &now, Vector3::from(g.map(Lanes))).map(|tau| tau.0)
    }
}
