//! A base that rocks, and the inertial sensor on it: what is true, and what the sensor feels.

use super::random::Random;
use gravcomp::{BaseMotion, Mounting, STANDARD_GRAVITY, SpecificForce};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Noise of the accelerometer, m/s², and of the gyroscope, rad/s.
const NOISE: (f64, f64) = (0.03, 0.003);

/// The base turns by θ = θ₀ + A sin(2π f t + φ) about a horizontal axis n through a pivot.
#[derive(Clone, Debug)]
pub struct World {
    axis: Vector3<f64>,
    mid: f64,
    amplitude: f64,
    rate: f64,
    phase: f64,
    /// From the pivot to the base origin, m.
    arm: Vector3<f64>,
    rotation: Matrix3<f64>,
    position: Vector3<f64>,
    pub has_gyro: bool,
}

impl World {
    /// 10-20° at 1 Hz about any horizontal axis. Every second sensor has a gyroscope, if nothing else is wanted; one that has
    /// sits away from the base origin.
    pub fn rocking(random: &mut Random, gyro: Option<bool>) -> Self {
        let heading = random.within(0.0, TAU);
        let any = random.chance(0.5);
        let has_gyro = gyro.unwrap_or(any);
        let quarters = [0.0, 1.0, 2.0, 3.0][random.below(4)];
        let turned = Rotation3::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2 * quarters);
        let yaw = Rotation3::from_axis_angle(&Vector3::z_axis(), random.within(0.0, TAU));
        Self {
            axis: Vector3::new(heading.cos(), heading.sin(), 0.0),
            mid: 15_f64.to_radians(),
            amplitude: 5_f64.to_radians(),
            rate: TAU,
            phase: random.within(0.0, TAU),
            arm: 0.3 * random.direction(),
            rotation: (yaw * turned).into_inner(),
            position: if has_gyro { 0.3 * random.direction() } else { Vector3::zeros() },
            has_gyro,
        }
    }

    pub fn mounting(&self) -> Mounting {
        Mounting::new(self.rotation, self.position).expect("a rotation")
    }

    /// Motion of the base at time `t`, s.
    pub fn motion(&self, t: f64) -> BaseMotion {
        let (angle, spin, swing) = self.angle(t);
        BaseMotion {
            specific_force: SpecificForce(self.force_at(angle, spin, swing, &self.arm)),
            angular_velocity: spin * self.axis,
            angular_acceleration: swing * self.axis,
        }
    }

    /// What an ideal accelerometer with the sensor's place reads, in base axes, m/s².
    pub fn force_at_sensor(&self, t: f64) -> Vector3<f64> {
        let (angle, spin, swing) = self.angle(t);
        self.force_at(angle, spin, swing, &(self.arm + self.position))
    }

    /// What the sensor sends, in its own axes: specific force, m/s², and angular velocity, rad/s.
    pub fn sensed(&self, t: f64, random: &mut Random) -> (Vector3<f64>, Option<Vector3<f64>>) {
        let back = self.rotation.transpose();
        let force = back * self.force_at_sensor(t) + NOISE.0 * random.normals();
        let (_, spin, _) = self.angle(t);
        (force, self.has_gyro.then(|| back * (spin * self.axis) + NOISE.1 * random.normals()))
    }

    /// The sensor's axis that is closest to the vertical of a level base.
    pub fn vertical_axis(&self) -> usize {
        (self.rotation.transpose() * Vector3::z()).iamax()
    }

    /// θ, θ̇, θ̈.
    fn angle(&self, t: f64) -> (f64, f64, f64) {
        let (sin, cos) = (self.rate * t + self.phase).sin_cos();
        let (a, r) = (self.amplitude, self.rate);
        (self.mid + a * sin, a * r * cos, -a * r * r * sin)
    }

    /// f = Rᵀ (0, 0, g) + θ̈ n × d + θ̇² n × (n × d).
    fn force_at(&self, angle: f64, spin: f64, swing: f64, d: &Vector3<f64>) -> Vector3<f64> {
        let (n, up) = (&self.axis, Vector3::z());
        let rest = STANDARD_GRAVITY * (up * angle.cos() - n.cross(&up) * angle.sin());
        rest + swing * n.cross(d) + spin * spin * n.cross(&n.cross(d))
    }
}
