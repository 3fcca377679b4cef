//! A target that keeps its velocity, or its acceleration, until it is pushed: a Kalman filter per axis, all with one covariance.
//!
//! > x = (p, v) or (p, v, a),  x(t+dt) = F(dt) x(t) + G(dt) w,  F_ij = dt^(j−i)/(j−i)!,  G_i = dt^(n−i)/(n−i)!/√dt
//!
//! w is white with a density q that follows the innovations ν: q ← q e^{η (ν²/S − 1)} (Mehra 1970, as a stochastic
//! approximation), so that it needs no tuning.

use super::{LARGEST_DENSITY, Moving, Point, SMALLEST_DENSITY};
use core::array::from_fn;
use nalgebra::ComplexField;

/// η.
const ADAPTATION: f64 = 0.02;

/// Where a target may be found at the start, and how fast, as standard deviations in units of m and s.
const START: f64 = 0.1;

/// A filter with `N` states per axis: 2 for constant velocity, 3 for constant acceleration.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kinematic<const N: usize> {
    x: [Point; N],
    P: [[f64; N]; N],
    /// q, m²/s^(2N−1)
    density: f64,
    at: f64,
    is_started: bool,
}

impl<const N: usize> Kinematic<N> {
    pub(super) fn new() -> Self {
        let density = if N == 2 { 1e-4 } else { 1e-3 };
        Self { x: [Point::zeros(); N], P: [[0.0; N]; N], density, at: 0.0, is_started: false }
    }

    /// Takes a sample at `t`, s, of variance `noise`, m²; `axes` of its numbers count.
    pub(super) fn update(&mut self, t: f64, y: &Point, noise: f64, axes: usize) {
        if !self.is_started {
            self.begin(t, y, noise);
            return;
        }
        self.advance(t - self.at);
        self.at = t;
        let s = self.P[0][0] + noise;
        let innovation = y - self.x[0];
        let column: [f64; N] = from_fn(|i| self.P[i][0]);
        for i in 0..N {
            self.x[i] += innovation * (column[i] / s);
            for j in 0..N {
                self.P[i][j] -= column[i] * column[j] / s;
            }
        }
        let surprise = (innovation.norm_squared() / (axes as f64 * s)).min(9.0);
        let change: f64 = ComplexField::exp(ADAPTATION * (surprise - 1.0));
        self.density = (self.density * change).clamp(SMALLEST_DENSITY, LARGEST_DENSITY);
    }

    fn begin(&mut self, t: f64, y: &Point, noise: f64) {
        self.x = [Point::zeros(); N];
        self.x[0] = *y;
        self.P = from_fn(|i| from_fn(|j| if i == j { START * START } else { 0.0 }));
        self.P[0][0] = noise;
        (self.at, self.is_started) = (t, true);
    }

    fn advance(&mut self, dt: f64) {
        let powers = powers(dt);
        self.x = from_fn(|i| (i..N).map(|j| self.x[j] * powers[j - i]).sum());
        let half: [[f64; N]; N] = from_fn(|i| from_fn(|j| (i..N).map(|k| powers[k - i] * self.P[k][j]).sum()));
        let density = self.density / dt;
        let push = |i: usize, j: usize| powers[N - i] * powers[N - j] * density;
        self.P = from_fn(|i| from_fn(|j| (j..N).map(|k| half[i][k] * powers[k - j]).sum::<f64>() + push(i, j)));
    }

    /// Where the target is at `t`, and how fast; none before the first sample.
    pub(super) fn at(&self, t: f64) -> Option<Moving> {
        let powers = powers(t - self.at);
        self.is_started.then(|| Moving {
            position: (0..N).map(|j| self.x[j] * powers[j]).sum(),
            velocity: (1..N).map(|j| self.x[j] * powers[j - 1]).sum(),
        })
    }
}

/// dt^k/k! for k = 0…3
fn powers(dt: f64) -> [f64; 4] {
    let half = dt * dt / 2.0;
    [1.0, dt, half, half * dt / 3.0]
}
