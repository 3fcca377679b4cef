//! Resolved-rate motion where limits meet, steps are no steps, and tasks are more than an arm has.

use crate::builds::{Build, builds};
use gravcomp::resolved_rate::{Damping, Event, Goal, Inputs, Limit, Priority, Settings, TARGET, Task};
use gravcomp::{
    DhRow, Frame, Inertia, JacobianAxes, Joint, Joints, MAX_JOINTS, Pose, ResolvedRate, Robot, RobotBuilder,
};
use nalgebra::Vector3;

const DT: f64 = 1e-3;

/// A chain of so many turning joints, with a tool beside the last.
fn arm(joints: usize) -> Robot {
    let (mut builder, mut frame) = (RobotBuilder::new(), Frame::ROOT);
    for _ in 0..joints {
        let row = DhRow { alpha: 1.2, a: 0.3, d: 0.1, theta: 0.4 }.modified().expect("finite");
        frame = builder.link(&frame, Joint::Revolute, &row, &Inertia::ZERO).expect("at most 16 bodies");
    }
    let tool =
        frame.then(Pose::new(nalgebra::Matrix3::identity(), Vector3::new(0.2, 0.1, 0.3), "tool").expect("a pose"));
    builder.build(Pose::IDENTITY, tool, None).expect("at most 16 bodies")
}

fn made(robot: &Robot, change: impl FnOnce(&mut Settings)) -> ResolvedRate {
    let mut settings = Settings::of(robot.coordinates());
    change(&mut settings);
    ResolvedRate::new(settings).expect("settings that make sense")
}

fn inputs<'a>(q: &'a Joints, goal: Goal<'a>, dt: f64) -> Inputs<'a> {
    Inputs { q, goal, base_twist: None, base_in_doubt: false, dt }
}

/// The twist with which these rates move the tool.
fn twist_of(build: &Build, robot: &Robot, q: &Joints, rates: &Joints) -> [f64; 6] {
    let columns = build.jacobian(robot, q, robot.tool(), JacobianAxes::Base);
    std::array::from_fn(|k| (0..robot.coordinates()).map(|j| columns[j][k] * rates[j]).sum())
}

/// A joint that runs into its limit stops there, however slowly its acceleration may change.
#[test]
fn a_limit_of_the_position_is_met_without_turning_back() {
    let robot = arm(1);
    for build in builds() {
        for most in [f64::INFINITY, 20.0] {
            let mut rate = made(&robot, |s| {
                (s.qd_max[0], s.qdd_max[0], s.qddd_max[0]) = (2.0, most, 50.0);
                (s.limits.0[0], s.limits.1[0]) = (-1.0, 0.3);
            });
            let mut q = Joints::default();
            for cycle in 0..3000 {
                let twist = twist_of(&build, &robot, &q, &Joints::from_slice(&[1.5]));
                (build.resolved_rate)(&robot, &mut rate, &inputs(&q, Goal::Move(&twist), DT));
                let qd = rate.output().qd[0];
                assert!(qd >= 0.0, "{} turns back in cycle {cycle} at {} with {qd}", build.name, q[0]);
                q[0] += DT * qd;
                assert!(q[0] <= 0.3, "{} is at {} in cycle {cycle}", build.name, q[0]);
            }
            assert!(q[0] > 0.29, "{} stays at {}", build.name, q[0]);
        }
    }
}

#[test]
fn a_step_of_no_length_is_not_one() {
    let robot = arm(7);
    for build in builds() {
        let mut rate =
            made(&robot, |s| (s.qdd_max, s.qddd_max) = (Joints([5.0; MAX_JOINTS]), Joints([50.0; MAX_JOINTS])));
        for dt in [5e-324, 1e-300, 1e-9, 0.0, -DT, f64::NAN, f64::INFINITY, 1e300] {
            (build.resolved_rate)(&robot, &mut rate, &inputs(&Joints::default(), Goal::Move(&[0.3; 6]), dt));
            assert!(rate.status().seen.has(Event::Time), "{dt}");
            assert!(rate.output().qd.iter().all(|x| x.abs() < 0.1), "{dt}: {:?}", rate.output().qd);
        }
    }
}

/// The joint that is named is the one that would go on, not one that leaves its limit.
#[test]
fn the_joint_that_stands_at_its_limit_is_named() {
    let robot = arm(6);
    for build in builds() {
        let mut rate = made(&robot, |s| {
            (s.limits.1[0], s.limits.1[1]) = (0.0, 0.0);
            (s.eps, s.lambda_max) = (1e-6, 1e-6);
        });
        let q = Joints::default();
        let twist = twist_of(&build, &robot, &q, &Joints::from_slice(&[-0.5, 0.5, 0.1, 0.1, 0.1, 0.1]));
        (build.resolved_rate)(&robot, &mut rate, &inputs(&q, Goal::Move(&twist), DT));
        assert_eq!(rate.output().limiting, Some((1, Limit::Position)), "{}", build.name);
        assert_eq!(rate.output().scale, 0.0);
        assert_eq!(rate.output().at_limits.of(Limit::Position), 1 << 1);
        assert_eq!(rate.output().at_limits.any(), 1 << 1);
    }
}

/// All joints that would go on are named, whether the motion is slowed down, bent or led uphill.
#[test]
fn all_joints_that_stand_at_limits_are_named() {
    let robot = arm(7);
    let (q, own) = (Joints::default(), Joints::from_slice(&[0.5, 0.5, 0.1, 0.1, 0.1, 3.0, 0.1]));
    for (build, priority) in builds().flat_map(|build| Priority::ALL.map(|priority| (build, priority))) {
        let mut rate = made(&robot, |s| {
            (s.limits.1[0], s.limits.1[1], s.priority) = (0.0, 0.0, priority);
            (s.qd_max, s.eps) = (Joints([0.05; MAX_JOINTS]), 1e-6);
        });
        let twist = twist_of(&build, &robot, &q, &own);
        (build.resolved_rate)(&robot, &mut rate, &inputs(&q, Goal::Move(&twist), DT));
        let (output, at) = (*rate.output(), rate.output().at_limits);
        let stands = |j: usize| output.qd[j].abs() == 0.05 || j < 2 && output.qd[j] == 0.0;
        for j in (0..MAX_JOINTS).filter(|j| at.has(*j)) {
            assert!(stands(j), "{} {}: joint {j} with {:?}", build.name, priority.name(), output.qd);
        }
        for limit in Limit::ALL {
            assert_eq!(rate.status().seen.has(limit.event()), at.of(limit) != 0, "{}", limit.name());
        }
        let (joint, limit) = output.limiting.expect("one stands");
        assert!(at.of(limit) >> joint & 1 == 1);
        if priority != Priority::Direction {
            assert!(at.any().count_ones() > 1, "{} {}: {at:?}", build.name, priority.name());
        }
        (build.resolved_rate)(&robot, &mut rate, &inputs(&Joints([f64::NAN; MAX_JOINTS]), Goal::Move(&twist), DT));
        assert_eq!(rate.output().at_limits.any(), 0);
    }
}

/// Three joints do what they can of six rows; what they leave is said, but not what rounding does.
#[test]
fn what_too_few_joints_leave_undone_is_said() {
    let robot = arm(3);
    let q = Joints([0.4; MAX_JOINTS]);
    for build in builds() {
        for damping in Damping::ALL.into_iter().filter(|damping| *damping != Damping::Constant) {
            let mut rate = made(&robot, |s| s.damping = damping);
            let own = twist_of(&build, &robot, &q, &Joints::from_slice(&[0.1, -0.2, 0.15]));
            for (twist, left) in [(own, false), ([0.1, 0.0, 0.2, 0.0, 0.3, 0.0], true), ([0.0; 6], false)] {
                (build.resolved_rate)(&robot, &mut rate, &inputs(&q, Goal::Move(&twist), DT));
                assert_eq!(rate.status().seen.has(Event::Undone), left, "{} {}", build.name, damping.name());
            }
        }
    }
}

/// However long a step is, a joint beyond its limit is led back half of the way at most.
#[test]
fn the_way_back_is_not_overshot() {
    let robot = arm(7);
    for build in builds() {
        for priority in [Priority::Task, Priority::Manipulability] {
            let mut rate = made(&robot, |s| {
                s.priority = priority;
                (s.limits.0[0], s.limits.1[0], s.qd_max) = (-1.0, 0.3, Joints([9.0; MAX_JOINTS]));
            });
            let mut q = Joints([0.1; MAX_JOINTS]);
            q[0] = 0.5;
            (build.resolved_rate)(&robot, &mut rate, &inputs(&q, Goal::Move(&[0.0; 6]), 0.8));
            let next = q[0] + 0.8 * rate.output().qd[0];
            assert!((0.39..0.5).contains(&next), "{} {}: {next}", build.name, priority.name());
        }
    }
}

#[test]
fn a_trocar_at_the_tip_is_said_and_bounded() {
    let robot = arm(7);
    let q = Joints([0.3; MAX_JOINTS]);
    for build in builds() {
        let tip = gravcomp::portable::forward_kinematics(&robot, &q, robot.tool());
        for away in [0.0, 1e-9, 1e-4, 0.2] {
            let mut rate = made(&robot, |s| {
                (s.task, s.qd_max) = (Task::RemoteCentre, Joints([2.0; MAX_JOINTS]));
                s.remote_centre = tip.fixed_view::<3, 1>(0, 3) - away * tip.fixed_view::<3, 1>(0, 2);
            });
            for _ in 0..20 {
                (build.resolved_rate)(&robot, &mut rate, &inputs(&q, Goal::Move(&[0.1, 0.2, -0.1, 0.0, 0.1, 0.0]), DT));
                assert_eq!(rate.status().seen.has(Event::Centre), away < 1e-3, "{away}");
                assert!(rate.output().qd.iter().all(|x| x.abs() <= 2.0));
            }
        }
    }
}

/// A trocar that is missing once is where it was, in that step and after it.
#[test]
fn a_trocar_that_is_no_point_is_forgotten() {
    let robot = arm(7);
    let q = Joints([0.3; MAX_JOINTS]);
    let (mut target, twist) = ([0.0; TARGET], [0.1, 0.0, 0.0, 0.0, 0.0, 0.0]);
    target[4] = f64::NAN;
    for build in builds() {
        let mut rate = made(&robot, |s| (s.task, s.remote_centre) = (Task::RemoteCentre, Vector3::new(0.2, 0.1, 0.4)));
        (build.resolved_rate)(&robot, &mut rate, &inputs(&q, Goal::Reach(&target, &[0.0; 6]), DT));
        assert!(rate.status().seen.has(Event::Target));
        (build.resolved_rate)(&robot, &mut rate, &inputs(&q, Goal::Move(&twist), DT));
        assert!(!rate.status().seen.has(Event::Overflow));
        assert!(rate.output().qd.iter().any(|x| *x != 0.0));
    }
    let nowhere = Settings { remote_centre: Vector3::new(0.0, f64::NAN, 0.0), ..Settings::of(7) };
    assert_eq!(ResolvedRate::new(nowhere).expect_err("no point").field, "remote_centre");
}

#[test]
fn a_target_that_is_no_rotation_is_missing() {
    let robot = arm(7);
    let mut sheared = [0.0; TARGET];
    for k in 0..4 {
        sheared[5 * k] = 1.0;
    }
    let (s, c) = 0.3_f64.sin_cos();
    (sheared[1], sheared[5]) = (s, c);
    for build in builds() {
        let mut rate = made(&robot, |_| ());
        (build.resolved_rate)(&robot, &mut rate, &inputs(&Joints::default(), Goal::Reach(&sheared, &[0.0; 6]), DT));
        assert!(rate.status().seen.has(Event::Target));
        assert_eq!(rate.output().qd, Joints::default());
    }
}

/// One joint and sixteen, every task, at rest and wound up, with limits that leave no room.
#[test]
fn arms_of_any_size_are_bounded_at_every_task() {
    for (joints, task, priority) in every() {
        let robot = arm(joints);
        for build in builds() {
            let mut rate = made(&robot, |s| {
                (s.task, s.priority) = (task, priority);
                (s.qd_max, s.qdd_max, s.qddd_max) =
                    (Joints([2.0; MAX_JOINTS]), Joints([20.0; MAX_JOINTS]), Joints([500.0; MAX_JOINTS]));
                s.limits = (Joints([-1e-12; MAX_JOINTS]), Joints([1e-12; MAX_JOINTS]));
            });
            for q in [0.0, 1e-12, 1.0, -4.0, 1e5].map(|x| Joints([x; MAX_JOINTS])) {
                for twist in [[0.0; 6], [1e6; 6], [1e-300; 6], [-3.0; 6]] {
                    (build.resolved_rate)(&robot, &mut rate, &inputs(&q, Goal::Move(&twist), DT));
                    let output = rate.output();
                    assert!(output.qd.iter().all(|x| x.abs() <= 2.0), "{joints} {} {:?}", task.name(), output.qd);
                    assert!(output.sigma_min.is_finite() && (0.0..=1.0).contains(&output.scale));
                }
            }
        }
    }
}

fn every() -> impl Iterator<Item = (usize, Task, Priority)> {
    [1, 2, 16].into_iter().flat_map(|joints| {
        Task::ALL.into_iter().flat_map(move |task| {
            let all = Priority::ALL.into_iter();
            all.filter(move |p| task != Task::RemoteCentre || *p != Priority::Manipulability)
                .map(move |p| (joints, task, p))
        })
    })
}
