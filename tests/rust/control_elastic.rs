//! Elastic joints in the law: gravity where the variant says, PD at the motors' goal, and whatever comes in.

use crate::builds::builds;
use crate::control::{Rig, plain, raven_cables, three_joints, two_rods};
use crate::scale::{cases, close};
use gravcomp::control::{Event, Law, Settings, Side, State};
use gravcomp::elastic::{Settings as ElasticSettings, Stiffness, Variant};
use gravcomp::{BaseMotion, Controller, ElasticGravity, Gravity, Joints, MAX_JOINTS};
use proptest::prelude::*;

const VARIANTS: [Variant; 5] = [Variant::Desired, Variant::Motor, Variant::Biased, Variant::QuasiStatic, Variant::Link];

const WITH_PD: [Law; 3] = [Law::PdStaticGravity, Law::PdDynamicGravity, Law::PdBaseMotion];

/// Springs of so many N·m/rad (N/m) on each of so many joints.
fn springs(variant: Variant, stiffness: f64, n: usize) -> ElasticGravity {
    let springs = Stiffness::each(&[stiffness; MAX_JOINTS][..n]).expect("positive");
    ElasticGravity::new(springs, ElasticSettings { variant, contraction: 0.02, iterations: 40, tolerance: 1e-13 })
}

/// An arm of three joints on such springs, armed, its motors at `q` on the way to `target`.
fn rig(law: Law, variant: Variant, stiffness: f64, q: &Joints, target: &Joints) -> Rig {
    let mut rig = Rig::new(&three_joints(), plain(law, 3)).elastic(springs(variant, stiffness, 3)).armed();
    (rig.q, rig.q_link, rig.q_desired) = (*q, Some(Joints(q.map(|q| q - 0.01))), *target);
    rig
}

fn three(bound: f64) -> impl Strategy<Value = Joints> {
    proptest::collection::vec(-bound..bound, 3).prop_map(|q| Joints::from_slice(&q))
}

proptest! {
    #![proptest_config(cases(200))]

    /// u = Kp (θ_d − θ) − Kd θ̇ + g(at), with θ_d and g(at) those of `elastic`.
    #[test]
    fn the_terms_are_those_of_the_elastic_law(q in three(1.0), rates in three(2.0), target in three(1.0)) {
        for build in builds() {
            for variant in VARIANTS {
                let settings = plain(Law::PdDynamicGravity, 3);
                let mut rig = Rig::with(&three_joints(), settings, build.control).elastic(springs(variant, 400.0, 3)).armed();
                (rig.q, rig.qd, rig.q_link, rig.q_desired) = (q, Some(rates), Some(target), target);
                let (out, hold) = (rig.step(), |q: &Joints| (build.gravity_torque)(&three_joints(), q, &Gravity::LEVEL));
                let wanted = springs(variant, 400.0, 3).step(hold, Gravity::LEVEL.0.norm(), &q, &target, &target);
                for j in 0..3 {
                    let pd = settings.kp[j] * (wanted.theta_d[j] - q[j]) + settings.kd[j] * (0.0 - rates[j]);
                    prop_assert_eq!((out.tau_pd[j], out.tau_gravity[j]), (pd, wanted.torque[j]));
                }
                prop_assert_eq!(&rig.controller.theta_desired().expect("a goal")[..3], &wanted.theta_d[..3]);
            }
        }
    }

    /// Joints that do not give are rigid: the law is the one without springs.
    #[test]
    fn infinite_stiffness_is_the_rigid_law(q in three(1.0), target in three(1.0)) {
        for law in WITH_PD {
            for variant in [Variant::Motor, Variant::Biased, Variant::QuasiStatic, Variant::Link] {
                let mut elastic = rig(law, variant, f64::INFINITY, &q, &target);
                let mut rigid = Rig::new(&three_joints(), plain(law, 3)).armed();
                elastic.q_link = Some(q);
                (rigid.q, rigid.q_desired) = (q, target);
                for _ in 0..3 {
                    let (a, b) = (elastic.step(), rigid.step());
                    close("tau", &a.tau[..3], &b.tau[..3], 1e-12)?;
                }
            }
        }
    }

    /// Gains at the motors aim at C⁻¹ (θ_d − c₀), and gravity is carried there.
    #[test]
    fn gains_at_the_motors_aim_at_the_motors_goal(q in three(1.0), target in three(1.0)) {
        let cables = raven_cables();
        let settings = Settings { feedback: Side::Motor, output: Side::Motor, transmission: Some(cables), ..plain(Law::PdDynamicGravity, 3) };
        let mut rig = Rig::new(&three_joints(), settings).elastic(springs(Variant::Desired, 400.0, 3)).armed();
        (rig.q, rig.q_desired) = (cables.motor_positions(&q), target);
        let out = rig.step();
        let aim = cables.motor_positions(rig.controller.theta_desired().expect("a goal"));
        let held = cables.motor_efforts(&gravcomp::portable::gravity_torque(&three_joints(), &target, &Gravity::LEVEL));
        for j in 0..3 {
            prop_assert_eq!(out.tau_pd[j], settings.kp[j] * (aim[j] - rig.q[j]) + settings.kd[j] * 0.0);
            prop_assert_eq!(out.tau_gravity[j], held[j]);
        }
    }

    /// On the ramp pose and torque start where they are, and end at the law's.
    #[test]
    fn arming_is_bumpless(q in three(0.5), target in three(0.5), variant in proptest::sample::select(&VARIANTS[..])) {
        let settings = Settings { ramp_s: 0.1, ..plain(Law::PdDynamicGravity, 3) };
        let mut rig = Rig::new(&three_joints(), settings).elastic(springs(variant, 300.0, 3)).armed();
        (rig.q, rig.q_link, rig.q_desired) = (q, Some(q), target);
        let (mut before, mut most) = (Joints::default(), [0.0_f64; 3]);
        for _ in 0..100 {
            let out = rig.step();
            for j in 0..3 {
                most[j] = most[j].max((out.tau[j] - before[j]).abs());
            }
            before = out.tau;
        }
        let last = rig.step();
        prop_assert_eq!(rig.state(), State::Armed);
        for j in 0..3 {
            let law = last.tau_pd[j] + last.tau_gravity[j];
            prop_assert_eq!(last.tau[j], law);
            // s moves by at most 15/8 of a cycle's share, and PD itself grows with it: (s²)' ≤ 3.2.
            let size = last.tau_pd[j].abs() + last.tau_gravity[j].abs() + 30.0;
            prop_assert!(most[j] <= 0.05 * size, "{} of {size} in a cycle", most[j]);
        }
    }

    /// Finite, limited, slewed: [`Rig::step`] looks at every torque.
    #[test]
    fn no_input_breaks_a_limit(words in proptest::collection::vec((any::<u64>(), 0..24_usize), 60), law in proptest::sample::select(&Law::ALL[1..])) {
        for variant in VARIANTS {
            let settings = Settings { tau_max: Joints([20.0; MAX_JOINTS]), tau_rate_max: Joints([5e3; MAX_JOINTS]), jump: Joints([0.5; MAX_JOINTS]), ..plain(law, 3) };
            let controller = Controller::new(settings, gravcomp::control::Kernels::PORTABLE).expect("settings that make sense");
            let Ok(controller) = controller.with_elastic(springs(variant, 50.0, 3)) else { continue };
            let mut rig = Rig { controller, ..Rig::new(&three_joints(), settings) }.armed();
            rig.q_link = Some(Joints::default());
            for (word, place) in &words {
                let x = f64::from_bits(*word);
                let (q, target, links) = (rig.q, rig.q_desired, rig.q_link);
                match place {
                    0..=2 => rig.q[*place] = x,
                    3..=5 => rig.q_desired[place - 3] = x,
                    6..=8 => rig.base.specific_force.0[place - 6] = x,
                    9 => rig.q_link = None,
                    10..=12 => rig.q_link = Some(Joints([x; MAX_JOINTS])),
                    13 => rig.controller.acknowledge(),
                    14 => rig.q[0] += 2.0,
                    _ => {}
                }
                rig.steps(3);
                (rig.q, rig.q_desired, rig.q_link) = (q, target, links);
                rig.base = BaseMotion::at_rest(Gravity::LEVEL);
            }
        }
    }
}

/// Armed without a target the links stay where they hang, and with them the motors.
#[test]
fn without_a_target_the_links_stay_where_they_are() {
    let none = Joints([f64::NAN; MAX_JOINTS]);
    for variant in [Variant::Desired, Variant::Biased, Variant::QuasiStatic] {
        let mut rig = rig(Law::PdDynamicGravity, variant, 200.0, &Joints::from_slice(&[0.3, -0.4, 0.1]), &none);
        rig.base = BaseMotion::at_rest(Gravity(nalgebra::Vector3::new(1.0, -2.0, -9.5)));
        let out = rig.steps(5);
        assert!(out.tau_pd[..3].iter().all(|tau| tau.abs() < 1e-8), "{variant:?}: {out:?}");
        let theta_d = rig.controller.theta_desired().expect("a goal");
        assert!((0..3).all(|j| (theta_d[j] - rig.q[j]).abs() < 1e-9));
    }
}

/// What holds the arm after a fault is gravity where the links hang, whatever the variant.
#[test]
fn a_fault_holds_the_links_where_they_hang() {
    let (q, target) = (Joints::from_slice(&[0.3, -0.4, 0.1]), Joints::from_slice(&[1.0, 1.0, 0.3]));
    for variant in [Variant::Desired, Variant::Motor, Variant::Biased, Variant::QuasiStatic] {
        let mut rig = rig(Law::PdDynamicGravity, variant, 200.0, &q, &target);
        rig.step();
        rig.q = Joints([f64::NAN; MAX_JOINTS]);
        let out = rig.steps(100);
        assert_eq!(rig.state(), State::Fault);
        let hold = |q: &Joints| gravcomp::portable::gravity_torque(&three_joints(), q, &Gravity::LEVEL);
        let hanging = springs(Variant::QuasiStatic, 200.0, 3).hanging(hold, 9.81, &q).torque;
        assert!((0..3).all(|j| (out.tau[j] - hanging[j]).abs() < 1e-10), "{variant:?}: {out:?}, {hanging:?}");
    }
}

#[test]
fn a_missing_link_is_a_missing_joint_state() {
    let (q, target) = (Joints::from_slice(&[0.3, -0.4, 0.1]), Joints::default());
    for missing in [None, Some(Joints([f64::NAN; MAX_JOINTS])), Some(Joints([1e300; MAX_JOINTS]))] {
        let mut rig = rig(Law::PdDynamicGravity, Variant::Link, 200.0, &q, &target);
        let good = rig.step();
        rig.q_link = missing;
        let held = rig.step();
        assert!(rig.sees(Event::Absent));
        assert_eq!(held, good);
        rig.steps(60);
        assert_eq!(rig.state(), State::Fault);
        assert_eq!(rig.controller.output().tau_gravity, good.tau_gravity);
    }
    for variant in &VARIANTS[..4] {
        let mut rig = rig(Law::PdDynamicGravity, *variant, 200.0, &q, &target);
        rig.q_link = None;
        rig.step();
        assert!(!rig.sees(Event::Absent), "{variant:?} reads no links");
    }
}

#[test]
fn gravity_alone_holds_the_links_where_they_hang() {
    let q = Joints::from_slice(&[0.3, -0.4, 0.1]);
    let mut rig = rig(Law::Passive, Variant::QuasiStatic, 200.0, &q, &q);
    let hold = |q: &Joints| gravcomp::portable::gravity_torque(&three_joints(), q, &Gravity::LEVEL);
    let hanging = springs(Variant::QuasiStatic, 200.0, 3).hanging(hold, Gravity::LEVEL.0.norm(), &q);
    assert_eq!(rig.step().tau[..3], hanging.torque[..3]);
    assert_eq!(rig.controller.fixed_point(), Some((hanging.iterations, hanging.error)));
    assert!(hanging.iterations > 2 && hanging.error < 1e-12);
}

#[test]
fn springs_that_cannot_be_meant_are_refused() {
    let refused = |law, variant, joints| {
        let law =
            Controller::new(plain(law, 2), gravcomp::control::Kernels::PORTABLE).expect("settings that make sense");
        law.with_elastic(springs(variant, 100.0, joints)).map(|_| ()).map_err(|error| error.to_string())
    };
    let says =
        |found: Result<(), String>, what: &str| assert!(found.as_ref().is_err_and(|e| e.contains(what)), "{found:?}");
    says(refused(Law::PdDynamicGravity, Variant::Desired, 3), "elastic (joints) is 3.0; it should be as many joints");
    says(refused(Law::Pd, Variant::QuasiStatic, 2), "no gravity term");
    for variant in [Variant::Desired, Variant::Motor, Variant::Biased] {
        says(refused(Law::Passive, variant, 2), "no goal");
    }
    for law in WITH_PD {
        assert_eq!(refused(law, Variant::Biased, two_rods().coordinates()), Ok(()));
    }
}
