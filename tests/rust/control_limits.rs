//! Every limit: broken without it, kept with it, whatever comes in.
#![allow(clippy::large_types_passed_by_value)] // settings are built where they are passed

use crate::arms::arms;
use crate::control::{Rig, each, plain, raven_cables, two_rods};
use crate::disturbance::one_of_each;
use crate::scale::cases;
use gravcomp::control::{Event, Law, OnFault, Settings, SettingsError, Side, State};
use gravcomp::{BaseMotion, Controller, Gravity, Joints, MAX_JOINTS};
use gravcomp::{SpecificForce, control::Kernels};
use nalgebra::Vector3;
use proptest::collection::vec;
use proptest::prelude::*;

const LIMITED: Joints = Joints([7.0; MAX_JOINTS]);
const INFINITE: Joints = Joints([f64::INFINITY; MAX_JOINTS]);

/// A number as it is usual, or any 64 bits.
fn anything() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -3.0..3.0,
        1 => -1e9..1e9,
        1 => any::<u64>().prop_map(f64::from_bits),
        1 => prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::MAX), Just(-f64::MAX), Just(1e9), Just(f64::MIN_POSITIVE)],
    ]
}

/// A cycle in which anything may come in, often only one number of many: joint state, target, base, and an order.
#[derive(Clone, Debug)]
struct Cycle {
    usual: f64,
    odd: f64,
    place: usize,
    order: u8,
}

fn cycle() -> impl Strategy<Value = Cycle> {
    (-3.0..3.0, anything(), 0..64_usize, any::<u8>()).prop_map(|(usual, odd, place, order)| Cycle {
        usual,
        odd,
        place,
        order,
    })
}

impl Cycle {
    fn enter(&self, rig: &mut Rig) {
        let usual = |k: f64| each(|j| self.usual * (1.0 + (k + j) / 16.0));
        (rig.q, rig.qd, rig.q_desired, rig.qd_desired) = (usual(0.0), Some(usual(1.0)), usual(2.0), usual(3.0));
        rig.base.specific_force = SpecificForce(Vector3::new(self.usual, 0.0, 9.8));
        (rig.base.angular_velocity, rig.base.angular_acceleration) = (Vector3::zeros(), Vector3::repeat(self.usual));
        match self.place {
            k @ 0..16 => rig.q[k % 4] = self.odd,
            k @ 16..24 => rig.qd.as_mut().expect("just given")[k % 4] = self.odd,
            24..28 => rig.qd = None,
            k @ 28..40 => rig.q_desired[k % 4] = self.odd,
            k @ 40..48 => rig.qd_desired[k % 4] = self.odd,
            k @ 48..52 => rig.base.specific_force.0[k % 3] = self.odd,
            k @ 52..56 => rig.base.angular_velocity[k % 3] = self.odd,
            k @ 56..60 => rig.base.angular_acceleration[k % 3] = self.odd,
            _ => {}
        }
        match self.order {
            0..4 => rig.controller.disarm(),
            4..32 => rig.controller.arm(),
            32..40 => rig.controller.acknowledge(),
            40..44 => rig.controller.skip(u32::from(self.order) * 1000),
            _ => {}
        }
    }
}

fn settings() -> impl Strategy<Value = Settings> {
    let choices = (0..5_usize, any::<[bool; 8]>(), prop_oneof![Just(0.0), 0.001..0.05], 1e-3..1e5);
    (choices, 1.0..1e5, 0.0..0.02).prop_map(|((law, yes, ramp_s, size), rate_hz, hold_s)| {
        let if_so = |yes, x: f64| if yes { Joints([x; MAX_JOINTS]) } else { INFINITE };
        let modulus = if_so(yes[3], 6.0);
        Settings {
            tau_max: if_so(yes[0], size),
            tau_rate_max: if_so(yes[1], 10.0 * size),
            jump: if_so(yes[2], 2.9),
            modulus,
            limits: if yes[4] {
                (Joints([-1.0; MAX_JOINTS]), Joints([1.5; MAX_JOINTS]))
            } else {
                (Joints(INFINITE.map(|x| -x)), INFINITE)
            },
            kp: Joints([if yes[5] { 1e30 } else { 300.0 }; MAX_JOINTS]),
            on_fault: if yes[6] { OnFault::Decay } else { OnFault::Gravity },
            ramp_s,
            hold_s,
            rate_hz,
            ..plain(Law::ALL[law], 1)
        }
    })
}

proptest! {
    #![proptest_config(cases(400))]

    /// The harness checks each step: finite, within limits, within rate, to the last bit.
    #[test]
    fn no_input_breaks_a_limit(
        arm in arms(),
        settings in settings(),
        disturbs in any::<bool>(),
        cycles in vec(cycle(), 1..400),
    ) {
        let n = arm.coordinates();
        let mut rig = Rig::new(&arm.build(), Settings { coordinates: n, ..settings });
        rig.disturbances = disturbs.then(|| Box::new(one_of_each(n).expect("elements that make sense")));
        for cycle in &cycles {
            cycle.enter(&mut rig);
            rig.step();
        }
        let counters = rig.controller.counters();
        prop_assert_eq!(counters.cycles, cycles.len() as u64);
        prop_assert!(counters.events.iter().all(|count| *count <= counters.cycles));
    }

    #[test]
    fn nor_on_either_side_of_a_transmission(settings in settings(), sides in any::<[bool; 2]>(), cycles in vec(cycle(), 1..200)) {
        let [feedback, output] = sides.map(|motor| if motor { Side::Motor } else { Side::Joint });
        let three = Settings { coordinates: 3, feedback, output, transmission: Some(raven_cables()), ..settings };
        let mut rig = Rig::new(&crate::control::three_joints(), three);
        for cycle in &cycles {
            cycle.enter(&mut rig);
            rig.step();
        }
    }

    #[test]
    fn targets_are_kept_within_the_limits_and_do_not_move_on_outwards(target in -9.0..9.0, speed in -9.0..9.0) {
        let limits = (Joints([-1.0; MAX_JOINTS]), Joints([1.5; MAX_JOINTS]));
        let torque = |settings: Settings| {
            let mut rig = Rig::new(&two_rods(), settings).armed();
            (rig.q_desired, rig.qd_desired) = (Joints([target; MAX_JOINTS]), Joints([speed; MAX_JOINTS]));
            (rig.step().tau_pd[0], rig.sees(Event::TargetLimit))
        };
        let (free, kept) = (torque(plain(Law::Pd, 2)), torque(Settings { limits, ..plain(Law::Pd, 2) }));
        prop_assert_eq!(free, (100.0 * target + 5.0 * speed, false));
        let outside = !(-1.0..=1.5).contains(&target);
        let on = if target < -1.0 { speed.max(0.0) } else if target > 1.5 { speed.min(0.0) } else { speed };
        prop_assert_eq!(kept, (100.0 * target.clamp(-1.0, 1.5) + 5.0 * on, outside));
    }
}

/// A step of the target by 1 rad under these settings: the torque of joint 0, and the events of the step.
fn after_a_step(settings: Settings) -> (f64, Vec<Event>) {
    let mut rig = Rig::new(&two_rods(), Settings { law: Law::Pd, ..settings }).armed();
    rig.step();
    rig.q_desired[0] = 1.0;
    let tau = rig.step().tau[0];
    (tau, rig.controller.status().seen.iter().collect())
}

#[test]
fn the_torque_limit_is_broken_without_it_and_kept_with_it() {
    let free = plain(Law::Pd, 2);
    assert_eq!(after_a_step(free), (100.0, vec![]));
    assert_eq!(after_a_step(Settings { tau_max: LIMITED, ..free }), (7.0, vec![Event::TorqueLimit]));
}

#[test]
fn the_rate_limit_is_broken_without_it_and_kept_with_it() {
    let slow = Settings { tau_rate_max: Joints([2000.0; MAX_JOINTS]), ..plain(Law::Pd, 2) };
    assert_eq!(after_a_step(slow), (2.0, vec![Event::TorqueRate]));
    let both = Settings { tau_max: LIMITED, ..slow };
    assert_eq!(after_a_step(both), (2.0, vec![Event::TorqueLimit, Event::TorqueRate]));
}

#[test]
fn a_target_that_is_none_leaves_the_last_one_and_before_it_the_pose() {
    let mut rig = Rig::new(&two_rods(), plain(Law::Pd, 2)).armed();
    (rig.q[0], rig.q_desired[1]) = (0.5, f64::NAN);
    assert_eq!(rig.step().tau_pd, Joints::default());
    assert!(rig.sees(Event::Target));
    rig.q_desired = Joints::from_slice(&[1.0, 0.0]);
    let good = rig.step();
    for bad in [f64::NAN, f64::INFINITY, -1.1e9] {
        rig.q_desired[0] = bad;
        assert_eq!(rig.step(), good);
        (rig.q_desired[0], rig.qd_desired[1]) = (1.0, bad);
        assert_eq!(rig.step(), good);
        rig.qd_desired[1] = 0.0;
    }
    assert_eq!(rig.controller.counters().of(Event::Target), 7);
}

#[test]
fn joints_outside_their_limits_are_seen() {
    let limits = (Joints([-1.0; MAX_JOINTS]), Joints([1.5; MAX_JOINTS]));
    let mut rig = Rig::new(&two_rods(), Settings { limits, ..plain(Law::Passive, 2) }).armed();
    for (q, outside) in [(0.0, false), (1.5, false), (1.6, true), (-1.0, false), (-1.1, true)] {
        rig.q[1] = q;
        rig.step();
        assert_eq!(rig.sees(Event::JointLimit), outside, "{q}");
    }
    assert_eq!(rig.state(), State::Armed);
}

#[test]
fn the_largest_numbers_stay_finite() {
    let largest =
        Settings { kp: Joints([1e30; MAX_JOINTS]), kd: Joints([1e30; MAX_JOINTS]), ..plain(Law::PdBaseMotion, 2) };
    let mut rig = Rig::new(&two_rods(), Settings { rate_hz: 1e5, ..largest }).armed();
    rig.qd = None;
    for sign in [1.0, -1.0, 1.0] {
        (rig.q, rig.q_desired) = (Joints([sign * 1e9; MAX_JOINTS]), Joints([-sign * 1e9; MAX_JOINTS]));
        rig.base = BaseMotion {
            specific_force: Gravity(Vector3::repeat(1e6)).into(),
            angular_velocity: Vector3::repeat(1e6),
            angular_acceleration: Vector3::repeat(-1e6),
        };
        rig.step();
        assert!(!rig.sees(Event::Absent) && !rig.sees(Event::BaseMotion) && !rig.sees(Event::Overflow));
    }
}

/// Settings that cannot be meant, and the field, joint and value that the error names.
fn impossible() -> Vec<(Settings, &'static str, Option<usize>, f64)> {
    let good = plain(Law::PdDynamicGravity, 2);
    let second = |x: f64, rest: f64| Joints(std::array::from_fn(|j| if j == 1 { x } else { rest }));
    let mut wrong = Vec::new();
    for bad in [-1.0, f64::NAN, f64::INFINITY, 2e30] {
        wrong.push((Settings { kp: second(bad, 1.0), ..good }, "kp", Some(1), bad));
        wrong.push((Settings { kd: second(bad, 1.0), ..good }, "kd", Some(1), bad));
    }
    for bad in [-1.0, f64::NAN, f64::NEG_INFINITY] {
        wrong.push((Settings { tau_max: second(bad, 1.0), ..good }, "tau_max", Some(1), bad));
    }
    for bad in [0.0, -1.0, f64::NAN] {
        wrong.push((Settings { tau_rate_max: second(bad, 1.0), ..good }, "tau_rate_max", Some(1), bad));
        wrong.push((Settings { jump: second(bad, 1.0), ..good }, "jump", Some(1), bad));
        wrong.push((Settings { modulus: second(bad, 1.0), ..good }, "wrap", Some(1), bad));
        wrong.push((Settings { rate_hz: bad, ..good }, "rate_hz", None, bad));
    }
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        wrong.push((Settings { ramp_s: bad, ..good }, "ramp_s", None, bad));
        wrong.push((Settings { hold_s: bad, ..good }, "hold_s", None, bad));
    }
    let crossing = (second(1.0, -1.0), second(0.5, 1.0));
    wrong.push((Settings { limits: crossing, ..good }, "limits (upper)", Some(1), 0.5));
    wrong.push((Settings { limits: (second(f64::NAN, 0.0), INFINITE), ..good }, "limits (lower)", Some(1), f64::NAN));
    let wide = Settings { jump: second(0.6, 0.1), modulus: Joints([1.0; MAX_JOINTS]), ..good };
    wrong.push((wide, "jump", Some(1), 0.6));
    wrong.push((Settings { coordinates: 0, ..good }, "coordinates", None, 0.0));
    wrong.push((Settings { coordinates: 17, ..good }, "coordinates", None, 17.0));
    wrong.push((Settings { feedback: Side::Motor, ..good }, "feedback", None, f64::NAN));
    wrong.push((Settings { output: Side::Motor, ..good }, "output", None, f64::NAN));
    wrong.push((Settings { transmission: Some(raven_cables()), ..good }, "transmission (motors)", None, 3.0));
    wrong
}

#[test]
fn what_cannot_be_meant_is_refused_with_its_field_joint_and_value() {
    for (settings, field, joint, value) in impossible() {
        let refused = Controller::new(settings, Kernels::PORTABLE).expect_err(field);
        let SettingsError { value: found, wanted, .. } = refused;
        assert_eq!((refused.field, refused.joint), (field, joint));
        assert!(found == value || found.is_nan() && value.is_nan(), "{refused}");
        let whose = joint.map_or(String::new(), |joint| format!(" of joint {joint}"));
        assert_eq!(refused.to_string(), format!("{field}{whose} is {found:?}; it should be {wanted}"));
    }
    assert!(Controller::new(plain(Law::PdDynamicGravity, 2), Kernels::PORTABLE).is_ok());
}
