//! Sines of fixed frequencies over the band, their amplitudes followed by a Kalman filter.
//!
//! > y(t) = w₀ + Σ_k w_k cos ω_k t + w'_k sin ω_k t,  ω_k evenly over the band
//!
//! The weights walk at random; all axes have one covariance. After K. Veluvolu and W. Ang, "Estimation of Physiological Tremor
//! from Accelerometers for Real-Time Applications", Sensors 2011 (BMFLC), with the Kalman filter of their later work.

use super::{Moving, Point, Settings};
use core::f64::consts::TAU;
use nalgebra::ComplexField;

/// Frequencies.
const LINES: usize = 12;

/// The constant, cosines, sines.
const N: usize = 1 + 2 * LINES;

/// A sample is believed as if its standard deviation were this many times larger.
const MISTRUST: f64 = 2.0;

/// Standard deviation of a weight at the start, m; and the density of its walk, m²/s.
const START: f64 = 0.01;
const WALK: f64 = 1e-5;

type Row = [f64; N];

/// The weights.
#[derive(Clone, Debug)]
pub(super) struct Fourier {
    lowest: f64,
    spacing: f64,
    noise: f64,
    w: [Point; N],
    P: [Row; N],
    zero: f64,
    at: f64,
    is_started: bool,
}

impl Fourier {
    pub(super) fn new(settings: &Settings) -> Self {
        let (low, high) = settings.band;
        Self {
            lowest: TAU * low,
            spacing: TAU * (high - low) / (LINES - 1) as f64,
            noise: (MISTRUST * settings.noise) * (MISTRUST * settings.noise),
            w: [Point::zeros(); N],
            P: [[0.0; N]; N],
            zero: 0.0,
            at: 0.0,
            is_started: false,
        }
    }

    /// Forgets everything.
    pub(super) fn stop(&mut self) {
        self.is_started = false;
    }

    /// Takes a sample at `t`, s.
    pub(super) fn update(&mut self, t: f64, y: &Point) {
        if !self.is_started {
            self.begin(t, y);
        }
        let (walk, basis) = (WALK * (t - self.at), self.basis(t).0);
        self.at = t;
        let mut column = [0.0; N];
        for i in 0..N {
            self.P[i][i] += walk;
            column[i] = dot(&self.P[i], &basis);
        }
        let scale = 1.0 / ComplexField::sqrt(dot(&column, &basis) + self.noise);
        for c in &mut column {
            *c *= scale;
        }
        let innovation = y - self.sum(&basis);
        for i in 0..N {
            self.w[i] += innovation * (column[i] * scale);
            for (p, c) in self.P[i].iter_mut().zip(&column) {
                *p -= column[i] * c;
            }
        }
    }

    fn begin(&mut self, t: f64, y: &Point) {
        (self.zero, self.at, self.is_started) = (t, t, true);
        (self.w, self.P) = ([Point::zeros(); N], [[0.0; N]; N]);
        self.w[0] = *y;
        (0..N).for_each(|i| self.P[i][i] = START * START);
    }

    /// The target is elsewhere by `distance`, m: the constant is as uncertain.
    pub(super) fn shift(&mut self, distance: f64) {
        self.P[0][0] += distance * distance;
    }

    fn sum(&self, basis: &Row) -> Point {
        self.w.iter().zip(basis).map(|(w, f)| w * *f).sum()
    }

    /// The sines at `t`, and their rates.
    fn basis(&self, t: f64) -> (Row, Row) {
        let (mut basis, mut rates) = ([0.0; N], [0.0; N]);
        let (mut s, mut c): (f64, f64) = ComplexField::sin_cos(self.lowest * (t - self.zero));
        let (turn_s, turn_c): (f64, f64) = ComplexField::sin_cos(self.spacing * (t - self.zero));
        basis[0] = 1.0;
        for k in 0..LINES {
            let w = self.lowest + self.spacing * k as f64;
            (basis[1 + k], basis[1 + LINES + k]) = (c, s);
            (rates[1 + k], rates[1 + LINES + k]) = (-w * s, w * c);
            (c, s) = (c * turn_c - s * turn_s, s * turn_c + c * turn_s);
        }
        (basis, rates)
    }

    /// Where the target is at `t`, and how fast; none before the first sample.
    pub(super) fn at(&self, t: f64) -> Option<Moving> {
        let (basis, rates) = self.basis(t);
        self.is_started.then(|| Moving { position: self.sum(&basis), velocity: self.sum(&rates) })
    }
}

fn dot(a: &Row, b: &Row) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
