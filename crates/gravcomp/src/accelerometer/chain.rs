//! The chain: one call per control cycle.

use super::clock::HostClock;
use super::doubt::Doubt;
use super::fault::{Counters, Fault, Faults, Status, up};
use super::gate::{Felt, Gate};
use super::motion::MotionFilter;
use super::output::Output;
use super::run::{Order, Run};
use super::sample::{Reading, Sample};
use super::settings::{Settings, SettingsError};
use super::state::{Event, Policy, State};
use super::tilt::{Tilt, cosine, is_within};
use super::unit::{LikelyUnit, UnitWatch};
use crate::base::{BaseMotion, Gravity};
use crate::constants::STANDARD_GRAVITY;
use nalgebra::Vector3;

/// Samples in a row after which the direction of up is judged: enough against noise, few enough to alarm early.
const POSE_COUNT: u32 = 5;

/// Runs of the usual length for which a mean of the wrong size is waited on: a base that swings has it for a while.
const PATIENCE: u32 = 5;

/// Samples in a row that end a mere silence, if they agree with the last value.
const RETURN_COUNT: u32 = 3;

/// Cosine below which up is down: 120°.
const OPPOSITE: f64 = -0.5;

/// The base's accelerometer as a monitored signal: see [`accelerometer`](super).
#[derive(Clone, Debug)]
pub struct Accelerometer {
    settings: Settings,
    /// Cosines of [`Settings::pose_limit`] and [`Settings::tilt_limit`].
    pose_cosine: f64,
    tilt_cosine: f64,
    up: Vector3<f64>,

    clock: HostClock,
    gate: Gate,
    run: Run,
    doubt: Doubt,
    unit: UnitWatch,
    filter: MotionFilter,
    tilt: Tilt,
    output: Output,

    state: State,
    status: Status,
    counters: Counters,
    /// Where the output goes while the sensor is trusted, or where it was going when trust was lost.
    goal: BaseMotion,
    /// The last accepted sample, m/s², sensor axes.
    anchor: Option<Vector3<f64>>,
    /// The slow tilt estimate may be contradicted: somebody acknowledged that the base stands otherwise.
    tilt_is_void: bool,
    age_ns: Option<i64>,
    /// Time without an accepted sample, ns; an acknowledgement sets it back.
    silent_ns: i64,
    /// Time without a sample that could be used, ns.
    unusable_ns: i64,
}

impl Accelerometer {
    /// A chain that has received nothing.
    ///
    /// # Errors
    /// Those of [`Settings::checked`].
    pub fn new(settings: Settings) -> Result<Self, SettingsError> {
        let settings = settings.checked()?;
        let (nominal, up) = (settings.nominal(), settings.up.normalize());
        Ok(Self {
            pose_cosine: cosine(settings.pose_limit),
            tilt_cosine: cosine(settings.tilt_limit),
            up,
            clock: HostClock::default(),
            gate: Gate::default(),
            run: Run::default(),
            doubt: Doubt::default(),
            unit: UnitWatch::default(),
            filter: MotionFilter::new(&settings),
            tilt: Tilt::new(up),
            output: Output::new(nominal),
            state: State::first(settings.policy),
            status: Status::default(),
            counters: Counters::default(),
            goal: BaseMotion::at_rest(Gravity(nominal)),
            anchor: None,
            tilt_is_void: false,
            age_ns: None,
            silent_ns: 0,
            unusable_ns: 0,
            settings,
        })
    }

    /// One control cycle: `now_ns` on the caller's monotonic clock, and the newest sample that has not been handed in yet.
    ///
    /// Never fails, whatever comes in.
    pub fn step(&mut self, now_ns: i64, sample: Option<&Sample>) -> Reading {
        self.status.seen = Faults::NONE;
        let (elapsed_ns, jumped) = self.clock.advance(now_ns);
        self.wait(elapsed_ns);
        self.alarm(jumped);
        if let Some(sample) = sample {
            self.receive(now_ns, sample);
        }
        self.watch_silence();
        self.output.follow(&self.target(), elapsed_ns, &self.settings);
        self.reading()
    }

    /// The arm may be armed: under [`Policy::Strict`] on a live sensor only, under [`Policy::Paper`] also without any; never
    /// while another alarm stands.
    #[must_use]
    pub fn armable(&self) -> bool {
        let against = self.status.alarms.without(Faults::only(Fault::NoSensor));
        match (self.settings.policy, self.state) {
            (_, State::Live) => !self.status.is_alarm(),
            (Policy::Paper, State::Nominal) => against.is_empty(),
            _ => false,
        }
    }

    /// Somebody has looked at it. A latched fault is left: the output stays on the tilt estimate until the sensor is trusted
    /// again or the fault latches anew. Where trust was lost, the base may stand otherwise than the tilt estimate says.
    pub fn acknowledge(&mut self) {
        if self.state == State::Live || self.state.is_start() {
            return;
        }
        if self.state == State::Fault {
            self.silent_ns = self.settings.hold_ns.saturating_add(1);
        }
        self.tilt_is_void = true;
        self.anchor = None;
        self.run.restart();
        self.happens(Event::Acknowledged);
    }

    /// How often what happened, since the start.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// The unit that the sensor seems to send; none while its samples have the size of gravity in m/s², or of nothing known.
    #[must_use]
    pub fn likely_unit(&self) -> Option<LikelyUnit> {
        self.unit.named()
    }

    /// What was declared.
    #[must_use]
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// What the last step returned; before the first one, the nominal gravity.
    #[must_use]
    pub fn reading(&self) -> Reading {
        Reading {
            gravity: self.output.gravity(),
            base: self.output.base(),
            state: self.state,
            age_ns: self.age_ns,
            status: self.status,
        }
    }

    /// Where the output should be. Held values are those of a base at rest: what turned may have stopped.
    fn target(&self) -> BaseMotion {
        match self.state {
            State::Live => self.goal,
            State::Degraded | State::Fault => BaseMotion::at_rest(Gravity(self.tilt.gravity())),
            _ => BaseMotion::at_rest(self.goal.specific_force.into()),
        }
    }

    /// Time passes.
    fn wait(&mut self, elapsed_ns: i64) {
        for age in [&mut self.silent_ns, &mut self.unusable_ns] {
            *age = age.saturating_add(elapsed_ns);
        }
        self.age_ns = self.age_ns.map(|age| age.saturating_add(elapsed_ns));
    }

    /// A sample comes in: stamp, order, numbers, change, in this order.
    fn receive(&mut self, now_ns: i64, sample: &Sample) {
        up(&mut self.counters.received);
        if self.state == State::Live && self.silent_ns > self.settings.fault_after_ns {
            self.alarm(Faults::only(Fault::Age));
        }
        let wrong_time = Gate::stamp(&self.settings, now_ns, sample.stamp_ns);
        if !wrong_time.has(Fault::Clock) && !self.is_next(sample) {
            return;
        }
        self.watch_unit(sample);
        match self.gate.felt(&self.settings, sample) {
            Ok(felt) if wrong_time.is_empty() => self.weigh(felt, now_ns.saturating_sub(sample.stamp_ns)),
            Ok(_) => self.reject(wrong_time),
            Err(faults) => self.reject(wrong_time.and(faults)),
        }
    }

    /// The sample follows the last one that fitted. One that does not is neither good nor bad: links duplicate and reorder.
    fn is_next(&mut self, sample: &Sample) -> bool {
        let order = self.run.place(sample.seq, sample.stamp_ns);
        if order != Order::Next {
            self.note(Faults::only(Fault::Sequence));
        }
        if order == Order::Restarted {
            self.alarm(Faults::only(Fault::Sequence));
        }
        order == Order::Next
    }

    /// A sample that is good by itself: does it fit the one before?
    fn weigh(&mut self, felt: Felt, latency_ns: i64) {
        if self.jumps(&felt) {
            self.reject(Faults::only(Fault::Jerk));
            if self.state == State::Live {
                return;
            }
        } else {
            self.doubt.clear();
        }
        let dt = self.run.since_last(&felt);
        self.run.extend(felt);
        self.filter.take(&felt, dt);
        self.unusable_ns = 0;
        if self.state == State::Live || self.qualifies() {
            self.accept(&felt, dt.unwrap_or_default(), latency_ns);
        }
    }

    /// Further from the last sample that fitted than the base can have moved. Only samples that never came widen that:
    /// a jump must not become small by waiting while samples are rejected.
    fn jumps(&self, felt: &Felt) -> bool {
        let dt = self.run.since_last(felt).map(|dt| if self.doubt.is_any() { 0.0 } else { dt });
        dt.is_some_and(|dt| self.run.distance(felt) > self.settings.jump(dt))
    }

    /// The output follows the sample.
    fn accept(&mut self, felt: &Felt, dt: f64, latency_ns: i64) {
        up(&mut self.counters.accepted);
        self.age_ns = Some(latency_ns.max(0));
        self.silent_ns = latency_ns.max(0);
        self.anchor = Some(felt.force);
        self.goal = self.filter.base(&self.settings);
        let (f, w) = (self.goal.specific_force.0, self.goal.angular_velocity);
        self.tilt.follow(&f, &w, dt, self.settings.tilt_time);
        if !self.settings.moving_base {
            self.watch_tilt(&f);
        }
    }

    /// What a creeping fault cannot escape: a mean of the wrong size or outside its cone, or a direction far from the mean.
    fn watch_tilt(&mut self, f: &Vector3<f64>) {
        let is_mature = self.tilt.memory() >= self.settings.tilt_time;
        let wrong_size = (self.tilt.size() - 1.0).abs() > self.settings.norm_tolerance;
        if is_mature && wrong_size || !is_within(&self.tilt.up(), &self.up, self.pose_cosine) {
            self.alarm(Faults::only(Fault::Drift));
        }
        if self.tilt.strays(f, self.pose_cosine) {
            self.alarm(Faults::only(Fault::Tilt));
        }
    }

    /// The sample is not used; several make an alarm.
    fn reject(&mut self, faults: Faults) {
        self.note(faults);
        let alarms = self.doubt.add(faults, self.settings.density);
        if self.state != State::Live {
            self.run.restart();
        }
        self.alarm(alarms);
    }

    /// The run is long enough and plausible; then the sensor is trusted.
    fn qualifies(&mut self) -> bool {
        if self.state == State::Fault || !(self.returns() || self.is_plausible()) {
            return false;
        }
        if self.tilt_is_old() {
            let memory = f64::from(self.run.count()) * self.settings.period();
            self.tilt.seed(self.mean(), memory);
        }
        self.tilt_is_void = false;
        self.doubt = Doubt::default();
        self.unit = UnitWatch::default();
        self.status.alarms = Faults::NONE;
        self.happens(Event::Qualified);
        true
    }

    /// After a short silence the level is what it was.
    fn returns(&self) -> bool {
        let near = |anchor: Vector3<f64>| (self.run.mean() - anchor).norm() <= self.settings.jump(0.0);
        self.run.count() >= RETURN_COUNT.min(self.settings.start_count)
            && self.status.alarms.without(Faults::SILENCE).is_empty()
            && self.silent_ns <= self.settings.fault_after_ns
            && self.anchor.is_some_and(near)
    }

    /// Up is where it can be, gravity has its size, and neither contradicts the slow tilt estimate.
    fn is_plausible(&mut self) -> bool {
        let (mean, count) = (self.mean(), self.run.count());
        if count < POSE_COUNT.min(self.settings.start_count) {
            return false;
        }
        if !is_within(&mean, &self.up, self.pose_cosine) {
            let opposite = !is_within(&mean, &self.up, OPPOSITE);
            return self.refuse(if opposite { Fault::Sign } else { Fault::Axes });
        }
        if count < self.settings.start_count {
            return false;
        }
        if (mean.norm() / STANDARD_GRAVITY - 1.0).abs() > self.settings.norm_tolerance {
            count >= PATIENCE.saturating_mul(self.settings.start_count) && self.refuse(Fault::Units)
        } else if !self.tilt_is_old() && !is_within(&mean, &self.tilt.up(), self.tilt_cosine) {
            self.refuse(Fault::Tilt)
        } else {
            true
        }
    }

    /// There is no slow tilt estimate, it is what was found wrong, somebody said that the base stands otherwise, or nothing was
    /// heard for so long that it may: silence alone says nothing against the sensor. After any other alarm it has to agree.
    fn tilt_is_old(&self) -> bool {
        let alarms = self.status.alarms;
        let was_silent = alarms.without(Faults::SILENCE).is_empty() && self.silent_ns > self.settings.fault_after_ns;
        self.tilt_is_void || !self.tilt.is_known() || alarms.has(Fault::Drift) || was_silent
    }

    /// Not this run; perhaps the next one.
    fn refuse(&mut self, fault: Fault) -> bool {
        self.alarm(Faults::only(fault));
        self.run.restart();
        false
    }

    /// Mean of the run in base axes, m/s².
    fn mean(&self) -> Vector3<f64> {
        self.settings.mounting.pose().rotation() * self.run.mean()
    }

    /// While the sensor is not trusted: what unit would explain what it sends?
    fn watch_unit(&mut self, sample: &Sample) {
        if self.state != State::Live && self.unit.sees(sample.specific_force.norm()) {
            self.alarm(Faults::only(Fault::Units));
        }
    }

    /// Ages: the alarm, and what the policy makes of it.
    fn watch_silence(&mut self) {
        if self.state == State::Live && self.silent_ns > self.settings.max_age_ns {
            self.alarm(Faults::only(Fault::Age));
        }
        if self.state.is_start() && self.unusable_ns > self.settings.no_sensor_ns {
            self.alarm(Faults::only(Fault::NoSensor));
        }
        if self.silent_ns > self.settings.hold_ns {
            self.happens(Event::HoldOver);
        }
        if self.silent_ns > self.settings.fault_after_ns {
            self.happens(Event::PatienceOver);
        }
    }

    /// Something in this sample or step.
    fn note(&mut self, faults: Faults) {
        self.status.seen = self.status.seen.and(faults);
        self.counters.add(faults);
    }

    /// Alarms stand until the sensor is trusted again. One that belongs to no single sample is counted when it is raised.
    fn alarm(&mut self, faults: Faults) {
        self.note(faults.common(Faults::COLLECTIVE).without(self.status.alarms));
        self.status.alarms = self.status.alarms.and(faults);
        if self.state == State::Live && !faults.is_empty() {
            self.run.restart();
            self.happens(Event::TrustLost);
        }
    }

    fn happens(&mut self, event: Event) {
        self.state = self.state.after(event, self.settings.policy);
    }
}
