//! The gravity torque: what it is equal to, and what follows from potential energy.

use crate::arms::{arms, states, vector};
use crate::builds::builds;
use crate::scale::{DIFFERENCE, ROUNDING, Scale, cases, close, derivative, moved, unit};
use gravcomp::{BaseMotion, Gravity, Joints, SpecificForce};
use nalgebra::Vector3;
use proptest::prelude::*;

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn equals_inverse_dynamics_at_rest(arm in arms(), state in states()) {
        let (robot, state) = (arm.build(), state.at_rest());
        let (n, scale) = (robot.coordinates(), Scale::of(&arm, &state));
        for build in builds() {
            let tau = (build.gravity_torque)(&robot, &state.q, &state.gravity());
            let dynamic = (build.inverse_dynamics)(&robot, &state.q, &state.qd, &state.qdd, &state.base);
            close(build.name, &tau[..n], &dynamic[..n], ROUNDING * scale.torque())?;
        }
    }

    #[test]
    fn is_the_slope_of_potential_energy(arm in arms(), state in states()) {
        let (robot, g, scale) = (arm.build(), state.gravity(), Scale::of(&arm, &state.at_rest()));
        for build in builds() {
            let tau = (build.gravity_torque)(&robot, &state.q, &g);
            for j in 0..robot.coordinates() {
                let energy = |t| [(build.potential_energy)(&robot, &moved(&state.q, t, &unit(j)), &g)];
                close(build.name, &derivative(scale.gain, energy), &[tau[j]], DIFFERENCE * scale.torque())?;
            }
        }
    }

    #[test]
    fn free_fall_needs_no_torque(arm in arms(), state in states()) {
        let (robot, still) = (arm.build(), Joints::default());
        let falling = BaseMotion { specific_force: SpecificForce(Vector3::zeros()), ..state.at_rest().base };
        for build in builds() {
            let tau = (build.gravity_torque)(&robot, &state.q, &Gravity(Vector3::zeros()));
            let dynamic = (build.inverse_dynamics)(&robot, &state.q, &still, &still, &falling);
            let wrench = (build.base_wrench)(&robot, &state.q, &still, &still, &falling);
            for j in 0..robot.coordinates() {
                prop_assert_eq!((tau[j], dynamic[j]), (0.0, 0.0), "{}", build.name);
            }
            prop_assert_eq!(wrench.amax(), 0.0, "{}", build.name);
        }
    }

    #[test]
    fn is_linear_in_g(arm in arms(), state in states(), other in vector(20.0), a in -3.0..3.0, b in -3.0..3.0) {
        let (robot, g) = (arm.build(), state.gravity().0);
        let (n, mut still) = (robot.coordinates(), state.at_rest());
        still.base.specific_force = SpecificForce(4.0 * Vector3::repeat(20.0));
        let bound = ROUNDING * Scale::of(&arm, &still).torque();
        for build in builds() {
            let tau = |g: Vector3<f64>| (build.gravity_torque)(&robot, &state.q, &Gravity(g));
            let (one, two) = (tau(g), tau(other));
            let sum: Vec<f64> = (0..n).map(|j| a * one[j] + b * two[j]).collect();
            close(build.name, &tau(a * g + b * other)[..n], &sum, bound)?;
        }
    }

    #[test]
    fn stiffness_is_its_slope_and_symmetric(arm in arms(), state in states()) {
        let (robot, g, scale) = (arm.build(), state.gravity(), Scale::of(&arm, &state.at_rest()));
        let n = robot.coordinates();
        for build in builds() {
            let stiffness = build.gravity_stiffness(&robot, &state.q, &g);
            for j in 0..n {
                let torque = |t| (build.gravity_torque)(&robot, &moved(&state.q, t, &unit(j)), &g).0;
                let slope = derivative(scale.gain, torque);
                let column: Vec<f64> = (0..n).map(|i| stiffness[i][j]).collect();
                close(build.name, &column, &slope[..n], DIFFERENCE * scale.stiffness())?;
                close("transpose", &column, &stiffness[j][..n], ROUNDING * scale.stiffness())?;
            }
        }
    }

    #[test]
    fn energy_is_that_of_the_whole_mass_at_its_centre(arm in arms(), state in states()) {
        let (robot, g) = (arm.build(), state.gravity());
        let mass: f64 = (0..robot.bodies()).map(|body| robot.inertia(body).mass()).sum();
        prop_assume!(mass > 0.0);
        let bound = ROUNDING * Scale::of(&arm, &state.at_rest()).moment();
        for build in builds() {
            let energy = (build.potential_energy)(&robot, &state.q, &g);
            let center = (build.center_of_mass)(&robot, &state.q);
            close(build.name, &[energy], &[-mass * g.0.dot(&center)], bound)?;
        }
    }
}
