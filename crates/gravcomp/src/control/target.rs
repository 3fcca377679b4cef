//! Where the joints should be: the last good target, within the joint limits.

use super::encoder::are_numbers;
use super::places::{Places, all, between};
use super::settings::Settings;
use super::status::{Event, Watch};
use crate::robot::Joints;

/// Positions and rates of the coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Target {
    pub(super) q: Joints,
    pub(super) qd: Joints,
}

/// The joint limits and the last good target.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Targets {
    lower: Joints,
    upper: Joints,
    last: Target,
    /// There has been a good target.
    known: bool,
}

impl Targets {
    pub(super) fn new(settings: &Settings) -> Self {
        let (lower, upper) = settings.limits;
        Self { lower, upper, last: Target::default(), known: false }
    }

    /// Takes the target of this cycle if it is one, moved to within the limits, else stays at the last one. At a limit a
    /// target does not move on outwards.
    #[inline(always)]
    pub(super) fn follow<const N: usize>(&mut self, q: &Places<N>, qd: &Places<N>, watch: &mut Watch) {
        if !(are_numbers(q) & are_numbers(qd)) {
            watch.note(true, Event::Target);
            return;
        }
        for j in 0..N {
            // Below its limit a joint may only rise, above only fall: the other bound of its rate is infinite.
            let slowest = if q[j] < self.lower[j] { 0.0 } else { f64::NEG_INFINITY };
            let fastest = if q[j] > self.upper[j] { 0.0 } else { f64::INFINITY };
            self.last.q[j] = between(q[j], self.lower[j], self.upper[j]);
            self.last.qd[j] = between(qd[j], slowest, fastest);
        }
        watch.note(!all::<N>(|j| self.last.q[j] == q[j]), Event::TargetLimit);
        self.known = true;
    }

    /// The last good target.
    pub(super) const fn last(&self) -> &Target {
        &self.last
    }

    /// There has been a good target.
    pub(super) const fn is_known(&self) -> bool {
        self.known
    }

    /// The arm is armed without a target: it is to stay at `q`.
    pub(super) const fn stay(&mut self, q: &Joints) {
        self.last.q = *q;
    }

    /// Every joint of `q` is within its limits.
    #[inline(always)]
    pub(super) fn contain<const N: usize>(&self, q: &Places<N>) -> bool {
        all::<N>(|j| between(q[j], self.lower[j], self.upper[j]) == q[j])
    }
}
