//! The samples in a row that fit each other: in order, and no further apart than the base can move.

use super::clock::seconds;
use super::gate::Felt;
use nalgebra::Vector3;

/// Stragglers in a row after which the sensor is said to have restarted.
const RESTARTED: u32 = 3;

/// How a sample stands to the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    Next,
    /// The same again, or one that was overtaken.
    Misplaced,
    /// The third straggler in a row: the numbers begin anew.
    Restarted,
}

/// The run and its sum, in the sensor's axes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Run {
    last: Option<Felt>,
    count: u32,
    sum: Vector3<f64>,
    stragglers: u32,
}

impl Run {
    /// Places number and stamp behind the last sample that fitted.
    ///
    /// Copies of the last one are harmless and change nothing; only stragglers can show that the numbers began anew.
    pub(super) fn place(&mut self, seq: u64, stamp_ns: i64) -> Order {
        let Some(last) = self.last else { return Order::Next };
        if seq > last.seq && stamp_ns > last.stamp_ns {
            self.stragglers = 0;
            return Order::Next;
        }
        if seq != last.seq || stamp_ns != last.stamp_ns {
            self.stragglers += 1;
        }
        if self.stragglers < RESTARTED {
            return Order::Misplaced;
        }
        *self = Self::default();
        Order::Restarted
    }

    /// Time since the last sample that fitted, s; none at the beginning of a run.
    pub(super) fn since_last(&self, felt: &Felt) -> Option<f64> {
        let last = self.last.filter(|_| self.count > 0)?;
        Some(seconds(felt.stamp_ns.saturating_sub(last.stamp_ns)))
    }

    /// How far the sample is from the last one, m/s².
    pub(super) fn distance(&self, felt: &Felt) -> f64 {
        self.last.map_or(0.0, |last| (felt.force - last.force).norm())
    }

    /// How far the angular velocity is from the last one, rad/s: none without a gyroscope, infinite where it comes or goes.
    pub(super) fn spin(&self, felt: &Felt) -> f64 {
        match (self.last.and_then(|last| last.rate), felt.rate) {
            (Some(before), Some(now)) => (now - before).norm(),
            (None, None) => 0.0,
            _ => f64::INFINITY,
        }
    }

    /// The last sample that fitted had an angular velocity.
    pub(super) fn turns(&self) -> bool {
        self.last.is_some_and(|last| last.rate.is_some())
    }

    /// The sample fits.
    pub(super) fn extend(&mut self, felt: Felt) {
        self.last = Some(felt);
        self.count = self.count.saturating_add(1);
        self.sum += felt.force;
    }

    /// The next sample that comes begins a new run; its number still has to follow.
    pub(super) fn restart(&mut self) {
        (self.count, self.sum) = (0, Vector3::zeros());
    }

    /// Samples in the run.
    pub(super) const fn count(&self) -> u32 {
        self.count
    }

    /// Mean of the run, m/s², in the sensor's axes; zero before the first sample.
    pub(super) fn mean(&self) -> Vector3<f64> {
        self.sum / f64::from(self.count.max(1))
    }
}
