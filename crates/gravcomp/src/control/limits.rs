//! The last word on every torque: within its limit, and no further from the one before than its rate allows.

use super::places::{Places, all, between};
use super::settings::Settings;
use super::status::{Event, Watch};
use crate::robot::Joints;

/// Limits of the torques at the side where they go.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Limits {
    /// Largest torque; the largest number where there is no limit, so that what overflows stays finite.
    most: Joints,
    /// Largest change per cycle.
    step: Joints,
}

impl Limits {
    pub(super) fn new(settings: &Settings) -> Self {
        let period = settings.period();
        Self {
            most: Joints(settings.tau_max.map(|most| most.min(f64::MAX))),
            step: Joints(settings.tau_rate_max.map(|rate| rate * period)),
        }
    }

    /// The next torques after `last`, on the way from `from` to the law's: τ = (1 − s) τ₀ + s τ_law with |τ_law| ≤ τ_max, as far
    /// as |τ − τ_last| ≤ τ̇_max Δt allows.
    #[inline(always)]
    pub(super) fn drive<const N: usize>(
        &self,
        last: &mut Joints,
        from: &Joints,
        s: f64,
        law: &Places<N>,
        watch: &mut Watch,
    ) {
        let (mut limited, mut slewed) = ([0.0; N], [0.0; N]);
        for j in 0..N {
            limited[j] = between(law[j], -self.most[j], self.most[j]);
        }
        let wanted = if s >= 1.0 { limited } else { blend(from, &limited, s) };
        for j in 0..N {
            slewed[j] = between(wanted[j], last[j] - self.step[j], last[j] + self.step[j]);
            last[j] = between(slewed[j], -self.most[j], self.most[j]);
        }
        watch.note(!all::<N>(|j| limited[j] == law[j]), Event::TorqueLimit);
        watch.note(!all::<N>(|j| slewed[j] == wanted[j]), Event::TorqueRate);
    }
}

/// (1 − s) τ₀ + s τ.
#[inline(always)]
fn blend<const N: usize>(from: &Joints, to: &Places<N>, s: f64) -> Places<N> {
    let mut between = [0.0; N];
    for j in 0..N {
        between[j] = (1.0 - s) * from[j] + s * to[j];
    }
    between
}
