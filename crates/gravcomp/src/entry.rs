//! The functions, as they are called: each text once, compiled once for any processor and once for those with FMA.

use crate::base::{BaseMotion, Gravity};
use crate::box_qp::{Active, Problem, ROWS, Solution};
use crate::constants::MAX_JOINTS;
use crate::disturbance::Disturbances;
use crate::dynamics::{Motion, Wrench};
use crate::elastic::{Compensation, ElasticGravity};
use crate::jacobian::JacobianAxes;
use crate::lanes::{Lanes, Vec3, splat3};
use crate::manipulability::{self, Ascent, Manipulability, Projection, Step};
use crate::motion::{JointsNow, single, to_mechanism};
use crate::resolved_rate::{self, ResolvedRate};
use crate::robot::{Frame, Joints, Robot};
use crate::{box_qp, dynamics, energy, gravity, jacobian, kinematics, regressor};
use nalgebra::{Matrix4, Vector3, Vector6};

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
fn force_then_moment<const FUSED: bool>(wrench: &Wrench<1, FUSED>) -> Vector6<f64> {
    let (f, m) = (plain(&wrench.force), plain(&wrench.moment));
    Vector6::new(f.x, f.y, f.z, m.x, m.y, m.z)
}

/// Positions as the mechanism's joints see them: those given, or what a coupling makes of them.
macro_rules! mechanism {
    (let $x:ident = positions of $robot:ident) => {
        let coupled;
        let $x = match $robot.coupling() {
            None => $x,
            Some(coupling) => {
                coupled = to_mechanism::<_, FUSED>(coupling, $x, Some(coupling.offset()));
                &coupled
            }
        };
    };
    (let $x:ident = rates of $robot:ident) => {
        let coupled;
        let $x = match $robot.coupling() {
            None => $x,
            Some(coupling) => {
                coupled = to_mechanism::<_, FUSED>(coupling, $x, None);
                &coupled
            }
        };
    };
}

/// Plain numbers, one per joint, as single lanes to write to.
#[inline(always)]
fn single_mut(x: &mut Joints) -> Option<&mut [[f64; 1]; MAX_JOINTS]> {
    x.0.as_chunks_mut().0.first_chunk_mut()
}

/// The first `len` numbers of `out`, if it has so many.
macro_rules! exactly {
    ($out:ident, $len:expr) => {
        let len = $len;
        let Some($out) = $out.get_mut(..len) else { return };
    };
}

macro_rules! entry_points {
    ($fused:expr $(, $target:meta)?) => {
        const FUSED: bool = $fused;

        /// Efforts that hold the arm still (N·m, N): eqs (1)-(3) of Lewis & Hannaford, equal to +∂U/∂q.
        $(#[$target])?
        #[must_use]
        pub fn gravity_torque(robot: &Robot, q: &Joints, g: &Gravity) -> Joints {
            let q = single(q);
            mechanism!(let q = positions of robot);
            let mut now = JointsNow::<1, FUSED>::at(q);
            now.turn_single(robot);
            let mut tau = Joints::default();
            if let Some(tau) = single_mut(&mut tau) {
                gravity::gravity_torque(robot, &now, splat3(&g.0), tau);
            }
            tau
        }

        /// One cycle of gravity compensation with the motors of an arm with elastic joints at `theta`, its goal at `q_d`, and
        /// its links at `q`, which only [`crate::elastic::Variant::Link`] reads.
        $(#[$target])?
        pub fn elastic_gravity(
            robot: &Robot,
            elastic: &mut ElasticGravity,
            theta: &Joints,
            q_d: &Joints,
            q: &Joints,
            g: &Gravity,
        ) -> Compensation {
            elastic.step(|q| gravity_torque(robot, q, g), g.0.norm(), theta, q_d, q)
        }

        /// Efforts (N·m, N) against the disturbance elements at q, q̇: see [`mod@crate::disturbance`].
        $(#[$target])?
        #[must_use]
        pub fn disturbance_torque(robot: &Robot, elements: &Disturbances, q: &Joints, qd: &Joints) -> Joints {
            let mut tau = elements.efforts(q, qd);
            if elements.has_springs() {
                let q = single(q);
                mechanism!(let q = positions of robot);
                let mut now = JointsNow::<1, FUSED>::at(q);
                now.turn_single(robot);
                elements.add_springs(robot, &now, &mut tau);
            }
            tau
        }

        /// Writes their regressor, coordinates × parameters, row-major. Nothing is written where `out` has no room for it.
        $(#[$target])?
        pub fn disturbance_regressor(
            robot: &Robot,
            elements: &Disturbances,
            q: &Joints,
            qd: &Joints,
            out: &mut [f64],
        ) {
            exactly!(out, robot.coordinates() * elements.parameters().len());
            elements.write_along(q, qd, out);
            if elements.has_springs() {
                let q = single(q);
                mechanism!(let q = positions of robot);
                let mut now = JointsNow::<1, FUSED>::at(q);
                now.turn_single(robot);
                elements.write_springs(robot, &now, out);
            }
        }

        /// Writes the efforts that hold the arm still for `W` configurations at once, one gravity vector each. Entries of `tau`
        /// beyond the robot's coordinates are left as they are, or set to zero.
        $(#[$target])?
        pub fn gravity_torques<const W: usize>(
            robot: &Robot,
            q: &[[f64; W]; MAX_JOINTS],
            g: &[[f64; W]; 3],
            tau: &mut [[f64; W]; MAX_JOINTS],
        ) {
            mechanism!(let q = positions of robot);
            let mut now = JointsNow::<W, FUSED>::at(q);
            now.turn_many(robot);
            gravity::gravity_torque(robot, &now, Vector3::from(g.map(Lanes)), tau);
        }

        /// One step of resolved-rate motion: see [`mod@resolved_rate`].
        $(#[$target])?
        pub fn resolved_rate(robot: &Robot, rate: &mut ResolvedRate, inputs: &resolved_rate::Inputs<'_>) {
            rate.step::<FUSED>(robot, inputs);
        }

        /// The pose of `frame` in the base frame B as a homogeneous matrix.
        $(#[$target])?
        #[must_use]
        pub fn forward_kinematics(robot: &Robot, q: &Joints, frame: &Frame) -> Matrix4<f64> {
            let q = single(q);
            mechanism!(let q = positions of robot);
            let mut now = JointsNow::<1, FUSED>::at(q);
            now.turn_single(robot);
            let pose = kinematics::pose(robot, &now, frame);
            Matrix4::from([pose.x.0, pose.y.0, pose.z.0, pose.origin.0])
        }

        /// Writes the geometric Jacobian of `frame`, 6 × coordinates, row-major, linear rows first. Nothing is written where
        /// `out` has no room for it.
        $(#[$target])?
        pub fn jacobian(robot: &Robot, q: &Joints, frame: &Frame, axes: JacobianAxes, out: &mut [f64]) {
            exactly!(out, 6 * robot.coordinates());
            let q = single(q);
            mechanism!(let q = positions of robot);
            let mut now = JointsNow::<1, FUSED>::at(q);
            now.turn_single(robot);
            jacobian::jacobian(robot, &now, frame, axes, out);
        }

        /// Efforts for the motion (q, q̇, q̈) on a moving base.
        $(#[$target])?
        #[must_use]
        pub fn inverse_dynamics(robot: &Robot, q: &Joints, qd: &Joints, qdd: &Joints, base: &BaseMotion) -> Joints {
            let (q, qd, qdd) = (single(q), single(qd), single(qdd));
            mechanism!(let q = positions of robot);
            mechanism!(let qd = rates of robot);
            mechanism!(let qdd = rates of robot);
            let mut now = JointsNow::<1, FUSED>::at(q);
            now.turn_single(robot);
            let mut tau = Joints::default();
            if let Some(tau) = single_mut(&mut tau) {
                dynamics::inverse_dynamics(robot, &now, qd, qdd, &base_motion(base), tau);
            }
            tau
        }

        /// What the mount exerts on the arm and all that is fixed to the base: force (N), then moment about the base
        /// origin (N·m), in base axes.
        $(#[$target])?
        #[must_use]
        pub fn base_wrench(robot: &Robot, q: &Joints, qd: &Joints, qdd: &Joints, base: &BaseMotion) -> Vector6<f64> {
            let (q, qd, qdd) = (single(q), single(qd), single(qdd));
            mechanism!(let q = positions of robot);
            mechanism!(let qd = rates of robot);
            mechanism!(let qdd = rates of robot);
            let mut now = JointsNow::<1, FUSED>::at(q);
            now.turn_single(robot);
            let (base, mut tau) = (base_motion(base), [[0.0]; MAX_JOINTS]);
            let wrench = dynamics::inverse_dynamics(robot, &now, qd, qdd, &base, &mut tau);
            force_then_moment(&dynamics::with_base_inertia(robot, &wrench, &base))
        }

        /// Writes M(q), coordinates × coordinates, symmetric. Nothing is written where `out` has no room for it.
        $(#[$target])?
        pub fn mass_matrix(robot: &Robot, q: &Joints, out: &mut [f64]) {
            exactly!(out, robot.coordinates() * robot.coordinates());
            let q = single(q);
            mechanism!(let q = positions of robot);
            let mut now = JointsNow::<1, FUSED>::at(q);
            now.turn_single(robot);
            dynamics::mass_matrix(robot, &now, out);
        }

        /// q̈ under efforts τ on a moving base; NaN where M(q) is not positive definite (massless tips).
        $(#[$target])?
        #[must_use]
        pub fn forward_dynamics(robot: &Robot, q: &Joints, qd: &Joints, tau: &Joints, base: &BaseMotion) -> Joints {
            let (q, qd) = (single(q), single(qd));
            mechanism!(let q = positions of robot);
            mechanism!(let qd = rates of robot);
            let mut now = JointsNow::<1, FUSED>::at(q);
            now.turn_single(robot);
            let (mut bias, still) = ([[0.0]; MAX_JOINTS], [[0.0]; MAX_JOINTS]);
            dynamics::inverse_dynamics(robot, &now, qd, &still, &base_motion(base), &mut bias);
            let mut qdd = Joints(core::array::from_fn(|j| tau[j] - bias[j][0]));
            let (n, mut matrix) = (robot.coordinates(), [0.0; MAX_JOINTS * MAX_JOINTS]);
            if let Some(matrix) = matrix.get_mut(..n * n) {
                dynamics::mass_matrix(robot, &now, matrix);
                dynamics::solve::<FUSED>(matrix, &mut qdd.0[..n.min(MAX_JOINTS)]);
            }
            qdd
        }

        /// The minimum of a weighted sum of squares in a box, looked for from the bounds `warm`.
        $(#[$target])?
        #[must_use]
        pub fn minimum_in_box<const N: usize>(problem: &Problem<N>, warm: Active) -> Solution<N> {
            box_qp::solve::<N, FUSED>(problem, warm)
        }

        /// Rates of the task T x = v that climb `gradient`, in the box `(lower, upper)`.
        $(#[$target])?
        #[must_use]
        pub fn ascend<const N: usize>(
            T: &[[f64; N]; ROWS],
            v: &[f64; ROWS],
            gradient: &[f64; N],
            ascent: Ascent,
            limits: ([f64; N], [f64; N]),
            warm: [Active; 2],
        ) -> Step<N> {
            manipulability::ascend::<N, FUSED>(T, v, gradient, ascent, limits, warm)
        }

        /// The manipulability of `frame` for the task P, and its gradient.
        $(#[$target])?
        #[must_use]
        pub fn manipulability(robot: &Robot, q: &Joints, frame: &Frame, P: &Projection) -> Manipulability<MAX_JOINTS> {
            let q = single(q);
            mechanism!(let q = positions of robot);
            let mut now = JointsNow::<1, FUSED>::at(q);
            now.turn_single(robot);
            let J = manipulability::mechanism_jacobian::<MAX_JOINTS, FUSED>(robot, &now, frame);
            manipulability::manipulability::<MAX_JOINTS, FUSED>(&J, robot.coupling(), P)
        }

        /// Writes the regressor of the gravity torque, coordinates × (4 bodies), row-major. Nothing is written where `out` has
        /// no room for it.
        $(#[$target])?
        pub fn gravity_regressor(robot: &Robot, q: &Joints, g: &Gravity, out: &mut [f64]) {
            exactly!(out, robot.coordinates() * regressor::GRAVITY_PARAMETERS * robot.bodies());
            let q = single(q);
            mechanism!(let q = positions of robot);
            let mut now = JointsNow::<1, FUSED>::at(q);
            now.turn_single(robot);
            let still = [[0.0]; MAX_JOINTS];
            let base = base_motion(&BaseMotion::at_rest(*g));
            regressor::regressor::<{ regressor::GRAVITY_PARAMETERS }, FUSED>(robot, &now, &still, &still, &base, out);
        }

        /// Writes the regressor of the inverse dynamics, coordinates × (10 bodies), row-major. Nothing is written where `out`
        /// has no room for it.
        $(#[$target])?
        pub fn inverse_dynamics_regressor(
            robot: &Robot,
            q: &Joints,
            qd: &Joints,
            qdd: &Joints,
            base: &BaseMotion,
            out: &mut [f64],
        ) {
            exactly!(out, robot.coordinates() * regressor::PARAMETERS * robot.bodies());
            let (q, qd, qdd) = (single(q), single(qd), single(qdd));
            mechanism!(let q = positions of robot);
            mechanism!(let qd = rates of robot);
            mechanism!(let qdd = rates of robot);
            let mut now = JointsNow::<1, FUSED>::at(q);
            now.turn_single(robot);
            regressor::regressor::<{ regressor::PARAMETERS }, FUSED>(robot, &now, qd, qdd, &base_motion(base), out);
        }

        /// Writes ∂τ_g/∂q, coordinates × coordinates, symmetric. Nothing is written where `out` has no room for it.
        $(#[$target])?
        pub fn gravity_stiffness(robot: &Robot, q: &Joints, g: &Gravity, out: &mut [f64]) {
            exactly!(out, robot.coordinates() * robot.coordinates());
            let q = single(q);
            mechanism!(let q = positions of robot);
            let mut now = JointsNow::<1, FUSED>::at(q);
            now.turn_single(robot);
            energy::gravity_stiffness(robot, &now, &splat3(&g.0), out);
        }

        /// U = −Σ m g·p, J, zero at the base origin; what is fixed to the base is not counted.
        $(#[$target])?
        #[must_use]
        pub fn potential_energy(robot: &Robot, q: &Joints, g: &Gravity) -> f64 {
            let q = single(q);
            mechanism!(let q = positions of robot);
            let mut now = JointsNow::<1, FUSED>::at(q);
            now.turn_single(robot);
            let (_, moment) = energy::moment(robot, &now);
            -plain(&moment).dot(&g.0)
        }

        /// Centre of mass of everything that moves, in B, m; NaN for a robot without mass.
        $(#[$target])?
        #[must_use]
        pub fn center_of_mass(robot: &Robot, q: &Joints) -> Vector3<f64> {
            let q = single(q);
            mechanism!(let q = positions of robot);
            let mut now = JointsNow::<1, FUSED>::at(q);
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

    const FUSED: bool = true;

    /// Writes the efforts that hold the arm still for `W` configurations at once, one gravity vector each. Entries of `tau`
    /// beyond the robot's coordinates are left as they are, or set to zero.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2,fma")]
    pub fn gravity_torques<const W: usize>(
        robot: &Robot,
        q: &[[f64; W]; MAX_JOINTS],
        g: &[[f64; W]; 3],
        tau: &mut [[f64; W]; MAX_JOINTS],
    ) {
        mechanism!(let q = positions of robot);
        let mut now = JointsNow::<W, FUSED>::at(q);
        now.turn_many(robot);
        gravity::gravity_torque(robot, &now, Vector3::from(g.map(Lanes)), tau);
    }
}
