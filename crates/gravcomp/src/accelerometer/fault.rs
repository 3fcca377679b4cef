//! What can be wrong with a sensor or its stream, as bits of a status word, and how often it was.

use crate::flags::{flags, up};

/// What was found wrong; its number is its bit in [`Faults`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Fault {
    /// A number of the sample is NaN or infinite.
    NotFinite = 0,
    /// An axis stands at the end of its range: the sensor saturates.
    Range = 1,
    /// The specific force is longer than any that the base can feel.
    Norm = 2,
    /// Free fall: the specific force is shorter than any that a fixed base can feel.
    LowG = 3,
    /// The specific force changed faster than the base can.
    Jerk = 4,
    /// The sensor, or one of its axes, repeats itself bit by bit.
    Stuck = 5,
    /// Number or stamp of the sample does not follow the one before: a duplicate, a straggler or a restarted sensor.
    Sequence = 6,
    /// The stamp lies in the future or far in the past: it comes from another clock, or a clock jumped.
    Clock = 7,
    /// The sample was older than the age limit when it came.
    Late = 8,
    /// No good sample for longer than the age limit.
    Age = 9,
    /// Too many of the last 32 samples were rejected.
    Density = 10,
    /// The size of gravity belongs to another unit or range setting.
    Units = 11,
    /// Gravity points against the declared up direction: the source reports gravity, not specific force.
    Sign = 12,
    /// Gravity is further from the declared up direction than the base can tilt: axes permuted, or mounted otherwise.
    Axes = 13,
    /// Gravity is not where the slow tilt estimate knows it.
    Tilt = 14,
    /// The slow mean of gravity left its size or its cone: bias or scale have drifted far.
    Drift = 15,
    /// Nothing that could be used has come since the start.
    NoSensor = 16,
    /// The caller's own clock went backwards or stands still.
    HostClock = 17,
    /// The angular velocity, or what it means for the lever arm, changed faster than the base can; or the gyroscope that was
    /// there fell silent.
    Gyro = 18,
    /// Gravity does not turn as the gyroscope says: axes or a sign were exchanged, one of the two sensors is wrong, or the base
    /// accelerates harder than declared.
    Turn = 19,
}

impl Fault {
    /// All of them, by number.
    pub const ALL: [Self; 20] = [
        Self::NotFinite,
        Self::Range,
        Self::Norm,
        Self::LowG,
        Self::Jerk,
        Self::Stuck,
        Self::Sequence,
        Self::Clock,
        Self::Late,
        Self::Age,
        Self::Density,
        Self::Units,
        Self::Sign,
        Self::Axes,
        Self::Tilt,
        Self::Drift,
        Self::NoSensor,
        Self::HostClock,
        Self::Gyro,
        Self::Turn,
    ];

    /// Its name in logs: lower case, words joined by underscores.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotFinite => "not_finite",
            Self::Range => "range",
            Self::Norm => "norm",
            Self::LowG => "low_g",
            Self::Jerk => "jerk",
            Self::Stuck => "stuck",
            Self::Sequence => "sequence",
            Self::Clock => "clock",
            Self::Late => "late",
            Self::Age => "age",
            Self::Density => "density",
            Self::Units => "units",
            Self::Sign => "sign",
            Self::Axes => "axes",
            Self::Tilt => "tilt",
            Self::Drift => "drift",
            Self::NoSensor => "no_sensor",
            Self::HostClock => "host_clock",
            Self::Gyro => "gyro",
            Self::Turn => "turn",
        }
    }

    /// What it says about the sensor, in one line.
    #[must_use]
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::NotFinite => "a number is NaN or infinite",
            Self::Range => "an axis is at the end of its range",
            Self::Norm => "the specific force is too large for this base",
            Self::LowG => "free fall, on a base that is not declared to move so",
            Self::Jerk => "the specific force jumped",
            Self::Stuck => "the sensor or an axis repeats the same bits",
            Self::Sequence => "samples are duplicated, out of order, or the sensor restarted",
            Self::Clock => "stamps are in the future or from another clock",
            Self::Late => "samples are older than the age limit when they come",
            Self::Age => "no good sample within the age limit",
            Self::Density => "too many of the last samples were rejected",
            Self::Units => "gravity has the size of another unit or range setting",
            Self::Sign => "gravity points against the declared up direction",
            Self::Axes => "gravity is far from the declared up direction",
            Self::Tilt => "gravity is far from where it was on average",
            Self::Drift => "the mean of gravity left its size or its cone",
            Self::NoSensor => "nothing usable has come since the start",
            Self::HostClock => "the caller's clock went backwards or stands still",
            Self::Gyro => "the angular velocity jumped, or the gyroscope fell silent",
            Self::Turn => "gravity turns otherwise than the gyroscope says, or the base accelerates too hard",
        }
    }
}

flags!(
    /// A set of [`Fault`]s.
    Faults of Fault
);

impl Faults {
    /// Those that say nothing against what the sensor measures.
    pub(super) const SILENCE: Self = Self::of(&[Fault::Age, Fault::Late, Fault::Sequence]);

    /// Those that are seen in no single sample.
    pub(super) const COLLECTIVE: Self = Self::of(&[
        Fault::Age,
        Fault::Density,
        Fault::Units,
        Fault::Sign,
        Fault::Axes,
        Fault::Tilt,
        Fault::Drift,
        Fault::NoSensor,
        Fault::HostClock,
        Fault::Turn,
    ]);
}

/// What is wrong now. As a word of 64 bits: alarms in the low half, what was seen in the high one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Status {
    /// What took the sensor's trust away; each stands until the sensor is trusted again.
    pub alarms: Faults,
    /// What was found in this very step; a single rejected sample shows here and raises no alarm.
    pub seen: Faults,
}

impl Status {
    /// `alarms | seen << 32`.
    #[must_use]
    pub const fn word(self) -> u64 {
        self.alarms.bits() as u64 | (self.seen.bits() as u64) << 32
    }

    /// An alarm stands.
    #[must_use]
    pub const fn is_alarm(self) -> bool {
        !self.alarms.is_empty()
    }
}

/// How often, since the start. No counter wraps: it stays at the largest number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Samples handed in.
    pub received: u64,
    /// Samples that the output follows.
    pub accepted: u64,
    /// By the number of the [`Fault`]: samples in which it was seen, or alarms where it belongs to no single sample.
    pub faults: [u64; Fault::ALL.len()],
}

impl Counters {
    /// How often `fault` was seen.
    #[must_use]
    pub const fn of(&self, fault: Fault) -> u64 {
        self.faults[fault as usize]
    }

    pub(super) fn add(&mut self, faults: Faults) {
        for fault in faults.iter() {
            up(&mut self.faults[fault as usize]);
        }
    }
}
