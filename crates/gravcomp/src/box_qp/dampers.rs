//! Position limits as a box of rates: velocity dampers.
//!
//! After B. Faverjon, P. Tournassoud, "A local based approach for path planning of manipulators with a high number of degrees of
//! freedom", ICRA 1987: a joint at the distance ρ < ρᵢ from a limit may approach it by at most η (ρ − ρₛ) / (ρᵢ − ρₛ).

use super::between;

/// What no joint may exceed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits<const N: usize> {
    /// Lowest positions, may be −∞.
    pub lower: [f64; N],
    /// Highest positions, may be ∞.
    pub upper: [f64; N],
    /// Largest rates, ≥ 0.
    pub rate: [f64; N],
}

/// How a joint slows down near its limits; in the joint's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damper<const N: usize> {
    /// ρᵢ: nearer than this it slows down.
    pub influence: [f64; N],
    /// ρₛ < ρᵢ: here it stands still; beyond, it is led back.
    pub stop: [f64; N],
    /// η: what it may still do at ρᵢ, per second.
    pub gain: [f64; N],
}

/// The rates that are allowed at `q`: those of the damper, and none that would pass a limit within `dt`.
///
/// Never beyond the largest rate, and never reversed: where both limits push, the joint stands still.
#[inline(always)]
#[must_use]
pub fn velocity_box<const N: usize>(
    limits: &Limits<N>,
    damper: &Damper<N>,
    q: &[f64; N],
    dt: f64,
) -> ([f64; N], [f64; N]) {
    let (mut lower, mut upper) = ([0.0; N], [0.0; N]);
    for i in 0..N {
        let slowed = |room: f64| {
            let damped = damper.gain[i] * (room - damper.stop[i]) / (damper.influence[i] - damper.stop[i]);
            let damped = if room < damper.influence[i] { damped } else { f64::INFINITY };
            let exact = room / dt;
            between(if damped < exact { damped } else { exact }, -limits.rate[i], limits.rate[i])
        };
        let (down, up) = (-slowed(q[i] - limits.lower[i]), slowed(limits.upper[i] - q[i]));
        let squeezed = down > up;
        lower[i] = if squeezed { 0.0 } else { down };
        upper[i] = if squeezed { 0.0 } else { up };
    }
    (lower, upper)
}
