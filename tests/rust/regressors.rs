//! Torque is linear in the inertial parameters: τ = Y π, payload and fixed links included.

use crate::arms::{State, arms, body, states};
use crate::builds::{Build, builds};
use crate::scale::{ROUNDING, Scale, cases, close};
use gravcomp::{GRAVITY_PARAMETERS, JacobianAxes, PARAMETERS, Robot};
use proptest::prelude::*;

/// The parameters of all moving links, the first `each` of every link.
fn parameters(robot: &Robot, each: usize) -> Vec<f64> {
    (0..robot.bodies()).flat_map(|body| robot.inertia(body).parameters().into_iter().take(each)).collect()
}

/// Y π for Y row by row.
fn product(Y: &[f64], parameters: &[f64]) -> Vec<f64> {
    Y.chunks_exact(parameters.len()).map(|row| row.iter().zip(parameters).map(|(y, p)| y * p).sum()).collect()
}

fn full_regressor(build: &Build, robot: &Robot, state: &State) -> Vec<f64> {
    let mut Y = vec![f64::NAN; robot.coordinates() * PARAMETERS * robot.bodies()];
    (build.inverse_dynamics_regressor)(robot, &state.q, &state.qd, &state.qdd, &state.base, &mut Y);
    Y
}

fn gravity_regressor(build: &Build, robot: &Robot, state: &State) -> Vec<f64> {
    let mut Y = vec![f64::NAN; robot.coordinates() * GRAVITY_PARAMETERS * robot.bodies()];
    (build.gravity_regressor)(robot, &state.q, &state.gravity(), &mut Y);
    Y
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn times_the_parameters_is_the_torque(arm in arms(), state in states(), payload in body(0.0)) {
        let (mut robot, scale) = (arm.build(), Scale::of(&arm, &state).with(&payload));
        robot.set_payload(payload);
        let (n, bound) = (robot.coordinates(), ROUNDING * scale.torque());
        for build in builds() {
            let tau = (build.inverse_dynamics)(&robot, &state.q, &state.qd, &state.qdd, &state.base);
            let Y = full_regressor(&build, &robot, &state);
            close(build.name, &product(&Y, &parameters(&robot, PARAMETERS)), &tau[..n], bound)?;
            let tau = (build.gravity_torque)(&robot, &state.q, &state.gravity());
            let Y = gravity_regressor(&build, &robot, &state);
            close(build.name, &product(&Y, &parameters(&robot, GRAVITY_PARAMETERS)), &tau[..n], bound)?;
        }
    }

    /// The two regressors share their first four columns per link where nothing moves.
    #[test]
    fn the_gravity_regressor_is_a_part_of_the_full_one(arm in arms(), state in states()) {
        let (robot, state) = (arm.build(), state.at_rest());
        for build in builds() {
            let full = full_regressor(&build, &robot, &state);
            let some: Vec<f64> = full.chunks_exact(PARAMETERS).flat_map(|link| &link[..GRAVITY_PARAMETERS]).copied().collect();
            prop_assert_eq!(some, gravity_regressor(&build, &robot, &state), "{}", build.name);
        }
    }

    /// A buffer that is too short gets whole rows, and nothing panics.
    #[test]
    fn a_short_buffer_is_left_alone(arm in arms(), state in states(), missing in 1..40_usize) {
        let robot = arm.build();
        let (n, bodies) = (robot.coordinates(), robot.bodies());
        let State { q, qd, qdd, base } = &state;
        let (tool, g) = (robot.tool(), state.gravity());
        for build in builds() {
            let untouched = |size: usize, compute: &dyn Fn(&mut [f64])| {
                let mut short = vec![f64::NAN; size.saturating_sub(missing)];
                compute(&mut short);
                short.iter().all(|x| x.is_nan())
            };
            let regressor = untouched(n * PARAMETERS * bodies, &|out| {
                (build.inverse_dynamics_regressor)(&robot, q, qd, qdd, base, out);
            });
            prop_assert!(regressor);
            let gravity = untouched(n * GRAVITY_PARAMETERS * bodies, &|out| (build.gravity_regressor)(&robot, q, &g, out));
            prop_assert!(gravity);
            prop_assert!(untouched(n * n, &|out| (build.write_mass_matrix)(&robot, q, out)));
            prop_assert!(untouched(n * n, &|out| (build.write_gravity_stiffness)(&robot, q, &g, out)));
            prop_assert!(untouched(6 * n, &|out| (build.write_jacobian)(&robot, q, tool, JacobianAxes::Base, out)));
        }
    }
}
