//! Arming, faults and what leads out of them: torque and reference go on from where they are.

use crate::control::{Rig, plain, two_rods};
use crate::scale::cases;
use gravcomp::control::{Event, Law, OnFault, Settings, State};
use gravcomp::{Gravity, Joints};
use proptest::prelude::*;

const NAN: Joints = Joints([f64::NAN; gravcomp::MAX_JOINTS]);

/// Two rods under PD + DG, with ramps of a tenth of a second.
fn ramped(on_fault: OnFault) -> Rig {
    let mut rig = Rig::new(&two_rods(), Settings { ramp_s: 0.1, on_fault, ..plain(Law::PdDynamicGravity, 2) });
    rig.q = Joints::from_slice(&[0.3, -0.4]);
    rig.q_desired = Joints::from_slice(&[0.5, 0.1]);
    rig
}

/// In its law for a while, then without joint states until the fault is latched.
fn faulted(on_fault: OnFault) -> Rig {
    let mut rig = ramped(on_fault).armed();
    rig.steps(150);
    rig.q = NAN;
    rig.steps(51);
    assert_eq!(rig.state(), State::Fault);
    rig
}

fn held(rig: &Rig) -> Joints {
    gravcomp::portable::gravity_torque(&rig.robot, &rig.controller.output().q, &Gravity::LEVEL)
}

proptest! {
    #![proptest_config(cases(200))]

    /// Whatever pose, target and gains: the first torque is zero, the reference starts at the pose, no step is larger than
    /// the law's torque times the ramp's steepest slope, and the end of the ramp is the law.
    #[test]
    fn arming_is_bumpless(
        pose in [-3.0..3.0, -3.0..3.0], target in [-3.0..3.0, -3.0..3.0], ramp_s in 0.01..0.3, rate in 50.0..1e4,
        waits in 0_u32..5,
    ) {
        let law = Settings { ramp_s, ..plain(Law::PdDynamicGravity, 2) };
        for fastest in [rate, f64::INFINITY] {
            let settings = Settings { tau_rate_max: Joints([fastest; 16]), ..law };
            let mut rig = Rig::new(&two_rods(), settings);
            (rig.q, rig.q_desired) = (Joints::from_slice(&pose), Joints::from_slice(&target));
            (0..waits).for_each(|_| { rig.step(); });
            prop_assert_eq!(rig.state(), State::Disarmed);
            rig.controller.arm();
            let first = rig.step();
            prop_assert_eq!((&first.tau, &first.tau_pd), (&Joints::default(), &Joints::default()));
            prop_assert_eq!(rig.state(), State::Ramping);
            let (mut before, mut largest) = (first, 0.0_f64);
            let steepest = 15.0 / 8.0 / (ramp_s * 1000.0);
            while rig.state() == State::Ramping {
                let now = rig.step();
                for j in 0..2 {
                    let law = now.tau_pd[j] + now.tau_gravity[j];
                    let change = law - before.tau_pd[j] - before.tau_gravity[j];
                    largest = largest.max(law.abs());
                    let allowed = 1.01 * steepest * largest + change.abs();
                    let caught_up = settings.tau_rate_max[j].is_finite();
                    prop_assert!(caught_up || (now.tau[j] - before.tau[j]).abs() <= allowed + 1e-9);
                }
                before = now;
            }
            prop_assert_eq!(rig.state(), State::Armed);
            let last = rig.steps(5000);
            for j in 0..2 {
                let pd = settings.kp[j] * (target[j] - pose[j]) + settings.kd[j] * (0.0 - 0.0);
                prop_assert_eq!(last.tau_pd[j], pd);
                prop_assert!(settings.tau_rate_max[j].is_finite() || last.tau[j] == pd + last.tau_gravity[j]);
            }
        }
    }

    /// Every change of the state goes on from the torque of the cycle before, whenever it comes.
    #[test]
    fn every_change_of_state_is_bumpless(orders in proptest::collection::vec((0..5, 1_u32..120), 1..20)) {
        let mut rig = ramped(OnFault::Gravity);
        let good = rig.q;
        let mut before = rig.step().tau;
        for (order, steps) in orders {
            match order {
                0 => rig.controller.arm(),
                1 => rig.controller.disarm(),
                2 => rig.controller.acknowledge(),
                3 => rig.q = NAN,
                _ => rig.q = good,
            }
            for _ in 0..steps {
                let tau = rig.step().tau;
                for j in 0..2 {
                    // The law's torque is 40 N m and more; a ramp of 100 cycles goes there in steps of a few.
                    prop_assert!((tau[j] - before[j]).abs() < 6.0, "{} to {}", before[j], tau[j]);
                }
                before = tau;
            }
        }
    }
}

#[test]
fn without_a_ramp_the_first_cycle_is_the_law() {
    let mut rig = Rig::new(&two_rods(), plain(Law::PdDynamicGravity, 2)).armed();
    rig.q_desired[0] = 0.1;
    let out = rig.step();
    assert_eq!((rig.state(), out.tau[0]), (State::Armed, 100.0 * 0.1 + out.tau_gravity[0]));
}

#[test]
fn a_disarmed_arm_gets_no_torque_but_says_what_would_hold_it() {
    let mut rig = ramped(OnFault::Gravity);
    let out = rig.steps(10);
    assert_eq!((rig.state(), out.tau, out.tau_pd), (State::Disarmed, Joints::default(), Joints::default()));
    assert_eq!(out.tau_gravity, held(&rig));
    rig.controller.arm();
    rig.steps(150);
    rig.controller.disarm();
    assert_eq!(rig.steps(101).tau, Joints::default());
    assert_eq!(rig.state(), State::Disarmed);
}

#[test]
fn arming_waits_for_the_base_sensor() {
    let mut rig = ramped(OnFault::Gravity).armed();
    rig.armable = false;
    rig.steps(1000);
    assert_eq!(rig.state(), State::Disarmed);
    assert!(rig.sees(Event::Waiting));
    rig.armable = true;
    rig.step();
    assert_eq!(rig.state(), State::Ramping);
    rig.armable = false;
    rig.steps(150);
    assert_eq!(rig.state(), State::Armed, "an armed arm does not fall because its sensor is in doubt");
}

#[test]
fn arming_without_any_joint_state_is_a_fault() {
    let mut rig = ramped(OnFault::Gravity).armed();
    let good = rig.q;
    rig.q = NAN;
    rig.steps(50);
    assert_eq!(rig.state(), State::Disarmed);
    assert!(rig.sees(Event::Waiting) && rig.sees(Event::Absent));
    assert_eq!(rig.steps(100).tau, Joints::default());
    assert_eq!(rig.state(), State::Fault);
    rig.q = good;
    assert_eq!(rig.steps(10).tau_gravity, held(&rig));
    assert_eq!(rig.state(), State::Fault, "nobody has acknowledged it");
    rig.controller.acknowledge();
    assert_eq!(rig.steps(150).tau, {
        let out = rig.controller.output();
        Joints(std::array::from_fn(|j| out.tau_pd[j] + out.tau_gravity[j]))
    });
}

#[test]
fn a_missing_joint_state_freezes_pd_and_leaves_gravity_live() {
    let mut rig = ramped(OnFault::Gravity).armed();
    let good = rig.steps(150);
    rig.q[1] = f64::NAN;
    rig.q_desired[0] = 2.0;
    rig.base = gravcomp::BaseMotion::at_rest(Gravity(nalgebra::Vector3::new(3.0, 0.0, -9.0)));
    let out = rig.step();
    assert_eq!((out.tau_pd, out.q), (good.tau_pd, good.q));
    assert_ne!(out.tau_gravity, good.tau_gravity);
    assert!(rig.sees(Event::Absent));
    rig.q[1] = good.q[1];
    assert_eq!(rig.step().tau_pd[0], 100.0 * (2.0 - rig.q[0]));
    assert_eq!(rig.state(), State::Armed);
}

#[test]
fn a_pose_is_held_for_as_long_as_declared_and_no_longer() {
    let mut rig = ramped(OnFault::Gravity).armed();
    rig.steps(150);
    rig.q = NAN;
    rig.steps(50);
    assert_eq!(rig.state(), State::Armed);
    rig.step();
    assert_eq!(rig.state(), State::Fault);
    assert!(rig.sees(Event::Fault));
    assert_eq!(rig.controller.counters().of(Event::Fault), 1);
    rig.step();
    assert!(!rig.sees(Event::Fault) && rig.controller.status().since.has(Event::Fault));
}

#[test]
fn cycles_that_were_left_out_make_the_pose_older() {
    let mut rig = ramped(OnFault::Gravity).armed();
    rig.steps(150);
    let good = rig.q;
    rig.controller.skip(60);
    rig.step();
    assert_eq!(rig.state(), State::Armed, "the pose is good again");
    rig.q = NAN;
    rig.controller.skip(60);
    rig.step();
    assert_eq!(rig.state(), State::Fault);
    rig.controller.skip(u32::MAX);
    rig.q = good;
    rig.step();
}

#[test]
fn the_fault_holds_the_arm_or_lets_it_go_as_declared() {
    let mut rig = faulted(OnFault::Gravity);
    let out = rig.steps(101);
    assert_eq!((out.tau, out.tau_pd), (held(&rig), Joints::default()));
    let mut rig = faulted(OnFault::Decay);
    assert_eq!(rig.steps(101).tau, Joints::default());
}

#[test]
fn even_a_law_without_gravity_holds_the_arm_after_a_fault() {
    let mut rig = Rig::new(&two_rods(), plain(Law::Pd, 2)).armed();
    rig.q = Joints::from_slice(&[0.3, -0.4]);
    assert_eq!(rig.steps(10).tau_gravity, Joints::default());
    rig.q = NAN;
    rig.steps(60);
    assert_eq!((rig.state(), rig.controller.output().tau), (State::Fault, held(&rig)));
}

#[test]
fn only_an_acknowledgement_with_a_good_joint_state_leaves_the_fault() {
    let mut rig = faulted(OnFault::Gravity);
    rig.controller.arm();
    rig.controller.acknowledge();
    rig.step();
    assert!(rig.state() == State::Fault && rig.sees(Event::Waiting));
    rig.q = Joints::from_slice(&[0.35, -0.45]);
    rig.steps(300);
    assert_eq!(rig.state(), State::Fault);
    let before = rig.step().tau;
    rig.controller.acknowledge();
    assert!(rig.controller.status().since.is_empty());
    let out = rig.step();
    assert_eq!((rig.state(), out.tau, out.tau_pd), (State::Ramping, before, Joints::default()));
    rig.steps(100);
    assert_eq!(rig.state(), State::Armed);
}

#[test]
fn a_fault_that_is_disarmed_lets_go_and_is_left_disarmed() {
    let mut rig = faulted(OnFault::Gravity);
    rig.steps(101);
    rig.controller.disarm();
    rig.steps(101);
    assert_eq!((rig.state(), rig.controller.output().tau), (State::Fault, Joints::default()));
    rig.q = Joints::from_slice(&[0.3, -0.4]);
    rig.controller.acknowledge();
    assert_eq!(rig.steps(101).tau, Joints::default());
    assert_eq!(rig.state(), State::Disarmed);
}
