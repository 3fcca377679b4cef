//! Any bits at all may come in: nothing panics, NaN goes in and NaN comes out, and angles may be huge.

use crate::arms::{State, arms, states};
use crate::builds::{WIDTH, builds};
use crate::same_bits::everything;
use crate::scale::{ROUNDING, Scale, cases, close};
use gravcomp::{BaseMotion, Gravity, Joint, Joints, MAX_JOINTS, SpecificForce};
use nalgebra::Vector3;
use proptest::prelude::*;

/// Any double: any bits, and those that trip programs up.
fn bits() -> impl Strategy<Value = f64> {
    let special =
        vec![0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE, 5e-324, 1e300];
    prop_oneof![3 => any::<u64>().prop_map(f64::from_bits), 1 => proptest::sample::select(special), 1 => -4.0..4.0]
}

fn any_joints() -> impl Strategy<Value = Joints> {
    proptest::array::uniform16(bits()).prop_map(Joints)
}

fn any_vector() -> impl Strategy<Value = Vector3<f64>> {
    proptest::array::uniform3(bits()).prop_map(Vector3::from)
}

fn any_state() -> impl Strategy<Value = State> {
    (any_joints(), any_joints(), any_joints(), any_vector(), any_vector(), any_vector()).prop_map(
        |(q, qd, qdd, f, angular_velocity, angular_acceleration)| State {
            q,
            qd,
            qdd,
            base: BaseMotion { specific_force: SpecificForce(f), angular_velocity, angular_acceleration },
        },
    )
}

/// Angles that the polynomial does not take.
fn huge() -> impl Strategy<Value = f64> {
    prop_oneof![Just(1e5), Just(-1e5), Just(1e300), Just(f64::MAX), 1e4..1e9]
}

const NOT_FINITE: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn nothing_panics(arm in arms(), state in any_state()) {
        let robot = arm.build();
        for build in builds() {
            let first = everything(&build, &robot, &state);
            prop_assert_eq!(first.len(), everything(&build, &robot, &state).len());
            let (q, g) = (state.q.map(|q| [q; WIDTH]), state.gravity().0);
            (build.gravity_torques)(&robot, &q, &[[g.x; WIDTH], [g.y; WIDTH], [g.z; WIDTH]]);
        }
    }

    /// A position that is no number makes no number of every effort that depends on it.
    #[test]
    fn a_bad_position_shows(arm in arms(), state in states(), pick in 0..MAX_JOINTS, bad in 0..3_usize) {
        let arm = arm.uncoupled();
        let (robot, mut q) = (arm.build(), state.q);
        let i = pick % robot.bodies();
        q[i] = NOT_FINITE[bad];
        for build in builds() {
            let held = (build.gravity_torque)(&robot, &q, &state.gravity());
            let tau = (build.inverse_dynamics)(&robot, &q, &state.qd, &state.qdd, &state.base);
            for j in arm.related(i) {
                prop_assert!(held[j].is_nan() && tau[j].is_nan(), "{}: joint {j}", build.name);
            }
            let qdd = (build.forward_dynamics)(&robot, &q, &state.qd, &state.qdd, &state.base);
            prop_assert!(qdd[..robot.bodies()].iter().all(|x| x.is_nan()), "{}: {qdd:?}", build.name);
            prop_assert!((build.potential_energy)(&robot, &q, &state.gravity()).is_nan());
            prop_assert!((build.center_of_mass)(&robot, &q).iter().any(|x| x.is_nan()));
            let pose = (build.forward_kinematics)(&robot, &q, &robot.link_frame(i));
            prop_assert!(pose.iter().any(|x| x.is_nan()));
            let wrench = (build.base_wrench)(&robot, &q, &state.qd, &state.qdd, &state.base);
            prop_assert!(wrench.iter().all(|x| x.is_nan()));
        }
    }

    /// A batch shows the same.
    #[test]
    fn a_bad_lane_is_a_bad_cycle(arm in arms(), state in any_state(), lane in 0..WIDTH) {
        let (robot, g) = (arm.build(), state.gravity());
        let mut q = [[0.0; WIDTH]; MAX_JOINTS];
        for i in 0..MAX_JOINTS {
            q[i][lane] = state.q[i];
        }
        for build in builds() {
            let many = (build.gravity_torques)(&robot, &q, &[[g.0.x; WIDTH], [g.0.y; WIDTH], [g.0.z; WIDTH]]);
            let single = (build.gravity_torque)(&robot, &state.q, &g);
            for j in 0..robot.coordinates() {
                prop_assert_eq!(many[j][lane].is_nan(), single[j].is_nan(), "{}: joint {}", build.name, j);
            }
        }
    }

    #[test]
    fn a_bad_gravity_shows_everywhere(arm in arms(), state in states(), axis in 0..3_usize, bad in 0..3_usize) {
        let (robot, mut g) = (arm.build(), state.gravity());
        g.0[axis] = NOT_FINITE[bad];
        for build in builds() {
            let held = (build.gravity_torque)(&robot, &state.q, &g);
            let energy = (build.potential_energy)(&robot, &state.q, &g);
            let finite = held[..robot.coordinates()].iter().filter(|x| x.is_finite()).count();
            prop_assert!(finite == 0 || bad != 0, "{}: {held:?}", build.name);
            prop_assert!(!energy.is_finite());
        }
    }

    #[test]
    fn a_bad_rate_or_acceleration_shows(arm in arms(), state in states(), pick in 0..MAX_JOINTS) {
        let arm = arm.uncoupled();
        let (robot, State { q, qd, qdd, base }) = (arm.build(), &state);
        let i = pick % robot.bodies();
        let bad = |x: &Joints| Joints(core::array::from_fn(|k| if k == i { f64::NAN } else { x[k] }));
        for build in builds() {
            prop_assert!((build.inverse_dynamics)(&robot, q, &bad(qd), qdd, base)[i].is_nan());
            prop_assert!((build.inverse_dynamics)(&robot, q, qd, &bad(qdd), base)[i].is_nan());
            prop_assert!((build.forward_dynamics)(&robot, q, qd, &bad(qdd), base)[i].is_nan());
        }
    }

    /// However far a joint has turned, only where it points matters.
    #[test]
    fn huge_angles_are_the_angles_they_are(arm in arms(), state in states(), turned in huge(), pick in 0..MAX_JOINTS) {
        let mut arm = arm.uncoupled();
        let moving = arm.moving();
        let i = pick % moving.len();
        arm.links[moving[i]].joint = Joint::Revolute;
        let robot = arm.build();
        let (mut far, mut near) = (state.q, state.q);
        far[i] = turned;
        near[i] = turned.sin().atan2(turned.cos());
        let bound = ROUNDING * Scale::of(&arm, &state.at_rest()).torque();
        for build in builds() {
            let [a, b] = [far, near].map(|q| (build.gravity_torque)(&robot, &q, &state.gravity()));
            close(build.name, &a[..robot.bodies()], &b[..robot.bodies()], bound)?;
        }
    }
}

#[test]
fn without_mass_there_is_no_centre_and_no_acceleration() {
    let mut builder = gravcomp::RobotBuilder::new();
    let row = gravcomp::DhRow { a: 1.0, ..gravcomp::DhRow::default() }.modified().expect("finite");
    let link = builder.link(&gravcomp::Frame::ROOT, Joint::Revolute, &row, &gravcomp::Inertia::ZERO);
    let robot = builder.build(gravcomp::Pose::IDENTITY, link.expect("one body"), None).expect("one body");
    let (q, tau) = (Joints::default(), Joints::from_slice(&[1.0]));
    for build in builds() {
        assert_eq!((build.gravity_torque)(&robot, &q, &Gravity::LEVEL)[0], 0.0);
        assert!((build.center_of_mass)(&robot, &q).iter().all(|x| x.is_nan()));
        assert!((build.forward_dynamics)(&robot, &q, &q, &tau, &BaseMotion::at_rest(Gravity::LEVEL))[0].is_nan());
    }
}
