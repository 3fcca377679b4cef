//! Manipulability is √det(T Tᵀ) of the Jacobian's rows, its gradient is how that changes, and a step that climbs it keeps to the
//! box and to the floor under its progress.

use crate::arms::{arms, states};
use crate::builds::PORTABLE;
use crate::scale::{cases, moved, unit};
use gravcomp::box_qp::{Active, Outcome, ROWS};
use gravcomp::manipulability::{Ascent, Manipulability, Projection, Step};
use gravcomp::{Frame, JacobianAxes, Joints, MAX_JOINTS, Robot};
use nalgebra::{DMatrix, Matrix3, SMatrix};
use proptest::prelude::*;

type Found = Manipulability<MAX_JOINTS>;
type Rows = [[f64; 8]; ROWS];
type Limits = ([f64; 8], [f64; 8]);

/// The function of every build that this processor can run.
fn manipulability(robot: &Robot, q: &Joints, frame: &Frame, P: &Projection) -> Vec<Found> {
    let mut found = vec![gravcomp::portable::manipulability(robot, q, frame, P)];
    #[cfg(target_arch = "x86_64")]
    if std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma") {
        // SAFETY: the processor has what the function was compiled for.
        found.push(unsafe { gravcomp::avx2::manipulability(robot, q, frame, P) });
    }
    found
}

fn ascend(T: &Rows, v: &[f64; ROWS], gradient: &[f64; 8], ascent: Ascent, limits: Limits) -> Vec<Step<8>> {
    let warm = [Active::default(); 2];
    let mut found = vec![gravcomp::portable::ascend(T, v, gradient, ascent, limits, warm)];
    #[cfg(target_arch = "x86_64")]
    if std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma") {
        // SAFETY: the processor has what the function was compiled for.
        found.push(unsafe { gravcomp::avx2::ascend(T, v, gradient, ascent, limits, warm) });
    }
    found
}

/// What a task takes of the twist: all of it, the position, or the position and where the frame's z axis points.
#[derive(Clone, Copy, Debug)]
enum Task {
    Twist,
    Position,
    Pointing,
}

impl Task {
    fn projection(self, robot: &Robot, q: &Joints, frame: &Frame) -> Projection {
        match self {
            Self::Twist => Projection::TWIST,
            Self::Position => Projection::POSITION,
            Self::Pointing => {
                let pose = (PORTABLE.forward_kinematics)(robot, q, frame);
                let R: Matrix3<f64> = pose.fixed_view::<3, 3>(0, 0).into_owned();
                let mut P = Projection { count: 5, ..Projection::POSITION };
                for k in 0..2 {
                    P.rows[3 + k][3..].copy_from_slice(R.column(k).as_slice());
                }
                P
            }
        }
    }
}

/// T = P J over the coordinates.
fn rows(robot: &Robot, q: &Joints, frame: &Frame, P: &Projection) -> DMatrix<f64> {
    let J = PORTABLE.jacobian(robot, q, frame, JacobianAxes::Base);
    let P = DMatrix::from_fn(P.count, 6, |k, r| P.rows[k][r]);
    P * DMatrix::from_fn(6, robot.coordinates(), |r, j| J[j][r])
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn it_is_the_root_of_the_determinant_and_its_gradient_the_difference(
        arm in arms(),
        state in states(),
        task in prop_oneof![Just(Task::Twist), Just(Task::Position), Just(Task::Position), Just(Task::Pointing)],
    ) {
        let robot = arm.build();
        let (q, tool) = (state.q, *robot.tool());
        let P = task.projection(&robot, &q, &tool);
        let T = rows(&robot, &q, &tool, &P);
        let value = (&T * T.transpose()).determinant().max(0.0).sqrt();
        let singular = T.singular_values();
        let clear = T.ncols() >= T.nrows() && singular.min() > 0.05 * singular.max();
        for found in manipulability(&robot, &q, &tool, &P) {
            prop_assert!(found.value >= 0.0);
            prop_assert!(found.gradient[robot.coordinates()..].iter().all(|x| *x == 0.0));
            if !clear {
                prop_assert!(found.gradient.iter().all(|x| x.is_finite()));
                continue;
            }
            prop_assert!((found.value - value).abs() <= 1e-9 * value);
            let size = found.gradient.iter().fold(value, |size, x| size.max(x.abs()));
            for j in 0..robot.coordinates() {
                let at = |h: f64| {
                    let q = moved(&q, h, &unit(j));
                    manipulability(&robot, &q, &tool, &task.projection(&robot, &q, &tool))[0].value
                };
                let difference = (8.0 * (at(1e-3) - at(-1e-3)) - (at(2e-3) - at(-2e-3))) / 12e-3;
                prop_assert!((found.gradient[j] - difference).abs() < 1e-6 * size, "{j}: {} or {difference}", found.gradient[j]);
            }
        }
    }

    /// Whatever is to be climbed; and as theirs where no floor is set.
    #[test]
    fn an_ascent_keeps_to_the_box_and_to_its_floor(
        T in proptest::array::uniform6(proptest::array::uniform8(-1.0..1.0)),
        v in proptest::array::uniform6(-2.0..2.0),
        gradient in proptest::array::uniform8(-0.3..0.3),
        rate in proptest::array::uniform8(0.1..2.0),
        progress in 0.0..1.0,
    ) {
        let limits = (rate.map(|x: f64| -x), rate);
        let going = |x: &[f64; 8]| -> f64 {
            let T = SMatrix::<f64, 6, 8>::from_fn(|k, i| T[k][i]);
            (T * nalgebra::SVector::from(*x)).dot(&nalgebra::SVector::from(v))
        };
        let settings = Ascent { effort: 0.01, slack: 2.0, progress };
        let alone = ascend(&T, &v, &[0.0; 8], settings, limits);
        for (step, alone) in ascend(&T, &v, &gradient, settings, limits).iter().zip(alone) {
            prop_assert_eq!(step.outcome, Outcome::Solved);
            prop_assert!((0..8).all(|i| step.x[i].abs() <= rate[i]));
            prop_assert!(going(&step.x) >= progress * going(&alone.x) - 1e-9);
        }
        for free in ascend(&T, &v, &gradient, Ascent { progress: 0.0, ..settings }, limits) {
            prop_assert!(free.restrained == 0.0 || going(&free.x).abs() < 1e-9);
        }
    }
}

#[test]
fn what_is_no_number_stays_at_rest() {
    let still = [[0.0; 8]; ROWS];
    for bad in [f64::NAN, f64::INFINITY] {
        for step in ascend(&still, &[bad; ROWS], &[bad; 8], Ascent::towards(bad), ([-1.0; 8], [1.0; 8])) {
            assert_eq!((step.outcome, step.x), (Outcome::Refused, [0.0; 8]));
        }
    }
}
