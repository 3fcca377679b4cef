//! The slow estimate of where up is.

use super::carried::Carried;
use crate::constants::STANDARD_GRAVITY;
use nalgebra::{ComplexField, Vector3};

/// Shorter means than this have no direction, m/s²: only a base that falls for long has them.
const SHORTEST: f64 = 1.0;

/// The direction of the mean of the specific force over a long time, in base axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tilt {
    mean: Carried,
    up: Vector3<f64>,
    /// Samples in a row that were outside the cone about `up`.
    astray: u32,
}

impl Tilt {
    /// Knows nothing but the unit vector that is called up.
    pub(super) fn new(up: Vector3<f64>) -> Self {
        Self { mean: Carried::new(up * STANDARD_GRAVITY, 0.0), up, astray: 0 }
    }

    /// There has been something to estimate it from.
    pub(super) fn is_known(&self) -> bool {
        self.mean.memory() > 0.0
    }

    /// How long the mean reaches back, s; T once it has seen enough.
    pub(super) const fn memory(&self) -> f64 {
        self.mean.memory()
    }

    /// Starts from a mean over `memory` seconds, m/s², base axes.
    pub(super) fn seed(&mut self, mean: Vector3<f64>, memory: f64) {
        *self = Self { mean: Carried::new(mean, memory), up: direction(&mean).unwrap_or(self.up), astray: 0 };
    }

    /// Takes a sample: `f` m/s² and `w` rad/s in base axes, `dt` s after the one before; `time` is T, s.
    pub(super) fn follow(&mut self, f: &Vector3<f64>, w: &Vector3<f64>, dt: f64, time: f64) {
        self.mean.turn(w, dt);
        self.mean.mix(f, dt, time);
        self.up = direction(&self.mean.mean()).unwrap_or(self.up);
    }

    /// Up in base axes, of length 1.
    pub(super) const fn up(&self) -> Vector3<f64> {
        self.up
    }

    /// Gravity of standard size along it, base axes, m/s².
    pub(super) fn gravity(&self) -> Vector3<f64> {
        self.up * -STANDARD_GRAVITY
    }

    /// Size of the mean in standard gravities.
    pub(super) fn size(&self) -> f64 {
        self.mean.mean().norm() / STANDARD_GRAVITY
    }

    /// The latest samples are, three in a row, outside the cone about the estimate with this cosine of its half angle.
    pub(super) fn strays(&mut self, f: &Vector3<f64>, cosine: f64) -> bool {
        self.astray = if is_within(f, &self.up, cosine) { 0 } else { self.astray.saturating_add(1) };
        self.astray >= 3
    }
}

/// `v` is inside the cone about the unit vector `axis` with this cosine of its half angle; zero is in every cone.
pub(super) fn is_within(v: &Vector3<f64>, axis: &Vector3<f64>, cosine: f64) -> bool {
    v.dot(axis) >= cosine * v.norm()
}

/// The cosine of a limit.
pub(super) fn cosine(limit: f64) -> f64 {
    ComplexField::cos(limit)
}

fn direction(v: &Vector3<f64>) -> Option<Vector3<f64>> {
    let length = v.norm();
    (length >= SHORTEST).then(|| v / length)
}
