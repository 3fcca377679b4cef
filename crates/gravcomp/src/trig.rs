//! Sine and cosine of several angles at once, by polynomial: the C library's cost more than the rest of a cycle.
//!
//! x = k π/2 + r with |r| ≤ π/4, π/2 in three parts (Cody & Waite), then the minimax polynomials of fdlibm
//! (`k_sin.c`, `k_cos.c`, Sun Microsystems 1993) for sin r and cos r, exchanged and negated by the quadrant k mod 4.
//! Errors stay below 2.5 ulp for |x| ≤ [`REDUCTION_LIMIT`]; beyond it, for angles that no arm has, and for NaN, callers take
//! [`library_sin_cos`] (slower, as exact).

use crate::lanes::Lanes;
use nalgebra::ComplexField;

/// Largest |x|, rad, for which the three-part reduction keeps its accuracy.
pub const REDUCTION_LIMIT: f64 = 1e4;

/// π/2 in three parts; the first two have 33 significant bits, so that k times them is exact for |k| < 2²⁰.
const HALF_PI: [f64; 3] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];

/// Adding and subtracting 1.5·2⁵² rounds to the nearest integer, which then stands in the low bits of the sum.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// sin r ≈ r + r³ (S₀ + S₁ r² + …).
const SIN: [f64; 6] = [
    -0.166_666_666_666_666_32,
    0.008_333_333_333_322_49,
    -0.000_198_412_698_298_579_5,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];

/// cos r ≈ 1 − r²/2 + r⁴ (C₀ + C₁ r² + …).
const COS: [f64; 6] = [
    0.041_666_666_666_666_6,
    -0.001_388_888_888_887_411,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// `c₀ + z (c₁ + z (…))`.
#[inline(always)]
fn polynomial<const W: usize, const FUSED: bool>(c: &[f64; 6], z: Lanes<W, FUSED>) -> Lanes<W, FUSED> {
    let mut sum = Lanes::splat(c[5]);
    for k in (0..5).rev() {
        sum = sum.mul_add(z, Lanes::splat(c[k]));
    }
    sum
}

/// Every angle is small enough for [`sin_cos`].
#[inline(always)]
#[must_use]
pub fn reducible<const W: usize, const FUSED: bool>(x: Lanes<W, FUSED>) -> bool {
    x.0.iter().fold(true, |all, x| all & (x.abs() <= REDUCTION_LIMIT))
}

/// `(sin x, cos x)` in every lane for |x| ≤ [`REDUCTION_LIMIT`], rad.
#[inline(always)]
#[must_use]
pub fn sin_cos<const W: usize, const FUSED: bool>(x: Lanes<W, FUSED>) -> (Lanes<W, FUSED>, Lanes<W, FUSED>) {
    let shifted = x.mul_add(Lanes::splat(core::f64::consts::FRAC_2_PI), Lanes::splat(ROUNDER));
    let k = shifted - Lanes::splat(ROUNDER);
    let mut r = x;
    for part in HALF_PI {
        r = k.neg_mul_add(Lanes::splat(part), r);
    }
    let z = r * r;
    let sin_r = (z * r).mul_add(polynomial(&SIN, z), r);
    let half = z * Lanes::splat(0.5);
    let head = Lanes::splat(1.0) - half;
    let lost = (Lanes::splat(1.0) - head) - half;
    let cos_r = head + (z * z).mul_add(polynomial(&COS, z), lost);

    let mut sin = Lanes::ZERO;
    let mut cos = Lanes::ZERO;
    for l in 0..W {
        let quadrant = shifted.0[l].to_bits();
        let odd = 0_u64.wrapping_sub(quadrant & 1);
        let (s, c) = (sin_r.0[l].to_bits(), cos_r.0[l].to_bits());
        let swap = (s ^ c) & odd;
        let sin_sign = (quadrant & 2) << 62;
        let cos_sign = (quadrant.wrapping_add(1) & 2) << 62;
        sin.0[l] = f64::from_bits((s ^ swap) ^ sin_sign);
        cos.0[l] = f64::from_bits((c ^ swap) ^ cos_sign);
    }
    (sin, cos)
}

/// `(sin x, cos x)` of any angle by the library's functions, lane by lane; NaN for NaN and infinities.
#[must_use]
pub fn library_sin_cos<const W: usize, const FUSED: bool>(x: Lanes<W, FUSED>) -> (Lanes<W, FUSED>, Lanes<W, FUSED>) {
    (Lanes(x.0.map(ComplexField::sin)), Lanes(x.0.map(ComplexField::cos)))
}
