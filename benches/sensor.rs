//! The base sensor's chain: a step of the control cycle without a new sample, and one with a sample.

use criterion::Criterion;
use gravcomp::accelerometer::{Sample, Settings};
use gravcomp::{Accelerometer, Mounting, Slot};
use nalgebra::{Matrix3, Vector3};
use std::hint::black_box;

/// Steps at 1 kHz of a chain whose sensor sends at 100 Hz, already trusted.
struct Stream {
    chain: Accelerometer,
    step: i64,
    phase: f64,
    has_gyro: bool,
}

impl Stream {
    fn new(has_gyro: bool) -> Self {
        let position = Vector3::new(0.3, -0.2, 0.1);
        let mounting = Mounting::new(Matrix3::identity(), position).expect("a rotation");
        let settings = Settings { mounting, ..Settings::default() };
        let chain = Accelerometer::new(settings).expect("the defaults make sense");
        let mut stream = Self { chain, step: 0, phase: 0.0, has_gyro };
        for _ in 0..100 {
            stream.with_sample();
        }
        stream
    }

    /// A millisecond later, with the sample that has come by then.
    fn with_sample(&mut self) {
        self.step += 10;
        // Noise that never repeats, far below any limit.
        self.phase += 1.7;
        let noise = 1e-2 * Vector3::new(self.phase.sin(), (self.phase + 1.0).sin(), (self.phase + 2.0).sin());
        let sample = Sample {
            seq: self.step.cast_unsigned(),
            stamp_ns: self.step * 1_000_000,
            specific_force: Vector3::new(0.0, 0.0, 9.8) + noise,
            angular_velocity: self.has_gyro.then_some(0.1 * noise),
        };
        black_box(self.chain.step(self.step * 1_000_000, Some(&sample)));
    }
}

/// Times the steps, and handing a sample from one thread to another.
pub fn bench(criterion: &mut Criterion) {
    for (name, has_gyro) in [("step with a sample", false), ("step with a sample, gyroscope", true)] {
        let mut stream = Stream::new(has_gyro);
        criterion.bench_function(&format!("accelerometer/{name}"), |b| b.iter(|| stream.with_sample()));
    }
    let stream = Stream::new(false);
    let (now_ns, mut chain) = (stream.step * 1_000_000, stream.chain);
    criterion.bench_function("accelerometer/step", |b| b.iter(|| chain.step(black_box(now_ns), None)));
    let slot = Slot::<9>::new();
    criterion.bench_function("accelerometer/slot put and take", |b| {
        b.iter(|| {
            slot.put(black_box(&[1; 9]));
            slot.take()
        });
    });
}
