//! Numbers that look random and are the same in every run.

use nalgebra::Vector3;
use std::f64::consts::TAU;

/// `SplitMix64` (Steele, Lea & Flood 2014): one stream per seed.
#[derive(Clone, Debug)]
pub struct Random {
    state: u64,
    /// The second of the last pair of normal numbers.
    spare: Option<f64>,
}

impl Random {
    /// Streams of neighbouring seeds begin far from each other: all are pieces of one and the same.
    pub fn new(seed: u64) -> Self {
        Self { state: mixed(seed), spare: None }
    }

    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        mixed(self.state)
    }

    /// Evenly from `low` to `high`.
    #[allow(clippy::cast_precision_loss)] // 53 bits
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.bits() >> 11) as f64 / (1_u64 << 53) as f64)
    }

    /// True in this share of the cases.
    pub fn chance(&mut self, share: f64) -> bool {
        self.within(0.0, 1.0) < share
    }

    /// One of the first `n` numbers.
    pub fn below(&mut self, n: u64) -> usize {
        usize::try_from(self.bits() % n).expect("a small number")
    }

    /// Normal, mean 0, deviation 1 (Box & Muller 1958).
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = (-2.0 * self.within(f64::MIN_POSITIVE, 1.0).ln()).sqrt();
        let (sin, cos) = (TAU * self.within(0.0, 1.0)).sin_cos();
        self.spare = Some(radius * sin);
        radius * cos
    }

    pub fn normals(&mut self) -> Vector3<f64> {
        Vector3::new(self.normal(), self.normal(), self.normal())
    }

    /// Of length 1.
    pub fn direction(&mut self) -> Vector3<f64> {
        self.normals().normalize()
    }
}

/// A permutation that leaves no bit where it was.
fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}
