//! Encoders: unwrapping undoes wrapping, jumps and absences are not used, rates are first differences.
#![allow(clippy::large_types_passed_by_value)] // settings are built where they are passed

use crate::control::{Rig, plain, two_rods};
use crate::scale::cases;
use gravcomp::control::{Event, Law, Settings, Side, State};
use gravcomp::{Joints, MAX_JOINTS, Transmission};
use proptest::collection::vec;
use proptest::prelude::*;

fn reading(settings: Settings) -> Rig {
    let mut rig = Rig::new(&two_rods(), settings).armed();
    rig.qd = None;
    rig
}

proptest! {
    #![proptest_config(cases(300))]

    /// Any motion in steps below half a modulus, wrapped to [0, M) or (−M/2, M/2], comes out as it went in.
    #[test]
    fn unwrapping_undoes_wrapping(
        modulus in 0.01..100.0, start in -0.5..0.5, steps in vec((-0.499..0.499, 1_u32..4), 1..300), centred in any::<bool>(),
    ) {
        let mut rig = reading(Settings { modulus: Joints([modulus; MAX_JOINTS]), hold_s: 1.0, ..plain(Law::PdDynamicGravity, 2) });
        let wrap = |x: f64| if centred { x - modulus * (x / modulus).round() } else { x - modulus * (x / modulus).floor() };
        let mut x = modulus * start;
        rig.q = Joints([wrap(x); MAX_JOINTS]);
        // What the first reading leaves open is a whole number of turns.
        let turns = rig.step().q[0] - x;
        for (step, age) in steps {
            // A missing reading in between is bridged, as long as the arm stays within half a turn.
            rig.q = Joints([f64::NAN; MAX_JOINTS]);
            (1..age).for_each(|_| { rig.step(); });
            let last = x;
            x += modulus * step;
            rig.q = Joints([wrap(x); MAX_JOINTS]);
            let out = rig.step();
            let size = 1e-12 * (x.abs() + modulus);
            prop_assert!((out.q[1] - turns - x).abs() <= size, "{} for {x}, turns {turns}", out.q[1]);
            let rate = (x - last) / (f64::from(age) * 1e-3);
            let (kd, target) = (rig.controller.settings().kd[0], rig.controller.settings().kp[0] * (0.0 - out.q[0]));
            let damping = out.tau_pd[0] - target;
            prop_assert!((damping + kd * rate).abs() <= 1e4 * kd * size + 1e-9 * target.abs(), "{damping} for {rate}");
        }
        prop_assert_eq!(rig.state(), State::Armed);
    }

    /// A jump is not used; what comes back from it is.
    #[test]
    fn a_jump_is_not_used(jump in 0.001..0.1, factor in 1.01..1e3, missing in 0_u32..5) {
        let mut rig = reading(Settings { jump: Joints([jump; MAX_JOINTS]), ..plain(Law::PdDynamicGravity, 2) });
        let good = rig.step();
        rig.q[0] = jump * 0.99;
        prop_assert_eq!(rig.step().q[0], jump * 0.99);
        rig.q[0] = f64::NAN;
        (0..missing).for_each(|_| { rig.step(); });
        let allowed = jump * f64::from(missing + 1);
        rig.q[0] = jump * 0.99 + allowed * factor;
        prop_assert_eq!(rig.step().q[0], jump * 0.99);
        prop_assert!(rig.sees(Event::Jump));
        rig.q[0] = good.q[0];
        prop_assert_eq!(rig.step().q[0], good.q[0]);
        prop_assert!(!rig.sees(Event::Jump));
    }
}

#[test]
fn without_the_check_a_jump_goes_into_the_torque() {
    let torque = |jump: f64| {
        let mut rig = reading(Settings { jump: Joints([jump; MAX_JOINTS]), ..plain(Law::Pd, 2) });
        rig.step();
        rig.q[0] = 1.0;
        rig.step().tau[0]
    };
    assert_eq!((torque(f64::INFINITY), torque(0.01)), (-100.0 - 5.0 * 1000.0, 0.0));
}

#[test]
fn a_jump_that_stays_is_a_fault_and_then_the_new_pose() {
    let mut rig = reading(Settings { jump: Joints([0.01; MAX_JOINTS]), ..plain(Law::PdDynamicGravity, 2) });
    rig.steps(10);
    rig.q[0] = 2.0;
    rig.steps(60);
    assert_eq!((rig.state(), rig.controller.output().q[0]), (State::Fault, 0.0));
    rig.controller.acknowledge();
    assert_eq!(rig.steps(200).q[0], 2.0);
    assert_eq!(rig.state(), State::Fault, "acknowledged before the joint state was good");
    rig.controller.acknowledge();
    rig.step();
    assert_eq!(rig.state(), State::Armed);
}

#[test]
fn an_encoder_that_wraps_reads_within_its_modulus() {
    let mut rig = reading(Settings { modulus: Joints([1.0; MAX_JOINTS]), ..plain(Law::Pd, 2) });
    for (raw, good) in [(0.0, true), (1.0, true), (-0.5, true), (1.01, false), (7.0, false), (-1.01, false)] {
        rig.q[0] = raw;
        rig.step();
        assert_eq!(rig.sees(Event::EncoderRange), !good, "{raw}");
    }
}

#[test]
fn every_number_of_a_joint_state_must_be_one() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.1e9, f64::MAX] {
        for part in 0..4 {
            let mut rig = Rig::new(&two_rods(), plain(Law::PdDynamicGravity, 2)).armed();
            let good = rig.step();
            if part < 2 {
                rig.q[part] = bad;
            } else {
                rig.qd.as_mut().expect("given")[part - 2] = bad;
            }
            assert_eq!(rig.step(), good);
            assert!(rig.sees(Event::Absent));
        }
    }
    let mut rig = Rig::new(&two_rods(), plain(Law::Pd, 2)).armed();
    rig.q[2] = f64::NAN;
    rig.step();
    assert!(!rig.sees(Event::Absent), "beyond the robot's own coordinates");
}

#[test]
fn jumps_and_moduli_are_those_of_the_motors() {
    let gear = Transmission::new(&[0.01, 0.0, 0.0, 0.01], &[0.0, 0.0]).expect("can be inverted");
    let settings = Settings {
        feedback: Side::Motor,
        output: Side::Joint,
        transmission: Some(gear),
        modulus: Joints([6.0; MAX_JOINTS]),
        jump: Joints([2.0; MAX_JOINTS]),
        ..plain(Law::PdDynamicGravity, 2)
    };
    let mut rig = reading(settings);
    for k in 0..100 {
        rig.q = Joints([1.9 * f64::from(k) % 6.0; MAX_JOINTS]);
        let out = rig.step();
        assert!((out.q[0] - 0.019 * f64::from(k)).abs() < 1e-12 && !rig.sees(Event::Jump));
    }
    rig.q[0] = (rig.q[0] + 2.1) % 6.0;
    rig.step();
    assert!(rig.sees(Event::Jump));
}
