//! The caller's clock, and how much of it to believe.

use super::fault::{Fault, Faults};

/// Steps at one and the same time after which the clock is said to stand still.
const STANDSTILL: u32 = 100;

/// A clock that is this far behind its latest time has jumped, ns; less is a wobble that is waited out.
const WOBBLE_NS: i64 = 1_000_000;

/// Times that only grow, from a clock that may do anything.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HostClock {
    latest: Option<i64>,
    still: u32,
}

impl HostClock {
    /// Time since the step before, ns, never negative; and the alarm if the clock jumped back or stands still.
    ///
    /// After a jump back time goes on from there: ages keep growing, whatever the clock's own numbers are.
    pub(super) fn advance(&mut self, now_ns: i64) -> (i64, Faults) {
        let elapsed = now_ns.saturating_sub(self.latest.unwrap_or(now_ns));
        let jumped = elapsed < -WOBBLE_NS;
        if elapsed > 0 || jumped || self.latest.is_none() {
            self.latest = Some(now_ns);
        }
        self.still = if elapsed > 0 { 0 } else { self.still.saturating_add(1) };
        (elapsed.max(0), Faults::when(jumped || self.still >= STANDSTILL, Fault::HostClock))
    }
}

/// Nanoseconds as seconds.
#[allow(clippy::cast_precision_loss)] // beyond 104 days a nanosecond is lost
pub(super) fn seconds(ns: i64) -> f64 {
    ns as f64 * 1e-9
}
