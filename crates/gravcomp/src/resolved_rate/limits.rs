//! What the joints can do: rates within their limits, on the way there no harder than their accelerations and jerks allow.
//!
//! What is too fast is slowed down as a whole, so that the tool keeps its direction. From the rates of the last step to the
//! new ones goes a straight line, of which a step covers as much as every joint can: a step in the twist becomes a ramp on
//! which the tool's twist turns straight from the one to the other.

use super::settings::Settings;
use super::status::Limit;
use crate::box_qp::between;
use crate::robot::Joints;
use nalgebra::ComplexField;

/// What the coordinates may do in a step: rest at least.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds<const N: usize> {
    pub lower: [f64; N],
    pub upper: [f64; N],
    /// How fast the distance from a limit of the position decays at most, 1/s.
    decay: f64,
}

/// A joint that stands at a limit.
pub(super) type Standing = Option<(usize, Limit)>;

impl<const N: usize> Bounds<N> {
    /// None at all.
    pub(super) const NONE: Self = Self { lower: [f64::NEG_INFINITY; N], upper: [f64::INFINITY; N], decay: 0.0 };

    /// With the positions where they are.
    #[inline(always)]
    pub(super) fn at(settings: &Settings, limited: Limited, q: &Joints, dt: f64) -> Self {
        let (mut lower, mut upper) = ([0.0; N], [0.0; N]);
        // In one long step no joint goes further than it should.
        let decay = if settings.damper * dt > FASTEST_DECAY { FASTEST_DECAY / dt } else { settings.damper };
        if !limited.acceleration {
            for j in 0..N {
                let most = settings.qd_max[j];
                upper[j] = between(decay * (settings.limits.1[j] - q[j]), 0.0, most);
                lower[j] = between(decay * (settings.limits.0[j] - q[j]), -most, 0.0);
            }
            return Self { lower, upper, decay };
        }
        for j in 0..N {
            let (low, high) = (settings.limits.0[j], settings.limits.1[j]);
            let most = settings.qd_max[j];
            upper[j] = closing(high - q[j], most, settings.qdd_max[j], settings.damper, dt);
            lower[j] = -closing(q[j] - low, most, settings.qdd_max[j], settings.damper, dt);
        }
        Self { lower, upper, decay }
    }

    /// The same, with the way back where a joint is beyond a limit.
    #[inline(always)]
    pub(super) fn leading_back(&self, settings: &Settings, q: &Joints) -> Self {
        let mut bounds = *self;
        for j in 0..N {
            let (below, above) = (settings.limits.0[j] - q[j], q[j] - settings.limits.1[j]);
            let back = |beyond: f64| (beyond * self.decay).min(settings.qd_max[j]);
            if above > 0.0 {
                bounds.upper[j] = -back(above);
            }
            if below > 0.0 {
                bounds.lower[j] = back(below);
            }
        }
        bounds
    }

    /// A joint that has to move.
    #[inline(always)]
    pub(super) fn pushed(&self) -> Option<usize> {
        (0..N).find(|j| self.lower[*j] > 0.0 || self.upper[*j] < 0.0)
    }

    /// The rates are within the bounds.
    #[inline(always)]
    pub(super) fn hold(&self, rates: &[f64; N]) -> bool {
        let mut within = true;
        for j in 0..N {
            within &= rates[j] <= self.upper[j];
            within &= rates[j] >= self.lower[j];
        }
        within
    }

    /// The largest share, at most 1, of the rates that is within the bounds.
    #[inline(always)]
    pub(super) fn share(&self, rates: &[f64; N]) -> f64 {
        if self.hold(rates) { 1.0 } else { self.less(rates) }
    }

    #[inline(always)]
    fn less(&self, rates: &[f64; N]) -> f64 {
        let mut share = 1.0;
        for j in 0..N {
            let bound = if rates[j] > 0.0 { self.upper[j] } else { self.lower[j] };
            let beyond = rates[j] > self.upper[j] || rates[j] < self.lower[j];
            let own = if beyond { bound / rates[j] } else { 1.0 };
            share = if own < share { own } else { share };
        }
        share
    }

    /// The joints that let the rates have no larger share than this, and why.
    pub(super) fn standing(
        &self,
        rates: &[f64; N],
        share: f64,
        settings: &Settings,
    ) -> impl Iterator<Item = (usize, Limit)> {
        let stands = move |&j: &usize| {
            let rate = rates[j] * share;
            rates[j] > 0.0 && rate >= self.upper[j] * SAME || rates[j] < 0.0 && rate <= self.lower[j] * SAME
        };
        (0..N).filter(stands).map(move |j| {
            let bound = if rates[j] > 0.0 { self.upper[j] } else { -self.lower[j] };
            (j, if bound >= settings.qd_max[j] { Limit::Velocity } else { Limit::Position })
        })
    }

    /// The largest share, at most 1, of other rates that fits beside these.
    #[inline(always)]
    pub(super) fn room(&self, rates: &[f64; N], other: &[f64; N]) -> f64 {
        let mut share = 1.0;
        for j in 0..N {
            let left = if other[j] > 0.0 { self.upper[j] - rates[j] } else { self.lower[j] - rates[j] };
            let own = if other[j].abs() > left.abs() { left / other[j] } else { 1.0 };
            share = if own < share { own } else { share };
        }
        if share > 0.0 { share } else { 0.0 }
    }

    /// The same rates without what rounding carries beyond the bounds.
    #[inline(always)]
    pub(super) fn clamped(&self, rates: &[f64; N]) -> [f64; N] {
        let mut clamped = *rates;
        for j in 0..N {
            let raised = if rates[j] < self.lower[j] { self.lower[j] } else { rates[j] };
            clamped[j] = if raised > self.upper[j] { self.upper[j] } else { raised };
        }
        clamped
    }
}

/// What rounding takes off a bound.
const SAME: f64 = 1.0 - 1e-9;

/// Largest rate towards a limit at this distance: one that is not passed, nor forces a change of more than `change` per second.
///
/// Near the limit the distance decays with `decay`, v = κ d (a velocity damper, B. Faverjon, P. Tournassoud 1987); further away
/// the joint brakes with a: k steps of a dt take a dt² k (k + 1)/2, so v = a dt (√(¼ + 2 (d − δ)/(a dt²)) − ½), where δ joins the two
/// at v = a/κ.
#[inline(always)]
fn closing(distance: f64, most: f64, change: f64, decay: f64, dt: f64) -> f64 {
    let room = if distance > 0.0 { distance } else { 0.0 };
    let share = if decay * dt > FASTEST_DECAY { FASTEST_DECAY } else { decay * dt };
    let mut bound = room * share / dt;
    let step = BRAKING * change * dt;
    let knee = step * dt / (share * share);
    if room > knee {
        let left = (room - 0.5 * (1.0 - share) * knee) / (step * dt);
        let braking = step * (ComplexField::sqrt(0.25 + 2.0 * left) - 0.5);
        bound = if braking < bound { braking } else { bound };
    }
    if bound < most { bound } else { most }
}

/// Largest share of the distance from a limit that goes in a step: what is then left of a braking joint's rate it can lose.
const FASTEST_DECAY: f64 = 0.5;

/// Share of the largest change that braking is planned with; where a step passes from braking to decay, it takes 1.07 of it.
const BRAKING: f64 = 0.9;

/// The rates of the last step, and how they came about.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ramp {
    rates: Joints,
    /// Rates per second, between the last two steps.
    slope: Joints,
}

impl Ramp {
    /// At rest.
    pub(super) fn reset(&mut self) {
        *self = Self::default();
    }

    /// The rates of the last step.
    #[inline(always)]
    pub(super) const fn rates(&self) -> &Joints {
        &self.rates
    }

    /// Straight on towards the goal, as far as a step may go; and the joint and the limit that keep it from arriving, if any.
    #[inline(always)]
    pub(super) fn towards<const N: usize>(
        &self,
        goal: &[f64; N],
        settings: &Settings,
        limited: Limited,
        dt: f64,
    ) -> ([f64; N], Standing) {
        if !(limited.acceleration || limited.jerk) {
            return (*goal, None);
        }
        let (mut way, mut share, mut standing) = ([0.0; N], 1.0, None);
        for j in 0..N {
            way[j] = goal[j] - self.rates[j];
            let most = settings.qdd_max[j] * dt;
            if way[j].abs() * share > most {
                share = most / way[j].abs();
                standing = Some((j, Limit::Acceleration));
            }
        }
        if limited.jerk {
            return self.eased(&way, share, standing, settings, dt);
        }
        let mut next = [0.0; N];
        for j in 0..N {
            next[j] = if share < 1.0 { self.rates[j] + share * way[j] } else { goal[j] };
        }
        (next, standing)
    }

    /// These are the rates of this step, `wanted` what they were before bounds cut them. A joint that was cut begins its
    /// acceleration anew: carried on, it would lead away from the bound.
    #[inline(always)]
    pub(super) fn go<const N: usize>(&mut self, wanted: &[f64; N], rates: &[f64; N], limited: Limited, dt: f64) {
        if limited.jerk {
            for j in 0..N {
                let slope = (rates[j] - self.rates[j]) / dt;
                self.slope[j] = if rates[j] == wanted[j] { slope } else { 0.0 };
            }
        }
        for j in 0..N {
            self.rates[j] = rates[j];
        }
    }

    /// The same with accelerations that change no faster than they may, and are gone when the goal is reached.
    #[inline(always)]
    fn eased<const N: usize>(
        &self,
        way: &[f64; N],
        share: f64,
        by: Standing,
        settings: &Settings,
        dt: f64,
    ) -> ([f64; N], Standing) {
        let (mut share, mut standing) = (share, by);
        for j in 0..N {
            let most = closing(way[j].abs(), f64::INFINITY, settings.qddd_max[j], f64::INFINITY, dt) * dt;
            if way[j].abs() * share > most {
                share = most / way[j].abs();
                standing = Some((j, Limit::Jerk));
            }
        }
        let (mut change, mut part) = ([0.0; N], 1.0);
        for j in 0..N {
            change[j] = share * way[j] / dt - self.slope[j];
            let most = settings.qddd_max[j] * dt;
            if change[j].abs() * part > most {
                part = most / change[j].abs();
                standing = Some((j, Limit::Jerk));
            }
        }
        let mut next = [0.0; N];
        for j in 0..N {
            next[j] = self.rates[j] + (self.slope[j] + part * change[j]) * dt;
        }
        (next, standing)
    }
}

/// Which limits there are at all.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limited {
    pub acceleration: bool,
    pub jerk: bool,
}

impl Limited {
    /// By any joint.
    pub(super) fn of(settings: &Settings) -> Self {
        let n = settings.coordinates;
        let any = |x: &Joints| x[..n].iter().any(|x| x.abs() < f64::INFINITY);
        Self { acceleration: any(&settings.qdd_max), jerk: any(&settings.qddd_max) }
    }
}
