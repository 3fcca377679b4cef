//! Where a moving target will be: breathing organs, beating hearts, whatever a camera sees late and in noise.
//!
//! [`Predictor::update`] takes a sample when one comes, [`Predictor::predict`] is asked in every control cycle. Both are total:
//! whatever comes in, a prediction is finite and no further from the newest sample than the declared speed allows, and
//! [`Notes`] say what was found.
//!
//! # Methods
//! | method | model |
//! |---|---|
//! | `Hold` | the newest sample |
//! | `Velocity`, `Acceleration` | kept until pushed, by pushes as large as they have lately been |
//! | `Periodic` | cycles of one learnt shape; each has its own rate and size, which it chooses where it rests |
//! | `Autoregressive` | a weighted sum of the past, the weights learnt for the very horizon |
//! | `Fourier` | sines of fixed frequencies over the band |
//! | `Switch` | those that have lately predicted best at the horizon |
//!
//! # The stream
//! Stamps order the samples, not the time at which they come: late and dropped ones need no care. Repeated and older ones are
//! refused; a stamp far ahead or a position far off waits until the next sample confirms it; three older stamps in a row mean
//! that the clock was set, and everything begins anew. `benches/predictions.py` prints how well each method does.
#![allow(clippy::cast_precision_loss)] // counts of bins, axes and harmonics, all below a thousand

mod autoregressive;
mod chain;
mod fourier;
mod kinematic;
mod past;
mod periodic;
mod settings;
mod spectrum;
mod status;
mod stream;
mod switch;

pub use crate::error::SettingsError;
pub use chain::Predictor;
pub use settings::{Method, Settings};
pub use status::{Counters, Note, Notes};

use crate::lanes::Lanes;
use crate::trig;
use core::f64::consts::{PI, TAU};
use nalgebra::ComplexField;

/// A position, m, or a velocity, m/s; axes that a target does not have are zero.
pub type Point = nalgebra::Vector3<f64>;

/// Methods that are no switch.
const METHODS: usize = 6;

/// Densities of the pushes that a target is believed to get, in units of m and s.
const SMALLEST_DENSITY: f64 = 1e-9;
const LARGEST_DENSITY: f64 = 1e3;

/// sin x and cos x of a few angles, rad.
#[inline(always)]
fn sin_cos<const W: usize>(x: [f64; W]) -> ([f64; W], [f64; W]) {
    let (sine, cosine) = trig::sin_cos(Lanes::<W, false>(x));
    (sine.0, cosine.0)
}

/// Visits the multiples (k + 1) θ, k = 0…count−1, of an angle: k, their cosine, their sine.
#[inline(always)]
fn visit_multiples(theta: f64, count: usize, mut visit: impl FnMut(usize, f64, f64)) {
    let ([sine], [cosine]) = sin_cos([theta]);
    let (mut c, mut s) = (cosine, sine);
    for k in 0..count {
        visit(k, c, s);
        (c, s) = (c * cosine - s * sine, s * cosine + c * sine);
    }
}

/// The same angle within ±π.
fn wrapped(theta: f64) -> f64 {
    theta - TAU * ComplexField::floor((theta + PI) / TAU)
}

/// In four sums, none of which waits for another.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_left), (b, b_left)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    let left: f64 = a_left.iter().zip(b_left).map(|(a, b)| a * b).sum();
    left + (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// to + factor · from
#[inline(always)]
fn add<const N: usize>(to: &mut [f64; N], factor: f64, from: &[f64; N]) {
    for i in 0..N {
        to[i] += factor * from[i];
    }
}

/// kept · to + Σ factors · from
#[inline(always)]
fn mix<const N: usize>(to: &mut [f64; N], kept: f64, factors: [f64; 3], from: &[[f64; N]; 3]) {
    for i in 0..N {
        to[i] = kept * to[i] + (factors[0] * from[0][i] + factors[1] * from[1][i] + factors[2] * from[2][i]);
    }
}

/// A position and its velocity.
#[derive(Clone, Copy, Debug, Default)]
struct Moving {
    position: Point,
    velocity: Point,
}

impl Moving {
    fn standing(position: Point) -> Self {
        Self { position, velocity: Point::zeros() }
    }

    /// Where it is `dt` seconds later.
    fn after(&self, dt: f64) -> Point {
        self.position + self.velocity * dt
    }

    fn is_finite(&self) -> bool {
        (self.position.sum() + self.velocity.sum()).is_finite()
    }

    /// Brings it to where a target can be that was at `newest`, `ahead` seconds before (or after); true where it was not.
    fn limit(&mut self, newest: &Point, ahead: f64, settings: &Settings) -> bool {
        if !self.is_finite() {
            *self = Self::standing(*newest);
            return true;
        }
        let away = self.position - newest;
        let reach = settings.speed_limit * ahead.abs() + 10.0 * settings.noise;
        let is_far = away.norm_squared() > reach * reach;
        if is_far {
            self.position = newest + away * (reach / away.norm());
        }
        let is_fast = self.velocity.norm_squared() > settings.speed_limit * settings.speed_limit;
        if is_fast {
            self.velocity *= settings.speed_limit / self.velocity.norm();
        }
        is_far || is_fast
    }
}
