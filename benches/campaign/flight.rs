//! One scenario: a rocking base, a fault, and beside each other the chain under both policies and a gate that holds the last
//! sample.

use super::kinds::{Fault, Kind, Sent};
use super::random::Random;
use super::world::World;
use gravcomp::accelerometer::{Accelerometer, Policy, Reading, Sample, Settings};
use gravcomp::{Gravity, Mounting};
use nalgebra::Vector3;

/// Control cycles per second.
const CYCLES: f64 = 1000.0;

/// The sensor's period, s.
const PERIOD: f64 = 0.01;

/// The host's clock at the start, ns.
const BOOT_NS: i64 = 1_000_000_000_000;

/// What a gate did in a scenario.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// From the fault's onset to the first reading with an alarm, s.
    pub alarm: Option<f64>,
    /// An alarm stood before the onset.
    pub early: bool,
    /// Largest distance from the true gravity after the onset, m/s².
    pub error: f64,
    /// The same while the chain said that the arm may be armed.
    pub armed: f64,
    pub not_finite: u64,
    /// Steps further than the declared rate allows.
    pub too_far: u64,
}

/// The outcomes under both policies, and of the gate that holds the last sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct Flight {
    pub paper: Outcome,
    pub strict: Outcome,
    pub naive: Outcome,
    /// Control cycles.
    pub cycles: u64,
}

impl Flight {
    /// Flies the scenario with this seed.
    pub fn new(kind: Kind, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let world = World::rocking(&mut random, kind.gyro());
        let fault = Fault::new(kind, &world, &mut random);
        let seconds = fault.onset + kind.lasts();
        Self::of(&world, fault, seconds, &mut random)
    }

    /// `seconds` of rocking with nothing wrong; every alarm is a false one.
    pub fn healthy(seconds: f64, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let world = World::rocking(&mut random, None);
        let fault = Fault::new(Kind::Healthy, &world, &mut random);
        Self::of(&world, fault, seconds, &mut random)
    }

    fn of(world: &World, fault: Fault, seconds: f64, random: &mut Random) -> Self {
        let mut link = Link::new(world, fault, random);
        let mut chains = [Policy::Paper, Policy::Strict].map(|policy| Watched::new(world, policy));
        let mut naive = Naive::new(world);
        let mut flight = Self::default();
        let mut t = 0.0;
        while t < seconds {
            let now_ns = BOOT_NS + nanoseconds(t) + link.fault.host_offset_ns(t);
            let sample = link.newest(t, random);
            let since_onset = t - link.fault.onset;
            let truth = (since_onset >= 0.0).then(|| (since_onset, world.motion(t).specific_force.into()));
            for chain in &mut chains {
                chain.step(now_ns, sample.as_ref(), truth.as_ref());
            }
            naive.step(sample.as_ref(), truth.map(|_| world.force_at_sensor(t)));
            flight.cycles += 1;
            t += 1.0 / CYCLES;
        }
        let [paper, strict] = chains.map(|chain| chain.outcome);
        Self { paper, strict, naive: naive.outcome, ..flight }
    }
}

/// What lies between the sensor and the loop.
struct Link<'a> {
    world: &'a World,
    fault: Fault,
    /// When the next sample is taken, s.
    next: f64,
    seq: u64,
    /// On the way, with the time of arrival, s.
    flying: Vec<(f64, Sample)>,
}

impl<'a> Link<'a> {
    fn new(world: &'a World, fault: Fault, random: &mut Random) -> Self {
        Self { world, fault, next: random.within(0.0, PERIOD), seq: 0, flying: Vec::with_capacity(16) }
    }

    /// The sample that came last, if any came since the last time.
    fn newest(&mut self, t: f64, random: &mut Random) -> Option<Sample> {
        while self.next <= t {
            self.take(random);
        }
        let arrived = |(arrival, _): &(f64, Sample)| *arrival <= t;
        let latest = self.flying.iter().filter(|sent| arrived(sent)).max_by(|a, b| a.0.total_cmp(&b.0)).copied();
        self.flying.retain(|sent| !arrived(sent));
        latest.map(|(_, sample)| sample)
    }

    fn take(&mut self, random: &mut Random) {
        // The sensor's own clock jitters by 0.3 ms.
        let t = self.next + random.within(0.0, 3e-4);
        let (specific_force, angular_velocity) = self.world.sensed(t - self.fault.age_at_stamp(), random);
        let stamp_ns = BOOT_NS + nanoseconds(t);
        let sample = Sample { seq: self.seq, stamp_ns, specific_force, angular_velocity };
        let sent = Sent { sample, latency: random.within(0.001, 0.004), copy: None };
        if let Some(sent) = self.fault.apply(t, sent, random) {
            let arrival = t + sent.latency;
            self.flying.push((arrival, sent.sample));
            self.flying.extend(sent.copy.map(|later| (arrival + later, sent.sample)));
        }
        self.next += PERIOD;
        self.seq += 1;
    }
}

/// A chain, and what is noticed of it.
struct Watched {
    chain: Accelerometer,
    rate: f64,
    before: Option<(i64, Reading)>,
    outcome: Outcome,
}

impl Watched {
    fn new(world: &World, policy: Policy) -> Self {
        let settings = Settings { mounting: world.mounting(), policy, ..Settings::default() };
        let chain = Accelerometer::new(settings).expect("the defaults make sense");
        Self { chain, rate: settings.gravity_rate, before: None, outcome: Outcome::default() }
    }

    /// `truth`: after the onset, how long ago that was, s, and the true gravity.
    fn step(&mut self, now_ns: i64, sample: Option<&Sample>, truth: Option<&(f64, Gravity)>) {
        let reading = self.chain.step(now_ns, sample);
        let alarm = reading.status.is_alarm();
        if let Some((since_onset, truth)) = truth {
            self.outcome.alarm = self.outcome.alarm.or(alarm.then_some(*since_onset));
            let error = (reading.gravity.0 - truth.0).norm();
            self.outcome.error = self.outcome.error.max(error);
            self.outcome.armed = self.outcome.armed.max(if self.chain.armable() { error } else { 0.0 });
        } else {
            self.outcome.early |= alarm;
        }
        self.outcome.not_finite += u64::from(!is_finite(&reading));
        if let Some((then_ns, before)) = self.before.replace((now_ns, reading)) {
            self.outcome.too_far +=
                u64::from(steps_too_far(&before, &reading, now_ns.saturating_sub(then_ns), self.rate));
        }
    }
}

/// All numbers of the reading are.
pub fn is_finite(reading: &Reading) -> bool {
    let base = &reading.base;
    let vectors = [reading.gravity.0, base.specific_force.0, base.angular_velocity, base.angular_acceleration];
    vectors.iter().flatten().all(|x| x.is_finite())
}

/// Gravity moved by more than `rate` (m/s³) times the cycle, of which no more than 10 ms count; a rounding is forgiven.
pub fn steps_too_far(before: &Reading, after: &Reading, cycle_ns: i64, rate: f64) -> bool {
    let cycle = f64::from(i32::try_from(cycle_ns.clamp(0, 10_000_000)).expect("at most 10 ms")) * 1e-9;
    exceeds((after.gravity.0 - before.gravity.0).norm(), rate * cycle * (1.0 + 1e-9) + 1e-12)
}

/// Larger, or no number.
pub fn exceeds(x: f64, limit: f64) -> bool {
    x.is_nan() || x > limit
}

/// The gate that most arms have: the last sample, whatever it was. Its error is that at the sensor's own place.
struct Naive {
    mounting: Mounting,
    force: Option<Vector3<f64>>,
    outcome: Outcome,
}

impl Naive {
    fn new(world: &World) -> Self {
        Self { mounting: world.mounting(), force: None, outcome: Outcome::default() }
    }

    /// `truth`: after the onset, what an ideal sensor would read.
    fn step(&mut self, sample: Option<&Sample>, truth: Option<Vector3<f64>>) {
        if let Some(sample) = sample {
            self.force = Some(self.mounting.pose().rotation() * sample.specific_force);
        }
        let force = self.force.unwrap_or(-Gravity::LEVEL.0);
        if !force.iter().all(|x| x.is_finite()) {
            self.outcome.not_finite += 1;
        } else if let Some(truth) = truth {
            self.outcome.error = self.outcome.error.max((force - truth).norm().min(f64::MAX));
        }
    }
}

/// Whole nanoseconds of a time that is not long.
#[allow(clippy::cast_possible_truncation)]
fn nanoseconds(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}
