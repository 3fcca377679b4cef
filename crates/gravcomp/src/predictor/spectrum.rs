//! The first guess of the cycles: the frequency whose harmonics fit a record best, and their shape from where it rests.
//!
//! The record is kept as means over short bins. One candidate is tried per sample, so that no update takes long.

use super::periodic::MAX_HARMONICS;
use super::{Point, Settings, dot, visit_multiples};
use core::f64::consts::{PI, TAU};
use nalgebra::ComplexField;

/// Bins of a record.
const BINS: usize = 64;
const BIN_COUNT: i64 = 64;

/// Candidate frequencies, in a geometric sequence over the band; and further ones about the best.
const CANDIDATES: usize = 48;
const REFINEMENTS: usize = 10;

/// A multiple of the best frequency is taken if it leaves no more than that by this share of the variance: half of a frequency
/// fits as well as itself, and better than one a little off.
const AS_GOOD: f64 = 0.2;

/// From this ratio on a frequency may be a multiple of another, and is no neighbour.
const MULTIPLE: f64 = 1.7;

/// Unknowns of a fit: the mean, and two per harmonic.
const UNKNOWNS: usize = 1 + 2 * MAX_HARMONICS;

/// Cycles that leave more of the motion's variance than this unexplained are none.
const SHARE: f64 = 0.6;

/// Phases at which the rest of a cycle is sought.
const PHASES: usize = 64;

/// Cycles of one shape, as the filter begins with them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycles {
    /// rad/s
    pub rate: f64,
    /// Where in the cycle the end of the record is, rad from its rest.
    pub phase: f64,
    /// m
    pub rest: Point,
    /// By harmonic, m.
    pub cosines: [Point; MAX_HARMONICS],
    pub sines: [Point; MAX_HARMONICS],
}

impl Cycles {
    /// Sum of the squares of the shape's numbers, m².
    pub(super) fn size(&self) -> f64 {
        self.cosines.iter().chain(&self.sines).map(Point::norm_squared).sum()
    }
}

/// Mean time since the beginning, and mean place, of the samples in it; the sum of their squares about that.
#[derive(Clone, Copy, Debug, Default)]
struct Bin {
    count: f64,
    time: f64,
    place: Point,
    scatter: f64,
}

/// A least-squares fit: its numbers, and the squares that it leaves, of those about the mean.
struct Fit {
    numbers: [Point; UNKNOWNS],
    left: f64,
    about_mean: f64,
}

/// The record of the last seconds, and the search in it.
#[derive(Clone, Debug)]
pub(super) struct Spectrum {
    bins: [Bin; BINS],
    /// Number of the newest bin since the time `zero`.
    newest: i64,
    zero: f64,
    width: f64,
    harmonics: usize,
    band: (f64, f64),
    trial: usize,
    misfits: [f64; CANDIDATES],
    /// Of the record, times the number of its bins, m².
    variance: f64,
    best: (f64, f64),
    is_begun: bool,
    /// The last search found no cycles in the band.
    has_failed: bool,
}

impl Spectrum {
    pub(super) fn new(settings: &Settings) -> Self {
        Self {
            bins: [Bin::default(); BINS],
            newest: 0,
            zero: 0.0,
            width: settings.start / BINS as f64,
            harmonics: settings.harmonics,
            band: (TAU * settings.band.0, TAU * settings.band.1),
            trial: 0,
            misfits: [0.0; CANDIDATES],
            variance: 0.0,
            best: (f64::INFINITY, 0.0),
            is_begun: false,
            has_failed: false,
        }
    }

    /// Forgets the record.
    pub(super) fn clear(&mut self) {
        (self.is_begun, self.trial) = (false, 0);
    }

    /// Takes a sample at `t`, s.
    pub(super) fn record(&mut self, t: f64, y: &Point) {
        if !self.is_begun {
            (self.bins, self.newest, self.zero, self.is_begun) = ([Bin::default(); BINS], 0, t, true);
        }
        #[allow(clippy::cast_possible_truncation)] // `as` saturates; the stream has no gaps of 2⁶³ bins
        let number = ComplexField::floor((t - self.zero) / self.width) as i64;
        for skipped in (self.newest + 1..=number).take(BINS) {
            self.bins[slot(skipped)] = Bin::default();
        }
        self.newest = number;
        let bin = &mut self.bins[slot(number)];
        bin.count += 1.0;
        bin.time += (t - self.zero - bin.time) / bin.count;
        let off = y - bin.place;
        bin.place += off / bin.count;
        bin.scatter += off.dot(&(y - bin.place));
    }

    /// The last search found no cycles in the band.
    pub(super) const fn has_failed(&self) -> bool {
        self.has_failed
    }

    /// Tries the next frequency on a record that is full; the cycles at time `t` when all have been tried and one stands out.
    pub(super) fn search(&mut self, t: f64) -> Option<Cycles> {
        if !self.is_begun || self.newest < BIN_COUNT {
            return None;
        }
        let rate = self.candidate();
        let Fit { left: misfit, about_mean, .. } = self.fit(t, rate);
        self.variance = about_mean;
        if self.trial < CANDIDATES {
            self.misfits[self.trial] = misfit;
        } else if misfit < self.best.0 {
            self.best = (misfit, rate);
        }
        self.trial += 1;
        if self.trial == CANDIDATES {
            self.best = (f64::INFINITY, self.grid(self.coarse() as f64));
        }
        if self.trial < CANDIDATES + REFINEMENTS {
            return None;
        }
        self.trial = 0;
        self.cycles(t, self.best.1)
    }

    /// The rate to try next, rad/s.
    fn candidate(&self) -> f64 {
        if self.trial < CANDIDATES {
            return self.grid(self.trial as f64);
        }
        let step = (self.trial - CANDIDATES) as f64 / (REFINEMENTS - 1) as f64 * 2.0 - 1.0;
        self.refined(step)
    }

    fn grid(&self, number: f64) -> f64 {
        let (low, high) = self.band;
        low * ComplexField::powf(high / low, number / (CANDIDATES - 1) as f64)
    }

    /// From one grid step below the coarse choice (−1) to one above (1).
    fn refined(&self, step: f64) -> f64 {
        let center = self.coarse() as f64;
        self.grid((center + step).clamp(0.0, (CANDIDATES - 1) as f64))
    }

    /// The candidate that fits best, or the highest multiple that fits well and better than its neighbours.
    fn coarse(&self) -> usize {
        let near = |i: usize| self.misfits.get(i).copied().unwrap_or(f64::INFINITY);
        let best = (0..CANDIDATES).min_by(|a, b| near(*a).total_cmp(&near(*b))).unwrap_or(0);
        let is_a_dip = |i: usize| near(i) <= near(i.wrapping_sub(1)) && near(i) <= near(i + 1);
        let is_a_multiple = |i: &usize| self.grid(*i as f64) >= MULTIPLE * self.grid(best as f64);
        let mut multiples = (0..CANDIDATES).rev().take_while(is_a_multiple);
        let fits = |i: &usize| near(*i) <= near(best) + AS_GOOD * self.variance && is_a_dip(*i);
        multiples.find(fits).unwrap_or(best)
    }

    /// How many harmonics of `rate` are slow enough to be told from others by bins as wide as these.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // `as` saturates, and takes the whole number
    fn seen(&self, rate: f64) -> usize {
        self.harmonics.min((PI / (rate * self.width)) as usize)
    }

    /// Least squares of the mean and the harmonics of `rate` at times from `t`.
    fn fit(&self, t: f64, rate: f64) -> Fit {
        let harmonics = self.seen(rate);
        let n = 1 + 2 * harmonics;
        let shift = self.bins[slot(self.newest)].place;
        // By unknown and by axis, a number for each bin; none for those without samples.
        let (mut rows, mut places) = ([[0.0; BINS]; UNKNOWNS], [[0.0; BINS]; 3]);
        for (b, bin) in self.bins.iter().enumerate().filter(|(_, bin)| bin.count > 0.0) {
            (0..3).for_each(|axis| places[axis][b] = bin.place[axis] - shift[axis]);
            rows[0][b] = 1.0;
            visit_multiples(rate * (bin.time + self.zero - t), harmonics, |k, cosine, sine| {
                (rows[1 + 2 * k][b], rows[2 + 2 * k][b]) = (cosine, sine);
            });
        }
        let (mut matrix, mut right) = ([[0.0; UNKNOWNS]; UNKNOWNS], [Point::zeros(); UNKNOWNS]);
        for i in 0..n {
            (0..=i).for_each(|j| matrix[i][j] = dot(&rows[i], &rows[j]));
            right[i] = Point::from(places.each_ref().map(|places| dot(&rows[i], places)));
        }
        let energy: f64 = places.iter().map(|places| dot(places, places)).sum();
        let about_mean = energy - right[0].norm_squared() / matrix[0][0].max(1.0);
        let mut numbers = solve(&mut matrix, right, n);
        numbers[n..].fill(Point::zeros());
        let explained: f64 = (0..n).map(|i| numbers[i].dot(&right[i])).sum();
        numbers[0] += shift;
        Fit { numbers, left: (energy - explained).max(0.0), about_mean }
    }

    /// The cycles of a rate, if they are most of the motion.
    fn cycles(&mut self, t: f64, rate: f64) -> Option<Cycles> {
        let Fit { numbers, left, about_mean } = self.fit(t, rate);
        // What moves within the bins is not explained either: it may be what seems slow by being seen too rarely.
        let within: f64 = self.bins.iter().map(|bin| bin.scatter / bin.count.max(1.0)).sum();
        self.has_failed = left + within > SHARE * (about_mean + within);
        if self.has_failed {
            return None;
        }
        let rest = self.rest(&numbers);
        let mut cycles = Cycles {
            rate,
            phase: -rest,
            rest: numbers[0],
            cosines: [Point::zeros(); MAX_HARMONICS],
            sines: [Point::zeros(); MAX_HARMONICS],
        };
        for k in 0..self.harmonics {
            let (a, b) = (numbers[1 + 2 * k], numbers[2 + 2 * k]);
            let (s, c): (f64, f64) = ComplexField::sin_cos((k + 1) as f64 * rest);
            cycles.cosines[k] = a * c + b * s;
            cycles.sines[k] = b * c - a * s;
            cycles.rest += cycles.cosines[k];
        }
        Some(cycles)
    }

    /// The phase at which the shape moves and turns least.
    fn rest(&self, numbers: &[Point; UNKNOWNS]) -> f64 {
        let unrest = |theta: f64| {
            let row = harmonics(theta, self.harmonics);
            let (mut speed, mut turn) = (Point::zeros(), Point::zeros());
            for k in 0..self.harmonics {
                let order = (k + 1) as f64;
                let (a, b) = (numbers[1 + 2 * k], numbers[2 + 2 * k]);
                speed += (b * row[1 + 2 * k] - a * row[2 + 2 * k]) * order;
                turn += (a * row[1 + 2 * k] + b * row[2 + 2 * k]) * (order * order);
            }
            speed.norm_squared() + 0.3 * turn.norm_squared()
        };
        let phase = |i: usize| TAU * i as f64 / PHASES as f64;
        (0..PHASES).map(phase).min_by(|a, b| unrest(*a).total_cmp(&unrest(*b))).unwrap_or(0.0)
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // below BINS, and not negative
fn slot(number: i64) -> usize {
    number.rem_euclid(BIN_COUNT) as usize
}

/// 1, cos θ, sin θ, cos 2θ, …
fn harmonics(theta: f64, count: usize) -> [f64; UNKNOWNS] {
    let mut row = [1.0; UNKNOWNS];
    visit_multiples(theta, count, |k, cosine, sine| (row[1 + 2 * k], row[2 + 2 * k]) = (cosine, sine));
    row
}

/// Solves the first `n` equations of a symmetric positive matrix, of which the lower half is read (Cholesky, with a ridge
/// against a matrix that is not definite).
fn solve(matrix: &mut [[f64; UNKNOWNS]; UNKNOWNS], mut right: [Point; UNKNOWNS], n: usize) -> [Point; UNKNOWNS] {
    let ridge = 1e-9 * (1.0 + (0..n).map(|i| matrix[i][i]).sum::<f64>());
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum();
            matrix[i][j] = if i == j {
                ComplexField::sqrt((matrix[i][i] + ridge - sum).max(ridge))
            } else {
                (matrix[i][j] - sum) / matrix[j][j]
            };
        }
        let sum: Point = (0..i).map(|k| right[k] * matrix[i][k]).sum();
        right[i] = (right[i] - sum) / matrix[i][i];
    }
    for i in (0..n).rev() {
        let sum: Point = (i + 1..n).map(|k| right[k] * matrix[k][i]).sum();
        right[i] = (right[i] - sum) / matrix[i][i];
    }
    right
}
