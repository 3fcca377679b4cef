//! A step of resolved-rate motion, in each of its ways, on an arm that moves a little from step to step.

use crate::arms::Arm;
use crate::functions::Level;
use criterion::Criterion;
use gravcomp::resolved_rate::{Goal, Inputs, NullSpace, Priority, Settings, TARGET, Task};
use gravcomp::{Joints, MAX_JOINTS, ResolvedRate};
use std::f64::consts::TAU;
use std::hint::black_box;

/// Steps of a round trip.
const STEPS: usize = 1024;

/// What is declared for a way to compute a step.
type Way = fn(&mut Settings);

/// Ways to compute a step, by name.
const WAYS: [(&str, Way); 7] = [
    ("damped", |_| ()),
    ("position", |s| s.task = Task::Position),
    ("pointing", |s| s.task = Task::Pointing),
    ("null space", |s| s.null_space = NullSpace::Posture),
    ("midpoint", |s| s.midpoint = true),
    ("limits qp", |s| (s.priority, s.qd_max) = (Priority::Task, Joints([0.1; MAX_JOINTS]))),
    ("manipulability", |s| s.priority = Priority::Manipulability),
];

/// Times the ways at 3, 6 and 7 joints.
pub fn bench(criterion: &mut Criterion, arms: &[Arm]) {
    for arm in arms {
        for (name, way) in WAYS {
            time(criterion, &format!("resolved_rate/{name}"), arm, way, false);
        }
        time(criterion, "resolved_rate/closed loop", arm, |_| (), true);
    }
}

fn time(criterion: &mut Criterion, name: &str, arm: &Arm, way: Way, closed: bool) {
    let n = arm.joints();
    let mut settings = Settings { qd_max: Joints([2.0; MAX_JOINTS]), ..Settings::of(n) };
    way(&mut settings);
    let poses: Vec<Joints> = (0..STEPS).map(|k| near(&arm.samples[0].q, k)).collect();
    let (twist, target) = ([0.05, -0.02, 0.03, 0.1, 0.05, -0.1], target(arm));
    for level in [Level::Portable, Level::Avx2].into_iter().filter(|level| level.available()) {
        let mut rate = ResolvedRate::new(settings).expect("settings that make sense");
        criterion.bench_function(&format!("{name}/{}/{n}", level.name()), |b| {
            let mut places = (0..STEPS).cycle();
            b.iter(|| {
                let q = &poses[places.next().unwrap_or(0)];
                let goal = if closed { Goal::Reach(&target, &twist) } else { Goal::Move(&twist) };
                let inputs = black_box(Inputs { q, goal, base_twist: Some(&twist), base_in_doubt: false, dt: 1e-3 });
                step(level, arm, &mut rate, &inputs);
                black_box(rate.output());
            });
        });
    }
}

fn step(level: Level, arm: &Arm, rate: &mut ResolvedRate, inputs: &Inputs<'_>) {
    match level {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: only levels that the processor has are timed.
        Level::Avx2 => unsafe { gravcomp::avx2::resolved_rate(&arm.robot, rate, inputs) },
        _ => gravcomp::portable::resolved_rate(&arm.robot, rate, inputs),
    }
}

/// A pose on a small round trip.
#[allow(clippy::cast_precision_loss)] // a few steps
fn near(q: &Joints, k: usize) -> Joints {
    let turn = TAU * k as f64 / STEPS as f64;
    Joints(std::array::from_fn(|j| q[j] + 0.1 * (turn + j as f64).sin()))
}

/// The pose of the first sample, row by row.
fn target(arm: &Arm) -> [f64; TARGET] {
    let pose = gravcomp::portable::forward_kinematics(&arm.robot, &arm.samples[0].q, arm.robot.tool());
    std::array::from_fn(|k| pose[(k / 4, k % 4)])
}
