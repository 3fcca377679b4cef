//! Sines of fixed frequencies over the band, their amplitudes followed by a Kalman filter.
//!
//! > y(t) = w₀ + Σ_k w_k cos ω_k t + w'_k sin ω_k t,  ω_k evenly over the band
//!
//! The weights walk at random; all axes have one covariance. After K. Veluvolu and W. Ang, "Estimation of Physiological Tremor
//! from Accelerometers for Real-Time Applications", Sensors 2011 (BMFLC), with the Kalman filter of their later work.

use super::{Moving, Point, Settings, add, sin_cos, wrapped};
use core::array::from_fn;
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
    /// Lowest frequency and distance of the frequencies, rad/s; and their phases at the newest sample.
    rates: [f64; 2],
    phases: [f64; 2],
    noise: f64,
    w: [Point; N],
    P: [Row; N],
    at: f64,
    is_started: bool,
}

impl Fourier {
    pub(super) fn new(settings: &Settings) -> Self {
        let (low, high) = settings.band;
        Self {
            rates: [TAU * low, TAU * (high - low) / (LINES - 1) as f64],
            phases: [0.0; 2],
            noise: (MISTRUST * settings.noise) * (MISTRUST * settings.noise),
            w: [Point::zeros(); N],
            P: [[0.0; N]; N],
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
        let walk = WALK * (t - self.at);
        self.phases = self.phases_at(t).map(wrapped);
        self.at = t;
        let mut basis = [1.0; N];
        let (mut column, mut s) = ([0.0; N], self.noise);
        self.lines(t, |k, _, cosine, sine| (basis[1 + k], basis[1 + LINES + k]) = (cosine, sine));
        for i in 0..N {
            self.P[i][i] += walk;
            add(&mut column, basis[i], &self.P[i]);
        }
        let mut innovation = *y;
        for i in 0..N {
            s += column[i] * basis[i];
            innovation -= self.w[i] * basis[i];
        }
        let scale = 1.0 / ComplexField::sqrt(s);
        for c in &mut column {
            *c *= scale;
        }
        for i in 0..N {
            self.w[i] += innovation * (column[i] * scale);
            add(&mut self.P[i], -column[i], &column);
        }
    }

    fn begin(&mut self, t: f64, y: &Point) {
        (self.phases, self.at, self.is_started) = ([0.0; 2], t, true);
        (self.w, self.P) = ([Point::zeros(); N], [[0.0; N]; N]);
        self.w[0] = *y;
        (0..N).for_each(|i| self.P[i][i] = START * START);
    }

    /// The target is elsewhere by `distance`, m: the constant is as uncertain.
    pub(super) fn shift(&mut self, distance: f64) {
        self.P[0][0] += distance * distance;
    }

    fn phases_at(&self, t: f64) -> [f64; 2] {
        from_fn(|i| self.phases[i] + self.rates[i] * (t - self.at))
    }

    /// Visits the sines at `t`: number, frequency in rad/s, cosine, sine.
    #[inline(always)]
    fn lines(&self, t: f64, mut visit: impl FnMut(usize, f64, f64, f64)) {
        let (s, c) = sin_cos(self.phases_at(t));
        let (mut sine, mut cosine) = (s[0], c[0]);
        for k in 0..LINES {
            visit(k, self.rates[0] + self.rates[1] * k as f64, cosine, sine);
            (cosine, sine) = (cosine * c[1] - sine * s[1], sine * c[1] + cosine * s[1]);
        }
    }

    /// Where the target is at `t`, and how fast; none before the first sample.
    pub(super) fn at(&self, t: f64) -> Option<Moving> {
        if !self.is_started {
            return None;
        }
        let mut found = Moving::standing(self.w[0]);
        self.lines(t, |k, rate, cosine, sine| {
            let (a, b) = (&self.w[1 + k], &self.w[1 + LINES + k]);
            found.position += a * cosine + b * sine;
            found.velocity += b * (rate * cosine) - a * (rate * sine);
        });
        Some(found)
    }
}
