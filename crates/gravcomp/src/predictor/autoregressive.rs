//! The target some time ahead as a weighted sum of where it was: weights learnt for that very time, with no model between.
//!
//! > y(t + h) ≈ y(t) + Σ_b w_b (m_b − y(t)),  m_b = mean of y over the b-th piece of the past
//!
//! The weights solve the least squares over the last half minute, all axes together, for half the horizon, the horizon and one
//! and a half (direct multi-step prediction, e.g. F. Ernst, "Compensating for Quasi-periodic Motion in Robotic
//! Radiosurgery", 2012); between them a parabola. As only differences are weighed, a still target is held exactly.

use super::past::{Back, Past};
use super::{Moving, Point, Settings, dot, mix};
use nalgebra::ComplexField;

/// Pieces of the past, and so weights.
const P: usize = 23;

/// Lengths of the pieces in steps, after the newest sample: fine where it is near.
const PIECES: [u32; P] = [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 3, 4, 6, 8];

/// Their inverse numbers.
const SHARES: [f64; P] = {
    let (mut shares, mut b) = ([0.0; P], 0);
    while b < P {
        shares[b] = 1.0 / PIECES[b] as f64;
        b += 1;
    }
    shares
};

/// Times ahead in horizons.
const NODES: [f64; 3] = [0.5, 1.0, 1.5];

/// Times closer than this are the same, whatever their rounding, in horizons.
const TIE: f64 = 1e-3;

/// Time over which errors are weighed, s.
const MEMORY: f64 = 30.0;

/// Relative to the mean square of the differences.
const RIDGE: f64 = 1e-4;

/// Samples learnt from before the weights are used.
const FEWEST: u32 = 36;

/// Rows of the factorisation per sample, so that no update takes long.
const ROWS: usize = 4;

/// Time ahead, in horizons, from which the parabola goes on as a straight line, and from which that stands.
const STRAIGHT: f64 = 1.75;
const STANDING: f64 = 3.0;

type Row = [f64; P];

/// Weights, what they are solved from, and the past.
#[derive(Clone, Debug)]
pub(super) struct Autoregressive {
    /// s
    step: f64,
    horizon: f64,
    past: Past,
    /// Normal equations and their right sides by node.
    A: [Row; P],
    b: [Row; 3],
    learnt: u32,
    /// The last sample that the equations learnt from.
    taught: f64,
    /// The factor of the equations as they were some samples ago, inverse numbers on its diagonal, and their right sides.
    L: [Row; P],
    c: [Row; 3],
    row: usize,
    weights: Option<[Row; 3]>,
    /// The newest sample that was used, and where the target is at the nodes after it.
    curve: Option<(f64, [Point; 3])>,
}

impl Autoregressive {
    pub(super) fn new(settings: &Settings) -> Self {
        Self {
            step: (1.0 / settings.rate_hz).max(settings.horizon / 16.0),
            horizon: settings.horizon,
            past: Past::new(),
            A: [[0.0; P]; P],
            b: [[0.0; P]; 3],
            learnt: 0,
            taught: f64::NEG_INFINITY,
            L: [[0.0; P]; P],
            c: [[0.0; P]; 3],
            row: 0,
            weights: None,
            curve: None,
        }
    }

    /// Forgets where the target was, but not what was learnt.
    pub(super) fn forget_past(&mut self) {
        self.past.clear();
        (self.curve, self.taught) = (None, f64::NEG_INFINITY);
    }

    /// Takes a sample at `t`, s; those much closer than a step are left out.
    pub(super) fn update(&mut self, t: f64, y: &Point) {
        if self.past.sample(0).is_some_and(|(newest, _)| t - newest < 0.6 * self.step) {
            return;
        }
        self.past.push(t, y);
        self.learn(t);
        self.factorise();
        self.curve = self.predicted().map(|curve| (t, curve));
    }

    /// m_b − y(t) for the sample y(t) that `back` others came after, axis by axis, and y(t).
    fn differences(&self, back: Back) -> Option<([Row; 3], Point)> {
        let (t, y) = self.past.sample(back)?;
        let (mut rows, mut steps, mut from) = ([[0.0; P]; 3], 0.0, back);
        for (b, length) in PIECES.into_iter().enumerate() {
            let mut sum = Point::zeros();
            for _ in 0..length {
                steps += 1.0;
                let (place, found) = self.past.at(t - steps * self.step, from)?;
                from = found;
                sum += place;
            }
            let mean = sum * SHARES[b] - y;
            (0..3).for_each(|axis| rows[axis][b] = mean[axis]);
        }
        Some((rows, y))
    }

    /// The newest sample whose future is known teaches.
    fn learn(&mut self, t: f64) {
        let Some(back) = self.past.until(t - (NODES[2] - TIE) * self.horizon) else { return };
        let Some((then, _)) = self.past.sample(back) else { return };
        if then <= self.taught {
            return;
        }
        let Some((rows, y)) = self.differences(back) else { return };
        let mut targets = [Point::zeros(); 3];
        for (target, node) in targets.iter_mut().zip(NODES) {
            let Some((place, _)) = self.past.at(then + node * self.horizon, 0) else { return };
            *target = place - y;
        }
        let elapsed = (then - self.taught).min(MEMORY);
        self.taught = then;
        self.teach(&rows, &targets, ComplexField::exp(-elapsed / MEMORY));
    }

    fn teach(&mut self, rows: &[Row; 3], targets: &[Point; 3], kept: f64) {
        for i in 0..P {
            mix(&mut self.A[i], kept, [rows[0][i], rows[1][i], rows[2][i]], rows);
        }
        for (b, target) in self.b.iter_mut().zip(targets) {
            mix(b, kept, (*target).into(), rows);
        }
        self.learnt = self.learnt.saturating_add(1);
    }

    /// Goes on with the Cholesky factor; when it is done, new weights.
    fn factorise(&mut self) {
        if self.row == 0 {
            if self.learnt < FEWEST {
                return;
            }
            (self.L, self.c) = (self.A, self.b);
            let mean = (0..P).map(|i| self.A[i][i]).sum::<f64>() / P as f64;
            let ridge = RIDGE * mean + f64::MIN_POSITIVE;
            (0..P).for_each(|i| self.L[i][i] += ridge);
        }
        for i in self.row..(self.row + ROWS).min(P) {
            let (above, rest) = self.L.split_at_mut(i);
            let own = &mut rest[0];
            for (j, row) in above.iter().enumerate() {
                own[j] = (own[j] - dot(&own[..j], &row[..j])) * row[j];
            }
            let square = own[i] - dot(&own[..i], &own[..i]);
            own[i] = if square > 0.0 { 1.0 / ComplexField::sqrt(square) } else { 0.0 };
        }
        self.row += ROWS;
        if self.row >= P {
            self.row = 0;
            self.weights = Some(self.c.map(|right| self.solved(right)));
        }
    }

    fn solved(&self, mut x: Row) -> Row {
        for i in 0..P {
            x[i] = (x[i] - dot(&self.L[i][..i], &x[..i])) * self.L[i][i];
        }
        for i in (0..P).rev() {
            x[i] *= self.L[i][i];
            let value = x[i];
            for (entry, l) in x[..i].iter_mut().zip(&self.L[i][..i]) {
                *entry -= value * l;
            }
        }
        x
    }

    fn predicted(&self) -> Option<[Point; 3]> {
        let weights = self.weights.as_ref()?;
        let (rows, y) = self.differences(0)?;
        Some(weights.map(|w| y + Point::new(dot(&w, &rows[0]), dot(&w, &rows[1]), dot(&w, &rows[2]))))
    }

    /// Where the target is at `t`, and how fast; none before there are weights and enough of a past.
    pub(super) fn at(&self, t: f64) -> Option<Moving> {
        let (newest, [first, second, third]) = self.curve?;
        let ahead = (t - newest) / self.horizon;
        // The parabola in u = (ahead − 1)/½ through −1, 0 and 1.
        let (slope, bend) = ((third - first) / 2.0, (third + first) / 2.0 - second);
        let bent = (2.0 * (ahead.clamp(0.0, STRAIGHT) - 1.0), 2.0 * (ahead.clamp(0.0, STANDING) - STRAIGHT).max(0.0));
        let tangent = slope + bend * (2.0 * bent.0);
        let is_moving = (0.0..STANDING).contains(&ahead);
        Some(Moving {
            position: second + slope * bent.0 + bend * (bent.0 * bent.0) + tangent * bent.1,
            velocity: if is_moving { tangent * (2.0 / self.horizon) } else { Point::zeros() },
        })
    }
}
