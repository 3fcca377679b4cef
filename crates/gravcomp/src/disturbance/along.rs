//! The direction in the coordinates that an element reads, or acts along.

use crate::constants::MAX_JOINTS;
use crate::error::{SettingsError, within};
use crate::robot::Joints;

/// One coordinate, or a share of each: s = vᵀq.
#[derive(Clone, Copy, Debug)]
pub struct Along {
    /// The first coordinate with a share, and how many there are from it to the last one.
    first: usize,
    len: usize,
    shares: Joints,
}

impl Along {
    /// A share for each coordinate.
    ///
    /// # Errors
    /// [`SettingsError`] for no share at all, for more than 16, and for numbers that are not finite.
    pub fn new(shares: &[f64]) -> Result<Self, SettingsError> {
        #[allow(clippy::cast_precision_loss)] // only sizes far beyond the capacity lose precision
        within("shares", shares.len() as f64, 1.0, MAX_JOINTS as f64, "1 to 16 numbers, one per coordinate")?;
        for &share in shares {
            within("share", share, -super::LARGEST, super::LARGEST, "a finite number of at most 1e9")?;
        }
        let Some(first) = shares.iter().position(|&share| share != 0.0) else {
            let wanted = "with at least one number that is not 0";
            return Err(SettingsError { field: "shares", joint: None, value: 0.0, wanted });
        };
        let last = shares.iter().rposition(|&share| share != 0.0).unwrap_or(first);
        Ok(Self { first, len: last + 1 - first, shares: Joints::from_slice(shares) })
    }

    /// Calls `give(j, v_j)` for the coordinates from the first to the last one with a share.
    #[inline(always)]
    pub(super) fn each(&self, mut give: impl FnMut(usize, f64)) {
        for (j, &share) in self.shares.iter().enumerate().skip(self.first).take(self.len) {
            give(j, share);
        }
    }

    /// vᵀx.
    #[inline(always)]
    pub(super) fn dot(&self, x: &Joints) -> f64 {
        let mut sum = 0.0;
        for (&share, &x) in self.shares.iter().zip(x.iter()).skip(self.first).take(self.len) {
            sum += share * x;
        }
        sum
    }

    /// τ += v φ.
    #[inline(always)]
    pub(super) fn add(&self, phi: f64, tau: &mut Joints) {
        for (&share, tau) in self.shares.iter().zip(tau.iter_mut()).skip(self.first).take(self.len) {
            *tau += share * phi;
        }
    }
}
