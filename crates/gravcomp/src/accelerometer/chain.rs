//! The chain: one call per control cycle.

use super::clock::HostClock;
use super::doubt::Doubt;
use super::fault::{Counters, Fault, Faults, Status};
use super::gate::{Felt, Gate};
use super::motion::MotionFilter;
use super::output::Output;
use super::run::{Order, Run};
use super::sample::{Reading, Sample};
use super::settings::Settings;
use super::state::{Event, Policy, State};
use super::tilt::{Tilt, cosine, is_within};
use super::turning::Turning;
use super::unit::{LikelyUnit, UnitWatch};
use crate::base::{BaseMotion, Gravity};
use crate::error::SettingsError;
use crate::flags::up;
use nalgebra::Vector3;

/// The base's accelerometer as a monitored signal: see [`accelerometer`](super).
///
/// Laid out as it is written: what a cycle without a sample touches stands side by side, as a paced loop runs on cold caches.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct Accelerometer {
    pub(super) output: Output,
    /// Where the output goes while the sensor is trusted, or where it was going when trust was lost.
    pub(super) goal: BaseMotion,
    pub(super) clock: HostClock,
    pub(super) age_ns: Option<i64>,
    /// Time without an accepted sample, ns; an acknowledgement sets it back.
    pub(super) silent_ns: i64,
    /// Time without a sample that could be used, ns.
    pub(super) unusable_ns: i64,
    pub(super) status: Status,
    pub(super) state: State,
    pub(super) settings: Settings,

    /// The slow tilt estimate may be contradicted: somebody acknowledged that the base stands otherwise.
    pub(super) tilt_is_void: bool,
    /// Cosines of [`Settings::pose_limit`] and [`Settings::tilt_limit`].
    pub(super) pose_cosine: f64,
    pub(super) tilt_cosine: f64,
    pub(super) up: Vector3<f64>,
    /// The last accepted sample, m/s², sensor axes.
    pub(super) anchor: Option<Vector3<f64>>,
    pub(super) gate: Gate,
    pub(super) run: Run,
    pub(super) doubt: Doubt,
    pub(super) unit: UnitWatch,
    pub(super) filter: MotionFilter,
    pub(super) tilt: Tilt,
    pub(super) turning: Turning,
    pub(super) counters: Counters,
}

impl Accelerometer {
    /// A chain that has received nothing.
    ///
    /// # Errors
    /// Those of [`Settings::checked`].
    pub fn new(settings: Settings) -> Result<Self, SettingsError> {
        let settings = settings.checked()?;
        let up = settings.up.normalize();
        let tilt = Tilt::new(up);
        let nominal = tilt.gravity();
        Ok(Self {
            output: Output::new(nominal),
            goal: BaseMotion::at_rest(Gravity(nominal)),
            clock: HostClock::default(),
            age_ns: None,
            silent_ns: 0,
            unusable_ns: 0,
            status: Status::default(),
            state: State::first(settings.policy),
            tilt_is_void: false,
            pose_cosine: cosine(settings.pose_limit),
            tilt_cosine: cosine(settings.tilt_limit),
            up,
            anchor: None,
            gate: Gate::default(),
            run: Run::default(),
            doubt: Doubt::default(),
            unit: UnitWatch::default(),
            filter: MotionFilter::new(&settings),
            tilt,
            turning: Turning::default(),
            counters: Counters::default(),
            settings,
        })
    }

    /// One control cycle: `now_ns` on the caller's monotonic clock, and the newest sample that has not been handed in yet.
    ///
    /// Never fails, whatever comes in.
    #[inline]
    pub fn step(&mut self, now_ns: i64, sample: Option<&Sample>) -> Reading {
        self.advance(now_ns, sample);
        self.reading()
    }

    #[inline(never)]
    fn advance(&mut self, now_ns: i64, sample: Option<&Sample>) {
        self.status.seen = Faults::NONE;
        let (elapsed_ns, jumped) = self.clock.advance(now_ns);
        self.wait(elapsed_ns);
        self.alarm(jumped);
        if let Some(sample) = sample {
            self.receive(now_ns, sample);
        }
        self.watch_silence();
        let held;
        let target = if self.state == State::Live {
            &self.goal
        } else {
            held = self.held();
            &held
        };
        self.output.follow(target, elapsed_ns, &self.settings);
    }

    /// The arm may be armed: under [`Policy::Strict`] on a live sensor only, under [`Policy::Paper`] also without any; never
    /// while another alarm stands, or the output is still on its way to what the sensor says.
    #[must_use]
    pub fn armable(&self) -> bool {
        let against = self.status.alarms.without(Faults::only(Fault::NoSensor));
        match (self.settings.policy, self.state) {
            (_, State::Live) => self.output.has_arrived() && !self.status.is_alarm(),
            (Policy::Paper, State::Nominal) => against.is_empty(),
            _ => false,
        }
    }

    /// Somebody has looked at it. A latched fault is left: the output stays on the tilt estimate until the sensor is trusted
    /// again or the fault latches anew, for which it gets as long as a run of good samples takes. Where trust was lost, the
    /// base may stand otherwise than the tilt estimate says.
    /// Before any sensor was trusted the alarms go; those whose cause is still there come again.
    pub fn acknowledge(&mut self) {
        if self.state == State::Live {
            return;
        }
        if self.state.is_start() {
            self.status.alarms = Faults::NONE;
            return;
        }
        let latest = self.settings.fault_after_ns.saturating_sub(self.settings.start_ns());
        self.silent_ns = self.silent_ns.min(self.settings.hold_ns.saturating_add(1)).min(latest);
        self.tilt_is_void = true;
        self.turning = Turning::default();
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
    #[inline]
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

    /// Where the output should be without a live sensor: a base at rest, as what turned may have stopped.
    fn held(&self) -> BaseMotion {
        BaseMotion::at_rest(match self.state {
            State::Degraded | State::Fault => Gravity(self.tilt.gravity()),
            _ => self.goal.specific_force.into(),
        })
    }

    /// Time passes.
    fn wait(&mut self, elapsed_ns: i64) {
        for age in [&mut self.silent_ns, &mut self.unusable_ns] {
            *age = age.saturating_add(elapsed_ns);
        }
        self.age_ns = self.age_ns.map(|age| age.saturating_add(elapsed_ns));
    }

    /// A sample comes in: stamp, order, numbers, change, in this order.
    #[inline(never)] // nine steps of ten have none, and need not fetch this
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
        let mut dt = self.run.since_last(&felt);
        let mut ahead = self.filter.after(&felt, dt);
        let jumps = self.jumps(&felt, dt, &ahead);
        if jumps.is_empty() {
            self.doubt.clear();
        } else {
            self.reject(jumps);
            if self.state == State::Live {
                return;
            }
            // A new run begins with it.
            dt = None;
            ahead = self.filter.after(&felt, dt);
        }
        self.run.extend(felt);
        self.filter = ahead;
        self.unusable_ns = 0;
        let motion = self.filter.base(&self.settings);
        if self.turns_otherwise(&felt, &motion) {
            self.refuse(Fault::Turn);
        } else if self.state == State::Live || self.qualifies() {
            self.accept(&felt, motion, dt.unwrap_or_default(), latency_ns);
        }
    }

    /// Further from the last sample that fitted than the base can have moved. Only samples that never came widen that:
    /// a jump must not become small by waiting while samples are rejected.
    fn jumps(&self, felt: &Felt, dt: Option<f64>, ahead: &MotionFilter) -> Faults {
        let Some(dt) = dt else { return Faults::NONE };
        let dt = if self.doubt.is_any() { 0.0 } else { dt };
        let limit = self.settings.jump(dt);
        let jerks = self.run.distance(felt) > limit;
        let spins = self.run.spin(felt) > self.settings.spin_up(dt) || self.throw(felt, ahead) > limit;
        Faults::when(jerks, Fault::Jerk).and(Faults::when(spins, Fault::Gyro))
    }

    /// How far the sample would move what is taken off for the lever arm, m/s²: a small jump of the angular velocity is a large
    /// one of its derivative. Only where the filter has settled.
    fn throw(&self, felt: &Felt, ahead: &MotionFilter) -> f64 {
        if felt.rate.is_none() || !self.filter.has_settled() {
            return 0.0;
        }
        (ahead.lever(&self.settings) - self.filter.lever(&self.settings)).norm()
    }

    /// The gyroscope contradicts: see [`Turning`].
    fn turns_otherwise(&mut self, felt: &Felt, motion: &BaseMotion) -> bool {
        if self.run.count() == 1 {
            self.turning.begin();
        }
        let motion = felt.rate.map(|_| motion).filter(|_| !self.settings.moving_base);
        self.turning.contradicts(felt.stamp_ns, motion, self.filter.has_settled(), &self.settings)
    }

    /// The output follows the sample.
    fn accept(&mut self, felt: &Felt, motion: BaseMotion, dt: f64, latency_ns: i64) {
        up(&mut self.counters.accepted);
        self.age_ns = Some(latency_ns.max(0));
        self.silent_ns = latency_ns.max(0);
        self.anchor = Some(felt.force);
        self.goal = motion;
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
    #[inline]
    pub(super) fn alarm(&mut self, faults: Faults) {
        if !faults.is_empty() {
            self.raise(faults);
        }
    }

    #[cold]
    fn raise(&mut self, faults: Faults) {
        self.note(faults.common(Faults::COLLECTIVE).without(self.status.alarms));
        self.status.alarms = self.status.alarms.and(faults);
        if self.state == State::Live {
            self.run.restart();
            self.turning.doubt();
            self.happens(Event::TrustLost);
        }
    }

    pub(super) fn happens(&mut self, event: Event) {
        self.state = self.state.after(event, self.settings.policy);
    }
}
