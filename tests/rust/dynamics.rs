//! Mass matrix, forward dynamics, Coriolis terms and power.

use crate::arms::{State, arms, solid_arms, states};
use crate::builds::{Build, JointMatrix, builds};
use crate::scale::{DIFFERENCE, ROUNDING, Scale, cases, close, derivative, moved, sum, unit};
use gravcomp::{BaseMotion, Gravity, Joints, MAX_JOINTS, Robot, SpecificForce};
use nalgebra::{DMatrix, Vector3};
use proptest::prelude::*;

/// Neither gravity nor motion.
fn weightless() -> BaseMotion {
    BaseMotion::at_rest(Gravity(Vector3::zeros()))
}

fn square(matrix: &JointMatrix, n: usize) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |i, j| matrix[i][j])
}

/// Ṁ along q̇.
fn mass_matrix_rate(build: &Build, robot: &Robot, q: &Joints, qd: &Joints, rate: f64) -> DMatrix<f64> {
    let entries = |t| -> [f64; MAX_JOINTS * MAX_JOINTS] {
        let matrix = build.mass_matrix(robot, &moved(q, t, qd));
        matrix.as_flattened().try_into().expect("16 x 16")
    };
    let n = robot.coordinates();
    DMatrix::from_column_slice(MAX_JOINTS, MAX_JOINTS, &derivative(rate, entries)).view((0, 0), (n, n)).into_owned()
}

/// C(q, q̇) by Christoffel's symbols: its column j is ½ (c(q̇ + e_j) − c(q̇) − c(e_j)), c(q̇) = C q̇ from inverse dynamics.
fn coriolis(build: &Build, robot: &Robot, q: &Joints, qd: &Joints) -> DMatrix<f64> {
    let bias = |qd: &Joints| (build.inverse_dynamics)(robot, q, qd, &Joints::default(), &weightless());
    let (n, own) = (robot.coordinates(), bias(qd));
    DMatrix::from_fn(n, n, |i, j| (bias(&moved(qd, 1.0, &unit(j)))[i] - own[i] - bias(&unit(j))[i]) / 2.0)
}

/// ½ q̇ᵀ M q̇ − Σ m g·p.
fn energy(build: &Build, robot: &Robot, q: &Joints, qd: &Joints, g: &Gravity) -> f64 {
    let n = robot.coordinates();
    let matrix = build.mass_matrix(robot, q);
    let kinetic: f64 = (0..n).map(|i| (0..n).map(|j| 0.5 * qd[i] * matrix[i][j] * qd[j]).sum::<f64>()).sum();
    kinetic + (build.potential_energy)(robot, q, g)
}

/// The fastest that any joint of the mechanism moves, at least 1.
fn rate(scale: &Scale, qd: &Joints, n: usize) -> f64 {
    scale.gain * sum(qd, n).max(1.0)
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn forward_dynamics_inverts_inverse_dynamics(arm in solid_arms(), state in states()) {
        let (robot, State { q, qd, qdd: tau, base }) = (arm.build(), &state);
        let n = robot.coordinates();
        for build in builds() {
            let qdd = (build.forward_dynamics)(&robot, q, qd, tau, base);
            let again = (build.inverse_dynamics)(&robot, q, qd, &qdd, base);
            let scale = Scale::of(&arm, &State { qdd, ..state.clone() });
            close(build.name, &again[..n], &tau[..n], ROUNDING * (scale.torque() + sum(tau, n)))?;
        }
    }

    #[test]
    fn mass_matrix_is_symmetric_and_positive_definite(arm in solid_arms(), state in states()) {
        let (robot, scale) = (arm.build(), Scale::of(&arm, &state));
        let bound = if arm.coupling.is_some() { ROUNDING * scale.mass_matrix() } else { 0.0 };
        for build in builds() {
            let matrix = square(&build.mass_matrix(&robot, &state.q), robot.coordinates());
            close(build.name, matrix.as_slice(), matrix.transpose().as_slice(), bound)?;
            prop_assert!(matrix.cholesky().is_some(), "{}", build.name);
        }
    }

    #[test]
    fn a_column_of_the_mass_matrix_is_a_unit_acceleration(arm in arms(), state in states()) {
        let (robot, still, scale) = (arm.build(), Joints::default(), Scale::of(&arm, &state));
        let n = robot.coordinates();
        for build in builds() {
            let matrix = build.mass_matrix(&robot, &state.q);
            for j in 0..n {
                let tau = (build.inverse_dynamics)(&robot, &state.q, &still, &unit(j), &weightless());
                close(build.name, &matrix[j][..n], &tau[..n], ROUNDING * scale.mass_matrix())?;
            }
        }
    }

    #[test]
    fn mass_matrix_rate_less_twice_coriolis_is_skew(arm in arms(), state in states()) {
        let (robot, scale) = (arm.build(), Scale::of(&arm, &state));
        let rate = rate(&scale, &state.qd, robot.coordinates());
        for build in builds() {
            let M_rate = mass_matrix_rate(&build, &robot, &state.q, &state.qd, rate);
            let N = M_rate - 2.0 * coriolis(&build, &robot, &state.q, &state.qd);
            let off = (&N + N.transpose()).amax();
            let bound = DIFFERENCE * rate * rate * scale.mass_matrix();
            prop_assert!(off <= bound, "{}: {off:e}, allowed {bound:e}", build.name);
        }
    }

    /// The joints' power is what the energy gains, d(T + U)/dt = τᵀ q̇, on a base at rest.
    #[test]
    fn power_is_the_rate_of_energy(arm in arms(), state in states()) {
        let (robot, g) = (arm.build(), state.gravity());
        let state = State { base: BaseMotion::at_rest(g), ..state };
        let (n, scale) = (robot.coordinates(), Scale::of(&arm, &state));
        let rate = rate(&scale, &state.qd, n).max(rate(&scale, &state.qdd, n));
        for build in builds() {
            let tau = (build.inverse_dynamics)(&robot, &state.q, &state.qd, &state.qdd, &state.base);
            let power: f64 = (0..n).map(|j| tau[j] * state.qd[j]).sum();
            let along = |t: f64| {
                let arc = Joints(core::array::from_fn(|i| state.q[i] + t * (state.qd[i] + t * state.qdd[i] / 2.0)));
                [energy(&build, &robot, &arc, &moved(&state.qd, t, &state.qdd), &g)]
            };
            let size = rate * (scale.moment() + rate * rate * scale.mass_matrix());
            close(build.name, &derivative(rate, along), &[power], DIFFERENCE * size)?;
        }
    }

    /// Gravity and a base that accelerates the other way are the same to the arm.
    #[test]
    fn base_acceleration_is_gravity(arm in arms(), state in states(), a in crate::arms::vector(10.0)) {
        let robot = arm.build();
        let g = state.gravity();
        let felt = BaseMotion { specific_force: SpecificForce(a - g.0), ..weightless() };
        let n = robot.coordinates();
        for build in builds() {
            let accelerated = (build.inverse_dynamics)(&robot, &state.q, &state.qd, &state.qdd, &felt);
            let tilted = BaseMotion::at_rest(Gravity(g.0 - a));
            let at_rest = (build.inverse_dynamics)(&robot, &state.q, &state.qd, &state.qdd, &tilted);
            prop_assert_eq!(&accelerated[..n], &at_rest[..n], "{}", build.name);
        }
    }
}
