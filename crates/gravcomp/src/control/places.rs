//! Loops over the places of an arm: as many as a controller's width N, 4, 8 or 16, so that they run side by side in the
//! processor's lanes. Places beyond the arm's own hold numbers that change nothing.
//!
//! What a law keeps of such numbers is aligned to cache lines (`align(64)`): eight places are then one line, not two.

use crate::constants::MAX_JOINTS;
use crate::robot::Joints;

/// One number per place.
pub(super) type Places<const N: usize> = [f64; N];

/// Which places are the arm's own: all bits set, or none.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Mask([u64; MAX_JOINTS]);

impl Mask {
    /// The first `n`.
    pub(super) fn of(n: usize) -> Self {
        Self(core::array::from_fn(|j| if j < n { u64::MAX } else { 0 }))
    }

    /// `x` with zeros beyond the arm's own places.
    #[inline(always)]
    pub(super) fn own<const N: usize>(&self, x: &Joints) -> Places<N> {
        let mut own = [0.0; N];
        for j in 0..N {
            own[j] = f64::from_bits(x[j].to_bits() & self.0[j]);
        }
        own
    }
}

/// The places of `x`.
#[inline(always)]
pub(super) fn places<const N: usize>(x: &Joints) -> &Places<N> {
    x.0.first_chunk().unwrap_or(&[0.0; N])
}

/// `yes` holds at every place; all are looked at, whatever the first ones are.
#[inline(always)]
pub(super) fn all<const N: usize>(yes: impl Fn(usize) -> bool) -> bool {
    let mut every = true;
    for j in 0..N {
        every &= yes(j);
    }
    every
}

#[inline(always)]
pub(super) fn copy<const N: usize>(from: &Places<N>, to: &mut Joints) {
    for j in 0..N {
        to[j] = from[j];
    }
}

/// `x` moved to within `low` ≤ `high`, in two instructions.
#[inline(always)]
pub(super) fn between(x: f64, low: f64, high: f64) -> f64 {
    let raised = if x < low { low } else { x };
    if raised > high { high } else { raised }
}
