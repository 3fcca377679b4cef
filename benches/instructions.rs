//! Work to be counted by callgrind: prints one line per counted block. `benches/instructions.py` runs and reads it.
//!
//! Each function runs on a few poses, each pose twice with different numbers of calls, so that the difference is the
//! calls' own cost without that of starting the block.

mod arms;
mod functions;

use arms::{Arm, Sample};
use functions::{Block, Level, Visitor, visit};
use std::hint::black_box;

/// Poses that each function is counted on.
const POSES: usize = 8;

/// Calls in the two blocks of a pose.
const CALLS: [usize; 2] = [1, 11];

/// Counts the functions of one arm.
struct Count<'a>(&'a Arm);

impl Count<'_> {
    fn run<T>(&self, function: &str, level: Level, inputs: &[T], mut call: impl FnMut(&T)) {
        // The first call of all may do work that later ones do not.
        call(&inputs[0]);
        for (pose, input) in inputs.iter().enumerate().take(POSES) {
            for calls in CALLS {
                counted(calls, &mut || call(black_box(input)));
                println!("{function} {} {} {pose} {calls}", level.name(), self.0.joints());
            }
        }
    }
}

impl Visitor for Count<'_> {
    fn cycle(&mut self, function: &'static str, level: Level, call: impl FnMut(&Sample)) {
        self.run(function, level, &self.0.samples, call);
    }

    fn batch(&mut self, function: &'static str, level: Level, call: impl FnMut(&Block)) {
        self.run(function, level, &Block::all(&self.0.samples), call);
    }
}

/// The only function in which callgrind counts.
#[inline(never)]
fn counted(calls: usize, work: &mut dyn FnMut()) {
    for _ in 0..calls {
        work();
    }
}

fn main() {
    for arm in &arms::all() {
        visit(arm, &mut Count(arm));
    }
}
