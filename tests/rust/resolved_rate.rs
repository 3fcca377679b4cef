//! Resolved-rate motion on any robot: the task is done, or the rates are bounded, and nothing that comes in can break it.

use crate::arms::{arms, joints};
use crate::builds::{Build, builds};
use gravcomp::resolved_rate::{Damping, Goal, Inputs, Priority, Settings, TARGET, Task};
use gravcomp::{JacobianAxes, Joints, MAX_JOINTS, ResolvedRate, Robot};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

const DT: f64 = 1e-3;
const MOST: f64 = 2.0;

/// An arm without limits.
fn free(robot: &Robot, change: impl FnOnce(&mut Settings)) -> ResolvedRate {
    let mut settings = Settings::of(robot.coordinates());
    change(&mut settings);
    ResolvedRate::new(settings).expect("settings that make sense")
}

fn step(build: &Build, robot: &Robot, rate: &mut ResolvedRate, q: &Joints, twist: &[f64; 6]) -> Joints {
    (build.resolved_rate)(
        robot,
        rate,
        &Inputs { q, goal: Goal::Move(twist), base_twist: None, base_in_doubt: false, dt: DT },
    );
    rate.output().qd
}

fn jacobian(build: &Build, robot: &Robot, q: &Joints) -> DMatrix<f64> {
    let columns = build.jacobian(robot, q, robot.tool(), JacobianAxes::Base);
    DMatrix::from_fn(6, robot.coordinates(), |k, j| columns[j][k])
}

fn twist() -> impl Strategy<Value = [f64; 6]> {
    proptest::array::uniform6(-2.0..2.0)
}

/// Numbers that occur, and those that should not.
fn anything() -> impl Strategy<Value = f64> {
    prop_oneof![8 => -3.0..3.0, 1 => Just(f64::NAN), 1 => Just(f64::INFINITY), 1 => Just(-1e300), 1 => Just(0.0), 1 => any::<f64>()]
}

fn damping() -> impl Strategy<Value = Damping> {
    proptest::sample::select(Damping::ALL.to_vec())
}

fn priority() -> impl Strategy<Value = Priority> {
    proptest::sample::select(Priority::ALL.to_vec())
}

fn task() -> impl Strategy<Value = Task> {
    proptest::sample::select(Task::ALL.to_vec())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn the_task_is_done_as_well_as_can_be_away_from_singularities(arm in arms(), q in joints(3.0), twist in twist()) {
        let robot = arm.build();
        for build in builds() {
            let J = jacobian(&build, &robot, &q);
            let svd = J.clone().svd(true, true);
            let (most, least) = (svd.singular_values.max(), svd.singular_values.min());
            let mut rate = free(&robot, |_| ());
            let qd = step(&build, &robot, &mut rate, &q, &twist);
            prop_assert!(qd.iter().all(|x| x.is_finite()));
            if least > 0.041 {
                let wanted = svd.solve(&DVector::from_column_slice(&twist), 0.0).expect("both bases");
                let scale = 1e-13 * (most / least).powi(2) * (1.0 + wanted.amax());
                for j in 0..robot.coordinates() {
                    prop_assert!((qd[j] - wanted[j]).abs() <= 1e-12 + scale, "{} {j}: {} {}", build.name, qd[j], wanted[j]);
                }
                // It is tracked: one step shows what lies near it too.
                for _ in 0..20 {
                    step(&build, &robot, &mut rate, &q, &twist);
                }
                prop_assert!((rate.output().sigma_min / least - 1.0).abs() < 0.01);
            }
        }
    }

    #[test]
    fn rates_are_within_limits_and_finite_whatever_comes_in(
        arm in arms(),
        task in task(),
        damping in damping(),
        priority in priority(),
        steps in proptest::collection::vec(
            (proptest::array::uniform16(anything()), proptest::array::uniform16(anything()), proptest::array::uniform6(anything()), anything(), any::<bool>()),
            1..6,
        ),
    ) {
        let robot = arm.build();
        let priority = if task == Task::RemoteCentre { Priority::Direction } else { priority };
        for build in builds() {
            let mut rate = free(&robot, |s| {
                (s.task, s.damping, s.priority) = (task, damping, priority);
                (s.qd_max, s.qdd_max) = (Joints([MOST; MAX_JOINTS]), Joints([100.0; MAX_JOINTS]));
                s.limits = (Joints([-1.0; MAX_JOINTS]), Joints([1.0; MAX_JOINTS]));
            });
            for (q, target, twist, dt, reach) in &steps {
                let goal = if *reach { Goal::Reach(target, twist) } else { Goal::Move(twist) };
                let inputs = Inputs { q: &Joints(*q), goal, base_twist: Some(twist), base_in_doubt: false, dt: *dt };
                (build.resolved_rate)(&robot, &mut rate, &inputs);
                let output = rate.output();
                prop_assert!(output.qd.iter().all(|x| x.abs() <= MOST));
                prop_assert!((0.0..=1.0).contains(&output.scale), "{}", output.scale);
                prop_assert!(output.damping.is_finite());
            }
            let calm = step(&build, &robot, &mut rate, &Joints::default(), &[0.0; 6]);
            prop_assert!(calm.iter().all(|x| x.is_finite()));
        }
    }

    #[test]
    fn no_twist_is_no_motion(arm in arms(), q in joints(3.0), damping in damping()) {
        let robot = arm.build();
        for build in builds() {
            let mut rate = free(&robot, |s| s.damping = damping);
            prop_assert_eq!(step(&build, &robot, &mut rate, &q, &[0.0; 6]), Joints::default());
        }
    }

    #[test]
    fn both_widths_of_the_arithmetic_agree(arm in arms(), q in joints(3.0), twist in twist()) {
        let robot = arm.build();
        let qd: Vec<Joints> = builds().map(|build| step(&build, &robot, &mut free(&robot, |s| s.damping = Damping::Constant), &q, &twist)).collect();
        for j in 0..robot.coordinates() {
            prop_assert!((qd[0][j] - qd[qd.len() - 1][j]).abs() <= 1e-9 * (1.0 + qd[0][j].abs()));
        }
    }
}

#[test]
fn a_bad_target_holds_the_tool() {
    let arm = crate::no_heap::chain();
    for build in builds() {
        let mut rate = free(&arm, |_| ());
        let inputs = Inputs {
            q: &Joints::default(),
            goal: Goal::Reach(&[f64::NAN; TARGET], &[1.0; 6]),
            base_twist: None,
            base_in_doubt: false,
            dt: DT,
        };
        (build.resolved_rate)(&arm, &mut rate, &inputs);
        assert_eq!(rate.output().qd, Joints::default());
    }
}
