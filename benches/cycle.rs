//! Time of every function at 3, 6 and 7 joints, and what it takes from the budget of a control cycle.
//!
//! `cargo bench -p gravcomp` (criterion's options follow `--`: a filter, `--test` for a single pass).

mod arms;
mod budget;
mod functions;

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
    /// Median time of `call` over the inputs in turn, ns; `None` where criterion was told to skip or only to try it.
    fn median<T>(&mut self, name: &str, level: Level, inputs: &[T], mut call: impl FnMut(&T)) -> Option<f64> {
        let mut rounds = Vec::new();
        self.criterion.bench_function(&format!("{name}/{}/{}", level.name(), self.arm.joints()), |b| {
            b.iter_custom(|calls| {
                let begin = Instant::now();
                for (_, input) in (0..calls).zip(inputs.iter().cycle()) {
                    call(black_box(input));
                }
                let taken = begin.elapsed();
                rounds.push(taken.div_duration_f64(Duration::from_nanos(calls)));
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
        if let Some(ns) = self.median(function, level, &self.arm.samples, call) {
            self.budget.cycle(function, self.arm.joints(), level, ns);
        }
    }

    fn batch(&mut self, function: &'static str, level: Level, call: impl FnMut(&Block)) {
        if let Some(ns) = self.median(function, level, &Block::all(&self.arm.samples), call) {
            self.budget.batch(function, self.arm.joints(), level, ns / WIDTH as f64);
        }
    }
}

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(ROUNDS)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(600))
        .nresamples(2000)
        .configure_from_args();
    let mut budget = Budget::default();
    for arm in &arms::all() {
        visit(arm, &mut Bench { arm, criterion: &mut criterion, budget: &mut budget });
    }
    criterion.final_summary();
    print!("{budget}");
}
