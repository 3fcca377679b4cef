//! What happened in a cycle, as bits of a status word, and how often.

use crate::flags::watch;

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

watch!(Events of Event);
