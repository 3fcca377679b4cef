//! The predictor: one update per sample, one prediction per control cycle.

use super::autoregressive::Autoregressive;
use super::fourier::Fourier;
use super::kinematic::Kinematic;
use super::periodic::Periodic;
use super::settings::{Method, Settings};
use super::spectrum::Spectrum;
use super::status::{Counters, Note, Notes};
use super::stream::{Sample, Stream, Verdict};
use super::switch::{Opinions, Switch};
use super::{METHODS, Moving, Point};
use crate::error::SettingsError;
use nalgebra::Matrix3;

/// Predictions for times further off, in horizons, and for times that are none, are no worse.
const LARGEST_GROWTH: f64 = 1e6;

/// Where a moving target will be: see [`predictor`](super).
#[derive(Clone, Debug)]
pub struct Predictor {
    settings: Settings,
    stream: Stream,
    velocity: Kinematic<2>,
    acceleration: Kinematic<3>,
    periodic: Periodic,
    spectrum: Spectrum,
    autoregressive: Autoregressive,
    fourier: Fourier,
    switch: Switch,
    /// The prediction that was given last.
    last: Moving,
    /// With the newest sample, and when a prediction was last asked for.
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
            autoregressive: Autoregressive::new(&settings),
            fourier: Fourier::new(&settings),
            switch: Switch::new(&settings),
            last: Moving::default(),
            notes: Notes::NONE,
            asked: Notes::NONE,
            counters: Counters::default(),
        })
    }

    /// Forgets everything but how often what was noted.
    pub fn reset(&mut self) {
        if let Ok(fresh) = Self::new(self.settings) {
            *self = Self { counters: self.counters, ..fresh };
        }
    }

    /// Takes a sample: its stamp, s, and the position, m. True when it was used; [`Self::notes`] says why not.
    pub fn update(&mut self, stamp: f64, position: &Point) -> bool {
        let sample = Sample { t: stamp - self.settings.latency, y: self.shown(position) };
        let expected =
            [self.blend(sample.t), self.velocity.at(sample.t)].map(|found| found.map(|moving| moving.position));
        let (before, had) = (self.believed(sample.t + self.settings.horizon).position, self.stream.newest());
        let verdict = self.stream.judge(sample, expected);
        let is_used = verdict.notes.common(Notes::REFUSED).is_empty();
        self.notes = verdict.notes;
        if is_used {
            let now = self.learn(&sample, &verdict, had);
            let jumps = had.is_some() && (now.position - before).norm() > self.settings.jump;
            self.notes = self.notes.and(Notes::when(jumps, Note::Jump));
        }
        self.counters.add(self.notes);
        is_used
    }

    /// The axes that count; the others are zero.
    fn shown(&self, position: &Point) -> Point {
        let mut y = *position;
        y.iter_mut().skip(self.settings.axes).for_each(|x| *x = 0.0);
        y
    }

    /// Learns from a sample that is used; what it says of the horizon now.
    fn learn(&mut self, sample: &Sample, verdict: &Verdict, had: Option<Sample>) -> Moving {
        if verdict.notes.has(Note::Restarted) {
            self.begin_anew();
        } else if verdict.notes.has(Note::Moved) {
            self.follow(sample, verdict.notes.has(Note::Dropped), had);
        }
        for each in verdict.waited.iter().chain([sample]) {
            self.switch.measure(each.t, &each.y);
            self.teach(each);
        }
        let about = sample.t + self.settings.horizon;
        let opinions = self.healed(about);
        let together = self.switch.blend(|method| opinions[method as usize]);
        let own = match self.settings.method {
            Method::Switch => together,
            single => opinions[single as usize],
        };
        let now = own.or(together).unwrap_or(Moving::standing(sample.y));
        self.switch.note(about, &opinions, now);
        let is_out = self.periodic.is_at_an_end() || self.spectrum.has_failed();
        self.notes =
            self.notes.and(Notes::when(own.is_none(), Note::Learning)).and(Notes::when(is_out, Note::OutOfBand));
        now
    }

    /// Forgets everything but the stream and what was counted, noted and given.
    fn begin_anew(&mut self) {
        if let Ok(fresh) = Self::new(self.settings) {
            let stream = self.stream.clone();
            *self = Self { stream, counters: self.counters, last: self.last, notes: self.notes, ..fresh };
        }
    }

    /// The target is elsewhere; after a `gap` nothing is known of the places between.
    fn follow(&mut self, sample: &Sample, gap: bool, had: Option<Sample>) {
        let distance = had.map_or(0.0, |had| (sample.y - had.y).norm());
        self.periodic.shift(distance);
        self.fourier.shift(distance);
        (self.velocity, self.acceleration) = (Kinematic::new(), Kinematic::new());
        self.switch.forget_said();
        if gap {
            self.autoregressive.forget_past();
            self.spectrum.clear();
        }
    }

    fn teach(&mut self, sample: &Sample) {
        let Sample { t, y } = sample;
        let noise = self.settings.noise * self.settings.noise;
        self.velocity.update(*t, y, noise, self.settings.axes);
        self.acceleration.update(*t, y, noise, self.settings.axes);
        self.periodic.update(*t, y);
        self.autoregressive.update(*t, y);
        self.fourier.update(*t, y);
        self.spectrum.record(*t, y);
        if self.periodic.should_begin(self.switch.is_lost(Method::Periodic))
            && let Some(cycles) = self.spectrum.search(*t)
        {
            self.periodic.begin(*t, &cycles);
            self.switch.forgive(Method::Periodic);
        }
    }

    /// What each method says of time `t`; one whose numbers overflowed begins anew and says nothing.
    fn healed(&mut self, t: f64) -> Opinions {
        let mut opinions = Method::SINGLE.map(|method| self.opinion(method, t));
        for (method, opinion) in Method::SINGLE.into_iter().zip(&mut opinions) {
            if opinion.is_some_and(|moving| !moving.is_finite()) {
                *opinion = None;
                self.restart(method);
            }
        }
        opinions
    }

    fn restart(&mut self, method: Method) {
        match method {
            Method::Velocity => self.velocity = Kinematic::new(),
            Method::Acceleration => self.acceleration = Kinematic::new(),
            Method::Periodic => self.periodic.stop(),
            Method::Autoregressive => self.autoregressive = Autoregressive::new(&self.settings),
            Method::Fourier => self.fourier.stop(),
            Method::Hold | Method::Switch => {}
        }
    }

    /// What one method says of time `t`; none where it cannot.
    fn opinion(&self, method: Method, t: f64) -> Option<Moving> {
        match method {
            Method::Hold => self.stream.newest().map(|sample| Moving::standing(sample.y)),
            Method::Velocity => self.velocity.at(t),
            Method::Acceleration => self.acceleration.at(t),
            Method::Periodic => self.periodic.at(t),
            Method::Autoregressive => self.autoregressive.at(t),
            Method::Fourier => self.fourier.at(t),
            Method::Switch => self.blend(t),
        }
    }

    /// The methods together, each with its weight; none before any has been measured.
    fn blend(&self, t: f64) -> Option<Moving> {
        self.switch.blend(|method| self.opinion(method, t))
    }

    /// What the method says of time `t`, or the switch, or at last the newest sample.
    fn believed(&self, t: f64) -> Moving {
        let own = self.opinion(self.settings.method, t);
        let held = || self.stream.newest().map_or(self.last, |sample| Moving::standing(sample.y));
        own.or_else(|| self.blend(t)).unwrap_or_else(held)
    }

    /// Where the target is at time `at`, s on the samples' clock, m. Total: finite, and within the speed limit of the newest
    /// sample; before that zero.
    pub fn predict(&mut self, at: f64) -> Point {
        self.moving(at).0
    }

    /// How fast it moves then, m/s: at most the speed limit.
    pub fn velocity(&mut self, at: f64) -> Point {
        self.moving(at).1
    }

    /// Both in one.
    pub fn moving(&mut self, at: f64) -> (Point, Point) {
        self.last = self.asked_for(at);
        (self.last.position, self.last.velocity)
    }

    fn asked_for(&mut self, at: f64) -> Moving {
        let Some(newest) = self.stream.newest() else { return self.last };
        if !at.is_finite() {
            self.asked = Notes::only(Note::NoTime);
            return self.last;
        }
        let ahead = at - newest.t;
        let within = ahead.clamp(-self.settings.horizon, self.settings.longest);
        let mut found = self.believed(newest.t + within);
        if ahead != within {
            found.velocity = Point::zeros();
        }
        let is_limited = found.limit(&newest.y, within, &self.settings);
        self.asked = Notes::when(is_limited, Note::Limited).and(Notes::when(ahead != within, Note::TooFar));
        found
    }

    /// Mean square of the prediction's error at time `at`, axis by axis, m²: what it was at the horizon lately, measurement noise
    /// included, and more for longer times.
    #[must_use]
    pub fn covariance(&self, at: f64) -> Matrix3<f64> {
        let ahead = self.stream.newest().map_or(f64::INFINITY, |newest| (at - newest.t).abs()) / self.settings.horizon;
        let growth = match ahead {
            near if near <= 1.0 => f64::midpoint(1.0, near),
            far if far <= LARGEST_GROWTH => far,
            _ => LARGEST_GROWTH,
        };
        let ignorance = self.settings.speed_limit * self.settings.horizon;
        let seen = self.switch.covariance();
        seen.unwrap_or_else(|| Matrix3::from_diagonal_element(ignorance * ignorance)) * (growth * growth)
    }

    /// What was noted with the newest sample, and when a prediction was last asked for.
    #[must_use]
    pub fn notes(&self) -> Notes {
        self.notes.and(self.asked).and(Notes::when(self.stream.newest().is_none(), Note::NoData))
    }

    /// How often.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// The method that predictions come from, or have most of their weight from.
    #[must_use]
    pub fn chosen(&self) -> Method {
        let newest = self.stream.newest().map_or(0.0, |sample| sample.t);
        let heaviest = || self.switch.best().map_or(Method::Hold, |best| Method::SINGLE[best]);
        match self.settings.method {
            Method::Switch => heaviest(),
            own if self.opinion(own, newest).is_some() => own,
            _ => heaviest(),
        }
    }

    /// Frequency of the present cycle and its margin, Hz: two standard deviations. None before cycles were found.
    #[must_use]
    pub fn frequency(&self) -> Option<(f64, f64)> {
        self.periodic.frequency().map(|(hz, deviation)| (hz, 2.0 * deviation))
    }

    /// From lowest to highest place of the present cycle, m per axis, and its margin: two standard deviations.
    #[must_use]
    pub fn amplitude(&self) -> Option<(Point, Point)> {
        self.periodic.amplitude().map(|(size, deviation)| (size, deviation * 2.0))
    }
}

const _: () = assert!(Method::SINGLE.len() == METHODS);
