//! How many rejected samples it takes until they are an alarm.

use super::fault::{Fault, Faults};

/// Rejected samples in a row, whatever for.
const REJECTS: u32 = 3;

/// Jumps in a row. Whether the two agree makes no difference: a sensor whose axes were exchanged agrees with itself.
const JUMPS: u32 = 2;

/// The verdicts on the last samples.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Doubt {
    rejects: u32,
    jumps: u32,
    /// What the samples in a row were rejected for.
    reasons: Faults,
    /// One bit per sample, the latest lowest; 1: rejected.
    verdicts: u32,
}

impl Doubt {
    /// The last sample was rejected.
    pub(super) const fn is_any(&self) -> bool {
        self.rejects > 0
    }

    /// A good sample.
    pub(super) fn clear(&mut self) {
        *self = Self { verdicts: self.verdicts << 1, ..Self::default() };
    }

    /// A rejected sample; returns the alarms that it raises.
    pub(super) fn add(&mut self, reasons: Faults, density: u32) -> Faults {
        self.rejects = self.rejects.saturating_add(1);
        self.jumps = self.jumps.saturating_add(u32::from(reasons.has(Fault::Jerk)));
        self.reasons = self.reasons.and(reasons);
        self.verdicts = self.verdicts << 1 | 1;
        let dense = Faults::when(self.verdicts.count_ones() >= density, Fault::Density);
        if self.rejects >= REJECTS || self.jumps >= JUMPS || reasons.has(Fault::Stuck) {
            dense.and(self.reasons)
        } else {
            dense
        }
    }
}
