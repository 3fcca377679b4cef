//! The predictor: one update per sample, one prediction per control cycle.

use super::kinematic::Kinematic;
use super::periodic::Periodic;
use super::settings::{Method, Settings, SettingsError};
use super::spectrum::Spectrum;
use super::status::{Counters, Note, Notes};
use super::stream::{Sample, Stream};
use super::{Moving, Point};

/// Where a moving target will be: see [`predictor`](super).
#[derive(Clone, Debug)]
pub struct Predictor {
    settings: Settings,
    stream: Stream,
    velocity: Kinematic<2>,
    acceleration: Kinematic<3>,
    periodic: Periodic,
    spectrum: Spectrum,
    last: Moving,
    notes: Notes,
    asked: Notes,
    counters: Counters,
}

impl Predictor {
    /// A predictor that has seen nothing.
    ///
    /// # Errors
    /// [`SettingsError`] for declarations that cannot be meant.
    pub fn new(settings: Settings) -> Result<Self, SettingsError> {
        let settings = settings.checked()?;
        Ok(Self {
            settings,
            stream: Stream::new(&settings),
            velocity: Kinematic::new(),
            acceleration: Kinematic::new(),
            periodic: Periodic::new(&settings),
            spectrum: Spectrum::new(&settings),
            last: Moving::default(),
            notes: Notes::only(Note::NoData),
            asked: Notes::NONE,
            counters: Counters::default(),
        })
    }

    /// Takes a sample: its stamp, s, and the position, m. True when it was used.
    pub fn update(&mut self, stamp: f64, position: &Point) -> bool {
        let sample = Sample { t: stamp - self.settings.latency, y: self.shown(position) };
        let expected = self.stream.newest().map(|_| self.believed(sample.t).position);
        self.notes = self.stream.judge(sample, expected);
        self.counters.add(self.notes);
        let is_used = self.notes.common(Notes::REFUSED).is_empty();
        if is_used {
            self.learn(&sample);
        }
        is_used
    }

    /// The axes that count; the others are zero.
    fn shown(&self, position: &Point) -> Point {
        let mut y = *position;
        y.iter_mut().skip(self.settings.axes).for_each(|x| *x = 0.0);
        y
    }

    fn learn(&mut self, sample: &Sample) {
        let Sample { t, y } = sample;
        let noise = self.settings.noise * self.settings.noise;
        if self.notes.has(Note::Restarted) {
            self.periodic.stop();
            self.spectrum.clear();
        }
        if self.notes.has(Note::Restarted) || self.notes.has(Note::Jump) {
            (self.velocity, self.acceleration) = (Kinematic::new(), Kinematic::new());
        }
        #[allow(clippy::cast_precision_loss)]
        let axes = self.settings.axes as f64;
        self.velocity.update(*t, y, noise, axes);
        self.acceleration.update(*t, y, noise, axes);
        self.periodic.update(*t, y);
        self.spectrum.record(*t, y);
        if !self.periodic.is_started() && self.spectrum.is_full() {
            if let Some(cycles) = self.spectrum.search(*t) {
                self.periodic.begin(*t, &cycles);
            }
        }
    }

    /// What the method says of time `t`, or a simpler one that can.
    fn believed(&self, t: f64) -> Moving {
        let found = match self.settings.method {
            Method::Velocity => self.velocity.at(t),
            Method::Acceleration => self.acceleration.at(t),
            Method::Periodic | Method::Switch => self.periodic.at(t).or_else(|| self.velocity.at(t)),
            _ => None,
        };
        let held = || Moving {
            position: self.stream.newest().map_or(Point::zeros(), |sample| sample.y),
            velocity: Point::zeros(),
        };
        found.unwrap_or_else(held)
    }

    /// Where the target is at time `at`, s on the samples' clock, m; total.
    pub fn predict(&mut self, at: f64) -> Point {
        self.moving(at).position
    }

    /// How fast it moves then, m/s.
    pub fn velocity(&mut self, at: f64) -> Point {
        self.moving(at).velocity
    }

    fn moving(&mut self, at: f64) -> Moving {
        let Some(newest) = self.stream.newest() else { return self.last };
        self.asked = Notes::NONE;
        if !at.is_finite() {
            self.asked = Notes::only(Note::NoTime);
            return self.last;
        }
        let ahead = at - newest.t;
        let within = ahead.clamp(-self.settings.longest, self.settings.longest);
        let mut found = self.believed(newest.t + within);
        let away = found.position - newest.y;
        let reach = self.settings.speed_limit * within.abs() + 10.0 * self.settings.noise;
        if away.norm() > reach {
            self.asked = self.asked.and(Notes::only(Note::Limited));
            found.position = newest.y + away * (reach / away.norm());
        }
        if ahead != within {
            self.asked = self.asked.and(Notes::only(Note::TooFar));
            found.velocity = Point::zeros();
        }
        self.last = found;
        found
    }

    /// What was noted with the newest sample, and when a prediction was last asked for.
    #[must_use]
    pub fn notes(&self) -> Notes {
        self.notes.and(self.asked)
    }

    /// How often.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Frequency of the present cycle and its margin, Hz: two standard deviations.
    #[must_use]
    pub fn frequency(&self) -> Option<(f64, f64)> {
        self.periodic.frequency().map(|(hz, deviation)| (hz, 2.0 * deviation))
    }
}
