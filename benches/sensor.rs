//! The base sensor's chain: a step of the control cycle without a new sample, one with a sample, and the whole bound cycle,
//! gate, calibration, filter and gravity torque.

use crate::arms::{Arm, SAMPLES};
use crate::functions::Level;
use criterion::Criterion;
use gravcomp::accelerometer::{Reading, Sample, Settings};
use gravcomp::{Accelerometer, Gravity, Joints, Mounting, Robot, Slot};
use nalgebra::{Matrix3, Vector3};
use std::hint::black_box;

/// A millisecond, ns.
const CYCLE_NS: i64 = 1_000_000;

/// Cycles at 1 kHz of a chain whose sensor sends at 100 Hz, already trusted.
struct Stream {
    chain: Accelerometer,
    cycle: i64,
    noise: Vec<Vector3<f64>>,
    has_gyro: bool,
}

impl Stream {
    fn new(has_gyro: bool) -> Self {
        let position = Vector3::new(0.3, -0.2, 0.1);
        let mounting = Mounting::new(Matrix3::identity(), position).expect("a rotation");
        let settings = Settings { mounting, ..Settings::default() };
        let chain = Accelerometer::new(settings).expect("the defaults make sense");
        // Far below any limit, and never twice the same in a row.
        let wave = |k: u32| 1.7 * f64::from(k);
        let noise = (0..257).map(|k| 1e-2 * Vector3::new(wave(k).sin(), (wave(k) + 1.0).sin(), (wave(k) + 2.0).sin()));
        let mut stream = Self { chain, cycle: 0, noise: noise.collect(), has_gyro };
        for _ in 0..100 {
            stream.with_sample(10);
        }
        stream
    }

    /// So many cycles later, with the sample that has come by then.
    #[inline]
    fn with_sample(&mut self, cycles: i64) -> Reading {
        self.cycle += cycles;
        let (seq, now_ns) = (self.cycle.cast_unsigned(), self.cycle * CYCLE_NS);
        #[allow(clippy::cast_possible_truncation)] // a remainder
        let noise = self.noise[(seq % self.noise.len() as u64) as usize];
        let sample = Sample {
            seq,
            stamp_ns: now_ns,
            specific_force: Vector3::new(0.0, 0.0, 9.8) + noise,
            angular_velocity: self.has_gyro.then_some(0.1 * noise),
        };
        self.chain.step(now_ns, Some(black_box(&sample)))
    }

    /// A cycle later, without one.
    #[inline]
    fn without_sample(&mut self) -> Reading {
        self.cycle += 1;
        self.chain.step(self.cycle * CYCLE_NS, None)
    }
}

/// The gravity torque in one build.
type GravityTorque = fn(&Robot, &Joints, &Gravity) -> Joints;

/// The builds that this processor runs.
fn builds() -> Vec<(Level, GravityTorque)> {
    let mut builds: Vec<(Level, GravityTorque)> = vec![(Level::Portable, gravcomp::portable::gravity_torque)];
    #[cfg(target_arch = "x86_64")]
    if Level::Avx2.available() {
        // SAFETY: AVX2 and FMA were detected just now.
        builds.push((Level::Avx2, |robot, q, g| unsafe { gravcomp::avx2::gravity_torque(robot, q, g) }));
    }
    builds
}

/// Times the whole cycle of an arm that gets its gravity from the chain.
fn bench_cycle(criterion: &mut Criterion, arm: &Arm, level: Level, gravity_torque: GravityTorque) {
    let mut place = 0;
    let mut torque = |reading: Reading| {
        place = (place + 1) % SAMPLES;
        black_box(gravity_torque(black_box(&arm.robot), &arm.samples[place].q, &reading.gravity));
    };
    let name = |what: &str| format!("accelerometer/{what}, gravity torque/{}/{}", level.name(), arm.joints());
    let mut stream = Stream::new(false);
    criterion.bench_function(&name("cycle with a sample"), |b| b.iter(|| torque(stream.with_sample(10))));
    criterion.bench_function(&name("ten cycles, one sample"), |b| {
        b.iter(|| {
            torque(stream.with_sample(1));
            (0..9).for_each(|_| torque(stream.without_sample()));
        });
    });
    assert!(stream.chain.armable(), "what was timed is a live sensor");
}

/// Times the steps, the whole cycles of every arm and build, and handing a sample from one thread to another.
pub fn bench(criterion: &mut Criterion, arms: &[Arm]) {
    for (name, has_gyro) in [("step with a sample", false), ("step with a sample, gyroscope", true)] {
        let mut stream = Stream::new(has_gyro);
        criterion.bench_function(&format!("accelerometer/{name}"), |b| b.iter(|| stream.with_sample(10)));
    }
    let stream = Stream::new(false);
    let (now_ns, mut chain) = (stream.cycle * CYCLE_NS, stream.chain);
    criterion.bench_function("accelerometer/step", |b| b.iter(|| chain.step(black_box(now_ns), None)));
    for arm in arms {
        for (level, gravity_torque) in builds() {
            bench_cycle(criterion, arm, level, gravity_torque);
        }
    }
    let slot = Slot::<9>::new();
    criterion.bench_function("accelerometer/slot put and take", |b| {
        b.iter(|| {
            slot.put(black_box(&[1; 9]));
            slot.take()
        });
    });
}
