//! Disturbance elements: one φ for torque and regressor, springs that are gradients, refusals, no heap, no panic.

use crate::arms::{Arm, arms, states};
use crate::builds::{Build, builds};
use crate::no_heap::{calls_during, chain};
use crate::scale::{ROUNDING, Scale, cases, close};
use gravcomp::disturbance::{Along, Blend, Direction, Pieces, Range, Shape};
use gravcomp::error::SettingsError;
use gravcomp::{Disturbances, Frame, Joints, MAX_JOINTS, Pose, Robot};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

const BLEND: Blend = Blend { dead_band: 0.01, saturation: 0.2, ratio: 0.8, smooth: false };
const STEP: f64 = 1e-5;

/// One of every shape, along one coordinate or along all of them.
pub fn one_of_each(n: usize) -> Result<Disturbances, SettingsError> {
    let mut all = Disturbances::new();
    let mut first = [0.0; MAX_JOINTS];
    first[n - 1] = 1.0;
    let (last, mixed) = (Along::new(&first[..n])?, Along::new(&vec![0.5; n])?);
    let range = Range { low: -1.0, high: 1.5 };
    let pieces = Pieces::new(&[-0.5, 0.25], &[2, 3, 1])?;
    let smooth = Blend { smooth: true, ..BLEND };
    for direction in [Direction::Both, Direction::Positive, Direction::Negative] {
        all.along(last, mixed, Shape::Polynomial { direction, blend: BLEND, range }, &[0.5, -1.0, 2.0])?;
    }
    all.along(mixed, last, Shape::Cable { pieces, range: Range::ALL }, &[1.0, 0.5, 0.1, -0.3, 0.7, 2.0])?;
    all.along(last, last, Shape::LinearSpring { rest: 0.2 }, &[3.0])?;
    all.along(last, last, Shape::Friction { blend: smooth, stribeck: Some(0.3) }, &[1.0, 0.2, 0.5])?;
    all.along(mixed, mixed, Shape::Constant, &[-0.4])?;
    all.along(last, mixed, Shape::Harmonic { order: 2.5 }, &[0.3, -0.6])?;
    Ok(all)
}

fn at(frame: &Frame, point: [f64; 3]) -> Frame {
    frame.then(Pose::new(Matrix3::identity(), point.into(), "drawn").expect("finite"))
}

/// The arm, with a spring from its base to its last body.
fn sprung(arm: &Arm, rest_length: f64) -> (Robot, Disturbances, [Frame; 2]) {
    let (robot, frames) = arm.build_with_frames();
    let moving = *arm.moving().last().expect("a body");
    let ends = [at(&Frame::ROOT, [0.3, -0.2, 0.5]), at(&frames[moving], [0.1, 0.2, -0.4])];
    let mut all = one_of_each(arm.coordinates()).expect("elements that make sense");
    all.between(&ends[0], &ends[1], rest_length, 50.0).expect("a spring between two bodies");
    (robot, all, ends)
}

fn length(build: &Build, robot: &Robot, ends: &[Frame; 2], q: &Joints) -> f64 {
    let [a, b] = ends.map(|end| (build.forward_kinematics)(robot, q, &end).column(3).xyz());
    (b - a).norm()
}

proptest! {
    #![proptest_config(cases(500))]

    #[test]
    fn torque_is_the_regressor_times_the_parameters(arm in arms(), state in states()) {
        let (robot, all, _) = sprung(&arm, 0.1);
        let (n, columns) = (robot.coordinates(), all.parameters().len());
        let scale = Scale::of(&arm, &state);
        let bound = ROUNDING * 1e3 * (1.0 + scale.gain * scale.lever * scale.lever);
        for build in builds() {
            let tau = (build.disturbance_torque)(&robot, &all, &state.q, &state.qd);
            let mut Y = vec![f64::NAN; n * columns];
            (build.disturbance_regressor)(&robot, &all, &state.q, &state.qd, &mut Y);
            let product: Vec<f64> =
                Y.chunks_exact(columns).map(|row| row.iter().zip(all.parameters()).map(|(y, p)| y * p).sum()).collect();
            close(build.name, &product, &tau[..n], bound)?;
        }
    }

    /// τ = ∂U/∂q with U = k (l − l₀)²/2, l from the forward kinematics.
    #[test]
    fn a_spring_is_the_gradient_of_its_energy(arm in arms(), state in states(), rest in 0.0..0.5) {
        let (robot, all, ends) = sprung(&arm, rest);
        let without = one_of_each(arm.coordinates()).expect("elements that make sense");
        let scale = Scale::of(&arm, &state);
        for build in builds() {
            prop_assume!(length(&build, &robot, &ends, &state.q) > 0.1);
            let energy = |q: &Joints| 25.0 * (length(&build, &robot, &ends, q) - rest).powi(2);
            let with = (build.disturbance_torque)(&robot, &all, &state.q, &state.qd);
            let rest = (build.disturbance_torque)(&robot, &without, &state.q, &state.qd);
            for j in 0..robot.coordinates() {
                let moved = |sign: f64| { let mut q = state.q; q[j] += sign * STEP; energy(&q) };
                let slope = (moved(1.0) - moved(-1.0)) / (2.0 * STEP);
                let bound = 1e-6 * 50.0 * (1.0 + scale.gain * scale.lever).powi(3);
                prop_assert!((with[j] - rest[j] - slope).abs() <= bound, "{}: {} {slope}", build.name, with[j] - rest[j]);
            }
        }
    }

    /// Any bits: nothing panics, and what is no number stays none.
    #[test]
    fn any_input_gives_an_output(arm in arms(), q in any::<[u64; 16]>(), qd in any::<[u64; 16]>()) {
        let (robot, all, _) = sprung(&arm, 0.1);
        let (q, qd) = (Joints(q.map(f64::from_bits)), Joints(qd.map(f64::from_bits)));
        let mut short = [0.0; 7];
        for build in builds() {
            let tau = (build.disturbance_torque)(&robot, &all, &q, &qd);
            let last = robot.coordinates() - 1;
            prop_assert!(q[last].is_finite() || tau[last].is_nan());
            (build.disturbance_regressor)(&robot, &all, &q, &qd, &mut short);
        }
    }

    #[test]
    fn friction_blends_without_a_step(v in -0.5..0.5_f64) {
        let mut all = Disturbances::new();
        let one = Along::new(&[1.0]).expect("a share");
        all.along(one, one, Shape::Friction { blend: BLEND, stribeck: None }, &[1.0, 0.0]).expect("friction");
        let robot = chain();
        let at = |v: f64| -> f64 {
            gravcomp::portable::disturbance_torque(&robot, &all, &Joints::default(), &Joints([v; MAX_JOINTS]))[0]
        };
        prop_assert_eq!(at(-v), -at(v));
        prop_assert!(at(v).abs() <= 0.8);
        prop_assert!((at(v + 1e-9) - at(v)).abs() <= 1.01e-9 * 0.8 / 0.19 + 1e-15);
    }
}

#[test]
fn what_cannot_be_meant_is_refused() {
    let one = Along::new(&[1.0]).expect("a share");
    let polynomial = |blend, range| Shape::Polynomial { direction: Direction::Both, blend, range };
    let (all, nan) = (Range::ALL, f64::NAN);
    let refused: [(Shape, &[f64], &str); 12] = [
        (polynomial(BLEND, all), &[], "coefficients"),
        (polynomial(BLEND, all), &[0.0; 11], "coefficients"),
        (polynomial(BLEND, all), &[nan], "parameter"),
        (polynomial(BLEND, Range { low: 1.0, high: 1.0 }), &[1.0], "range"),
        (polynomial(BLEND, Range { low: nan, high: 1.0 }), &[1.0], "range"),
        (polynomial(Blend { dead_band: -1.0, ..BLEND }, all), &[1.0], "dead_band"),
        (polynomial(Blend { saturation: 0.01, ..BLEND }, all), &[1.0], "saturation"),
        (polynomial(Blend { ratio: 1.1, ..BLEND }, all), &[1.0], "ratio"),
        (Shape::LinearSpring { rest: nan }, &[1.0], "rest"),
        (Shape::Friction { blend: BLEND, stribeck: Some(0.0) }, &[1.0; 3], "stribeck_velocity"),
        (Shape::Friction { blend: BLEND, stribeck: None }, &[1.0; 3], "parameters"),
        (Shape::Harmonic { order: 0.0 }, &[1.0; 2], "order"),
    ];
    for (shape, parameters, field) in refused {
        let error = Disturbances::new().along(one, one, shape, parameters).expect_err(field);
        assert_eq!(error.field, field, "{shape:?}");
    }
    for shares in [&[][..], &[0.0], &[nan], &[1.0; 17]] {
        assert!(Along::new(shares).is_err(), "{shares:?}");
    }
    for (knots, lengths) in
        [(&[][..], &[1][..]), (&[0.0], &[1]), (&[1.0, 1.0], &[1, 1, 1]), (&[nan], &[1, 1]), (&[0.0], &[1, 0])]
    {
        assert!(Pieces::new(knots, lengths).is_err(), "{knots:?}");
    }
    let (a, b) = (Frame::ROOT, at(&Frame::BASE, [0.1, 0.0, 0.0]));
    assert_eq!(Disturbances::new().between(&a, &b, 0.0, 1.0).expect_err("one body").field, "body_b");
    assert_eq!(Disturbances::new().between(&a, &b, -1.0, 1.0).expect_err("a length").field, "rest_length");
    assert_eq!(Disturbances::new().between(&a, &b, 0.0, -1.0).expect_err("stiffness").field, "stiffness");
}

#[test]
fn room_is_limited_and_a_refusal_changes_nothing() {
    let (one, mut all) = (Along::new(&[1.0]).expect("a share"), Disturbances::new());
    for _ in 0..64 {
        all.along(one, one, Shape::Constant, &[1.0]).expect("room for 64");
    }
    assert_eq!(all.along(one, one, Shape::Constant, &[1.0]).expect_err("full").field, "parameters");
    assert_eq!(all.parameters(), [1.0; 64]);
}

#[test]
fn a_spring_to_the_base_does_not_turn_with_it() {
    let (mut robot, mut all) = (chain(), one_of_each(7).expect("elements that make sense"));
    all.between(&Frame::ROOT, &robot.link_frame(5), 0.1, 20.0).expect("a spring");
    let state = Joints([0.3; MAX_JOINTS]);
    let before = gravcomp::portable::disturbance_torque(&robot, &all, &state, &state);
    let turned = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    robot.set_base(Pose::new(turned, Vector3::new(1.0, 2.0, 3.0), "turned").expect("a rotation"));
    let after = gravcomp::portable::disturbance_torque(&robot, &all, &state, &state);
    assert!(before.iter().zip(after.iter()).all(|(a, b)| (a - b).abs() < 1e-12));
}

#[test]
fn elements_take_no_heap() {
    let (robot, mut all) = (chain(), one_of_each(7).expect("elements that make sense"));
    all.between(&Frame::ROOT, &robot.link_frame(5), 0.1, 20.0).expect("a spring");
    let mut Y = vec![0.0; 7 * all.parameters().len()];
    for build in builds() {
        let calls = calls_during(100_000, |q| {
            std::hint::black_box((build.disturbance_torque)(&robot, &all, q, q));
            (build.disturbance_regressor)(&robot, &all, q, q, &mut Y);
        });
        assert_eq!(calls, 0, "{}", build.name);
    }
}
