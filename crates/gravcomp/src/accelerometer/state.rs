//! The states of the chain, and the table that leads from one to the next.

/// What happens when the sensor cannot be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Policy {
    /// The paper's rule. Nothing received yet: the nominal level vector. Interrupted: the last value, for as long as it
    /// takes; a sensor that is trusted again takes over by itself, with a ramp.
    #[default]
    Paper,
    /// Not armable without a live sensor. Interrupted: the last value for 50 ms, then the slow tilt estimate, then a
    /// latched fault that only an acknowledgement leaves.
    Strict,
}

/// Where the output comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum State {
    /// The sensor has never been trusted; the output is the nominal vector, and a strict arm must not be armed on it.
    NoData,
    /// The sensor has never been trusted; the output is the nominal vector, by the paper's rule.
    Nominal,
    /// The output follows the sensor.
    Live,
    /// Trust is lost; the output stays at the last value.
    Held,
    /// Trust is lost for longer than a value may be held; the output is the slow tilt estimate.
    Degraded,
    /// Latched until it is acknowledged; the output is the slow tilt estimate.
    Fault,
}

/// What can happen to the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Event {
    /// The sensor has shown that it can be trusted.
    Qualified,
    /// An alarm was raised.
    TrustLost,
    /// No good sample for longer than a value may be held.
    HoldOver,
    /// No good sample for so long that the arm must go to its safe hold.
    PatienceOver,
    /// Somebody has looked at it and says go on.
    Acknowledged,
}

impl State {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::NoData, Self::Nominal, Self::Live, Self::Held, Self::Degraded, Self::Fault];

    /// Before the first sample.
    #[must_use]
    pub const fn first(policy: Policy) -> Self {
        match policy {
            Policy::Paper => Self::Nominal,
            Policy::Strict => Self::NoData,
        }
    }

    /// The table: what is not listed changes nothing.
    #[must_use]
    pub const fn after(self, event: Event, policy: Policy) -> Self {
        match (self, event, policy) {
            (Self::NoData | Self::Nominal | Self::Held | Self::Degraded, Event::Qualified, _) => Self::Live,
            (Self::Live, Event::TrustLost, _) => Self::Held,
            (Self::Held, Event::HoldOver, Policy::Strict) | (Self::Fault, Event::Acknowledged, _) => Self::Degraded,
            (Self::Held | Self::Degraded, Event::PatienceOver, Policy::Strict) => Self::Fault,
            (state, _, _) => state,
        }
    }

    /// Its name in logs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NoData => "no_data",
            Self::Nominal => "nominal",
            Self::Live => "live",
            Self::Held => "held",
            Self::Degraded => "degraded",
            Self::Fault => "fault",
        }
    }

    /// The sensor has never been trusted.
    pub(super) const fn is_start(self) -> bool {
        matches!(self, Self::NoData | Self::Nominal)
    }
}

impl Event {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Qualified, Self::TrustLost, Self::HoldOver, Self::PatienceOver, Self::Acknowledged];
}
