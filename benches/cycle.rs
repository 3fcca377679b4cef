//! Time of every function at 3, 6 and 7 joints, and what it takes from the budget of a control cycle.
//!
//! `cargo bench -p gravcomp` (criterion's options follow `--`: a filter, `--test` for a single pass).

mod arms;
mod budget;
mod control;
mod functions;
mod predictor;
mod resolved_rate;
mod sensor;

use arms::{Arm, Sample};
use budget::Budget;
use criterion::Criterion;
use functions::{Block, Level, Visitor, WIDTH, visit};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Measurements that criterion takes of each function.
const ROUNDS: usize = 30;

/// Times the functions of one arm.
struct Bench<'a> {
    arm: &'a Arm,
    criterion: &'a mut Criterion,
    budget: &'a mut Budget,
}

impl Bench<'_> {
    /// The library's sines and cosines of all angles: what a cycle that uses them pays before anything else.
    fn yardstick(&mut self) {
        let joints = self.arm.joints();
        let sines = |sample: &Sample| {
            for angle in &sample.q[..joints] {
                black_box(black_box(*angle).sin_cos());
            }
        };
        if let Some(ns) = self.median(&format!("yardstick/std/{joints}"), 1, &self.arm.samples, sines) {
            self.budget.yardstick(joints, ns);
        }
    }

    /// Median time per configuration, ns, of `call` over the inputs in turn, each of which holds `width` configurations;
    /// `None` where criterion was told to skip it or only to try.
    fn median<T>(&mut self, name: &str, width: usize, inputs: &[T], mut call: impl FnMut(&T)) -> Option<f64> {
        let mut rounds = Vec::new();
        self.criterion.bench_function(name, |b| {
            b.iter_custom(|calls| {
                let begin = Instant::now();
                for (_, input) in (0..calls).zip(inputs.iter().cycle()) {
                    call(black_box(input));
                }
                let taken = begin.elapsed();
                rounds.push(taken.div_duration_f64(Duration::from_nanos(calls * width as u64)));
                taken
            });
        });
        // The warm-up comes first.
        let rounds = rounds.last_chunk_mut::<ROUNDS>()?;
        rounds.sort_unstable_by(f64::total_cmp);
        Some(rounds[ROUNDS / 2])
    }
}

impl Visitor for Bench<'_> {
    fn cycle(&mut self, function: &'static str, level: Level, call: impl FnMut(&Sample)) {
        let name = format!("{function}/{}/{}", level.name(), self.arm.joints());
        if let Some(ns) = self.median(&name, 1, &self.arm.samples, call) {
            self.budget.cycle(function, self.arm.joints(), level, ns);
        }
    }

    fn batch(&mut self, function: &'static str, level: Level, call: impl FnMut(&Block)) {
        let name = format!("{function}/{}/{}", level.name(), self.arm.joints());
        if let Some(ns) = self.median(&name, WIDTH, &Block::all(&self.arm.samples), call) {
            self.budget.batch(function, self.arm.joints(), level, ns);
        }
    }
}

/// Times the steps of every arm, law with a live sensor, and build.
fn bench_control(criterion: &mut Criterion, arm: &Arm) {
    control::visit(arm, |law, level, cycle| {
        let name = |what: &str| format!("control/{} {what}/{}/{}", law.name(), level.name(), arm.joints());
        criterion.bench_function(&name("step"), |b| b.iter(|| cycle.step()));
        criterion.bench_function(&name("ten steps, one sample"), |b| {
            b.iter(|| {
                cycle.send();
                (0..10).for_each(|_| cycle.step());
            });
        });
    });
}

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(ROUNDS)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(600))
        .nresamples(2000)
        .configure_from_args();
    let mut budget = Budget::default();
    let arms = arms::all();
    for arm in &arms {
        let mut bench = Bench { arm, criterion: &mut criterion, budget: &mut budget };
        bench.yardstick();
        visit(arm, &mut bench);
    }
    sensor::bench(&mut criterion, &arms);
    for arm in &arms {
        bench_control(&mut criterion, arm);
    }
    predictor::bench(&mut criterion);
    resolved_rate::bench(&mut criterion, &arms);
    criterion.final_summary();
    print!("{budget}");
}
