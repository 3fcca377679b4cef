//! The faults: what each does to the samples of a healthy sensor.

use super::random::Random;
use super::world::World;
use gravcomp::STANDARD_GRAVITY;
use gravcomp::accelerometer::Sample;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::TAU;

/// What is expected of the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// An alarm within 100 ms, always.
    Hard,
    /// No alarm: the sample is dropped, the stream goes on.
    Harmless,
    /// An alarm in some cases; the error is bounded in all.
    Partial,
    /// Not to be seen by one accelerometer; the error is what it is.
    Hidden,
}

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Healthy,
    Missing,
    Interrupted,
    Stuck,
    Nan,
    Infinite,
    Saturated,
    UnitsG,
    UnitsCm,
    UnitsAtStart,
    Sign,
    SignAtStart,
    Axes,
    AxesAtStart,
    ClockForward,
    ClockBack,
    HostClockBack,
    Delay,
    ZeroG,
    Spike,
    Reordered,
    Dropped,
    Jitter,
    Bursts,
    BitFlips,
    AxisStuck,
    GyroLost,
    GyroJump,
    GyroSpike,
    GyroStuck,
    GyroSign,
    BiasStep,
    Drift,
    HorizontalAxes,
    HorizontalAxesGyro,
    HorizontalSign,
    HorizontalSignGyro,
    Aliasing,
    HiddenDelay,
    Misaligned,
}

/// A kind with its name in the table and what is expected.
pub const KINDS: [(Kind, &str, Class); 40] = [
    (Kind::Healthy, "none: healthy rocking", Class::Harmless),
    (Kind::Missing, "missing at the start", Class::Hard),
    (Kind::Interrupted, "lost", Class::Hard),
    (Kind::Stuck, "stuck value", Class::Hard),
    (Kind::Nan, "NaN", Class::Hard),
    (Kind::Infinite, "infinite", Class::Hard),
    (Kind::Saturated, "saturated axis", Class::Hard),
    (Kind::UnitsG, "turns to g", Class::Hard),
    (Kind::UnitsCm, "turns to cm/s^2", Class::Hard),
    (Kind::UnitsAtStart, "wrong unit at the start", Class::Hard),
    (Kind::Sign, "sign turns", Class::Hard),
    (Kind::SignAtStart, "wrong sign at the start", Class::Hard),
    (Kind::Axes, "axes exchange", Class::Hard),
    (Kind::AxesAtStart, "wrong axes at the start", Class::Hard),
    (Kind::ClockForward, "stamps jump 1 h ahead", Class::Hard),
    (Kind::ClockBack, "stamps jump 1 h back", Class::Hard),
    (Kind::HostClockBack, "host clock jumps 1 h back", Class::Hard),
    (Kind::Delay, "delayed by 60 ms", Class::Hard),
    (Kind::ZeroG, "zero g", Class::Hard),
    (Kind::GyroLost, "gyroscope falls silent", Class::Hard),
    (Kind::GyroJump, "gyroscope jumps to 3 rad/s", Class::Hard),
    (Kind::Spike, "single spike", Class::Harmless),
    (Kind::GyroSpike, "single spike of a gyroscope", Class::Harmless),
    (Kind::Reordered, "duplicates, stragglers", Class::Harmless),
    (Kind::Jitter, "0-20 ms of jitter", Class::Harmless),
    (Kind::Dropped, "10 % dropped (CRC)", Class::Partial),
    (Kind::Bursts, "bursts of spikes", Class::Partial),
    (Kind::BitFlips, "bit flips without CRC", Class::Partial),
    (Kind::AxisStuck, "one axis stuck", Class::Partial),
    (Kind::GyroStuck, "gyroscope stuck", Class::Partial),
    (Kind::GyroSign, "gyroscope's sign turns", Class::Partial),
    (Kind::BiasStep, "bias step 0.5 m/s^2", Class::Hidden),
    (Kind::Drift, "drift 0.2 m/s^3, 10 s", Class::Hidden),
    (Kind::HorizontalAxes, "horizontal axes exchange", Class::Hidden),
    (Kind::HorizontalAxesGyro, "horizontal axes, gyroscope", Class::Hidden),
    (Kind::HorizontalSign, "horizontal sign turns", Class::Hidden),
    (Kind::HorizontalSignGyro, "horizontal sign, gyroscope", Class::Hidden),
    (Kind::Aliasing, "97 Hz vibration, 1 m/s^2", Class::Hidden),
    (Kind::HiddenDelay, "60 ms before the stamp", Class::Hidden),
    (Kind::Misaligned, "mounted 10 deg askew", Class::Hidden),
];

impl Kind {
    /// There from the first step on; the others come later.
    pub fn is_at_start(self) -> bool {
        matches!(self, Self::Missing | Self::UnitsAtStart | Self::SignAtStart | Self::AxesAtStart)
    }

    /// How long it lasts, s.
    pub fn lasts(self) -> f64 {
        match self {
            Self::Drift => 10.0,
            _ if self.is_horizontal() => 2.0,
            _ => 0.8,
        }
    }

    /// Something about the axes that are level when the base is.
    fn is_horizontal(self) -> bool {
        use Kind::{HorizontalAxes, HorizontalAxesGyro, HorizontalSign, HorizontalSignGyro};
        matches!(self, HorizontalAxes | HorizontalAxesGyro | HorizontalSign | HorizontalSignGyro)
    }

    /// The sensor has a gyroscope, has none, or either.
    pub fn gyro(self) -> Option<bool> {
        use Kind::{GyroJump, GyroLost, GyroSign, GyroSpike, GyroStuck};
        use Kind::{HorizontalAxes, HorizontalAxesGyro, HorizontalSign, HorizontalSignGyro};
        match self {
            HorizontalAxes | HorizontalSign => Some(false),
            HorizontalAxesGyro | HorizontalSignGyro | GyroLost | GyroJump | GyroSpike | GyroStuck | GyroSign => {
                Some(true)
            }
            _ => None,
        }
    }
}

/// What a sensor sends, and when it comes.
#[derive(Clone, Copy, Debug)]
pub struct Sent {
    pub sample: Sample,
    /// s
    pub latency: f64,
    /// A copy comes again so much later, s.
    pub copy: Option<f64>,
}

/// A fault with its numbers drawn.
#[derive(Clone, Debug)]
pub struct Fault {
    kind: Kind,
    /// When it sets in, s; of one that was there before it could be noticed, when the error begins to count.
    pub onset: f64,
    axis: usize,
    sign: f64,
    direction: Vector3<f64>,
    factor: f64,
    order: [usize; 3],
    /// One of the two horizontal axes.
    horizontal: usize,
    frozen: Option<Vector3<f64>>,
    done: bool,
}

/// One hour, ns.
pub const HOUR_NS: i64 = 3_600_000_000_000;

impl Fault {
    pub fn new(kind: Kind, world: &World, random: &mut Random) -> Self {
        // g, cm/s², mm/s², mg, counts of a converter; a gravity of each is no gravity in m/s².
        let factors = [1.0 / STANDARD_GRAVITY, 100.0, 1000.0, 1000.0 / STANDARD_GRAVITY, 16384.0 / STANDARD_GRAVITY];
        let up = world.vertical_axis();
        let (a, b) = ((up + 1) % 3, (up + 2) % 3);
        Self {
            kind,
            onset: if kind.is_at_start() { 0.0 } else { random.within(0.6, 1.2) },
            axis: random.below(3),
            sign: if random.chance(0.5) { 1.0 } else { -1.0 },
            direction: random.direction(),
            factor: factors[random.below(5)],
            order: if kind.is_horizontal() { exchange(a, b) } else { moving(up, a, b, random) },
            horizontal: [a, b][random.below(2)],
            frozen: None,
            done: false,
        }
    }

    /// The sample as it is sent at time `t`, s; none if it is lost.
    pub fn apply(&mut self, t: f64, mut sent: Sent, random: &mut Random) -> Option<Sent> {
        if t < self.onset && self.kind != Kind::Misaligned {
            return Some(sent);
        }
        self.on_numbers(t - self.onset, &mut sent.sample, random);
        self.on_gyro(&mut sent.sample.angular_velocity);
        self.on_stream(&mut sent, random).then_some(sent)
    }

    fn on_numbers(&mut self, t: f64, sample: &mut Sample, random: &mut Random) {
        let force = &mut sample.specific_force;
        match self.kind {
            Kind::Stuck => *force = *self.frozen.get_or_insert(*force),
            Kind::AxisStuck => force[self.axis] = self.frozen.get_or_insert(*force)[self.axis],
            Kind::Nan => force[self.axis] = f64::NAN,
            Kind::Infinite => force[self.axis] = self.sign * f64::INFINITY,
            Kind::Saturated => force[self.axis] = self.sign * 2.0 * STANDARD_GRAVITY,
            Kind::UnitsG => *force /= STANDARD_GRAVITY,
            Kind::UnitsCm => *force *= 100.0,
            Kind::UnitsAtStart => *force *= self.factor,
            Kind::Sign | Kind::SignAtStart => *force = -*force,
            Kind::Axes | Kind::AxesAtStart | Kind::HorizontalAxes | Kind::HorizontalAxesGyro => {
                *force = Vector3::from_fn(|i, _| force[self.order[i]]);
            }
            Kind::HorizontalSign | Kind::HorizontalSignGyro => force[self.horizontal] *= -1.0,
            Kind::ZeroG => *force = 0.03 * random.normals(),
            Kind::Spike if !self.done => {
                *force += 15.0 * self.direction;
                self.done = true;
            }
            Kind::Bursts if random.chance(0.3) => *force += random.within(5.0, 30.0) * random.direction(),
            Kind::BitFlips if random.chance(0.2) => flip(sample, random),
            Kind::BiasStep => *force += 0.5 * self.direction,
            Kind::Drift => *force += 0.2 * t * self.direction,
            Kind::Aliasing => *force += (TAU * 97.0 * t).sin() * self.direction,
            Kind::Misaligned => *force = Rotation3::new(10_f64.to_radians() * self.direction) * *force,
            _ => {}
        }
    }

    fn on_gyro(&mut self, rate: &mut Option<Vector3<f64>>) {
        match self.kind {
            Kind::GyroLost => *rate = None,
            Kind::GyroJump => *rate = Some(3.0 * self.direction),
            Kind::GyroStuck => *rate = rate.map(|w| *self.frozen.get_or_insert(w)),
            Kind::GyroSign => *rate = rate.map(|w| -w),
            Kind::GyroSpike if !self.done => {
                *rate = Some(15.0 * self.direction);
                self.done = true;
            }
            _ => {}
        }
    }

    /// False where the sample is lost.
    fn on_stream(&mut self, sent: &mut Sent, random: &mut Random) -> bool {
        let stamp = &mut sent.sample.stamp_ns;
        match self.kind {
            Kind::Missing | Kind::Interrupted => return false,
            Kind::Dropped => return !random.chance(0.1),
            Kind::ClockForward => *stamp += HOUR_NS,
            Kind::ClockBack => *stamp -= HOUR_NS,
            Kind::Delay => sent.latency += 0.06,
            Kind::Reordered if random.chance(0.2) => sent.latency += 0.012,
            Kind::Reordered if random.chance(0.2) => sent.copy = Some(0.003),
            Kind::Jitter => sent.latency = random.within(0.0, 0.02),
            _ => {}
        }
        true
    }

    /// How far the host's clock is off at time `t`, ns.
    pub fn host_offset_ns(&self, t: f64) -> i64 {
        if self.kind == Kind::HostClockBack && t >= self.onset { -HOUR_NS } else { 0 }
    }

    /// How long before its stamp a sample was taken, s.
    pub fn age_at_stamp(&self) -> f64 {
        if self.kind == Kind::HiddenDelay { 0.06 } else { 0.0 }
    }
}

fn exchange(a: usize, b: usize) -> [usize; 3] {
    let mut order = [0, 1, 2];
    order.swap(a, b);
    order
}

/// Any order that moves the vertical axis.
fn moving(up: usize, a: usize, b: usize, random: &mut Random) -> [usize; 3] {
    match random.below(4) {
        0 => exchange(up, a),
        1 => exchange(up, b),
        2 => [1, 2, 0],
        _ => [2, 0, 1],
    }
}

/// One bit of a frame's five words of 64.
fn flip(sample: &mut Sample, random: &mut Random) {
    let bit = 1_u64 << random.below(64);
    match random.below(5) {
        3 => sample.seq ^= bit,
        4 => sample.stamp_ns ^= bit.cast_signed(),
        i => sample.specific_force[i] = f64::from_bits(sample.specific_force[i].to_bits() ^ bit),
    }
}
