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
use super::{Moving, Point, Settings, add, mix, sin_cos, visit_multiples, wrapped};
use core::array::from_fn;
use core::f64::consts::TAU;
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

/// Time that cycles are given to be learnt, s.
const PATIENCE: f64 = 15.0;

/// Phases at which the extremes of a cycle are sought.
const PHASES: usize = 64;

/// Longest step of the filter in cycles, and most steps between two samples.
const LONGEST_STEP: f64 = 0.05;
const MOST_STEPS: f64 = 40.0;

/// Share of the shape's power below which harmonics are none: those below a multiple of the rate that is the true one.
const NEGLIGIBLE: f64 = 0.05;

/// Sizes of a cycle beyond which it is none of this shape.
const SIZES: (f64, f64) = (0.3, 3.0);

type Row = [f64; MAX_STATES];

/// The filter. States beyond those that the harmonics need are zero.
#[derive(Clone, Debug)]
pub(super) struct Periodic {
    harmonics: usize,
    axes: usize,
    band: (f64, f64),
    noise: f64,
    x: Row,
    P: [Row; MAX_STATES],
    /// ω̄, rad/s
    mean_rate: f64,
    /// Squared size of the shape, m².
    size: f64,
    /// λ
    looseness: f64,
    begun: f64,
    at: f64,
    is_started: bool,
    course: Course,
}

/// cos kθ − 1 for k = 1…m, then sin kθ.
type Basis = [f64; 2 * MAX_HARMONICS];

/// ∂y/∂x of an axis: by the phase, by the size, and by the axis's own numbers.
struct Slope {
    phase: f64,
    size: f64,
    own: [f64; MAX_AXIS],
}

impl Slope {
    /// By the number of the state, for an axis whose own numbers begin at `place`.
    #[inline(always)]
    fn numbers(&self, place: usize, width: usize) -> impl Iterator<Item = (usize, f64)> {
        let own = self.own.iter().take(width).enumerate().map(move |(i, slope)| (place + i, *slope));
        [(0, self.phase), (2, self.size)].into_iter().chain(own)
    }
}

/// The cycles as they are, for predictions: y = middle + Σ_k a_k cos kθ + b_k sin kθ.
#[derive(Clone, Copy, Debug, Default)]
struct Course {
    middle: Point,
    shape: [(Point, Point); MAX_HARMONICS],
}

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
            begun: 0.0,
            at: 0.0,
            is_started: false,
            course: Course::default(),
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

    /// Cycles are sought: there are none yet, or those there are are `lost` although they had their time.
    pub(super) fn should_begin(&self, lost: bool) -> bool {
        !self.is_started || (lost && self.at - self.begun > PATIENCE)
    }

    /// Forgets everything.
    pub(super) fn stop(&mut self) {
        self.is_started = false;
    }

    /// Begins with the cycles that were found in a record, at its end `t`.
    pub(super) fn begin(&mut self, t: f64, cycles: &Cycles) {
        self.x = [0.0; MAX_STATES];
        self.P = [[0.0; MAX_STATES]; MAX_STATES];
        (self.at, self.begun, self.is_started) = (t, t, true);
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
        self.plot();
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
        self.plot();
    }

    fn plot(&mut self) {
        self.course = Course::default();
        for axis in 0..self.axes {
            let j = self.place(axis);
            self.course.middle[axis] = self.x[j];
            for k in 0..self.harmonics {
                let (a, b) = (self.x[2] * self.x[j + 1 + k], self.x[2] * self.x[j + 1 + self.harmonics + k]);
                self.course.middle[axis] -= a;
                (self.course.shape[k].0[axis], self.course.shape[k].1[axis]) = (a, b);
            }
        }
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
        let window = f64::midpoint(1.0, sin_cos([self.x[0]]).1[0]).powi(SHARPNESS);
        let kept: f64 = ComplexField::exp(-FORGETTING * window / WINDOW_MEAN * self.mean_rate / TAU * dt);
        self.x[0] = wrapped(self.x[0] + self.x[1] * dt);
        self.x[1] = self.mean_rate + kept * (self.x[1] - self.mean_rate);
        self.x[2] = 1.0 + kept * (self.x[2] - 1.0);
        let [phase, rate, size, ..] = &mut self.P;
        for j in 0..n {
            phase[j] += dt * rate[j];
            rate[j] *= kept;
            size[j] *= kept;
        }
        for row in &mut self.P[..3] {
            row[0] += dt * row[1];
            row[1] *= kept;
            row[2] *= kept;
        }
        for i in 1..n {
            (0..i.min(3)).for_each(|j| self.P[i][j] = self.P[j][i]);
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

    /// One axis after the other, all linearised where the prediction is; P − Σ c cᵀ for all of them at once.
    fn correct(&mut self, y: &Point) {
        let (x, basis) = (self.x, self.basis(self.x[0]));
        let (mut columns, mut surprise) = ([[0.0; MAX_STATES]; 3], 0.0);
        for axis in 0..self.axes {
            let (place, slope) = self.model(&x, &basis, axis);
            let slopes = || slope.numbers(self.place(axis), self.width());
            let along = |column: &Row| slopes().map(|(i, slope)| slope * column[i]).sum::<f64>();
            let (earlier, later) = columns.split_at_mut(axis);
            let column = &mut later[0];
            let mut innovation = y[axis] - place;
            for (i, slope) in slopes() {
                innovation -= slope * (self.x[i] - x[i]);
                add(column, slope, &self.P[i]);
            }
            for c in earlier {
                add(column, -along(c), c);
            }
            let s = along(column) + self.noise;
            surprise += innovation * innovation / s / self.axes as f64;
            let scale = 1.0 / ComplexField::sqrt(s);
            for c in column.iter_mut() {
                *c *= scale;
            }
            add(&mut self.x, scale * innovation, column);
        }
        for i in 0..self.states() {
            mix(&mut self.P[i], 1.0, [-columns[0][i], -columns[1][i], -columns[2][i]], &columns);
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

    /// The place of an axis, and its slope.
    fn model(&self, x: &Row, basis: &Basis, axis: usize) -> (f64, Slope) {
        let (j, m) = (self.place(axis), self.harmonics);
        let mut slope = Slope { phase: 0.0, size: 0.0, own: [1.0; MAX_AXIS] };
        for k in 0..m {
            let (cosine, sine) = (basis[k], basis[m + k]);
            let (a, b) = (x[j + 1 + k], x[j + 1 + m + k]);
            slope.phase += x[2] * (b * (cosine + 1.0) - a * sine) * (k + 1) as f64;
            slope.size += a * cosine + b * sine;
            (slope.own[1 + k], slope.own[1 + m + k]) = (x[2] * cosine, x[2] * sine);
        }
        (x[j] + x[2] * slope.size, slope)
    }

    fn basis(&self, theta: f64) -> Basis {
        let mut basis = [0.0; 2 * MAX_HARMONICS];
        visit_multiples(theta, self.harmonics, |k, cosine, sine| {
            (basis[k], basis[self.harmonics + k]) = (cosine - 1.0, sine);
        });
        basis
    }

    /// Where the target is at `t`, and how fast; none before it has begun.
    pub(super) fn at(&self, t: f64) -> Option<Moving> {
        if !self.is_started {
            return None;
        }
        let mut found = Moving::standing(self.course.middle);
        visit_multiples(self.x[0] + self.x[1] * (t - self.at), self.harmonics, |k, cosine, sine| {
            let (a, b) = &self.course.shape[k];
            let rate = self.x[1] * (k + 1) as f64;
            found.position += a * cosine + b * sine;
            found.velocity += b * (rate * cosine) - a * (rate * sine);
        });
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
            let [(low, from), (high, to)] =
                self.extremes(axis).map(|theta| self.model(&self.x, &self.basis(theta), axis));
            amplitude[axis] = high - low;
            // At its extremes the place does not depend on the phase.
            let slope = Slope { phase: 0.0, size: to.size - from.size, own: from_fn(|i| to.own[i] - from.own[i]) };
            let slopes = || slope.numbers(self.place(axis), self.width());
            let square: f64 = slopes().flat_map(|(i, a)| slopes().map(move |(k, b)| a * self.P[i][k] * b)).sum();
            deviation[axis] = ComplexField::sqrt(square.max(0.0));
        }
        Some((amplitude, deviation))
    }

    /// The phases of the lowest and the highest place of an axis.
    fn extremes(&self, axis: usize) -> [f64; 2] {
        let (mut low, mut high) = ((f64::INFINITY, 0.0), (f64::NEG_INFINITY, 0.0));
        for theta in (0..PHASES).map(|i| TAU * i as f64 / PHASES as f64) {
            let (place, _) = self.model(&self.x, &self.basis(theta), axis);
            low = if place < low.0 { (place, theta) } else { low };
            high = if place > high.0 { (place, theta) } else { high };
        }
        [low.1, high.1]
    }

    /// The rate cannot be told from an end of the band, or is beyond it.
    pub(super) fn is_at_an_end(&self) -> bool {
        let deviation: f64 = ComplexField::sqrt(self.P[1][1].max(0.0));
        let rate = self.lowest_moving() * self.x[1];
        self.is_started && !(self.band.0 + deviation..=self.band.1 - deviation).contains(&rate)
    }

    /// Number of the lowest harmonic that moves: a shape whose first ones do not is one of faster cycles.
    fn lowest_moving(&self) -> f64 {
        let power = |k: usize| self.course.shape[k].0.norm_squared() + self.course.shape[k].1.norm_squared();
        let least = NEGLIGIBLE * (0..self.harmonics).map(power).sum::<f64>();
        (1 + (0..self.harmonics).find(|k| power(*k) >= least).unwrap_or(0)) as f64
    }
}
