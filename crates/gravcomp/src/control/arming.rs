//! Whether the arm is driven, and the ramp on which that changes.

use super::settings::Settings;
use super::status::{Event, Watch};

/// Whether the arm is driven.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum State {
    /// No torque, or on the way to none.
    #[default]
    Disarmed,
    /// On the way from the pose and torque of the moment of arming to the law.
    Ramping,
    /// The law.
    Armed,
    /// Latched until it is acknowledged: the safe torque, or on the way to it.
    Fault,
}

impl State {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Disarmed, Self::Ramping, Self::Armed, Self::Fault];

    /// Its name in logs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Disarmed => "disarmed",
            Self::Ramping => "ramping",
            Self::Armed => "armed",
            Self::Fault => "fault",
        }
    }

    /// The law drives the arm.
    #[must_use]
    pub const fn is_driven(self) -> bool {
        matches!(self, Self::Ramping | Self::Armed)
    }
}

/// What a cycle says about the arm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    /// The joint state of this cycle is good.
    pub(super) fresh: bool,
    /// Cycles without a good joint state.
    pub(super) missed: u32,
    /// The base sensor lets the arm be armed.
    pub(super) armable: bool,
}

/// The state, what was asked for, and the ramp.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arming {
    state: State,
    wanted: bool,
    /// What was wanted in the cycle before.
    was_wanted: bool,
    acknowledged: bool,
    /// Cycles for which a pose may be held.
    hold: f64,
    ramp: Ramp,
}

impl Arming {
    pub(super) fn new(settings: &Settings) -> Self {
        Self {
            state: State::Disarmed,
            wanted: false,
            was_wanted: false,
            acknowledged: false,
            hold: settings.hold_s * settings.rate_hz,
            ramp: Ramp { length: settings.ramp_s * settings.rate_hz, elapsed: 0.0 },
        }
    }

    pub(super) const fn state(&self) -> State {
        self.state
    }

    /// Somebody wants the arm to be driven, or not.
    pub(super) const fn want(&mut self, wanted: bool) {
        self.wanted = wanted;
    }

    /// Somebody wants the arm to be driven.
    pub(super) const fn is_wanted(&self) -> bool {
        self.wanted
    }

    /// Somebody has looked at the fault; the next cycle leaves it, if it has a good joint state.
    pub(super) fn acknowledge(&mut self) {
        self.acknowledged = self.state == State::Fault;
    }

    /// A cycle begins; true where the arm gets another goal, so that the ramp starts anew from the torque of now.
    #[inline(always)]
    pub(super) fn advance(&mut self, moment: Moment, watch: &mut Watch) -> bool {
        // Where PD is frozen its reference waits, or the two would be apart when it goes on.
        if moment.fresh || self.state != State::Ramping {
            self.ramp.elapsed += 1.0;
        }
        let next = self.after(moment);
        watch.note(next == State::Fault && self.state != State::Fault, Event::Fault);
        watch.note(self.acknowledged && next == State::Fault, Event::Waiting);
        watch.note(self.wanted && next == State::Disarmed, Event::Waiting);
        let regretted = next == State::Fault && self.wanted != self.was_wanted;
        let starts = next != self.state && next != State::Armed || regretted;
        (self.acknowledged, self.was_wanted) = (false, self.wanted);
        if starts {
            self.ramp.elapsed = 0.0;
        }
        self.state = if next == State::Ramping && self.ramp.is_over() { State::Armed } else { next };
        starts
    }

    /// The table: what is not listed changes nothing.
    fn after(&self, moment: Moment) -> State {
        let silent = f64::from(moment.missed) > self.hold;
        match self.state {
            State::Fault if self.acknowledged && moment.fresh => {
                if self.wanted {
                    State::Ramping
                } else {
                    State::Disarmed
                }
            }
            State::Fault => State::Fault,
            _ if !self.wanted => State::Disarmed,
            _ if silent => State::Fault,
            State::Disarmed if moment.fresh && moment.armable => State::Ramping,
            State::Ramping if self.ramp.is_over() => State::Armed,
            state => state,
        }
    }

    /// s: 0 at the change, 1 at the end of the ramp; and ds/d(cycle).
    pub(super) fn share(&self) -> (f64, f64) {
        self.ramp.share()
    }
}

/// From 0 to 1 in so many cycles, without a corner at either end.
#[derive(Clone, Copy, Debug)]
struct Ramp {
    length: f64,
    elapsed: f64,
}

impl Ramp {
    fn is_over(&self) -> bool {
        self.elapsed >= self.length
    }

    /// s = x³ (10 − 15 x + 6 x²) and ds/d(cycle), x the share of the time that has passed.
    fn share(&self) -> (f64, f64) {
        if self.is_over() {
            return (1.0, 0.0);
        }
        let x = self.elapsed / self.length;
        let (square, left) = (x * x, 1.0 - x);
        (x * square * (10.0 - 15.0 * x + 6.0 * square), 30.0 * square * left * left / self.length)
    }
}
