//! A full step of the control law: sensor slot, gate, gravity, PD, limits, transmission.
//!
//! At 1 kHz with a sensor at 100 Hz nine steps of ten find the slot empty; both kinds are timed, and the tenth with them.

use crate::arms::{Arm, Sample as Motion};
use crate::functions::Level;
use gravcomp::accelerometer::{Sample, Settings as SensorSettings};
use gravcomp::control::{Inputs, Kernels, Law, Settings, Side, State};
use gravcomp::{Accelerometer, Controller, Joints, MAX_JOINTS, Slot, Transmission};
use nalgebra::Vector3;
use std::hint::black_box;

/// A millisecond, ns.
const CYCLE_NS: i64 = 1_000_000;

/// The laws whose steps are measured.
const LAWS: [Law; 2] = [Law::PdDynamicGravity, Law::PdBaseMotion];

/// An arm under its law, with motor encoders, and a live sensor on its base.
pub struct Loop<'a> {
    arm: &'a Arm,
    motors: Vec<Joints>,
    sensor: Accelerometer,
    slot: Slot<4>,
    controller: Controller,
    cycle: i64,
    place: usize,
}

impl<'a> Loop<'a> {
    fn new(arm: &'a Arm, law: Law, kernels: Kernels) -> Self {
        let (n, gears) = (arm.joints(), gears(arm.joints()));
        let settings = Settings {
            kp: Joints([100.0; MAX_JOINTS]),
            kd: Joints([5.0; MAX_JOINTS]),
            tau_max: Joints([1e6; MAX_JOINTS]),
            tau_rate_max: Joints([1e9; MAX_JOINTS]),
            limits: (Joints([-4.0; MAX_JOINTS]), Joints([4.0; MAX_JOINTS])),
            jump: Joints([1e4; MAX_JOINTS]),
            feedback: Side::Motor,
            output: Side::Motor,
            transmission: Some(gears),
            ..Settings::of(law, n)
        };
        let sensor = Accelerometer::new(SensorSettings::default()).expect("the defaults make sense");
        let controller = Controller::new(settings, kernels).expect("settings that make sense");
        let motors = arm.samples.iter().map(|motion| gears.motor_positions(&motion.q)).collect();
        let mut this = Self { arm, motors, sensor, slot: Slot::new(), controller, cycle: 0, place: 0 };
        this.controller.arm();
        for _ in 0..2000 {
            this.send();
            for _ in 0..10 {
                this.step();
            }
        }
        assert_eq!(this.controller.state(), State::Armed);
        this
    }

    /// The sensor's thread: a sample with some noise.
    #[allow(clippy::cast_precision_loss)] // noise
    pub fn send(&self) {
        let noise = |axis: i64| 1e-2 * ((self.cycle + axis) as f64).sin();
        let force = [noise(1), noise(2), 9.8 + noise(3)].map(f64::to_bits);
        self.slot.put(&[self.cycle.cast_unsigned() + 1, force[0], force[1], force[2]]);
    }

    /// The control thread.
    #[inline]
    pub fn step(&mut self) {
        self.cycle += 1;
        let place = self.place;
        self.place = (place + 1) % self.arm.samples.len();
        let (motion, q): (&Motion, _) = (&self.arm.samples[place], &self.motors[place]);
        let next = &self.arm.samples[self.place];
        let now_ns = self.cycle * CYCLE_NS;
        let sample = self.slot.take().map(|[seq, force @ ..]| Sample {
            seq,
            stamp_ns: now_ns,
            specific_force: Vector3::from(force.map(f64::from_bits)),
            angular_velocity: None,
        });
        let reading = self.sensor.step(now_ns, sample.as_ref());
        let inputs = Inputs {
            q,
            qd: Some(&motion.qd),
            q_link: None,
            q_desired: &next.q,
            qd_desired: &next.qd,
            base: &reading.base,
            disturbances: None,
            armable: self.sensor.armable(),
        };
        black_box(self.controller.step(black_box(&self.arm.robot), &inputs));
    }
}

/// The RAVEN II's cables, or a gear of 100 at each joint.
fn gears(n: usize) -> Transmission {
    let raven = [136.196, 0.0, 0.0, 17.675, 121.522, 0.0, 16.831, 17.436, 2158.59];
    let cables = |i: usize, j: usize| raven[3 * i + j];
    let entry = |i: usize, j: usize| if i == j { 100.0 } else { 0.0 };
    let motor_per_joint = nalgebra::DMatrix::from_fn(n, n, |i, j| if n == 3 { cables(i, j) } else { entry(i, j) });
    let joint_per_motor = motor_per_joint.try_inverse().expect("triangular");
    Transmission::new(joint_per_motor.transpose().as_slice(), &vec![0.0; n]).expect("can be inverted")
}

/// The builds that this processor runs.
fn builds() -> Vec<(Level, Kernels)> {
    let mut builds = vec![(Level::Portable, Kernels::PORTABLE)];
    #[cfg(target_arch = "x86_64")]
    if Level::Avx2.available() {
        let kernels = Kernels {
            // SAFETY: AVX2 and FMA were detected just now.
            cycle: |law, robot, inputs| unsafe { gravcomp::control::avx2::cycle(law, robot, inputs) },
        };
        builds.push((Level::Avx2, kernels));
    }
    builds
}

/// Hands over the loop of an arm for every law and build.
pub fn visit(arm: &Arm, mut see: impl FnMut(Law, Level, &mut Loop<'_>)) {
    for (level, kernels) in builds() {
        for law in LAWS {
            see(law, level, &mut Loop::new(arm, law, kernels));
        }
    }
}
