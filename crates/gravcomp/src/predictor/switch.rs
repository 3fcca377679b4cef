//! Which method has lately predicted best: each is held to what it said of the horizon when the horizon has come.
//!
//! The weights of the methods are proportional to a high power of their mean square errors' inverse, so that one that is
//! clearly best stands alone, and several that are as good as each other are averaged.

use super::{METHODS, Method, Moving, Point, Settings};
use nalgebra::{ComplexField, Matrix3};

/// What each method says; none where one cannot.
pub(super) type Opinions = [Option<Moving>; METHODS];

/// Opinions that wait for their time.
const WAITING: usize = 32;

/// Time over which errors are remembered, s.
const MEMORY: f64 = 20.0;

/// Errors that a method must have been measured by before it is listened to.
const FEWEST: u32 = 8;

/// Power of the inverse of the mean square error.
const SHARPNESS: i32 = 4;

/// The mean square error of hold counts for so much: others are trusted where they are clearly better, as they can fail by more.
const TRUST_IN_HOLD: f64 = 0.8;

/// Shares of the mean square errors of hold and of the best above which a method is lost.
const LOST: (f64, f64) = (0.5, 2.0);

/// However noisy the samples, this share of an error is the method's.
const LEAST_SHARE: f64 = 0.2;

/// Smaller weights than this are none.
const SMALLEST: f64 = 1e-3;

/// An exponentially forgetting mean that begins as a plain one.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    value: f64,
    weight: f64,
    count: u32,
}

impl Mean {
    fn add(&mut self, value: f64, kept: f64) {
        self.weight = kept * self.weight + 1.0;
        self.value += (value - self.value) / self.weight;
        self.count = self.count.saturating_add(1);
    }
}

/// Errors of the methods, and what waits to be measured.
#[derive(Clone, Debug)]
pub(super) struct Switch {
    /// Density of the record of opinions, s.
    spacing: f64,
    said: [(f64, Opinions, Option<Moving>); WAITING],
    newest: usize,
    count: usize,
    /// Times closer than this are the same, whatever their rounding, s.
    tie: f64,
    /// Mean square of the noise of a sample, all axes, m².
    noise: f64,
    errors: [Mean; METHODS],
    /// Of the methods together.
    covariance: Matrix3<f64>,
    covariance_weight: f64,
    last: f64,
    weights: [f64; METHODS],
}

impl Switch {
    pub(super) fn new(settings: &Settings) -> Self {
        Self {
            spacing: settings.horizon / (WAITING - 6) as f64,
            said: [(f64::NEG_INFINITY, [None; METHODS], None); WAITING],
            newest: 0,
            count: 0,
            tie: 1e-3 * settings.horizon,
            noise: settings.axes as f64 * settings.noise * settings.noise,
            errors: [Mean::default(); METHODS],
            covariance: Matrix3::zeros(),
            covariance_weight: 0.0,
            last: 0.0,
            weights: [0.0; METHODS],
        }
    }

    /// Forgets what was said, but not how good it was: the target has jumped, or its samples were missing.
    pub(super) fn forget_said(&mut self) {
        self.count = 0;
    }

    /// The target is at `y` at time `t`, s: measures the newest opinions that were about an earlier time.
    pub(super) fn measure(&mut self, t: f64, y: &Point) {
        let Some(back) = (0..self.count).find(|back| self.said[self.slot(*back)].0 <= t + self.tie) else { return };
        let (about, opinions, together) = self.said[self.slot(back)];
        // What was said before it has been surpassed.
        self.count = back;
        let kept: f64 = ComplexField::exp(-(t - self.last).clamp(0.0, MEMORY) / MEMORY);
        self.last = t;
        for (mean, opinion) in self.errors.iter_mut().zip(opinions) {
            if let Some(moving) = opinion {
                mean.add((moving.after(t - about) - y).norm_squared(), kept);
            }
        }
        if let Some(moving) = together {
            let error = moving.after(t - about) - y;
            self.covariance_weight = kept * self.covariance_weight + 1.0;
            self.covariance += (error * error.transpose() - self.covariance) / self.covariance_weight;
        }
        self.weigh();
    }

    fn slot(&self, back: usize) -> usize {
        (self.newest + WAITING - back) % WAITING
    }

    /// Writes down what the methods, and all together, say of the time `about`.
    pub(super) fn note(&mut self, about: f64, opinions: &Opinions, together: Moving) {
        if self.count > 0 && about - self.said[self.newest].0 < self.spacing {
            return;
        }
        self.newest = (self.newest + 1) % WAITING;
        self.said[self.newest] = (about, *opinions, Some(together));
        self.count = (self.count + 1).min(WAITING);
    }

    fn weigh(&mut self) {
        let least = self.own(self.least());
        for method in 0..METHODS {
            let mean = self.errors[method];
            let trust = if method == Method::Hold as usize { TRUST_IN_HOLD } else { 1.0 };
            let share =
                if mean.count >= FEWEST { (least / (trust * self.own(mean.value))).powi(SHARPNESS) } else { 0.0 };
            self.weights[method] = if share >= SMALLEST { share } else { 0.0 };
        }
    }

    /// It has lately been little better than holding still, and much worse than the best.
    pub(super) fn is_lost(&self, method: Method) -> bool {
        let [own, hold] = [method, Method::Hold].map(|method| self.errors[method as usize]);
        own.count >= FEWEST && own.value > LOST.0 * hold.value && own.value > LOST.1 * self.least()
    }

    /// The smallest mean square error of a method that was measured often enough.
    fn least(&self) -> f64 {
        let heard = self.errors.iter().filter(|mean| mean.count >= FEWEST);
        heard.map(|mean| mean.value).fold(f64::INFINITY, f64::min)
    }

    /// The part of a mean square error that is not the samples' own.
    fn own(&self, value: f64) -> f64 {
        (value - self.noise).max(LEAST_SHARE * value) + f64::MIN_POSITIVE
    }

    /// Its errors are forgotten: it has begun anew.
    pub(super) fn forgive(&mut self, method: Method) {
        self.errors[method as usize] = Mean::default();
        self.weigh();
    }

    /// The methods together, each with its weight; none before any has been measured.
    #[inline(always)]
    pub(super) fn blend(&self, opinion: impl Fn(Method) -> Option<Moving>) -> Option<Moving> {
        let (mut sum, mut total) = (Moving::default(), 0.0);
        for (method, weight) in Method::SINGLE.into_iter().zip(self.weights) {
            if weight > 0.0
                && let Some(moving) = opinion(method)
            {
                sum.position += moving.position * weight;
                sum.velocity += moving.velocity * weight;
                total += weight;
            }
        }
        let share = 1.0 / total;
        (total > 0.0).then(|| Moving { position: sum.position * share, velocity: sum.velocity * share })
    }

    /// The method with the largest weight.
    pub(super) fn best(&self) -> Option<usize> {
        let heaviest = (0..METHODS).max_by(|a, b| self.weights[*a].total_cmp(&self.weights[*b]))?;
        (self.weights[heaviest] > 0.0).then_some(heaviest)
    }

    /// Mean square of the errors of all together at the horizon, measurement noise included, m²; none before some were seen.
    pub(super) fn covariance(&self) -> Option<Matrix3<f64>> {
        (self.errors[Method::Hold as usize].count >= FEWEST).then_some(self.covariance)
    }
}
