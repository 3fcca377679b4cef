//! Our kernels on the inputs that `benches/native.py` writes; `benches/native/pinocchio.cpp` is the same for pinocchio's.
//!
//! `native LEVEL INPUTS OPERATION MILLISECONDS` prints ns per call: the median of passes over all samples.
//! `native LEVEL INPUTS OPERATION 0` prints what was computed, a sample per line, matrices by rows.

mod inputs;

use gravcomp::resolved_rate::{Damping, Settings};
use gravcomp::{Joints, MAX_JOINTS, ResolvedRate, Robot};
use inputs::{Inputs, Sample};
use nalgebra::Matrix4;
use std::hint::black_box;
use std::time::{Duration, Instant};
use std::{env, fs};

/// λ of the damped inverse, on either side.
const DAMPING: f64 = 0.05;

/// Where the operations leave what they compute.
struct Out {
    tau: Joints,
    pose: Matrix4<f64>,
    jacobian: [f64; 6 * MAX_JOINTS],
    rate: ResolvedRate,
}

impl Out {
    fn of(joints: usize) -> Self {
        let damped = Settings {
            damping: Damping::Constant,
            lambda_max: DAMPING,
            characteristic_length: 1.0,
            ..Settings::of(joints)
        };
        let rate = ResolvedRate::new(damped).expect("settings that make sense");
        Self { tau: Joints::default(), pose: Matrix4::zeros(), jacobian: [0.0; 6 * MAX_JOINTS], rate }
    }
}

/// Computes once from a sample, on a processor that has the instructions of the operation's build.
type Operation = unsafe fn(&Robot, &Sample, &mut Out);

macro_rules! operations {
    ($level:ident $(, $target:meta)?) => {
        mod $level {
            use super::{Operation, Out, Robot, Sample};
            use gravcomp::resolved_rate::{Goal, Inputs};
            use gravcomp::{JacobianAxes, $level};

            $(#[$target])?
            fn gravity(robot: &Robot, s: &Sample, out: &mut Out) {
                out.tau = $level::gravity_torque(robot, &s.q, &s.g);
            }

            $(#[$target])?
            fn kinematics(robot: &Robot, s: &Sample, out: &mut Out) {
                out.pose = $level::forward_kinematics(robot, &s.q, robot.tool());
            }

            $(#[$target])?
            fn jacobian(robot: &Robot, s: &Sample, out: &mut Out) {
                $level::jacobian(robot, &s.q, robot.tool(), JacobianAxes::Base, &mut out.jacobian);
            }

            $(#[$target])?
            fn inverse_dynamics(robot: &Robot, s: &Sample, out: &mut Out) {
                out.tau = $level::inverse_dynamics(robot, &s.q, &s.qd, &s.qdd, &s.rest);
            }

            $(#[$target])?
            fn moving_base(robot: &Robot, s: &Sample, out: &mut Out) {
                out.tau = $level::inverse_dynamics(robot, &s.q, &s.qd, &s.qdd, &s.moving);
            }

            $(#[$target])?
            fn resolved_rate(robot: &Robot, s: &Sample, out: &mut Out) {
                let goal = Goal::Move(&s.twist);
                let inputs = Inputs { q: &s.near, goal, base_twist: None, base_in_doubt: false, dt: 1e-3 };
                $level::resolved_rate(robot, &mut out.rate, &inputs);
                out.tau = out.rate.output().qd;
            }

            pub fn named(operation: &str) -> Operation {
                match operation {
                    "gravity" => gravity,
                    "kinematics" => kinematics,
                    "jacobian" => jacobian,
                    "inverse_dynamics" => inverse_dynamics,
                    "moving_base" => moving_base,
                    "resolved_rate" => resolved_rate,
                    _ => panic!("no operation {operation}"),
                }
            }
        }
    };
}

operations!(portable);
#[cfg(target_arch = "x86_64")]
operations!(avx2, target_feature(enable = "avx2,fma"));

fn operation(name: &str, level: &str) -> Operation {
    match level {
        "portable" => portable::named(name),
        #[cfg(target_arch = "x86_64")]
        "avx2" if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") => avx2::named(name),
        _ => panic!("this processor has no build {level}"),
    }
}

/// An arm with the operation that is computed.
struct Work {
    inputs: Inputs,
    operation: Operation,
    out: Out,
}

impl Work {
    fn call(&mut self, k: usize) {
        // SAFETY: `operation` detected the instructions of the builds that it gives out.
        unsafe { (self.operation)(&self.inputs.robot, black_box(&self.inputs.samples[k]), &mut self.out) };
        black_box(&mut self.out);
    }

    /// Time of one call in ns, from a pass over all samples.
    fn pass(&mut self) -> f64 {
        let begin = Instant::now();
        for k in 0..self.inputs.samples.len() {
            self.call(k);
        }
        begin.elapsed().div_duration_f64(Duration::from_nanos(self.inputs.samples.len() as u64))
    }

    fn median(&mut self, duration: Duration) -> f64 {
        let (mut passes, begin) = (Vec::new(), Instant::now());
        while begin.elapsed() < duration {
            passes.push(self.pass());
        }
        passes.sort_unstable_by(f64::total_cmp);
        passes[passes.len() / 2]
    }

    /// What the operation of this name left.
    fn numbers(&self, name: &str) -> Vec<f64> {
        let n = self.inputs.robot.coordinates();
        match name {
            "kinematics" => self.out.pose.transpose().as_slice().to_vec(),
            "jacobian" => self.out.jacobian[..6 * n].to_vec(),
            _ => self.out.tau[..n].to_vec(),
        }
    }
}

fn main() {
    let arguments: Vec<_> = env::args().skip(1).collect();
    let [level, inputs, name, milliseconds] = &arguments[..] else { panic!("LEVEL INPUTS OPERATION MILLISECONDS") };
    let text = fs::read_to_string(inputs).expect("the file of inputs is readable");
    let inputs = Inputs::read(&text).expect("the robot is possible");
    let out = Out::of(inputs.robot.coordinates());
    let mut work = Work { inputs, operation: operation(name, level), out };
    match milliseconds.parse().expect("a number of milliseconds") {
        0 => (0..work.inputs.samples.len()).for_each(|k| {
            work.call(k);
            let words: Vec<_> = work.numbers(name).iter().map(f64::to_string).collect();
            println!("{}", words.join(" "));
        }),
        duration => println!("{}", work.median(Duration::from_millis(duration))),
    }
}
