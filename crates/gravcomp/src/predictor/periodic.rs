//! Cycles of one learnt shape whose rate and size vary from cycle to cycle: an extended Kalman filter.
//!
//! > y_i = e_i + g Σ_k [a_ik (cos kθ − 1) + b_ik sin kθ],  θ' = ω
//!
//! θ = 0 is where the cycle rests (the end of an exhalation). There, and only there, a breath chooses its rate ω and its
//! size g: within the window w(θ) = ((1 + cos θ)/2)^p they forget the last cycle and take the spread of the cycles,
//!
//! > ω ← ω̄ + α (ω − ω̄),  g ← 1 + α (g − 1),  variances + (1 − α²) σ²,  α = e^{−κ w(θ) dt}.
//!
//! The resting place e, the shape a, b and the mean rate ω̄ drift slowly; all of it faster by a factor λ that follows the
//! innovations ν, λ ← λ e^{η (ν² − 1)} with ν² in units of its variance, when the cycles are not what the model says. After S. Yuen et al., "Robotic motion compensation for
//! beating heart intracardiac surgery", IJRR 2009 (quasi-periodic filter), with the shape of A. Lujan et al., Medical
//! Physics 1999, as a special case: sin⁴ has two harmonics.

use super::spectrum::Cycles;
use super::{Moving, Point, Settings};
use core::f64::consts::{PI, TAU};
use nalgebra::ComplexField;

/// Most harmonics of a shape.
pub(super) const MAX_HARMONICS: usize = 5;

/// Numbers of an axis: its resting place, cosines, sines.
const MAX_AXIS: usize = 1 + 2 * MAX_HARMONICS;

/// θ, ω, g, and the axes.
const MAX_STATES: usize = 3 + 3 * MAX_AXIS;

/// Standard deviation of the rate and of the size over the cycles, relative: the largest measured in quiet breathing.
const SPREAD: f64 = 0.15;

/// κ times the time of a cycle in the window: how often over a cycle's rest the last one is forgotten.
const FORGETTING: f64 = 4.0;

/// p of the window, and the mean of the window over a cycle: (2p)!/(p!² 4^p).
const SHARPNESS: i32 = 6;
const WINDOW_MEAN: f64 = 924.0 / 4096.0;

/// How fast, per second, variances grow: relative to the squared size of the shape, or to the squared rate.
const RESTING_DRIFT: f64 = 5e-4;
const SHAPE_DRIFT: f64 = 1e-5;
const RATE_DRIFT: f64 = 5e-4;
const SIZE_DRIFT: f64 = 5e-4;
const PHASE_DRIFT: f64 = 1e-4;

/// η, the largest ν² that counts, and the largest λ.
const ADAPTATION: f64 = 0.05;
const LARGEST_SURPRISE: f64 = 6.0;
const LOOSEST: f64 = 1e4;

/// Time over which the mean rate is taken, s.
const RATE_TIME: f64 = 20.0;

/// A sample is believed as if its standard deviation were this many times larger: no shape is exact.
const MISTRUST: f64 = 2.0;

/// Phases at which the extremes of a cycle are sought.
const PHASES: usize = 64;

/// Longest step of the filter in cycles, and most steps between two samples.
const LONGEST_STEP: f64 = 0.05;
const MOST_STEPS: f64 = 40.0;

/// Sizes of a cycle beyond which it is none of this shape.
const SIZES: (f64, f64) = (0.3, 3.0);

/// The filter. States beyond those that the harmonics need are zero.
#[derive(Clone, Debug)]
pub(super) struct Periodic {
    harmonics: usize,
    axes: usize,
    band: (f64, f64),
    noise: f64,
    x: [f64; MAX_STATES],
    P: [[f64; MAX_STATES]; MAX_STATES],
    /// ω̄, rad/s
    mean_rate: f64,
    /// Squared size of the shape, m².
    size: f64,
    /// λ
    looseness: f64,
    at: f64,
    is_started: bool,
}

/// cos kθ − 1 for k = 1…m, then sin kθ.
type Basis = [f64; 2 * MAX_HARMONICS];

impl Periodic {
    pub(super) fn new(settings: &Settings) -> Self {
        Self {
            harmonics: settings.harmonics,
            axes: settings.axes,
            band: (TAU * settings.band.0, TAU * settings.band.1),
            noise: (MISTRUST * settings.noise) * (MISTRUST * settings.noise),
            x: [0.0; MAX_STATES],
            P: [[0.0; MAX_STATES]; MAX_STATES],
            mean_rate: 0.0,
            size: 0.0,
            looseness: 1.0,
            at: 0.0,
            is_started: false,
        }
    }

    /// Numbers of an axis.
    const fn width(&self) -> usize {
        1 + 2 * self.harmonics
    }

    const fn states(&self) -> usize {
        3 + self.axes * self.width()
    }

    /// Where the numbers of an axis begin.
    const fn place(&self, axis: usize) -> usize {
        3 + axis * self.width()
    }

    /// Cycles that were found are welcome: there are none yet, or those there are are `lost`.
    pub(super) const fn should_begin(&self, lost: bool) -> bool {
        !self.is_started || lost
    }

    /// Forgets everything.
    pub(super) fn stop(&mut self) {
        self.is_started = false;
    }

    /// Begins with the cycles that were found in a record, at its end `t`.
    pub(super) fn begin(&mut self, t: f64, cycles: &Cycles) {
        self.x = [0.0; MAX_STATES];
        self.P = [[0.0; MAX_STATES]; MAX_STATES];
        (self.at, self.is_started) = (t, true);
        self.mean_rate = cycles.rate;
        (self.size, self.looseness) = (cycles.size(), 1.0);
        (self.x[0], self.x[1], self.x[2]) = (cycles.phase, cycles.rate, 1.0);
        self.P[0][0] = 0.3;
        self.P[1][1] = (SPREAD * cycles.rate) * (SPREAD * cycles.rate);
        self.P[2][2] = SPREAD * SPREAD;
        let doubt = 0.02 * self.size + self.noise;
        for axis in 0..self.axes {
            let j = self.place(axis);
            self.x[j] = cycles.rest[axis];
            self.P[j][j] = doubt;
            for k in 0..self.harmonics {
                let order = (k + 1) as f64;
                for (i, value) in [(j + 1 + k, cycles.cosines[k]), (j + 1 + self.harmonics + k, cycles.sines[k])] {
                    self.x[i] = value[axis];
                    self.P[i][i] = doubt / (order * order);
                }
            }
        }
    }

    /// Takes a sample at `t`, s.
    pub(super) fn update(&mut self, t: f64, y: &Point) {
        if !self.is_started {
            return;
        }
        self.advance(t - self.at);
        self.at = t;
        self.correct(y);
        self.x[1] = self.x[1].clamp(self.band.0, self.band.1);
        self.x[2] = self.x[2].clamp(SIZES.0, SIZES.1);
    }

    /// A long time goes by in steps of a twentieth of a cycle, so that no rest is stepped over; but not in too many.
    fn advance(&mut self, time: f64) {
        let step = (LONGEST_STEP * TAU / self.mean_rate).max(time / MOST_STEPS);
        let mut left = time;
        while left > 0.0 {
            self.step(left.min(step));
            left -= step;
        }
    }

    fn step(&mut self, dt: f64) {
        let n = self.states();
        let window = f64::midpoint(1.0, ComplexField::cos(self.x[0])).powi(SHARPNESS);
        let kept: f64 = ComplexField::exp(-FORGETTING * window / WINDOW_MEAN * self.mean_rate / TAU * dt);
        self.x[0] = wrapped(self.x[0] + self.x[1] * dt);
        self.x[1] = self.mean_rate + kept * (self.x[1] - self.mean_rate);
        self.x[2] = 1.0 + kept * (self.x[2] - 1.0);
        for j in 0..n {
            self.P[0][j] += dt * self.P[1][j];
            self.P[1][j] *= kept;
            self.P[2][j] *= kept;
        }
        for row in &mut self.P[..n] {
            row[0] += dt * row[1];
            row[1] *= kept;
            row[2] *= kept;
        }
        self.loosen(dt, (1.0 - kept * kept) * SPREAD * SPREAD);
        self.mean_rate += (self.x[1] - self.mean_rate) * (dt / RATE_TIME).min(1.0);
    }

    /// The variances grow, those of rate and size also by what they `take` from the spread of the cycles.
    fn loosen(&mut self, dt: f64, taken: f64) {
        let drift = self.looseness * dt;
        self.P[0][0] += PHASE_DRIFT * drift;
        self.P[1][1] += (taken + RATE_DRIFT * drift) * self.mean_rate * self.mean_rate;
        self.P[2][2] += taken + SIZE_DRIFT * drift;
        for axis in 0..self.axes {
            let j = self.place(axis);
            self.P[j][j] += RESTING_DRIFT * self.size * drift;
            for i in j + 1..j + self.width() {
                self.P[i][i] += SHAPE_DRIFT * self.size * drift;
            }
        }
    }

    /// One axis after the other, all linearised where the prediction is.
    fn correct(&mut self, y: &Point) {
        let (n, x, basis) = (self.states(), self.x, self.basis(self.x[0]));
        let mut surprise = 0.0;
        for axis in 0..self.axes {
            let slope = self.slope(&x, &basis, axis);
            let j = self.place(axis);
            let linear = |z: &[f64; MAX_STATES]| {
                let own: f64 = (j..j + self.width()).map(|i| slope[i] * (z[i] - x[i])).sum();
                own + slope[0] * (z[0] - x[0]) + slope[2] * (z[2] - x[2])
            };
            let innovation = y[axis] - self.place_of(&x, &basis, axis) - linear(&self.x);
            let mut column = [0.0; MAX_STATES];
            for (sum, row) in column.iter_mut().zip(&self.P[..n]) {
                let own: f64 = (j..j + self.width()).map(|i| row[i] * slope[i]).sum();
                *sum = own + row[0] * slope[0] + row[2] * slope[2];
            }
            let own: f64 = (j..j + self.width()).map(|i| column[i] * slope[i]).sum();
            let s = own + column[0] * slope[0] + column[2] * slope[2] + self.noise;
            surprise += innovation * innovation / s / self.axes as f64;
            let scale = 1.0 / ComplexField::sqrt(s);
            for value in &mut column[..n] {
                *value *= scale;
            }
            for i in 0..n {
                self.x[i] += column[i] * scale * innovation;
                for (p, c) in self.P[i][..n].iter_mut().zip(&column[..n]) {
                    *p -= column[i] * c;
                }
            }
        }
        let change: f64 = ComplexField::exp(ADAPTATION * (surprise.min(LARGEST_SURPRISE) - 1.0));
        self.looseness = (self.looseness * change).clamp(1.0, LOOSEST);
    }

    /// The target is elsewhere by `distance`, m: its resting place is as uncertain.
    pub(super) fn shift(&mut self, distance: f64) {
        for axis in 0..self.axes {
            let j = self.place(axis);
            self.P[j][j] += distance * distance;
        }
    }

    /// ∂y_axis/∂x
    fn slope(&self, x: &[f64; MAX_STATES], basis: &Basis, axis: usize) -> [f64; MAX_STATES] {
        let (mut slope, j, m) = ([0.0; MAX_STATES], self.place(axis), self.harmonics);
        slope[j] = 1.0;
        for k in 0..m {
            let (cosine, sine) = (basis[k] + 1.0, basis[m + k]);
            let (a, b) = (x[j + 1 + k], x[j + 1 + m + k]);
            slope[0] += x[2] * (b * cosine - a * sine) * (k + 1) as f64;
            slope[2] += a * basis[k] + b * sine;
            slope[j + 1 + k] = x[2] * basis[k];
            slope[j + 1 + m + k] = x[2] * sine;
        }
        slope
    }

    fn place_of(&self, x: &[f64; MAX_STATES], basis: &Basis, axis: usize) -> f64 {
        let j = self.place(axis);
        let shape: f64 = x[j + 1..j + self.width()].iter().zip(basis).map(|(c, f)| c * f).sum();
        x[j] + x[2] * shape
    }

    fn basis(&self, theta: f64) -> Basis {
        let mut basis = [0.0; 2 * MAX_HARMONICS];
        let (sine, cosine): (f64, f64) = ComplexField::sin_cos(theta);
        let (mut s, mut c) = (sine, cosine);
        for k in 0..self.harmonics {
            (basis[k], basis[self.harmonics + k]) = (c - 1.0, s);
            (c, s) = (c * cosine - s * sine, s * cosine + c * sine);
        }
        basis
    }

    /// Where the target is at `t`, and how fast; none before it has begun.
    pub(super) fn at(&self, t: f64) -> Option<Moving> {
        if !self.is_started {
            return None;
        }
        let basis = self.basis(self.x[0] + self.x[1] * (t - self.at));
        let mut found = Moving { position: Point::zeros(), velocity: Point::zeros() };
        for axis in 0..self.axes {
            found.position[axis] = self.place_of(&self.x, &basis, axis);
            found.velocity[axis] = self.slope(&self.x, &basis, axis)[0] * self.x[1];
        }
        Some(found)
    }

    /// Frequency of the present cycle and its standard deviation, Hz.
    pub(super) fn frequency(&self) -> Option<(f64, f64)> {
        let deviation: f64 = ComplexField::sqrt(self.P[1][1].max(0.0));
        self.is_started.then(|| (self.x[1] / TAU, deviation / TAU))
    }

    /// From lowest to highest place of the present cycle, and the standard deviation of that, m per axis.
    pub(super) fn amplitude(&self) -> Option<(Point, Point)> {
        if !self.is_started {
            return None;
        }
        let (mut amplitude, mut deviation) = (Point::zeros(), Point::zeros());
        for axis in 0..self.axes {
            let (low, high) = self.extremes(axis);
            let (from, to) = (self.basis(low), self.basis(high));
            amplitude[axis] = self.place_of(&self.x, &to, axis) - self.place_of(&self.x, &from, axis);
            let (to, from) = (self.slope(&self.x, &to, axis), self.slope(&self.x, &from, axis));
            // At its extremes the place does not depend on the phase, and both have the same rest.
            let slope = |i: usize| if i < 2 { 0.0 } else { to[i] - from[i] };
            let n = self.states();
            let square: f64 = (0..n).map(|i| (0..n).map(|j| slope(i) * self.P[i][j] * slope(j)).sum::<f64>()).sum();
            deviation[axis] = ComplexField::sqrt(square.max(0.0));
        }
        Some((amplitude, deviation))
    }

    /// The phases of the lowest and the highest place of an axis.
    fn extremes(&self, axis: usize) -> (f64, f64) {
        let phases = (0..PHASES).map(|i| TAU * i as f64 / PHASES as f64);
        let place = |theta: &f64| self.place_of(&self.x, &self.basis(*theta), axis);
        let by_place = |a: &f64, b: &f64| place(a).total_cmp(&place(b));
        (phases.clone().min_by(by_place).unwrap_or(0.0), phases.max_by(by_place).unwrap_or(0.0))
    }

    /// The rate stands at an end of the band.
    pub(super) fn is_at_an_end(&self) -> bool {
        self.is_started && !(self.band.0 * 1.001..=self.band.1 * 0.999).contains(&self.x[1])
    }
}

/// The same angle within ±π, for one that is at most a few turns away.
fn wrapped(theta: f64) -> f64 {
    theta - TAU * ComplexField::floor((theta + PI) / TAU)
}
