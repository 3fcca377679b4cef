//! What happened in a cycle, as bits of a status word, and how often.

use crate::flags::{flags, up};

/// What can happen; its number is its bit in [`Events`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Event {
    /// A number of the joint state is missing: NaN, infinite, or beyond any arm.
    Absent = 0,
    /// An encoder that wraps reads beyond its modulus.
    EncoderRange = 1,
    /// An encoder moved further since its last good reading than the joint can.
    Jump = 2,
    /// A joint is outside its limits.
    JointLimit = 3,
    /// A number of the target is NaN, infinite, or beyond any arm: the last good target is used.
    Target = 4,
    /// The target is outside the joint limits: it is moved to the nearest one.
    TargetLimit = 5,
    /// Gravity or the base's motion is no number or beyond any base: the last good one is used.
    BaseMotion = 6,
    /// A term of the law is no number or infinite: its last good value is used.
    Overflow = 7,
    /// A torque stands at its limit.
    TorqueLimit = 8,
    /// A torque moves as fast as it may.
    TorqueRate = 9,
    /// Arming or an acknowledgement waits for a good joint state, or for the base sensor.
    Waiting = 10,
    /// The fault was latched in this cycle: no good joint state for longer than one may be held.
    Fault = 11,
}

impl Event {
    /// All of them, by number.
    pub const ALL: [Self; 12] = [
        Self::Absent,
        Self::EncoderRange,
        Self::Jump,
        Self::JointLimit,
        Self::Target,
        Self::TargetLimit,
        Self::BaseMotion,
        Self::Overflow,
        Self::TorqueLimit,
        Self::TorqueRate,
        Self::Waiting,
        Self::Fault,
    ];

    /// Its name in logs: lower case, words joined by underscores.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Absent => "absent",
            Self::EncoderRange => "encoder_range",
            Self::Jump => "jump",
            Self::JointLimit => "joint_limit",
            Self::Target => "target",
            Self::TargetLimit => "target_limit",
            Self::BaseMotion => "base_motion",
            Self::Overflow => "overflow",
            Self::TorqueLimit => "torque_limit",
            Self::TorqueRate => "torque_rate",
            Self::Waiting => "waiting",
            Self::Fault => "fault",
        }
    }

    /// What it says, in one line.
    #[must_use]
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Absent => "a joint state is missing; the last good pose is held",
            Self::EncoderRange => "an encoder reads beyond its modulus; the last good pose is held",
            Self::Jump => "an encoder jumped; the last good pose is held",
            Self::JointLimit => "a joint is outside its limits",
            Self::Target => "a target is missing; the last good one is used",
            Self::TargetLimit => "a target is outside the joint limits; it is moved to the nearest one",
            Self::BaseMotion => "gravity or the base's motion is missing; the last good one is used",
            Self::Overflow => "a term of the law overflows; its last good value is used",
            Self::TorqueLimit => "a torque stands at its limit",
            Self::TorqueRate => "a torque moves as fast as it may",
            Self::Waiting => "arming waits for a good joint state or for the base sensor",
            Self::Fault => "no good joint state for longer than one may be held; the fault is latched",
        }
    }
}

flags!(
    /// A set of [`Event`]s.
    Events of Event
);

/// What happened. As a word of 64 bits: since the last acknowledgement in the low half, in this cycle in the high one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Status {
    /// Since the start or the last acknowledgement.
    pub since: Events,
    /// In this very cycle.
    pub seen: Events,
}

impl Status {
    /// `since | seen << 32`.
    #[must_use]
    pub const fn word(self) -> u64 {
        self.since.bits() as u64 | (self.seen.bits() as u64) << 32
    }
}

/// How often, since the start. No counter wraps: it stays at the largest number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Cycles.
    pub cycles: u64,
    /// By the number of the [`Event`]: cycles in which it happened.
    pub events: [u64; Event::ALL.len()],
}

impl Counters {
    /// In how many cycles `event` happened.
    #[must_use]
    pub const fn of(&self, event: Event) -> u64 {
        self.events[event as usize]
    }
}

/// Collects the events of a cycle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Watch {
    pub(super) status: Status,
    pub(super) counters: Counters,
}

impl Watch {
    /// A cycle begins: nothing has happened in it.
    pub(super) const fn begin(&mut self) {
        self.status.seen = Events::NONE;
    }

    /// `event` happens in this cycle if `here`.
    pub(super) const fn note(&mut self, here: bool, event: Event) {
        self.status.seen = self.status.seen.and(Events::when(here, event));
    }

    /// The cycle ends: what happened is counted.
    pub(super) fn end(&mut self) {
        up(&mut self.counters.cycles);
        self.status.since = self.status.since.and(self.status.seen);
        for event in self.status.seen.iter() {
            up(&mut self.counters.events[event as usize]);
        }
    }

    /// Somebody has looked at what happened since.
    pub(super) const fn acknowledge(&mut self) {
        self.status.since = Events::NONE;
    }
}
