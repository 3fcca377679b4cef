//! Control laws: their terms are those of the formula, on either side of a transmission, for every robot and base.
#![allow(clippy::large_types_passed_by_value)] // settings are built where they are passed

use crate::arms::{Arm, State as Pose, arms, joints, states};
use crate::builds::{Build, builds};
use crate::disturbance::one_of_each;
use crate::scale::{ROUNDING, Scale, cases, close};
use gravcomp::control::{Event, Inputs, Kernels, Law, OnFault, Output, Settings, Side, State};
use gravcomp::{
    BaseMotion, Controller, DhRow, Disturbances, ElasticGravity, Frame, Gravity, Inertia, Joint, Joints, MAX_JOINTS,
    Robot, RobotBuilder,
};
use gravcomp::{SpecificForce, Transmission};
use nalgebra::Vector3;
use proptest::prelude::*;

/// A controller in its loop. Every step is checked against what always holds.
#[derive(Clone)]
pub struct Rig {
    pub robot: Robot,
    pub controller: Controller,
    pub q: Joints,
    pub qd: Option<Joints>,
    pub q_link: Option<Joints>,
    pub q_desired: Joints,
    pub qd_desired: Joints,
    pub base: BaseMotion,
    pub disturbances: Option<Box<Disturbances>>,
    pub armable: bool,
}

impl Rig {
    pub fn new(robot: &Robot, settings: Settings) -> Self {
        Self::with(robot, settings, Kernels::PORTABLE)
    }

    pub fn with(robot: &Robot, settings: Settings, kernels: Kernels) -> Self {
        Self {
            robot: robot.clone(),
            controller: Controller::new(settings, kernels).expect("settings that make sense"),
            q: Joints::default(),
            qd: Some(Joints::default()),
            q_link: None,
            q_desired: Joints::default(),
            qd_desired: Joints::default(),
            base: BaseMotion::at_rest(Gravity::LEVEL),
            disturbances: None,
            armable: true,
        }
    }

    pub fn elastic(mut self, law: ElasticGravity) -> Self {
        self.controller = self.controller.with_elastic(law).expect("springs that fit");
        self
    }

    pub fn armed(mut self) -> Self {
        self.controller.arm();
        self
    }

    pub fn step(&mut self) -> Output {
        let before = self.controller.output().tau;
        let inputs = Inputs {
            q: &self.q,
            qd: self.qd.as_ref(),
            q_link: self.q_link.as_ref(),
            q_desired: &self.q_desired,
            qd_desired: &self.qd_desired,
            base: &self.base,
            disturbances: self.disturbances.as_deref(),
            armable: self.armable,
        };
        let output = *self.controller.step(&self.robot, &inputs);
        check(self.controller.settings(), &before, &output);
        output
    }

    /// The last of so many steps.
    pub fn steps(&mut self, steps: u32) -> Output {
        (0..steps).map(|_| self.step()).last().expect("one step at least")
    }

    pub fn state(&self) -> State {
        self.controller.state()
    }

    pub fn sees(&self, event: Event) -> bool {
        self.controller.status().seen.has(event)
    }
}

/// Finite, within the limits, within the rate: to the last bit.
fn check(settings: &Settings, before: &Joints, output: &Output) {
    let (n, period) = (settings.coordinates, 1.0 / settings.rate_hz);
    for terms in [&output.tau, &output.tau_pd, &output.tau_gravity, &output.tau_disturbance] {
        assert!(terms[..n].iter().all(|x| x.is_finite()), "{output:?}");
    }
    for j in 0..n {
        let (tau, step) = (output.tau[j], settings.tau_rate_max[j] * period);
        assert!(tau.abs() <= settings.tau_max[j], "tau[{j}] is {tau:e}, at most {:e}", settings.tau_max[j]);
        let reach = before[j] - step..=before[j] + step;
        assert!(reach.contains(&tau), "tau[{j}] moved from {:e} to {tau:e}, at most by {step:e}", before[j]);
    }
}

/// A number for every place, by its number from 0.
pub fn each(number: impl Fn(f64) -> f64) -> Joints {
    let mut place = -1.0;
    Joints([(); MAX_JOINTS].map(|()| {
        place += 1.0;
        number(place)
    }))
}

/// A law with gains, without limits and without ramps.
pub fn plain(law: Law, n: usize) -> Settings {
    let gain = |k: f64| each(|j| k * (1.0 + 0.1 * j));
    Settings { kp: gain(100.0), kd: gain(5.0), ramp_s: 0.0, ..Settings::of(law, n) }
}

/// A shoulder and an elbow of 2 kg each, half a metre long, about horizontal axes.
pub fn two_rods() -> Robot {
    let (mut builder, mut frame) = (RobotBuilder::new(), Frame::ROOT);
    let rod = Inertia::new(2.0, Vector3::new(-0.25, 0.0, 0.0), [0.01, 0.0, 0.0, 0.05, 0.0, 0.05]).expect("a body");
    for alpha in [std::f64::consts::FRAC_PI_2, 0.0] {
        let row = DhRow { alpha, a: 0.5, d: 0.0, theta: 0.0 }.standard().expect("finite");
        frame = builder.link(&frame, Joint::Revolute, &row, &rod).expect("two bodies");
    }
    builder.build(gravcomp::Pose::IDENTITY, frame, None).expect("two bodies")
}

/// Two turning joints and a sliding one, askew.
pub fn three_joints() -> Robot {
    let (mut builder, mut frame) = (RobotBuilder::new(), Frame::ROOT);
    let body = Inertia::new(0.5, Vector3::new(0.01, -0.1, -0.2), [0.02, 0.0, 0.0, 0.02, 0.0, 0.02]).expect("a body");
    for (joint, alpha) in [(Joint::Revolute, 1.0), (Joint::Revolute, 1.3), (Joint::Prismatic, 2.2)] {
        let row = DhRow { alpha, a: 0.0, d: 0.0, theta: 0.5 }.modified().expect("finite");
        frame = builder.link(&frame, joint, &row, &body).expect("three bodies");
    }
    builder.build(gravcomp::Pose::IDENTITY, frame, None).expect("three bodies")
}

/// C of the RAVEN II's shoulder, elbow and insertion from m = C⁻¹ q: uw-biorobotics/raven2 inv_cable_coupling.cpp.
pub fn raven_cables() -> Transmission {
    let motor_per_joint = nalgebra::Matrix3::new(136.196, 0.0, 0.0, 17.675, 121.522, 0.0, 16.831, 17.436, 2158.59);
    let C = motor_per_joint.try_inverse().expect("triangular");
    Transmission::new(C.transpose().as_slice(), &[0.1, -0.2, 0.3]).expect("can be inverted")
}

/// An arm at a pose, on its way to another one.
fn at(arm: &Arm, law: Law, pose: &Pose, build: &Build) -> Rig {
    let mut rig = Rig::with(&arm.build(), plain(law, arm.coordinates()), build.control).armed();
    (rig.q, rig.qd, rig.base) = (pose.q, Some(pose.qd), pose.base);
    (rig.q_desired, rig.qd_desired) = (pose.qdd, Joints(pose.qd.map(|x| 0.5 * x)));
    rig
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn the_terms_are_those_of_the_formula((arm, pose) in (arms(), states())) {
        let n = arm.coordinates();
        for build in builds() {
            for law in Law::ALL {
                let mut rig = at(&arm, law, &pose, &build);
                let out = rig.step();
                let settings = rig.controller.settings();
                for j in 0..n {
                    let pd = settings.kp[j] * (rig.q_desired[j] - rig.q[j]) + settings.kd[j] * (rig.qd_desired[j] - pose.qd[j]);
                    prop_assert_eq!(out.tau_pd[j], if law.has_pd() { pd } else { 0.0 });
                    prop_assert_eq!(out.tau[j], out.tau_pd[j] + out.tau_gravity[j]);
                }
                prop_assert_eq!((rig.state(), &out.q[..n]), (State::Armed, &pose.q[..n]));
            }
        }
    }

    #[test]
    fn gravity_terms_are_the_gravity_torque((arm, pose) in (arms(), states())) {
        let n = arm.coordinates();
        for build in builds() {
            let gravity = |law| at(&arm, law, &pose, &build).step().tau_gravity;
            let held = (build.gravity_torque)(&arm.build(), &pose.q, &pose.gravity());
            for law in [Law::PdStaticGravity, Law::PdDynamicGravity, Law::Passive] {
                prop_assert_eq!(&gravity(law)[..n], &held[..n]);
            }
            prop_assert_eq!(&gravity(Law::Pd)[..n], &[0.0; MAX_JOINTS][..n]);
        }
    }

    #[test]
    fn full_base_motion_is_the_inverse_dynamics_of_the_arm_at_rest((arm, pose) in (arms(), states())) {
        let (n, still) = (arm.coordinates(), Joints::default());
        for build in builds() {
            let out = at(&arm, Law::PdBaseMotion, &pose, &build).step();
            let wanted = (build.inverse_dynamics)(&arm.build(), &pose.q, &still, &still, &pose.base);
            prop_assert_eq!(&out.tau_gravity[..n], &wanted[..n]);
        }
    }

    /// τ = τ_pd + τ_g + τ_e: at the pose and rates of the encoders, at rest off stale data, none without a gravity term.
    #[test]
    fn disturbance_terms_are_the_disturbance_torque((arm, pose) in (arms(), states())) {
        let (n, robot) = (arm.coordinates(), arm.build());
        let all = one_of_each(n).expect("elements that make sense");
        for build in builds() {
            for law in Law::ALL {
                let held = |qd: &Joints| match law {
                    Law::Pd => Joints::default(),
                    _ => (build.disturbance_torque)(&robot, &all, &pose.q, qd),
                };
                let mut rig = at(&arm, law, &pose, &build);
                rig.disturbances = Some(Box::new(all.clone()));
                let out = rig.step();
                prop_assert_eq!(&out.tau_disturbance[..n], &held(&pose.qd)[..n]);
                for j in 0..n {
                    prop_assert_eq!(out.tau[j], out.tau_pd[j] + out.tau_gravity[j] + out.tau_disturbance[j]);
                }
                rig.q[0] = f64::NAN;
                prop_assert_eq!(&rig.step().tau_disturbance[..n], &held(&Joints::default())[..n]);
            }
        }
    }

    /// PD + BM on a base at rest is PD + DG.
    #[test]
    fn a_base_at_rest_needs_no_more_than_gravity((arm, pose) in (arms(), states())) {
        let n = arm.coordinates();
        for build in builds() {
            let tau = |law| at(&arm, law, &pose.at_rest(), &build).step().tau_gravity;
            let bound = ROUNDING * Scale::of(&arm, &pose.at_rest()).torque();
            close("tau", &tau(Law::PdBaseMotion)[..n], &tau(Law::PdDynamicGravity)[..n], bound)?;
        }
    }

    /// τ_mᵀ ṁ = τ_qᵀ q̇, exactly and not by the diagonal of C, wherever gains act.
    #[test]
    fn no_power_is_lost_between_motors_and_joints(
        m in joints(300.0), md in joints(20.0), target in joints(1.0), feedback in prop_oneof![Just(Side::Joint), Just(Side::Motor)],
    ) {
        let (cables, robot) = (raven_cables(), three_joints());
        let [moved, zero] = [md, Joints::default()].map(|m| cables.joint_positions(&m));
        let (q, qd) = (cables.joint_positions(&m), Joints(std::array::from_fn(|j| moved[j] - zero[j])));
        let tau = |output| {
            let law = plain(Law::PdDynamicGravity, 3);
            let mut rig = Rig::new(&robot, Settings { feedback, output, transmission: Some(cables), ..law }).armed();
            (rig.q, rig.qd) = if feedback == Side::Motor { (m, Some(md)) } else { (q, Some(qd)) };
            (rig.q_desired, rig.qd_desired) = (target, Joints([0.1; MAX_JOINTS]));
            rig.step()
        };
        let (at_motors, at_joints) = (tau(Side::Motor), tau(Side::Joint));
        let power = |tau: &Joints, rate: &Joints| (0..3).map(|j| tau[j] * rate[j]).sum::<f64>();
        let size: f64 = (0..3).map(|j| (at_joints.tau[j] * qd[j]).abs()).sum();
        close("power", &[power(&at_motors.tau, &md)], &[power(&at_joints.tau, &qd)], 1e-11 * (1.0 + size))?;
        close("C^T tau", &cables.motor_efforts(&at_joints.tau)[..3], &at_motors.tau[..3], 1e-11 * (1.0 + size))?;
        close("q", &at_motors.q[..3], &q[..3], 1e-12)?;
    }

    /// Gains at the motors: τ_m = Kp (m_d − m) + Kd (ṁ_d − ṁ) + Cᵀ τ_g(q), with m_d = C⁻¹ (q_d − c₀).
    #[test]
    fn motor_gains_act_on_motor_angles(m in joints(300.0), md in joints(20.0), target in joints(1.0)) {
        let (cables, robot) = (raven_cables(), three_joints());
        let motors = Settings { feedback: Side::Motor, output: Side::Motor, transmission: Some(cables), ..plain(Law::PdDynamicGravity, 3) };
        let mut rig = Rig::new(&robot, motors).armed();
        (rig.q, rig.qd, rig.q_desired) = (m, Some(md), target);
        let (out, wanted) = (rig.step(), cables.motor_positions(&target));
        let held = cables.motor_efforts(&gravcomp::portable::gravity_torque(&robot, &out.q, &Gravity::LEVEL));
        for j in 0..3 {
            prop_assert_eq!(out.tau_pd[j], motors.kp[j] * (wanted[j] - m[j]) + motors.kd[j] * (0.0 - md[j]));
            prop_assert_eq!(out.tau_gravity[j], held[j]);
        }
    }

    #[test]
    fn the_same_inputs_give_the_same_bits((arm, pose) in (arms(), states()), bits in proptest::collection::vec(any::<u64>(), 64)) {
        for build in builds() {
            let mut rig = at(&arm, Law::PdBaseMotion, &pose, &build);
            let mut twin = rig.clone();
            for word in &bits {
                for rig in [&mut rig, &mut twin] {
                    rig.q[0] = f64::from_bits(*word);
                    rig.q_desired[0] += 0.01;
                }
                let [a, b] = [rig.step(), twin.step()].map(|out| out.tau.map(f64::to_bits));
                prop_assert_eq!(a, b);
            }
        }
    }
}

#[test]
fn static_gravity_is_that_of_the_moment_of_arming() {
    let robot = two_rods();
    let tilted = BaseMotion::at_rest(Gravity(Vector3::new(3.0, -1.0, -9.0)));
    let mut rig = Rig::new(&robot, plain(Law::PdStaticGravity, 2)).armed();
    rig.base = tilted;
    let held = gravcomp::portable::gravity_torque(&robot, &rig.q, &tilted.specific_force.into());
    assert_eq!(rig.step().tau_gravity, held);
    rig.base = BaseMotion::at_rest(Gravity::LEVEL);
    assert_eq!(rig.steps(10).tau_gravity, held);
    rig.controller.disarm();
    rig.steps(2);
    rig.controller.arm();
    assert_eq!(rig.step().tau_gravity, gravcomp::portable::gravity_torque(&robot, &rig.q, &Gravity::LEVEL));
}

#[test]
fn a_base_that_is_no_base_leaves_the_last_one() {
    for bad in [f64::NAN, f64::INFINITY, 1e7] {
        for part in 0..3 {
            let mut rig = Rig::new(&two_rods(), plain(Law::PdBaseMotion, 2)).armed();
            rig.base.angular_acceleration = Vector3::new(1.0, 0.0, 2.0);
            let (good, mut base) = (rig.step(), rig.base);
            let vectors = [&mut base.specific_force.0, &mut base.angular_velocity, &mut base.angular_acceleration];
            vectors.into_iter().nth(part).expect("three").y = bad;
            rig.base = base;
            assert_eq!(rig.step(), good);
            assert!(rig.sees(Event::BaseMotion));
            assert_eq!(rig.controller.counters().of(Event::BaseMotion), 1);
        }
    }
}

#[test]
fn a_robot_whose_torque_overflows_leaves_the_last_one() {
    let mut builder = RobotBuilder::new();
    let huge = Inertia::new(1e300, Vector3::new(1e300, 0.0, 0.0), [0.0; 6]);
    let row = DhRow { alpha: 1.57, a: 1.0, d: 0.0, theta: 0.0 }.standard().expect("finite");
    let Ok(frame) = huge.and_then(|huge| builder.link(&Frame::ROOT, Joint::Revolute, &row, &huge)) else { return };
    let robot = builder.build(gravcomp::Pose::IDENTITY, frame, None).expect("one body");
    let mut rig = Rig::new(&robot, plain(Law::PdDynamicGravity, 1)).armed();
    assert_eq!(rig.step().tau_gravity[0], 0.0);
    assert!(rig.sees(Event::Overflow));
}

#[test]
fn laws_sides_and_events_have_names() {
    assert_eq!(Law::ALL.map(Law::name), ["pd", "pd+sg", "pd+dg", "pd+bm", "passive"]);
    assert_eq!(State::ALL.map(State::name), ["disarmed", "ramping", "armed", "fault"]);
    for (number, event) in Event::ALL.into_iter().enumerate() {
        assert_eq!(event as usize, number);
        assert!(!event.name().is_empty() && !event.meaning().is_empty());
    }
    assert_eq!(
        (Side::default(), OnFault::default(), State::default()),
        (Side::Joint, OnFault::Gravity, State::Disarmed)
    );
    let force = SpecificForce(Vector3::zeros());
    assert_eq!(BaseMotion::at_rest(force.into()).specific_force.0, -Vector3::zeros());
}

/// Eight numbers are one cache line, not two.
#[test]
fn what_a_cycle_reads_and_writes_begins_where_cache_lines_do() {
    let controller = Controller::new(plain(Law::Pd, 3), Kernels::PORTABLE).expect("settings that make sense");
    let Output { tau, tau_pd, tau_gravity, tau_disturbance, q } = controller.output();
    for numbers in [tau, tau_pd, tau_gravity, tau_disturbance, q] {
        assert_eq!(std::ptr::from_ref(numbers).addr() % 64, 0);
    }
    assert_eq!(align_of::<Transmission>(), 64);
}
