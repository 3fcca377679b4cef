//! Gravity compensation for elastic joints: the springs, the fixed point and its bound, and how stiff gravity can be.

use crate::arms::{Arm, State, arms, axis, states};
use crate::builds::{Build, PORTABLE, builds};
use crate::scale::{ROUNDING, Scale, cases, close};
use gravcomp::elastic::{Field, Settings, Stiffness, StiffnessError, Variant, stiffness_bound};
use gravcomp::{DhRow, ElasticGravity, Frame, Gravity, Inertia, Joint, Joints, MAX_JOINTS, Pose, Robot, RobotBuilder};
use nalgebra::{DMatrix, Vector3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

const VARIANTS: [Variant; 5] = [Variant::Desired, Variant::Motor, Variant::Biased, Variant::QuasiStatic, Variant::Link];

/// Along −y of frame 0, in whose plane the arm of two links moves.
const DOWN: Gravity = Gravity(Vector3::new(0.0, -9.81, 0.0));

const GOAL: [f64; 2] = [0.3, 0.5];

/// Two links in a vertical plane, 2 kg and 1.5 kg, their middles 0.25 m from their joints 0.5 m apart; q₁ from the horizontal.
fn planar() -> Robot {
    let (mut builder, mut frame) = (RobotBuilder::new(), Frame::ROOT);
    for (a, mass, inertia) in [(0.0, 2.0, 0.05), (0.5, 1.5, 0.03)] {
        let row = DhRow { a, ..DhRow::default() }.modified().expect("finite");
        let body = Inertia::new(mass, Vector3::new(0.25, 0.0, 0.0), [inertia, 0.0, 0.0, inertia, 0.0, inertia]);
        frame = builder.link(&frame, Joint::Revolute, &row, &body.expect("a body")).expect("two bodies");
    }
    builder.build(Pose::IDENTITY, frame, None).expect("two bodies")
}

fn springs() -> Stiffness {
    Stiffness::each(&[100.0, 80.0]).expect("positive")
}

fn settings(variant: Variant, iterations: u32) -> Settings {
    Settings { variant, contraction: 16.960_204_761 / 9.81 / 80.0, iterations, tolerance: 0.0 }
}

fn hold(build: &Build, robot: &Robot, g: &Gravity) -> impl Fn(&Joints) -> Joints {
    let (gravity_torque, g) = (build.gravity_torque, *g);
    move |q| gravity_torque(robot, q, &g)
}

fn near(found: &[f64], wanted: &[f64], within: f64) {
    for (a, b) in found.iter().zip(wanted) {
        assert!((a - b).abs() <= within, "{found:?}, expected {wanted:?} within {within}");
    }
}

fn distance(a: &Joints, b: &Joints, n: usize) -> f64 {
    a.iter().zip(b.iter()).take(n).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// Largest |eigenvalue| of a symmetric matrix, row by row.
fn norm(matrix: &[f64], n: usize) -> f64 {
    DMatrix::from_row_slice(n, n, matrix).symmetric_eigenvalues().amax()
}

#[test]
fn the_arm_of_two_links_hangs_as_published() {
    let (robot, goal) = (planar(), Joints::from_slice(&GOAL));
    for build in builds() {
        let g = (build.gravity_torque)(&robot, &goal, &DOWN);
        near(&g[..2], &[14.277_823_5, 2.563_009_81], 5e-8);
        let law = ElasticGravity::new(springs(), settings(Variant::QuasiStatic, 60));
        near(&law.theta_desired(hold(&build, &robot, &DOWN), &goal)[..2], &[0.442_778_235, 0.532_037_622_6], 5e-10);
    }
}

#[test]
fn each_step_of_the_fixed_point_shrinks_the_error_as_published() {
    let (robot, goal) = (planar(), Joints::from_slice(&GOAL));
    let hold = hold(&PORTABLE, &robot, &DOWN);
    let law = ElasticGravity::new(springs(), settings(Variant::QuasiStatic, 60));
    let theta_d = law.theta_desired(&hold, &goal);
    let published = [1.13e-2, 8.85e-4, 7.09e-5, 5.72e-6, 4.62e-7, 3.74e-8];
    for (steps, error) in (2..).zip(published) {
        // The first step starts at θ_d, as nothing is known of the sag; what step k + 1 returns is iterate k.
        let found =
            ElasticGravity::new(springs(), settings(Variant::QuasiStatic, steps)).hanging(&hold, 9.81, &theta_d);
        let off = (0..2).map(|i| (found.q[i] - goal[i]).abs()).fold(0.0, f64::max);
        assert!((off / error - 1.0).abs() < 6e-3, "after {} steps {off:e}, published {error:e}", steps - 1);
        assert!(distance(&found.q, &goal, 2) <= found.error && found.iterations == steps, "{found:?}");
    }
    let end = law.hanging(&hold, 9.81, &theta_d);
    near(&end.q[..2], &GOAL, 1e-15);
}

#[test]
fn a_plane_arm_attains_the_bound() {
    let (robot, mut bound) = (planar(), [0.0; 4]);
    let anywhere = Joints([PI; MAX_JOINTS]);
    stiffness_bound(&robot, &Joints(anywhere.map(|x| -x)), &anywhere, Field::Along(DOWN.0 / 9.81), &mut bound);
    assert!((norm(&bound, 2) * 9.81 - 16.960_204_761).abs() < 5e-10);
    let (upright, mut stiffest) = (Joints::from_slice(&[FRAC_PI_2]), [0.0; 4]);
    gravcomp::portable::gravity_stiffness(&robot, &upright, &DOWN, &mut stiffest);
    assert!((norm(&stiffest, 2) - 16.960_204_761).abs() < 5e-10);
}

#[test]
fn a_shift_without_limits_has_no_bound_unless_it_moves_nothing() {
    let mut builder = RobotBuilder::new();
    let turn = DhRow { a: 0.1, ..DhRow::default() }.modified().expect("finite");
    let slide = DhRow { alpha: PI / 2.0, ..DhRow::default() }.modified().expect("finite");
    let heavy = Inertia::new(1.0, Vector3::x(), [0.0; 6]).expect("a point");
    let arm = builder.link(&Frame::ROOT, Joint::Revolute, &turn, &heavy).expect("a body");
    let mass = builder.link(&arm, Joint::Prismatic, &slide, &heavy).expect("a body");
    let robot = builder.build(Pose::IDENTITY, mass, None).expect("two bodies");
    let endless = Joints([f64::INFINITY; MAX_JOINTS]);
    let minus = Joints([f64::NEG_INFINITY; MAX_JOINTS]);
    let mut bound = [f64::NAN; 4];
    stiffness_bound(&robot, &minus, &endless, Field::Anyhow, &mut bound);
    assert_eq!(bound, [f64::INFINITY, 1.0, 1.0, 0.0]);
    // About the vertical, gravity has no torque at all.
    stiffness_bound(&robot, &minus, &endless, Field::Along(Vector3::z()), &mut bound);
    assert_eq!(bound, [0.0; 4]);
    let mut too_small = [7.0; 3];
    stiffness_bound(&robot, &minus, &endless, Field::Anyhow, &mut too_small);
    assert_eq!(too_small, [7.0; 3]);
}

#[test]
fn numbers_that_are_no_stiffness_are_refused() {
    use StiffnessError::{NotDefinite, NotFinite, NotPositive, NotSymmetric, Shape};
    assert_eq!(Stiffness::each(&[]), Err(Shape { entries: 0 }));
    assert_eq!(Stiffness::each(&[1.0; 17]), Err(Shape { entries: 17 }));
    assert_eq!(Stiffness::each(&[1.0, 0.0]), Err(NotPositive { joint: 1, value: 0.0 }));
    assert_eq!(Stiffness::each(&[-1.0]), Err(NotPositive { joint: 0, value: -1.0 }));
    assert!(matches!(Stiffness::each(&[f64::NAN]), Err(NotPositive { joint: 0, .. })));
    assert!(matches!(Stiffness::each(&[5e-324]), Err(NotPositive { joint: 0, .. })));
    assert_eq!(Stiffness::coupled(&[1.0; 3], 2), Err(Shape { entries: 3 }));
    assert_eq!(Stiffness::coupled(&[1.0, 0.0, 0.0, f64::INFINITY], 2), Err(NotFinite));
    assert_eq!(Stiffness::coupled(&[1.0, 0.5, 0.0, 1.0], 2), Err(NotSymmetric { at: (0, 1) }));
    assert_eq!(Stiffness::coupled(&[1.0, 1.0, 1.0, 1.0], 2), Err(NotDefinite));
    assert_eq!(Stiffness::coupled(&[1.0, 2.0, 2.0, 1.0], 2), Err(NotDefinite));
    for error in [
        Shape { entries: 3 },
        NotPositive { joint: 1, value: -2.0 },
        NotFinite,
        NotSymmetric { at: (0, 1) },
        NotDefinite,
    ] {
        assert!(error.to_string().len() > 20);
    }
}

#[test]
fn a_law_without_limits_on_its_steps_still_ends() {
    let (robot, goal) = (planar(), Joints::from_slice(&GOAL));
    let hold = hold(&PORTABLE, &robot, &DOWN);
    for (iterations, contraction, field) in
        [(0, 0.1, 9.81), (u32::MAX, 0.1, 9.81), (9, f64::INFINITY, 0.0), (9, f64::NAN, 1.0)]
    {
        let settings = Settings { variant: Variant::QuasiStatic, contraction, iterations, tolerance: f64::NAN };
        let mut law = ElasticGravity::new(springs(), settings);
        let found = law.step(&hold, field, &goal, &goal, &goal);
        assert!((1..=64).contains(&found.iterations), "{found:?}");
        assert!(found.torque.iter().all(|tau| tau.is_finite()) && found.error >= 0.0);
    }
}

/// Springs for which the fixed point shrinks by at most `rho` in the field `g`.
fn stiff_enough(robot: &Robot, g: &Gravity, spread: &Joints, rho: f64) -> (Stiffness, f64) {
    let (n, ranges) = (robot.coordinates(), Joints([4.0 * PI; MAX_JOINTS]));
    let mut bound = vec![0.0; n * n];
    stiffness_bound(robot, &Joints(ranges.map(|x| -x)), &ranges, Field::Anyhow, &mut bound);
    let alpha = norm(&bound, n) * g.0.norm();
    let k: Vec<f64> = (0..n).map(|i| (alpha / rho + 1e-6) * (1.0 + spread[i].abs())).collect();
    let contraction = alpha / g.0.norm() / k.iter().copied().fold(f64::INFINITY, f64::min);
    (Stiffness::each(&k).expect("positive"), contraction)
}

fn turning(arm: &Arm) -> Arm {
    let mut arm = arm.clone();
    for link in arm.links.iter_mut().filter(|link| link.joint == Joint::Prismatic) {
        link.joint = Joint::Revolute;
    }
    arm
}

proptest! {
    #![proptest_config(cases(400))]

    /// No entry of ∂g/∂q is larger than its bound, however the arm and its base stand.
    #[test]
    fn gravity_is_never_stiffer_than_the_bound(arm in arms(), state in states(), along in axis()) {
        let (robot, range) = (arm.build(), Joints([PI; MAX_JOINTS]));
        let (n, low) = (robot.coordinates(), Joints(range.map(|x| -x)));
        let g = along / along.norm();
        let rounding = ROUNDING * Scale::of(&arm, &State { q: range, ..state.at_rest() }).stiffness();
        for build in builds() {
            let found = build.gravity_stiffness(&robot, &state.q, &Gravity(g));
            for field in [Field::Anyhow, Field::Along(g)] {
                let mut bound = vec![0.0; n * n];
                stiffness_bound(&robot, &low, &range, field, &mut bound);
                for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                    let (k, most) = (found[i][j].abs(), bound[i * n + j]);
                    prop_assert!(k <= most + rounding, "{field:?}: entry {i}, {j} is {k:e}, bounded by {most:e}");
                }
            }
        }
    }

    /// The fixed point is found: the position found is as close to it as is said, from a cold start and from a warm one.
    #[test]
    fn the_fixed_point_is_as_close_as_is_said(arm in arms(), state in states(), rho in 0.05..0.9, most in 1..20_u32) {
        let arm = turning(&arm);
        let (robot, g, theta) = (arm.build(), state.gravity(), &state.q);
        let n = robot.coordinates();
        let hold = hold(&PORTABLE, &robot, &g);
        let (stiffness, contraction) = stiff_enough(&robot, &g, &state.qd, rho);
        let at = |iterations, tolerance| Settings { variant: Variant::QuasiStatic, contraction, iterations, tolerance };
        let exact = ElasticGravity::new(stiffness, at(64, 0.0));
        let mut q = *theta;
        for _ in 0..400 {
            let sag = stiffness.sag(&hold(&q));
            q = Joints(core::array::from_fn(|i| theta[i] - sag[i]));
        }
        let rounding = 1e-11 * (1.0 + Scale::of(&arm, &state.at_rest()).gain);
        prop_assert!(distance(&exact.hanging(&hold, g.0.norm(), theta).q, &q, n) <= rho.powi(63) / (1.0 - rho) * 7.0 * 4.0 + rounding);
        let mut law = ElasticGravity::new(stiffness, at(most, 1e-9));
        for cycle in 0..3 {
            let found = law.step(&hold, g.0.norm(), theta, &state.qd, &state.qdd);
            let off = distance(&found.at, &q, n);
            prop_assert!(off <= found.error + rounding, "cycle {cycle}: off {off:e}, said {:e}", found.error);
            prop_assert!(found.iterations <= most);
            prop_assert_eq!(found.torque, hold(&found.at));
        }
    }

    /// Motors where they belong: every variant that leaves no error compensates exactly the gravity of the goal.
    #[test]
    fn at_rest_at_the_goal_gravity_is_that_of_the_goal(arm in arms(), state in states(), rho in 0.05..0.5) {
        let arm = turning(&arm);
        let (robot, g, goal) = (arm.build(), state.gravity(), &state.q);
        let hold = hold(&PORTABLE, &robot, &g);
        let (stiffness, contraction) = stiff_enough(&robot, &g, &state.qd, rho);
        let bound = 1e-11 * Scale::of(&arm, &state.at_rest()).stiffness();
        let wanted = hold(goal);
        for variant in [Variant::Desired, Variant::Biased, Variant::QuasiStatic, Variant::Link] {
            let settings = Settings { variant, contraction, iterations: 64, tolerance: 0.0 };
            let mut law = ElasticGravity::new(stiffness, settings);
            let theta = law.theta_desired(&hold, goal);
            let found = law.step(&hold, g.0.norm(), &theta, goal, goal);
            close("θ_d", &found.theta_d[..], &theta[..], 0.0)?;
            close(&format!("{variant:?}"), &found.torque[..], &wanted[..], bound)?;
        }
    }

    /// Rigid joints: nothing sags, and motors are links.
    #[test]
    fn all_variants_agree_on_rigid_joints(arm in arms(), state in states()) {
        let (robot, g) = (arm.build(), state.gravity());
        let (n, hold) = (robot.coordinates(), hold(&PORTABLE, &robot, &g));
        let wanted = hold(&state.q);
        for variant in VARIANTS {
            let settings = Settings { variant, contraction: 0.0, iterations: 9, tolerance: 0.0 };
            let mut law = ElasticGravity::new(Stiffness::each(&vec![f64::INFINITY; n]).expect("rigid"), settings);
            let found = law.step(&hold, g.0.norm(), &state.q, &state.q, &state.q);
            prop_assert_eq!((found.torque, found.theta_d, found.at, found.error), (wanted, state.q, state.q, 0.0));
        }
    }

    /// The builds' own entry point is a step with the build's gravity torque.
    #[test]
    fn the_entry_point_is_a_step(arm in arms(), state in states(), pick in 0..5_usize) {
        let (robot, g) = (arm.build(), state.gravity());
        let k = vec![300.0; robot.coordinates()];
        let settings = Settings { variant: VARIANTS[pick], contraction: f64::INFINITY, iterations: 5, tolerance: 0.0 };
        let mut law = ElasticGravity::new(Stiffness::each(&k).expect("positive"), settings);
        let mut twin = law;
        for _ in 0..2 {
            let found = gravcomp::portable::elastic_gravity(&robot, &mut law, &state.q, &state.qd, &state.qdd, &g);
            let wanted = twin.step(hold(&PORTABLE, &robot, &g), g.0.norm(), &state.q, &state.qd, &state.qdd);
            prop_assert_eq!(format!("{found:?}"), format!("{wanted:?}"));
        }
    }

    /// A cycle with numbers that are none has none to give, and the next one knows nothing of it.
    #[test]
    fn a_bad_cycle_leaves_no_trace(arm in arms(), state in states(), pick in 0..5_usize, bad in 0..3_usize) {
        let arm = turning(&arm).uncoupled();
        let (robot, g, variant) = (arm.build(), state.gravity(), VARIANTS[pick]);
        let hold = hold(&PORTABLE, &robot, &g);
        let (stiffness, contraction) = stiff_enough(&robot, &g, &state.qd, 0.5);
        let mut law = ElasticGravity::new(stiffness, Settings { variant, contraction, iterations: 4, tolerance: 1e-12 });
        law.step(&hold, g.0.norm(), &state.q, &state.q, &state.q);
        let mut twin = law;
        let mut broken = state.q;
        broken[0] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][bad];
        let found = law.step(&hold, g.0.norm(), &broken, &broken, &broken);
        prop_assert!(found.torque[0].is_nan());
        prop_assert_eq!(law, twin);
        let again = law.step(&hold, g.0.norm(), &state.q, &state.q, &state.q);
        prop_assert_eq!(again, twin.step(&hold, g.0.norm(), &state.q, &state.q, &state.q));
    }

    /// Any bits at all: nothing panics, and what is no number is not remembered.
    #[test]
    fn nothing_panics(arm in arms(), bits in proptest::collection::vec(any::<u64>(), 52), pick in 0..5_usize) {
        let robot = arm.build();
        let numbers: Vec<f64> = bits.iter().copied().map(f64::from_bits).collect();
        let take = |k: usize| Joints::from_slice(&numbers[16 * k..]);
        let g = Gravity(Vector3::new(numbers[48], numbers[49], numbers[50]));
        let k = vec![100.0; robot.coordinates()];
        let settings = Settings { variant: VARIANTS[pick], contraction: numbers[51], iterations: 64, tolerance: numbers[51] };
        let mut law = ElasticGravity::new(Stiffness::each(&k).expect("positive"), settings);
        for _ in 0..3 {
            gravcomp::portable::elastic_gravity(&robot, &mut law, &take(0), &take(1), &take(2), &g);
        }
        law.reset();
        let (q, level) = (Joints::default(), Gravity::LEVEL);
        prop_assert!(gravcomp::portable::elastic_gravity(&robot, &mut law, &q, &q, &q, &level).torque[0].is_finite());
    }

    /// Coupled springs: K times the sag is the load; and springs that do not couple are each their own.
    #[test]
    fn the_sag_carries_the_load(rows in proptest::collection::vec(-1.0..1.0, 49), load in crate::arms::joints(10.0)) {
        let A = DMatrix::from_row_slice(7, 7, &rows);
        let K: DMatrix<f64> = &A * A.transpose() + DMatrix::identity(7, 7) * 0.5;
        let stiffness = Stiffness::coupled(K.transpose().as_slice(), 7).expect("positive definite");
        let sag = stiffness.sag(&load);
        let held = &K * DMatrix::from_row_slice(7, 1, &sag[..7]);
        close("K sag", held.as_slice(), &load[..7], 1e-11)?;
        prop_assert!(sag[7..].iter().all(|x| *x == 0.0));
        let each: Vec<f64> = (0..7).map(|i| K[(i, i)]).collect();
        let diagonal = Stiffness::coupled(DMatrix::from_diagonal(&K.diagonal()).as_slice(), 7).expect("positive");
        close("diagonal", &diagonal.sag(&load)[..], &Stiffness::each(&each).expect("positive").sag(&load)[..], 1e-12)?;
    }
}

/// At 1 kHz a joint that turns at 1 rad/s needs two steps for 1e-6 rad, with springs that sag by 8 degrees.
#[test]
fn a_warm_start_needs_two_steps() {
    let robot = planar();
    let hold = hold(&PORTABLE, &robot, &DOWN);
    let mut law = ElasticGravity::new(springs(), Settings { tolerance: 1e-4, ..settings(Variant::QuasiStatic, 20) });
    let mut theta = Joints::from_slice(&GOAL);
    law.step(&hold, 9.81, &theta, &theta, &theta);
    for _ in 0..2000 {
        theta[0] += 1e-3;
        let found = law.step(&hold, 9.81, &theta, &theta, &theta);
        assert!(found.iterations <= 2 && found.error <= 1e-4, "{found:?}");
    }
}
