//! The polynomial sine and cosine against a yardstick of 100 bits.

use crate::builds::builds;
use crate::double_double;
use crate::scale::cases;
use gravcomp::dh::explicit;
use gravcomp::lanes::Lanes;
use gravcomp::trig::{REDUCTION_LIMIT, library_sin_cos, reducible, sin_cos};
use gravcomp::{Frame, Gravity, Inertia, Joint, Joints, Pose, Robot, RobotBuilder};
use nalgebra::Vector3;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// The promise of the module.
const BAR: f64 = 2.5;

fn single<const FUSED: bool>(x: f64) -> (f64, f64) {
    let (s, c) = sin_cos(Lanes::<1, FUSED>([x]));
    (s.0[0], c.0[0])
}

/// The larger error of sine and cosine, fused or not, in units in the last place.
fn error(x: f64) -> f64 {
    let (sine, cosine) = double_double::sin_cos(x);
    [single::<false>(x), single::<true>(x)]
        .into_iter()
        .map(|(s, c)| sine.ulps_to(s).max(cosine.ulps_to(c)))
        .fold(0.0, f64::max)
}

fn assert_accurate(points: impl Iterator<Item = f64>) {
    let (mut worst, mut at) = (0.0, 0.0);
    for x in points.filter(|x| x.abs() <= REDUCTION_LIMIT) {
        let error = error(x);
        assert!(!error.is_nan(), "sin or cos of {x:e} is no number");
        if error > worst {
            (worst, at) = (error, x);
        }
    }
    println!("worst error {worst:.3} ulp at {at:e}");
    assert!(worst <= BAR, "{worst} ulp at {at:e}");
}

/// The doubles within `reach` units in the last place of `x`.
fn neighbours(x: f64, reach: i64) -> impl Iterator<Item = f64> {
    (-reach..=reach).filter_map(move |k| Some(f64::from_bits(x.to_bits().checked_add_signed(k)?)))
}

#[test]
fn accurate_over_the_whole_range() {
    // An irrational stride does not repeat itself modulo π/2.
    let count = 300_000;
    let stride = REDUCTION_LIMIT / f64::from(count);
    assert_accurate((0..count).map(|k| f64::from(k).mul_add(stride, 0.618_033_988_749_895 * stride)));
}

#[test]
fn accurate_next_to_every_multiple_of_a_right_angle() {
    assert_accurate((1..=6366).flat_map(|k| neighbours(f64::from(k) * FRAC_PI_2, 4)));
}

#[test]
fn accurate_where_the_quadrant_changes() {
    assert_accurate((0..6366).flat_map(|k| neighbours(f64::from(k).mul_add(FRAC_PI_2, FRAC_PI_4), 4)));
}

/// The worst places: r just above a power of two and sin r just below it, in units half as large. 2^-j (1 + u 2^-2j/6).
#[test]
fn accurate_where_errors_add_up() {
    let remainder = |k: u32| {
        let (edge, u) = (0.5_f64.powi(1 + (k % 9).cast_signed()), (f64::from(k) * 0.618_033_988_749_895).fract());
        edge * (1.0 + u * edge * edge / 6.0)
    };
    assert_accurate((0..300_000).map(|k| f64::from(k % 6366).mul_add(FRAC_PI_2, remainder(k))));
}

#[test]
fn accurate_for_small_angles() {
    assert_accurate((0..100_000).map(|k| 10_f64.powf(-1.0 - f64::from(k) * 3e-4)));
    assert_accurate((0..100_000).map(|k| f64::from(k) * 8e-6));
}

#[test]
fn exact_at_zero() {
    for x in [0.0, -0.0] {
        assert_eq!(single::<false>(x), (0.0, 1.0));
        assert_eq!(single::<true>(x), (0.0, 1.0));
    }
}

#[test]
fn reducible_up_to_the_limit_and_no_further() {
    let beyond = f64::from_bits(REDUCTION_LIMIT.to_bits() + 1);
    for (x, expected) in [(REDUCTION_LIMIT, true), (-REDUCTION_LIMIT, true), (beyond, false), (-beyond, false)] {
        assert_eq!(reducible(Lanes::<4, false>([0.0, 1.0, x, 2.0])), expected, "{x:e}");
    }
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
        assert!(!reducible(Lanes::<2, true>([0.0, x])), "{x:e}");
    }
}

/// A unit mass at x = 1 on an axis along z that lies level: τ = g cos q.
fn pendulum() -> Robot {
    let mut builder = RobotBuilder::new();
    let placement = explicit(Pose::IDENTITY, &Vector3::z(), Joint::Revolute).expect("a unit axis");
    let mass = Inertia::new(1.0, Vector3::x(), [0.0; 6]).expect("a point mass");
    let frame = builder.link(&Frame::ROOT, Joint::Revolute, &placement, &mass).expect("one body");
    builder.build(Pose::IDENTITY, frame, None).expect("one body")
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn odd_and_even(x in -REDUCTION_LIMIT..REDUCTION_LIMIT) {
        let ((s, c), (back_s, back_c)) = (single::<false>(x), single::<false>(-x));
        prop_assert_eq!((back_s, back_c), (-s, c));
        let ((s, c), (back_s, back_c)) = (single::<true>(x), single::<true>(-x));
        prop_assert_eq!((back_s, back_c), (-s, c));
    }

    #[test]
    fn lanes_do_not_see_each_other(x in proptest::array::uniform8(-REDUCTION_LIMIT..REDUCTION_LIMIT)) {
        let (s, c) = sin_cos(Lanes::<8, false>(x));
        let (fused_s, fused_c) = sin_cos(Lanes::<8, true>(x));
        for l in 0..8 {
            prop_assert_eq!((s.0[l], c.0[l]), single::<false>(x[l]));
            prop_assert_eq!((fused_s.0[l], fused_c.0[l]), single::<true>(x[l]));
        }
    }

    #[test]
    fn beyond_the_limit_the_library_computes(exponent in 4.0..308.0, sign in prop::bool::ANY) {
        let x = if sign { 10_f64.powf(exponent) } else { -10_f64.powf(exponent) };
        let (s, c) = library_sin_cos(Lanes::<1, true>([x]));
        prop_assert_eq!((s.0[0], c.0[0]), (x.sin(), x.cos()));
        let (robot, level) = (pendulum(), Gravity(-Vector3::y()));
        for build in builds() {
            let tau = (build.gravity_torque)(&robot, &Joints::from_slice(&[x]), &level)[0];
            prop_assert!((tau - x.cos()).abs() <= 1e-15, "{}: {tau:e} at {x:e}", build.name);
        }
    }

    #[test]
    fn the_library_agrees_with_the_yardstick(x in REDUCTION_LIMIT..1e6) {
        let (sine, cosine) = double_double::sin_cos(x);
        let (s, c) = library_sin_cos(Lanes::<1, false>([x]));
        prop_assert!(sine.ulps_to(s.0[0]) <= 1.0 && cosine.ulps_to(c.0[0]) <= 1.0);
    }

    #[test]
    fn sine_and_cosine_lie_on_the_unit_circle(x in -REDUCTION_LIMIT..REDUCTION_LIMIT) {
        let (s, c) = single::<false>(x);
        prop_assert!((s * s + c * c - 1.0).abs() <= 1e-15);
    }
}
