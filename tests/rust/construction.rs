//! What no robot can have is refused, and the message says what would be right.

use crate::arms::{axis, body, pose, turn, vector};
use crate::scale::cases;
use gravcomp::dh::explicit;
use gravcomp::joint::frame_with_z;
use gravcomp::{Coupling, DhRow, Frame, Inertia, Joint, MAX_JOINTS, ModelError, Placement, Pose, RobotBuilder};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

const STILL: Placement = Placement { before: Pose::IDENTITY, after: Pose::IDENTITY };

/// The message contains each of `parts`.
fn assert_says(error: &ModelError, parts: &[&str]) {
    let text = error.to_string();
    for part in parts {
        assert!(text.contains(part), "'{text}' does not say '{part}'");
    }
}

/// A chain of `bodies` hinges.
fn chain(bodies: usize) -> Result<(RobotBuilder, Frame), ModelError> {
    let (mut builder, mut frame) = (RobotBuilder::new(), Frame::ROOT);
    for _ in 0..bodies {
        frame = builder.link(&frame, Joint::Revolute, &STILL, &Inertia::ZERO)?;
    }
    Ok((builder, frame))
}

#[test]
fn a_robot_has_1_to_16_bodies() {
    let none = RobotBuilder::default().build(Pose::IDENTITY, Frame::ROOT, None).unwrap_err();
    assert_eq!(none, ModelError::BodyCount { found: 0 });
    assert_says(&none, &["0 moving bodies", "1 to 16"]);
    let too_many = chain(MAX_JOINTS + 1).unwrap_err();
    assert_eq!(too_many, ModelError::BodyCount { found: 17 });
    assert_says(&too_many, &["17 moving bodies", "1 to 16"]);
    for bodies in [1, MAX_JOINTS] {
        let (builder, frame) = chain(bodies).expect("not too many");
        let robot = builder.build(Pose::IDENTITY, frame, None).expect("not too many");
        assert_eq!((robot.bodies(), robot.coordinates()), (bodies, bodies));
    }
}

#[test]
fn fixed_links_do_not_count() {
    let (mut builder, mut frame) = chain(MAX_JOINTS).expect("16 bodies");
    for _ in 0..100 {
        frame = builder.link(&frame, Joint::Fixed, &STILL, &Inertia::ZERO).expect("fixed");
    }
    assert_eq!(builder.build(Pose::IDENTITY, frame, None).expect("16 bodies").bodies(), MAX_JOINTS);
    let mut bench = RobotBuilder::new();
    let frame = bench.link(&Frame::ROOT, Joint::Fixed, &STILL, &Inertia::ZERO).expect("fixed");
    assert_eq!(bench.build(Pose::IDENTITY, frame, None).unwrap_err(), ModelError::BodyCount { found: 0 });
}

#[test]
fn numbers_are_finite() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let ones = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];
        let v = Vector3::new(0.0, bad, 0.0);
        let mut spread = ones;
        spread[4] = bad;
        for (field, found) in [
            ("mass", Inertia::new(bad, Vector3::zeros(), ones).err()),
            ("com", Inertia::new(1.0, v, ones).err()),
            ("inertia", Inertia::new(1.0, Vector3::zeros(), spread).err()),
            ("tool", Pose::new(Matrix3::identity(), v, "tool").err()),
            ("tool", Pose::new(Matrix3::from_diagonal(&v), Vector3::zeros(), "tool").err()),
            ("alpha", DhRow { alpha: bad, ..DhRow::default() }.standard().err()),
            ("a", DhRow { a: bad, ..DhRow::default() }.modified().err()),
            ("d", DhRow { d: bad, ..DhRow::default() }.standard().err()),
            ("theta", DhRow { theta: bad, ..DhRow::default() }.modified().err()),
            ("axis", frame_with_z(&v).err()),
            ("coupling", Coupling::new(&[1.0, bad], &[0.0, 0.0], 1).err()),
            ("coupling", Coupling::new(&[1.0, 1.0], &[0.0, bad], 1).err()),
        ] {
            let found = found.unwrap_or_else(|| panic!("{field} = {bad} was accepted"));
            assert_eq!(found, ModelError::NotFinite { field });
            assert_says(&found, &[field, "not finite"]);
        }
    }
}

#[test]
fn mass_is_not_negative() {
    let error = Inertia::new(-0.5, Vector3::zeros(), [0.0; 6]).unwrap_err();
    assert_eq!(error, ModelError::NegativeMass { mass: -0.5 });
    assert_says(&error, &["-0.5 kg", "zero or positive"]);
    assert_eq!(Inertia::new(0.0, Vector3::x(), [0.0; 6]), Ok(Inertia::ZERO));
}

#[test]
fn inertia_needs_mass() {
    let error = Inertia::new(0.0, Vector3::zeros(), [1.0, 0.0, 0.0, 1.0, 0.0, 1.0]).unwrap_err();
    assert_eq!(error, ModelError::InertiaWithoutMass);
    assert_says(&error, &["without mass", "give the link a mass or no inertia"]);
}

#[test]
fn a_zero_axis_is_refused() {
    let error = explicit(Pose::IDENTITY, &Vector3::zeros(), Joint::Prismatic).unwrap_err();
    assert_eq!(error, ModelError::ZeroAxis);
    assert_says(&error, &["axis", "length zero"]);
    assert!(explicit(Pose::IDENTITY, &Vector3::zeros(), Joint::Fixed).is_ok(), "a fixed link has no axis");
}

#[test]
fn couplings_have_a_row_per_body_and_1_to_bodies_columns() {
    for (matrix, offset, columns) in [
        (vec![], vec![], 0),
        (vec![1.0], vec![0.0], 0),
        (vec![1.0, 0.0], vec![0.0], 2),
        (vec![1.0, 2.0, 3.0], vec![0.0, 0.0], 1),
        (vec![1.0; 17], vec![0.0; 17], 1),
        (vec![1.0], vec![0.0], usize::MAX),
    ] {
        let error = Coupling::new(&matrix, &offset, columns).unwrap_err();
        assert!(matches!(error, ModelError::CouplingShape { .. }), "{error}");
        assert_says(&error, &["coupling matrix is", "one row per moving body", "columns"]);
    }
}

#[test]
fn couplings_belong_to_their_robot() {
    let (builder, frame) = chain(3).expect("3 bodies");
    let coupling = Coupling::new(&[1.0, 2.0], &[0.0, 0.0], 1).expect("two bodies, one coordinate");
    assert_eq!((coupling.bodies(), coupling.coordinates()), (2, 1));
    let error = builder.build(Pose::IDENTITY, frame, Some(coupling)).unwrap_err();
    assert_eq!(error, ModelError::CouplingShape { found: (2, 1), bodies: 3 });
    assert_says(&error, &["2 x 1", "(3)", "1 to 3 columns"]);
}

#[test]
fn a_joint_that_no_coordinate_moves_is_allowed_but_an_idle_coordinate_is_not() {
    assert!(Coupling::new(&[1.0, 0.0], &[0.0, 0.3], 1).is_ok());
    let idle = Coupling::new(&[1.0, 0.0, 2.0, 0.0], &[0.0, 0.0], 2).unwrap_err();
    assert_eq!(idle, ModelError::CouplingRank);
    assert_says(&idle, &["columns of the coupling matrix", "linearly dependent"]);
}

/// R that is no rotation: scaled, sheared, rounded too far.
fn distorted() -> impl Strategy<Value = Matrix3<f64>> {
    (axis(), -3.0..3.0, 0..9_usize, prop_oneof![1e-8..1e3, -1e3..-1e-8]).prop_map(|(axis, angle, entry, by)| {
        let mut R = turn(&axis, angle);
        R[entry] += by;
        R
    })
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn frames_are_orthonormal(R in distorted(), p in vector(1.0)) {
        let error = (R.transpose() * R - Matrix3::identity()).amax();
        prop_assume!(error > 1e-9);
        let refused = Pose::new(R, p, "tool").unwrap_err();
        prop_assert_eq!(refused, ModelError::NotARotation { field: "tool", error });
        assert_says(&refused, &["tool is not a rotation", "at most 1e-9"]);
    }

    #[test]
    fn frames_rounded_to_ten_decimals_are_accepted(pose in pose()) {
        let rounded = pose.rotation().map(|x| (x * 1e10).round() / 1e10);
        prop_assert!(Pose::new(rounded, *pose.translation(), "base").is_ok());
    }

    #[test]
    fn frames_are_no_mirrors(pose in pose(), row in 0..3_usize) {
        let mut mirror = *pose.rotation();
        mirror.row_mut(row).neg_mut();
        let refused = Pose::new(mirror, *pose.translation(), "base").unwrap_err();
        prop_assert_eq!(refused, ModelError::Mirrored { field: "base" });
        assert_says(&refused, &["base is a mirror", "determinant -1", "one axis has the wrong sign"]);
    }

    /// Principal moments of a body obey a ≤ b ≤ c ≤ a + b; turned into any axes, the check sees them.
    #[test]
    fn impossible_inertias_are_refused(pose in pose(), a in 0.01..1.0_f64, b in 0.01..1.0_f64, excess in 1e-6..1.0_f64) {
        let spread = |moments: [f64; 3]| {
            let I = pose.rotation() * Matrix3::from_diagonal(&moments.into()) * pose.rotation().transpose();
            Inertia::new(1.0, *pose.translation(), [I.m11, I.m12, I.m13, I.m22, I.m23, I.m33])
        };
        prop_assert!(spread([a, b, a + b]).is_ok(), "a plate exists");
        prop_assert!(spread([0.0, b, b]).is_ok(), "a rod exists");
        for moments in [[a, b, a + b + excess], [a, a + b + excess, b], [a, b, -excess]] {
            let refused = spread(moments).unwrap_err();
            let ModelError::ImpossibleInertia { principal } = refused else { return Err(TestCaseError::fail("accepted")) };
            prop_assert!((principal[2] - a - b - excess).abs() < 1e-9 || (principal[0] + excess).abs() < 1e-9);
            assert_says(&refused, &["belong to no body", "none exceeds the sum", "about the centre of mass"]);
        }
    }

    #[test]
    fn a_real_body_is_accepted_from_anywhere(body in body(0.0), from in pose()) {
        let seen = body.seen_from(&from);
        prop_assert!((seen.mass() - body.mass()).abs() == 0.0);
        let there = from.rotation() * body.first_moment() + body.mass() * from.translation();
        prop_assert!((seen.first_moment() - there).amax() <= 1e-14 * (1.0 + body.mass()));
        let back = seen.seen_from(&from.inverse());
        for (a, b) in back.parameters().into_iter().zip(body.parameters()) {
            prop_assert!((a - b).abs() <= 1e-13 * (1.0 + body.mass()), "{a} and {b}");
        }
    }

    #[test]
    fn dependent_columns_are_refused(column in proptest::collection::vec(-2.0..2.0, 2..=MAX_JOINTS), factor in -3.0..3.0) {
        let matrix: Vec<f64> = column.iter().flat_map(|c| [*c, factor * c]).collect();
        let refused = Coupling::new(&matrix, &vec![0.0; column.len()], 2);
        prop_assert_eq!(refused, Err(ModelError::CouplingRank));
    }

    #[test]
    fn a_joint_frame_has_its_axis_for_z(axis in axis(), length in 1e-3..1e3_f64) {
        let frame = frame_with_z(&(length * axis)).expect("a direction");
        prop_assert!((frame.rotation().column(2) - axis).amax() <= 1e-15);
        prop_assert!(Pose::new(*frame.rotation(), Vector3::zeros(), "joint").is_ok());
    }
}
