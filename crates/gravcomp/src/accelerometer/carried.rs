//! The mean of the specific force, carried along with the base where a gyroscope says how it turns (a complementary filter):
//!
//! > s ← R s + (f − R s) Δt/T,  R = exp(−ω Δt)

use nalgebra::{Rotation3, Vector3};

/// The mean, m/s², and how long it reaches back.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carried {
    mean: Vector3<f64>,
    /// s; at most T.
    memory: f64,
}

impl Carried {
    /// Starts from a mean over `memory` seconds, m/s².
    pub(super) const fn new(mean: Vector3<f64>, memory: f64) -> Self {
        Self { mean, memory }
    }

    /// The base turns with `w`, rad/s, for `dt` seconds.
    pub(super) fn turn(&mut self, w: &Vector3<f64>, dt: f64) {
        self.mean = Rotation3::new(w * -dt) * self.mean;
    }

    /// Takes a sample `f`, m/s², that comes `dt` seconds after the one before; `time` is T, s.
    pub(super) fn mix(&mut self, f: &Vector3<f64>, dt: f64, time: f64) {
        self.memory = (self.memory + dt).min(time);
        if self.memory > 0.0 {
            self.mean += (f - self.mean) * (dt / self.memory).min(1.0);
        }
    }

    /// m/s²
    pub(super) const fn mean(&self) -> Vector3<f64> {
        self.mean
    }

    /// How long the mean reaches back, s; T once it has seen enough.
    pub(super) const fn memory(&self) -> f64 {
        self.memory
    }
}
