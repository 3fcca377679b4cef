//! A coupling changes what the user commands, not what the mechanism does: q_mechanism = C q + c₀, τ = Cᵀ τ_mechanism.

use crate::arms::{Arm, Mimics, State, arms, states};
use crate::builds::{Build, JointMatrix, builds};
use crate::scale::{ROUNDING, Scale, cases, close};
use gravcomp::{JacobianAxes, Joints};
use nalgebra::{DMatrix, Vector6};
use proptest::prelude::*;

fn coupled_arms() -> impl Strategy<Value = (Arm, Mimics)> {
    arms().prop_filter_map("uncoupled", |arm| arm.coupling.clone().map(|coupling| (arm, coupling)))
}

/// What the mechanism does when the coordinates do `state`.
fn seen_by_mechanism(arm: &Arm, state: &State) -> State {
    State {
        q: arm.mechanism(&state.q, true),
        qd: arm.mechanism(&state.qd, false),
        qdd: arm.mechanism(&state.qdd, false),
        base: state.base,
    }
}

/// Cᵀ τ.
fn transposed(C: &Mimics, tau: &Joints) -> Vec<f64> {
    let columns = 0..C.matrix[0].len();
    columns.map(|j| C.matrix.iter().zip(tau.iter()).map(|(row, tau)| row[j] * tau).sum()).collect()
}

/// Cᵀ A C, row by row.
fn congruent(C: &Mimics, A: &JointMatrix) -> Vec<f64> {
    let (rows, columns) = (C.matrix.len(), C.matrix[0].len());
    let C = DMatrix::from_fn(rows, columns, |i, j| C.matrix[i][j]);
    let A = DMatrix::from_fn(rows, rows, |i, j| A[i][j]);
    (C.transpose() * A * C).as_slice().to_vec()
}

fn corner(A: &JointMatrix, n: usize) -> Vec<f64> {
    A[..n].iter().flat_map(|row| &row[..n]).copied().collect()
}

fn dot(a: &Joints, b: &Joints, n: usize) -> f64 {
    (0..n).map(|i| a[i] * b[i]).sum()
}

/// Σ_k C_kj J_k, for all entries of column j.
fn mixed_columns(build: &Build, arm: &Arm, C: &Mimics, outer: &State, inner: &State) -> [Vec<f64>; 2] {
    let (robot, free) = (arm.build(), arm.uncoupled().build());
    let found = build.jacobian(&robot, &outer.q, robot.tool(), JacobianAxes::Base);
    let mechanism = build.jacobian(&free, &inner.q, free.tool(), JacobianAxes::Base);
    let n = robot.coordinates();
    let column = |j: usize| C.matrix.iter().zip(&mechanism).map(|(row, J)| row[j] * J).sum::<Vector6<f64>>();
    let wanted = (0..n).flat_map(|j| column(j).as_slice().to_vec()).collect();
    [found[..n].iter().flat_map(|J| J.as_slice().to_vec()).collect(), wanted]
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn efforts_map_by_the_transpose_and_power_stays((arm, C) in coupled_arms(), outer in states()) {
        let (robot, free) = (arm.build(), arm.uncoupled().build());
        let (inner, scale) = (seen_by_mechanism(&arm, &outer), Scale::of(&arm, &outer));
        let (n, bodies) = (robot.coordinates(), robot.bodies());
        for build in builds() {
            let tau = (build.inverse_dynamics)(&robot, &outer.q, &outer.qd, &outer.qdd, &outer.base);
            let tau_mechanism = (build.inverse_dynamics)(&free, &inner.q, &inner.qd, &inner.qdd, &inner.base);
            close(build.name, &tau[..n], &transposed(&C, &tau_mechanism), ROUNDING * scale.torque())?;
            let (power, spent) = (dot(&tau, &outer.qd, n), dot(&tau_mechanism, &inner.qd, bodies));
            let speed = crate::scale::sum(&outer.qd, n) * scale.torque();
            close("power", &[power], &[spent], ROUNDING * speed)?;
            let held = (build.gravity_torque)(&robot, &outer.q, &outer.gravity());
            let holding = (build.gravity_torque)(&free, &inner.q, &outer.gravity());
            close("gravity", &held[..n], &transposed(&C, &holding), ROUNDING * scale.torque())?;
        }
    }

    #[test]
    fn matrices_map_by_congruence((arm, C) in coupled_arms(), outer in states()) {
        let (robot, free, g) = (arm.build(), arm.uncoupled().build(), outer.gravity());
        let (inner, scale, n) = (seen_by_mechanism(&arm, &outer), Scale::of(&arm, &outer), robot.coordinates());
        for build in builds() {
            let M = corner(&build.mass_matrix(&robot, &outer.q), n);
            let wanted = congruent(&C, &build.mass_matrix(&free, &inner.q));
            close(build.name, &M, &wanted, ROUNDING * scale.mass_matrix())?;
            let K = corner(&build.gravity_stiffness(&robot, &outer.q, &g), n);
            let wanted = congruent(&C, &build.gravity_stiffness(&free, &inner.q, &g));
            close(build.name, &K, &wanted, ROUNDING * scale.stiffness())?;
        }
    }

    #[test]
    fn places_and_energies_stay((arm, C) in coupled_arms(), outer in states()) {
        let (robot, free, g) = (arm.build(), arm.uncoupled().build(), outer.gravity());
        let (inner, scale) = (seen_by_mechanism(&arm, &outer), Scale::of(&arm, &outer));
        for build in builds() {
            let [found, wanted] = [(&robot, &outer), (&free, &inner)]
                .map(|(robot, state)| (build.forward_kinematics)(robot, &state.q, robot.tool()));
            close(build.name, found.as_slice(), wanted.as_slice(), ROUNDING * scale.lever)?;
            let [found, wanted] = [(&robot, &outer), (&free, &inner)]
                .map(|(robot, state)| [(build.potential_energy)(robot, &state.q, &g)]);
            close(build.name, &found, &wanted, ROUNDING * scale.moment())?;
            let [found, wanted] = [(&robot, &outer), (&free, &inner)]
                .map(|(robot, s)| (build.base_wrench)(robot, &s.q, &s.qd, &s.qdd, &s.base));
            close(build.name, found.as_slice(), wanted.as_slice(), ROUNDING * scale.moment())?;
            let [found, wanted] = mixed_columns(&build, &arm, &C, &outer, &inner);
            close(build.name, &found, &wanted, ROUNDING * scale.jacobian())?;
        }
    }
}
