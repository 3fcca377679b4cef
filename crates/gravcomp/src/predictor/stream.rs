//! Which samples are used: stamps in order, numbers that are numbers, positions where the target can be.
//!
//! A sample that is far off in time or place may be the first of many, so it waits: if the next one comes from there too, both
//! are believed, and that is noted; if not, it was a glitch.

use super::status::{Note, Notes};
use super::{Point, Settings};

/// No target is further away, m.
const FARTHEST: f64 = 1e6;

/// No stamp is larger, s: a hundredth of a second must still be told apart.
const LATEST: f64 = 1e12;

/// Beyond so many times the usual surprise, and standard deviations of a sample, a position waits to be confirmed.
const FAR: f64 = 7.0;

/// How fast the usual surprise is followed, relative per sample; in the beginning faster.
const MEMORY: f64 = 0.05;
const FIRST_MEMORY: f64 = 0.5;

/// Least surprise that is followed, in standard deviations of a sample: after a long rest a motion is soon usual again.
const SMALLEST: f64 = 0.25;

/// After so many samples in a row that were far off, one as near to the last as the target can go confirms it.
const PATIENCE: u32 = 2;

/// Samples in a row, in order among themselves, that are older than the newest one when a clock was set.
const SET_BACK: u32 = 3;

/// Periods without a sample after which the next stamp has to be confirmed.
const GAP_PERIODS: f64 = 8.0;

/// Shortest gap, s.
const SHORTEST_GAP: f64 = 0.5;

/// Longest gap after which the cycles are still those of before, s.
const LONGEST_GAP: f64 = 10.0;

#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub t: f64,
    pub y: Point,
}

/// What became of a sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Verdict {
    /// It was used unless one of [`Notes::REFUSED`] is among them.
    pub notes: Notes,
    /// The sample before it that this one confirms.
    pub waited: Option<Sample>,
}

impl From<Notes> for Verdict {
    fn from(notes: Notes) -> Self {
        Self { notes, waited: None }
    }
}

/// The newest sample that was used, and the one that waits.
#[derive(Clone, Debug)]
pub(super) struct Stream {
    period: f64,
    noise: f64,
    speed_limit: f64,
    newest: Option<Sample>,
    waiting: Option<Sample>,
    /// Samples in a row that wait, or did.
    far: u32,
    older: u32,
    oldest: f64,
    /// What three of four samples surprise by less than, m: the quartile is blind to how large a spike is.
    usual: f64,
    count: f64,
}

impl Stream {
    pub(super) fn new(settings: &Settings) -> Self {
        let period = 1.0 / settings.rate_hz;
        Self {
            period,
            noise: settings.noise,
            speed_limit: settings.speed_limit,
            newest: None,
            waiting: None,
            far: 0,
            older: 0,
            oldest: 0.0,
            usual: settings.speed_limit * period / 8.0,
            count: 0.0,
        }
    }

    /// The newest sample that was used.
    pub(super) const fn newest(&self) -> Option<Sample> {
        self.newest
    }

    /// Judges a sample; `expected` is where the target should be by then, and where if it only goes on.
    pub(super) fn judge(&mut self, sample: Sample, expected: [Option<Point>; 2]) -> Verdict {
        if !(sample.t.abs() < LATEST && sample.y.iter().all(|x| x.abs() < FARTHEST)) {
            return Notes::only(Note::NotFinite).into();
        }
        let Some(newest) = self.newest else {
            self.newest = Some(sample);
            return Notes::NONE.into();
        };
        let dt = sample.t - newest.t;
        if dt <= 0.0 {
            return self.set_back(sample, dt).into();
        }
        self.older = 0;
        let is_gap = dt > self.gap();
        // What is near the newest sample, or on its way on from there, is no spike, however wrong the prediction.
        let held = (sample.y - newest.y).norm();
        let [surprise, swerve] = expected.map(|place| place.map_or(held, |place| held.min((sample.y - place).norm())));
        let is_spike = !is_gap && surprise.min(swerve) > self.limit();
        let dropped = Notes::when(dt > 1.5 * self.period, Note::Dropped);
        if !is_gap && !is_spike {
            self.follow(surprise);
            self.accept(sample);
            return dropped.into();
        }
        let waiting = self.waiting.replace(sample).filter(|waiting| self.confirms(waiting, &sample));
        if waiting.is_none() {
            self.far = self.far.saturating_add(1);
            return Notes::only(if is_gap { Note::Gap } else { Note::Spike }).into();
        }
        if is_spike {
            self.follow(surprise);
        }
        self.accept(sample);
        let moved = Notes::only(if is_gap && dt > LONGEST_GAP { Note::Restarted } else { Note::Moved });
        Verdict { notes: moved.and(Notes::when(is_gap, Note::Dropped)), waited: waiting }
    }

    fn accept(&mut self, sample: Sample) {
        (self.newest, self.waiting, self.far, self.older) = (Some(sample), None, 0, 0);
    }

    fn gap(&self) -> f64 {
        (GAP_PERIODS * self.period).max(SHORTEST_GAP)
    }

    /// How far a position may be from where it is expected, m.
    fn limit(&self) -> f64 {
        FAR * (self.usual + self.noise)
    }

    /// The sample that waits is shortly before this one and near it.
    fn confirms(&self, waiting: &Sample, sample: &Sample) -> bool {
        let dt = sample.t - waiting.t;
        let way = if self.far < PATIENCE { 0.0 } else { self.speed_limit * dt };
        dt > 0.0 && dt <= self.gap() && (sample.y - waiting.y).norm() <= self.limit() + way
    }

    fn follow(&mut self, surprise: f64) {
        self.count += 1.0;
        let rate = MEMORY.max(FIRST_MEMORY / nalgebra::ComplexField::sqrt(self.count));
        let change = if surprise > self.usual { 3.0 * rate } else { -rate };
        let factor: f64 = nalgebra::ComplexField::exp(change);
        self.usual = (self.usual * factor).clamp(SMALLEST * self.noise, FARTHEST);
    }

    fn set_back(&mut self, sample: Sample, dt: f64) -> Notes {
        if dt == 0.0 {
            return Notes::only(Note::Repeated);
        }
        let follows = self.older > 0 && sample.t > self.oldest && sample.t - self.oldest <= self.gap();
        self.older = if follows { self.older + 1 } else { 1 };
        self.oldest = sample.t;
        if self.older < SET_BACK {
            return Notes::only(Note::Backward);
        }
        self.accept(sample);
        Notes::only(Note::Restarted)
    }
}
