//! The same inputs give the same bits, whatever was computed before and whatever lies beside them; the builds differ only
//! in rounding.

use crate::arms::{State, arms, joints, states};
use crate::builds::{Build, Fields, Lanes, PORTABLE, WIDTH, avx2, avx512_gravity_torques, builds};
use crate::scale::{Scale, cases, close};
use gravcomp::{Frame, Gravity, JacobianAxes, Joints, MAX_JOINTS, PARAMETERS, Robot};
use nalgebra::Vector3;
use proptest::prelude::*;

/// "A few ulps of the scale": the builds round differently, the scale bounds the terms generously.
const FEW_ULPS: f64 = 16.0 * f64::EPSILON;

/// All results of all entry points, as bits.
pub fn everything(build: &Build, robot: &Robot, state: &State) -> Vec<u64> {
    let State { q, qd, qdd, base } = state;
    let (n, g) = (robot.coordinates(), state.gravity());
    let mut Y = vec![0.0; n * PARAMETERS * robot.bodies()];
    let mut all: Vec<f64> = Vec::new();
    for joints in [
        (build.gravity_torque)(robot, q, &g),
        (build.inverse_dynamics)(robot, q, qd, qdd, base),
        (build.forward_dynamics)(robot, q, qd, qdd, base),
    ] {
        all.extend(&joints[..n]);
    }
    for matrix in [build.mass_matrix(robot, q), build.gravity_stiffness(robot, q, &g)] {
        all.extend(matrix[..n].iter().flat_map(|row| &row[..n]));
    }
    for axes in [JacobianAxes::Base, JacobianAxes::Frame] {
        all.extend(build.jacobian(robot, q, robot.tool(), axes)[..n].iter().flatten());
    }
    for frame in [*robot.tool(), Frame::BASE, Frame::ROOT, robot.link_frame(0)] {
        all.extend(&(build.forward_kinematics)(robot, q, &frame));
    }
    all.extend(&(build.base_wrench)(robot, q, qd, qdd, base));
    all.extend(&(build.center_of_mass)(robot, q));
    all.push((build.potential_energy)(robot, q, &g));
    (build.inverse_dynamics_regressor)(robot, q, qd, qdd, base, &mut Y);
    all.extend(&Y);
    (build.gravity_regressor)(robot, q, &g, &mut Y);
    all.extend(&Y);
    all.into_iter().map(f64::to_bits).collect()
}

/// `x` with everything beyond the robot's own entries replaced.
fn padded(x: &Joints, n: usize, padding: f64) -> Joints {
    Joints(core::array::from_fn(|i| if i < n { x[i] } else { padding }))
}

/// One configuration per lane, one gravity vector each.
fn in_lanes(q: &[Joints; WIDTH], g: &[Vector3<f64>; WIDTH]) -> (Lanes, Fields) {
    (core::array::from_fn(|i| q.map(|q| q[i])), core::array::from_fn(|k| g.map(|g| g[k])))
}

fn many() -> impl Strategy<Value = ([Joints; WIDTH], [Vector3<f64>; WIDTH])> {
    let one = (joints(4.0), crate::arms::vector(20.0));
    proptest::collection::vec(one, WIDTH)
        .prop_map(|all| (core::array::from_fn(|l| all[l].0), core::array::from_fn(|l| all[l].1)))
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn nothing_is_remembered(arm in arms(), state in states(), other in states()) {
        let robot = arm.build();
        for build in builds() {
            let first = everything(&build, &robot, &state);
            let between = everything(&build, &robot, &other);
            prop_assert_eq!(&first, &everything(&build, &robot.clone(), &state), "{}", build.name);
            prop_assert_eq!(&between, &everything(&build, &arm.build(), &other), "{}", build.name);
        }
    }

    #[test]
    fn entries_beyond_the_robots_own_are_ignored(arm in arms(), state in states(), bits in any::<u64>()) {
        let (robot, n) = (arm.build(), arm.coordinates());
        for padding in [0.0, f64::NAN, 1e300, f64::from_bits(bits)] {
            let [q, qd, qdd] = [state.q, state.qd, state.qdd].map(|x| padded(&x, n, padding));
            let beside = State { q, qd, qdd, base: state.base };
            for build in builds() {
                let [a, b] = [&state, &beside].map(|state| everything(&build, &robot, state));
                prop_assert_eq!(a, b, "{} beside {}", build.name, padding);
            }
        }
    }

    #[test]
    fn builds_differ_by_a_few_ulps(arm in arms(), state in states()) {
        let (robot, scale, g) = (arm.build(), Scale::of(&arm, &state), state.gravity());
        let (n, State { q, qd, qdd, base }) = (robot.coordinates(), &state);
        if let Some(other) = avx2() {
            let pair = [PORTABLE, other];
            let [a, b] = pair.map(|build| (build.gravity_torque)(&robot, q, &g));
            close("gravity", &a[..n], &b[..n], FEW_ULPS * scale.torque())?;
            let [a, b] = pair.map(|build| (build.inverse_dynamics)(&robot, q, qd, qdd, base));
            close("dynamics", &a[..n], &b[..n], FEW_ULPS * scale.torque())?;
            let [a, b] = pair.map(|build| build.mass_matrix(&robot, q));
            close("M", a[..n].as_flattened(), b[..n].as_flattened(), FEW_ULPS * scale.mass_matrix())?;
            let [a, b] = pair.map(|build| build.gravity_stiffness(&robot, q, &g));
            close("K", a[..n].as_flattened(), b[..n].as_flattened(), FEW_ULPS * scale.stiffness())?;
            let [a, b] = pair.map(|build| (build.forward_kinematics)(&robot, q, robot.tool()));
            close("tool", a.as_slice(), b.as_slice(), FEW_ULPS * scale.lever)?;
            let [a, b] = pair.map(|build| (build.base_wrench)(&robot, q, qd, qdd, base));
            close("wrench", a.as_slice(), b.as_slice(), FEW_ULPS * scale.moment())?;
        }
    }

    /// A batch computes what a cycle computes.
    #[test]
    fn lanes_are_single_cycles(arm in arms(), (q, g) in many()) {
        let (robot, (positions, fields)) = (arm.build(), in_lanes(&q, &g));
        for build in builds() {
            let tau = (build.gravity_torques)(&robot, &positions, &fields);
            for l in 0..WIDTH {
                let single = (build.gravity_torque)(&robot, &q[l], &Gravity(g[l]));
                for i in 0..robot.coordinates() {
                    prop_assert_eq!(tau[i][l].to_bits(), single[i].to_bits(), "{}: joint {} lane {}", build.name, i, l);
                }
            }
        }
    }

    /// An angle beyond the polynomial's range in one lane changes the others by no more than their sines' last bits.
    #[test]
    fn a_huge_angle_in_one_lane_leaves_the_others(arm in arms(), (mut q, g) in many(), lane in 0..WIDTH, bits in any::<u64>()) {
        let robot = arm.build();
        q[lane] = Joints([f64::from_bits(bits); MAX_JOINTS]);
        let (positions, fields) = in_lanes(&q, &g);
        for build in builds() {
            let tau = (build.gravity_torques)(&robot, &positions, &fields);
            for l in (0..WIDTH).filter(|&l| l != lane) {
                let state = State { q: q[l], qd: q[l], qdd: q[l], base: gravcomp::BaseMotion::at_rest(Gravity(g[l])) };
                let single = (build.gravity_torque)(&robot, &q[l], &Gravity(g[l]));
                let found: Vec<f64> = (0..robot.coordinates()).map(|i| tau[i][l]).collect();
                let bound = FEW_ULPS * Scale::of(&arm, &state).torque();
                close(build.name, &found, &single[..robot.coordinates()], bound)?;
            }
        }
    }

    #[test]
    fn the_widest_batch_kernel_agrees(arm in arms(), (q, g) in many()) {
        let (robot, (positions, fields)) = (arm.build(), in_lanes(&q, &g));
        for (wide, build) in avx512_gravity_torques().into_iter().zip(avx2()) {
            let (a, b) = (wide(&robot, &positions, &fields), (build.gravity_torques)(&robot, &positions, &fields));
            for i in 0..robot.coordinates() {
                prop_assert_eq!(a[i], b[i]);
            }
        }
    }
}
