//! Work to be counted by callgrind: `benches/instructions.py` runs and reads it.
//!
//! Without arguments it lists what can be counted here, a function and a build per line. With those two as arguments it
//! runs that function on a few poses of each arm, each pose in two blocks with different numbers of calls, so that the
//! difference is the calls' own cost without that of starting the block; it prints a line per block.

mod arms;
mod control;
mod functions;

use arms::{Arm, Sample};
use functions::{Block, Level, Visitor, visit};
use std::env;
use std::hint::black_box;

/// Poses that each function is counted on.
const POSES: usize = 8;

/// Calls in the two blocks of a pose.
const CALLS: [usize; 2] = [1, 11];

/// Lists the functions of one arm, or runs the chosen one.
struct Count<'a> {
    arm: &'a Arm,
    chosen: Option<&'a [String; 2]>,
}

impl Count<'_> {
    fn show<T>(&self, function: &str, level: Level, inputs: &[T], call: impl FnMut(&T)) {
        match self.chosen {
            None => println!("{function} {}", level.name()),
            Some([name, build]) if name == function && build == level.name() => self.run(inputs, call),
            Some(_) => {}
        }
    }

    fn run<T>(&self, inputs: &[T], mut call: impl FnMut(&T)) {
        // The first call of all may do work that later ones do not.
        call(&inputs[0]);
        for (pose, input) in inputs.iter().enumerate().take(POSES) {
            for calls in CALLS {
                counted(calls, &mut || call(black_box(input)));
                println!("{} {pose} {calls}", self.arm.joints());
            }
        }
    }
}

impl Visitor for Count<'_> {
    fn cycle(&mut self, function: &'static str, level: Level, call: impl FnMut(&Sample)) {
        self.show(function, level, &self.arm.samples, call);
    }

    fn batch(&mut self, function: &'static str, level: Level, call: impl FnMut(&Block)) {
        self.show(function, level, &Block::all(&self.arm.samples), call);
    }
}

/// Steps of the laws with a live sensor: one that finds its slot empty, as nine of ten do, and one that finds a sample.
fn visit_steps(arm: &Arm, count: &Count<'_>) {
    control::visit(arm, |law, level, cycle| {
        let step = format!("step_{}", law.name());
        count.show(&step, level, &[(); POSES], |()| cycle.step());
        count.show(&format!("{step}_sample"), level, &[(); POSES], |()| {
            cycle.send();
            cycle.step();
        });
    });
}

/// The only function in which callgrind counts.
#[inline(never)]
fn counted(calls: usize, work: &mut dyn FnMut()) {
    for _ in 0..calls {
        work();
    }
}

fn main() {
    let arguments: Vec<_> = env::args().skip(1).collect();
    let chosen = arguments.first_chunk();
    let arms = arms::all();
    for arm in if chosen.is_some() { &arms[..] } else { &arms[..1] } {
        let mut count = Count { arm, chosen };
        visit(arm, &mut count);
        visit_steps(arm, &count);
    }
}
