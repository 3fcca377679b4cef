//! The monitored accelerometer, whatever comes in: finite, bounded, never further than its rate, never younger than it is.

use crate::scale::cases;
use gravcomp::accelerometer::{Counters, Event, Fault, Faults, LikelyUnit, Policy, Reading, Sample, Settings, State};
use gravcomp::{Accelerometer, Gravity, STANDARD_GRAVITY};
use nalgebra::{Rotation3, Vector3};
use proptest::collection::vec;
use proptest::prelude::*;
use std::time::Duration;

/// A sensor's period and a control cycle, ns.
pub const PERIOD_NS: i64 = 10_000_000;
pub const CYCLE_NS: i64 = 1_000_000;

/// A chain with its loop: a sample at the start of a period, then cycles without.
pub struct Feed {
    pub chain: Accelerometer,
    pub now_ns: i64,
    pub seq: u64,
    /// What the gyroscope says, rad/s.
    pub rate: Option<Vector3<f64>>,
    before: Option<(i64, Reading)>,
    noise: u64,
}

impl Feed {
    pub fn new(settings: &Settings) -> Self {
        let chain = Accelerometer::new(*settings).expect("settings that make sense");
        Self { chain, now_ns: 0, seq: 0, rate: None, before: None, noise: 1 }
    }

    pub fn of(policy: Policy) -> Self {
        Self::new(&Settings { policy, ..Settings::default() })
    }

    /// A sensor that has been trusted for a while, feeling `force`.
    pub fn live(policy: Policy, force: Vector3<f64>) -> Self {
        let mut feed = Self::of(policy);
        let reading = feed.feel(force, 100);
        assert_eq!((reading.state, reading.status.is_alarm()), (State::Live, false));
        feed
    }

    /// One cycle; every one is checked against what always holds.
    pub fn step(&mut self, sample: Option<&Sample>) -> Reading {
        let reading = self.chain.step(self.now_ns, sample);
        let before = self.before.replace((self.now_ns, reading));
        let elapsed_ns = before.map_or(0, |(then_ns, _)| self.now_ns.saturating_sub(then_ns));
        check(self.chain.settings(), before.map(|(_, reading)| reading).as_ref(), &reading, elapsed_ns);
        check_state(self.chain.settings(), &reading);
        check_turning(&self.chain, &reading);
        reading
    }

    /// `samples` of `force` m/s² with a little noise, and the cycles after each.
    pub fn feel(&mut self, force: Vector3<f64>, samples: u32) -> Reading {
        (0..samples).map(|_| self.period(Some(force))).last().expect("one sample at least")
    }

    /// Nothing comes for so many periods.
    pub fn silence(&mut self, periods: u32) -> Reading {
        (0..periods).map(|_| self.period(None)).last().expect("one period at least")
    }

    fn period(&mut self, force: Option<Vector3<f64>>) -> Reading {
        let sample = force.map(|force| self.sample(force));
        let mut reading = self.step(sample.as_ref());
        for _ in 1..PERIOD_NS / CYCLE_NS {
            self.now_ns += CYCLE_NS;
            reading = self.step(None);
        }
        self.now_ns += CYCLE_NS;
        reading
    }

    /// The next sample, 1 ms old.
    pub fn sample(&mut self, force: Vector3<f64>) -> Sample {
        self.seq += 1;
        // Some bits that change from sample to sample and from axis to axis.
        self.noise = self.noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let wobble = |shift: u32| f64::from(u16::try_from(self.noise >> shift & 0xFFF).expect("12 bits")) * 1e-5;
        Sample {
            seq: self.seq,
            stamp_ns: self.now_ns - 1_000_000,
            specific_force: force + Vector3::new(wobble(20), wobble(33), wobble(48)),
            angular_velocity: self.rate,
        }
    }
}

/// Finite, bounded, no further than the rate.
pub fn check(settings: &Settings, before: Option<&Reading>, after: &Reading, elapsed_ns: i64) {
    let base = &after.base;
    let vectors = [after.gravity.0, base.specific_force.0, base.angular_velocity, base.angular_acceleration];
    assert!(vectors.iter().flatten().all(|x| x.is_finite()), "{after:?}");
    assert_eq!(after.gravity.0, -base.specific_force.0);
    assert!(after.gravity.0.norm() <= settings.norm.1 * (1.0 + 1e-12), "{after:?}");
    assert!(after.age_ns.is_none_or(|age| age >= 0));
    let dt = Duration::from_nanos(u64::try_from(elapsed_ns.clamp(0, 10_000_000)).expect("not negative")).as_secs_f64();
    let steps = |of: fn(&Reading) -> Vector3<f64>| before.map_or(0.0, |before| (of(after) - of(before)).norm());
    for (step, rate) in [
        (steps(|reading| reading.gravity.0), settings.gravity_rate),
        (steps(|reading| reading.base.angular_velocity), settings.angular_acceleration),
        (steps(|reading| reading.base.angular_acceleration), settings.angular_jerk),
    ] {
        assert!(step <= rate * dt * (1.0 + 1e-9) + 1e-11, "a step of {step} at a rate of {rate} in {dt} s");
    }
}

/// How the base turns is finite and within twice the gyroscope's range, however far ahead it is asked for; only a live sensor
/// with a gyroscope says so.
fn check_turning(chain: &Accelerometer, reading: &Reading) {
    for ahead_s in [0.0, 5e-4, 1e9, -1.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
        let (w, trusted) = chain.turning(ahead_s);
        assert!(w.norm() <= 2.0 * chain.settings().gyro_range * (1.0 + 1e-12), "{w:?} at {ahead_s} s: {reading:?}");
        assert!(!trusted || reading.state == State::Live, "{reading:?}");
    }
}

/// A state is what its ages and alarms make it.
fn check_state(settings: &Settings, reading: &Reading) {
    let (age_ns, alarm) = (reading.age_ns, reading.status.is_alarm());
    assert!(reading.state != State::Live || !alarm && age_ns <= Some(settings.max_age_ns), "{reading:?}");
    assert_eq!(matches!(reading.state, State::NoData | State::Nominal), age_ns.is_none(), "{reading:?}");
    match settings.policy {
        Policy::Paper => assert!(matches!(reading.state, State::Nominal | State::Live | State::Held), "{reading:?}"),
        Policy::Strict => assert!(
            reading.state != State::Nominal && (reading.state != State::Held || age_ns <= Some(settings.hold_ns)),
            "{reading:?}"
        ),
    }
    assert!(!matches!(reading.state, State::Held | State::Degraded | State::Fault) || alarm, "{reading:?}");
}

/// What a sensor on a base that is tilted by so many degrees about x feels.
pub fn tilted(degrees: f64) -> Vector3<f64> {
    Rotation3::from_axis_angle(&Vector3::x_axis(), -degrees.to_radians()) * Vector3::new(0.0, 0.0, STANDARD_GRAVITY)
}

/// Any double: any bits, those that trip programs up, and good ones.
fn number(good: f64) -> impl Strategy<Value = f64> {
    let special =
        vec![0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE, 5e-324, 1e300];
    prop_oneof![
        2 => any::<u64>().prop_map(f64::from_bits),
        1 => proptest::sample::select(special),
        4 => -20.0..20.0,
        20 => (good - 0.05)..(good + 0.05),
    ]
}

fn vector(good: [f64; 3]) -> impl Strategy<Value = Vector3<f64>> {
    good.map(number).prop_map(Vector3::from)
}

/// A time that goes on, or does not, or is anything.
fn time() -> impl Strategy<Value = Time> {
    prop_oneof![
        40 => (0..20_000_000_i64).prop_map(Time::Later),
        1 => any::<i64>().prop_map(Time::Later),
        1 => any::<i64>().prop_map(Time::At),
    ]
}

#[derive(Clone, Copy, Debug)]
enum Time {
    Later(i64),
    At(i64),
}

impl Time {
    fn after(self, now_ns: i64) -> i64 {
        match self {
            Self::Later(ns) => now_ns.saturating_add(ns),
            Self::At(ns) => ns,
        }
    }
}

/// Number and stamp in order, or anything.
fn order() -> impl Strategy<Value = (Option<u64>, Time)> {
    let seq = prop_oneof![20 => Just(None), 1 => any::<u64>().prop_map(Some)];
    let stamp =
        prop_oneof![20 => (-5_000_000..1_000_000_i64).prop_map(Time::Later), 1 => any::<i64>().prop_map(Time::At)];
    (seq, stamp)
}

/// A cycle of any kind.
fn cycle() -> impl Strategy<Value = (Time, Option<Sample>, (Option<u64>, Time), bool)> {
    let force = vector([0.0, 0.0, STANDARD_GRAVITY]);
    let rate = proptest::option::of(vector([0.0; 3]));
    let sample = (force, rate).prop_map(|(specific_force, angular_velocity)| Sample {
        seq: 0,
        stamp_ns: 0,
        specific_force,
        angular_velocity,
    });
    (time(), proptest::option::weighted(0.7, sample), order(), proptest::bool::weighted(0.01))
}

fn policies() -> impl Strategy<Value = Policy> {
    prop_oneof![Just(Policy::Paper), Just(Policy::Strict)]
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn any_bits_make_a_bounded_output(policy in policies(), gyro_away in any::<bool>(), cycles in vec(cycle(), 1..300)) {
        let position = if gyro_away { Vector3::new(0.3, -0.2, 100.0) } else { Vector3::zeros() };
        let mounting = gravcomp::Mounting::new(nalgebra::Matrix3::identity(), position).expect("a rotation");
        let mut chain = Accelerometer::new(Settings { policy, mounting, ..Settings::default() }).expect("the defaults");
        let (mut now_ns, mut before, mut state) = (0_i64, None::<Reading>, State::first(policy));
        for (seq, (time, sample, (number, stamp), acknowledged)) in (0_u64..).zip(cycles) {
            let (then_ns, acknowledges) = (now_ns, acknowledged);
            now_ns = time.after(now_ns);
            let sample = sample.map(|sample| Sample {
                seq: number.unwrap_or(seq),
                stamp_ns: stamp.after(now_ns),
                ..sample
            });
            if acknowledges {
                chain.acknowledge();
            }
            let reading = chain.step(now_ns, sample.as_ref());
            check(chain.settings(), before.as_ref(), &reading, now_ns.saturating_sub(then_ns));
            prop_assert!(state != State::Fault || reading.state == State::Fault || acknowledges, "left without a word");
            check_state(chain.settings(), &reading);
            prop_assert!(reading.state == State::Live || !chain.armable() || policy == Policy::Paper);
            (before, state) = (Some(reading), reading.state);
        }
        let mut feed = Feed { chain, ..Feed::of(policy) };
        for _ in 0..2 {
            feed.feel(tilted(15.0), 5);
            feed.chain.acknowledge();
            feed.feel(tilted(15.0), 30);
        }
        prop_assert_eq!(feed.step(None).state, State::Live, "acknowledged and good samples, and all is forgotten");
    }

    /// However bad the samples are, they make nothing younger, and a trusted sensor is not trusted for long.
    #[test]
    fn rejected_samples_never_refresh_the_age(policy in policies(), bad in vec(bad_samples(), 1..100)) {
        let mut feed = Feed::live(policy, tilted(15.0));
        let mut age = feed.silence(1).age_ns.expect("it was live");
        let accepted = feed.chain.counters().accepted;
        for (count, spoil) in (1..).zip(bad) {
            let sample = spoil.of(feed.sample(tilted(15.0)));
            let reading = feed.step(Some(&sample));
            prop_assert_eq!(reading.age_ns, Some(age + CYCLE_NS));
            age = feed.silence(1).age_ns.expect("it was live");
            prop_assert!(count < 4 || (reading.status.is_alarm() && reading.state != State::Live));
        }
        prop_assert_eq!(feed.chain.counters().accepted, accepted);
    }
}

/// A way to make a sample bad.
#[derive(Clone, Copy, Debug)]
enum Spoil {
    Force(usize, f64),
    Rate(f64),
    Factor(f64),
    Age(i64),
    Old,
}

impl Spoil {
    fn of(self, mut sample: Sample) -> Sample {
        match self {
            Self::Force(axis, value) => sample.specific_force[axis] = value,
            Self::Rate(value) => sample.angular_velocity = Some(Vector3::new(0.0, value, 0.0)),
            Self::Factor(factor) => sample.specific_force *= factor,
            Self::Age(age_ns) => sample.stamp_ns -= age_ns,
            Self::Old => sample.seq = 1,
        }
        sample
    }
}

fn bad_samples() -> impl Strategy<Value = Spoil> {
    let value = prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(-19.5), Just(1e9), Just(f64::MIN)];
    let factor = prop_oneof![Just(-1.0), Just(0.1), Just(100.0), Just(0.0), Just(0.5)];
    let age = prop_oneof![50_000_000..i64::MAX / 2, Just(-3_600_000_000_000), Just(i64::MIN / 2)];
    prop_oneof![
        (0..3_usize, value).prop_map(|(axis, value)| Spoil::Force(axis, value)),
        prop_oneof![Just(f64::NAN), Just(-35.0), Just(1e9)].prop_map(Spoil::Rate),
        factor.prop_map(Spoil::Factor),
        age.prop_map(Spoil::Age),
        Just(Spoil::Old),
    ]
}

#[test]
fn every_state_answers_every_event() {
    for policy in [Policy::Paper, Policy::Strict] {
        for state in State::ALL {
            for event in Event::ALL {
                let next = state.after(event, policy);
                let stays = next == state;
                let says = format!("{policy:?}: {state:?}, {event:?} -> {next:?}");
                assert!(state != State::Fault || stays || event == Event::Acknowledged, "{says}");
                assert!(next != State::Live || stays || event == Event::Qualified, "{says}");
                assert!(state != State::Live || stays || event == Event::TrustLost, "{says}");
                assert!(event != Event::TrustLost || next != State::Live, "{says}");
                assert!(event != Event::Qualified || next == State::Live || state == State::Fault, "{says}");
                // Nothing ever leads back to a start.
                assert!(!matches!(next, State::NoData | State::Nominal) || stays, "{says}");
                // The paper's rule degrades and latches nothing.
                assert!(
                    policy == Policy::Strict || stays || matches!(next, State::Live | State::Held | State::Degraded)
                );
            }
        }
    }
}

/// What can be reached at all, by any sequence of events.
#[test]
fn the_papers_rule_never_latches() {
    for (policy, wanted) in [
        (Policy::Paper, vec![State::Nominal, State::Live, State::Held]),
        (Policy::Strict, vec![State::NoData, State::Live, State::Held, State::Degraded, State::Fault]),
    ] {
        let mut reached = vec![State::first(policy)];
        let mut next = 0;
        while next < reached.len() {
            for event in Event::ALL {
                let state = reached[next].after(event, policy);
                if !reached.contains(&state) {
                    reached.push(state);
                }
            }
            next += 1;
        }
        assert_eq!(reached, wanted);
    }
}

#[test]
fn names_and_bits_are_different() {
    let names: std::collections::BTreeSet<_> = Fault::ALL.iter().map(|fault| fault.name()).collect();
    let bits = Fault::ALL.iter().fold(0, |bits, fault| bits | Faults::only(*fault).bits());
    assert_eq!((names.len(), bits), (Fault::ALL.len(), (1 << Fault::ALL.len()) - 1));
    for (number, fault) in Fault::ALL.into_iter().enumerate() {
        assert_eq!(fault as usize, number);
        assert!(!fault.meaning().is_empty());
        assert_eq!(Faults::only(fault).iter().collect::<Vec<_>>(), [fault]);
        assert_eq!(Counters::default().of(fault), 0);
    }
}

#[test]
fn units_are_named() {
    for (factor, unit) in [
        (1.0 / STANDARD_GRAVITY, LikelyUnit::StandardGravity),
        (100.0, LikelyUnit::CentimetresOrMilliG),
        (1000.0 / STANDARD_GRAVITY, LikelyUnit::CentimetresOrMilliG),
        (1000.0, LikelyUnit::Millimetres),
        (1e6 / STANDARD_GRAVITY, LikelyUnit::MicroG),
        (1.0 / 0.3048, LikelyUnit::Feet),
        (16384.0 / STANDARD_GRAVITY, LikelyUnit::Counts),
        (0.5, LikelyUnit::RangeSetting),
        (2.0, LikelyUnit::RangeSetting),
    ] {
        let mut feed = Feed::of(Policy::Paper);
        let reading = feed.feel(tilted(15.0) * factor, 10);
        assert_eq!(feed.chain.likely_unit(), Some(unit), "{factor}");
        assert!(reading.status.alarms.has(Fault::Units) && !feed.chain.armable(), "{factor}");
        assert_eq!((reading.state, reading.gravity), (State::Nominal, Gravity::LEVEL), "{factor}");
        assert!(feed.chain.counters().of(Fault::Units) == 1);
    }
    let mut feed = Feed::live(Policy::Paper, tilted(15.0));
    feed.feel(tilted(15.0), 20);
    assert_eq!(feed.chain.likely_unit(), None);
}
