//! What happened in a step, as bits of a status word, how often, and which limit of which joint it was.

use crate::flags::watch;

/// What can happen; its number is its bit in [`Events`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Event {
    /// A position is NaN, infinite, or beyond any arm.
    Absent = 0,
    /// A number of the twist is NaN, infinite, or beyond any arm.
    Twist = 1,
    /// A number of the target is NaN, infinite, or beyond any arm, or its direction has no length.
    Target = 2,
    /// A number of the base's twist is NaN, infinite, or beyond any base.
    BaseTwist = 3,
    /// The time step is not positive, or longer than a second.
    Time = 4,
    /// The task is near a singularity: it is damped.
    Singular = 5,
    /// A joint would have to be faster than it may.
    VelocityLimit = 6,
    /// A joint is near a limit of its position, or beyond it, and would have to go on.
    PositionLimit = 7,
    /// A joint accelerates as hard as it may.
    AccelerationLimit = 8,
    /// A joint's acceleration changes as fast as it may.
    JerkLimit = 9,
    /// The pointing axis is opposed to its target.
    Opposed = 10,
    /// The tool's tip is at the trocar, where no shaft is left to turn about it.
    Centre = 11,
    /// The bounded optimum was not proven within its number of steps; what it gave is within the limits.
    Unproven = 12,
    /// The arithmetic overflows.
    Overflow = 13,
    /// The sensor that says how the base turns is not trusted.
    BaseSensor = 14,
    /// The arm has fewer coordinates than the task rows, and this twist needs more: they do it by least squares.
    Undone = 15,
}

impl Event {
    /// All of them, by number.
    pub const ALL: [Self; 16] = [
        Self::Absent,
        Self::Twist,
        Self::Target,
        Self::BaseTwist,
        Self::Time,
        Self::Singular,
        Self::VelocityLimit,
        Self::PositionLimit,
        Self::AccelerationLimit,
        Self::JerkLimit,
        Self::Opposed,
        Self::Centre,
        Self::Unproven,
        Self::Overflow,
        Self::BaseSensor,
        Self::Undone,
    ];

    /// Its name in logs: lower case, words joined by underscores.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Absent => "absent",
            Self::Twist => "twist",
            Self::Target => "target",
            Self::BaseTwist => "base_twist",
            Self::Time => "time",
            Self::Singular => "singular",
            Self::VelocityLimit => "velocity_limit",
            Self::PositionLimit => "position_limit",
            Self::AccelerationLimit => "acceleration_limit",
            Self::JerkLimit => "jerk_limit",
            Self::Opposed => "opposed",
            Self::Centre => "centre",
            Self::Unproven => "unproven",
            Self::Overflow => "overflow",
            Self::BaseSensor => "base_sensor",
            Self::Undone => "undone",
        }
    }

    /// What it says, in one line.
    #[must_use]
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Absent => "a joint position is missing; the arm is stopped",
            Self::Twist => "the twist is missing; none is used",
            Self::Target => "the target is missing; the tool is held where it is",
            Self::BaseTwist => "the base's twist is missing; the last good one is used",
            Self::Time => "the time step is none; the declared one is used",
            Self::Singular => "the task is near a singularity; it is damped",
            Self::VelocityLimit => "a joint would be faster than it may",
            Self::PositionLimit => "a joint would leave its limits",
            Self::AccelerationLimit => "a joint accelerates as hard as it may",
            Self::JerkLimit => "a joint's acceleration changes as fast as it may",
            Self::Opposed => "the pointing axis is opposed to its target; it turns about any axis across",
            Self::Centre => "the tool's tip is at the trocar; the shaft cannot be aligned",
            Self::Unproven => "the optimum within the limits was not proven; the step is within them",
            Self::Overflow => "the numbers overflow; the arm is stopped",
            Self::BaseSensor => "the base's sensor is not trusted or not stepped, or just was not; its turning fades",
            Self::Undone => "the arm has fewer coordinates than the task rows; what they cannot do is left undone",
        }
    }
}

watch!(Events of Event);

/// A limit that a joint stands at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Limit {
    /// Of its velocity.
    Velocity,
    /// Of its position.
    Position,
    /// Of its acceleration.
    Acceleration,
    /// Of its jerk.
    Jerk,
}

impl Limit {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Velocity, Self::Position, Self::Acceleration, Self::Jerk];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Velocity => "velocity",
            Self::Position => "position",
            Self::Acceleration => "acceleration",
            Self::Jerk => "jerk",
        }
    }

    /// The event of a joint that stands at it.
    #[must_use]
    pub const fn event(self) -> Event {
        match self {
            Self::Velocity => Event::VelocityLimit,
            Self::Position => Event::PositionLimit,
            Self::Acceleration => Event::AccelerationLimit,
            Self::Jerk => Event::JerkLimit,
        }
    }
}

/// Which joints stand at which limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct AtLimits([u16; Limit::ALL.len()]);

impl AtLimits {
    /// Those that stand at this limit: bit j is joint j.
    #[must_use]
    pub const fn of(self, limit: Limit) -> u16 {
        self.0[limit as usize]
    }

    /// Those that stand at any.
    #[must_use]
    pub const fn any(self) -> u16 {
        let [velocity, position, acceleration, jerk] = self.0;
        velocity | position | acceleration | jerk
    }

    /// This joint stands at one.
    #[must_use]
    pub const fn has(self, joint: usize) -> bool {
        self.any() >> joint & 1 == 1
    }

    /// This joint too.
    #[inline(always)]
    pub(super) const fn insert(&mut self, joint: usize, limit: Limit) {
        self.0[limit as usize] |= 1 << joint;
    }
}
