//! Motors and coordinates: q = C m + c₀, τ_motor = Cᵀ τ, both ways.

use crate::arms::joints;
use crate::scale::{cases, close};
use gravcomp::{Joints, MAX_JOINTS, ModelError, Transmission};
use nalgebra::DMatrix;
use proptest::collection::vec;
use proptest::prelude::*;

/// C and c₀ of 1 to 16 motors; the diagonal outweighs the rest of its row, so that C can be inverted.
#[derive(Clone, Debug)]
struct Gears {
    C: DMatrix<f64>,
    offset: Vec<f64>,
}

fn gears() -> impl Strategy<Value = Gears> {
    (1..=MAX_JOINTS, vec(-1.0..1.0, MAX_JOINTS * MAX_JOINTS), vec(-3.0..3.0, MAX_JOINTS)).prop_map(
        |(n, mix, offset)| {
            let gear = |i: usize| if mix[i] < 0.0 { -1.5 } else { 2.5 };
            let entry = |i: usize, j: usize| if i == j { gear(i) } else { mix[MAX_JOINTS * i + j] / 16.0 };
            Gears { C: DMatrix::from_fn(n, n, entry), offset: offset[..n].to_vec() }
        },
    )
}

impl Gears {
    fn row_major(&self) -> Vec<f64> {
        self.C.transpose().as_slice().to_vec()
    }

    fn checked(&self) -> Transmission {
        Transmission::new(&self.row_major(), &self.offset).expect("C can be inverted")
    }
}

/// Exchanging rows does not make a matrix singular: the elimination looks for its pivots.
fn exchanged(gears: &Gears) -> Gears {
    let n = gears.offset.len();
    Gears { C: DMatrix::from_fn(n, n, |i, j| gears.C[((i + 1) % n, j)]), ..gears.clone() }
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn positions_go_there_and_back(gears in gears(), m in joints(3.0)) {
        for gears in [exchanged(&gears), gears] {
            let (transmission, n) = (gears.checked(), gears.offset.len());
            let q = transmission.joint_positions(&m);
            let wanted = &gears.C * nalgebra::DVector::from_column_slice(&m[..n]) + nalgebra::DVector::from_vec(gears.offset);
            close("q", &q[..n], wanted.as_slice(), 1e-13)?;
            close("m", &transmission.motor_positions(&q)[..n], &m[..n], 1e-12)?;
            prop_assert_eq!(transmission.motors(), n);
        }
    }

    #[test]
    fn efforts_go_there_and_back_and_power_stays(gears in gears(), m in joints(3.0), tau in joints(50.0)) {
        for gears in [exchanged(&gears), gears] {
            let (transmission, n) = (gears.checked(), gears.offset.len());
            let tau_motor = transmission.motor_efforts(&tau);
            close("tau", &transmission.joint_efforts(&tau_motor)[..n], &tau[..n], 1e-11)?;
            let [moved, zero] = [m, Joints::default()].map(|m| transmission.joint_positions(&m));
            let spent: f64 = (0..n).map(|i| tau_motor[i] * m[i]).sum();
            let power: f64 = (0..n).map(|i| tau[i] * (moved[i] - zero[i])).sum();
            close("power", &[spent], &[power], 1e-10)?;
        }
    }

    #[test]
    fn motors_that_move_the_joints_alike_are_refused(gears in gears(), factor in -2.0..2.0) {
        let n = gears.offset.len();
        prop_assume!(n > 1);
        let mut alike = gears;
        let twin = factor * alike.C.column(0);
        alike.C.set_column(n - 1, &twin);
        let refused = Transmission::new(&alike.row_major(), &alike.offset).unwrap_err();
        prop_assert_eq!(refused, ModelError::TransmissionSingular);
        prop_assert!(refused.to_string().contains("two motors move the joints alike"), "{}", refused);
    }
}

#[test]
fn a_transmission_is_square() {
    for (entries, motors) in [(0, 0), (1, 0), (2, 1), (3, 2), (289, 17)] {
        let refused = Transmission::new(&vec![1.0; entries], &vec![0.0; motors]).unwrap_err();
        assert_eq!(refused, ModelError::TransmissionShape { entries, motors });
        assert!(refused.to_string().contains("it is square, with 1 to 16 motors"), "{refused}");
    }
}

#[test]
fn a_transmission_is_finite() {
    for (gear, offset) in [(f64::NAN, 0.0), (1.0, f64::INFINITY)] {
        let refused = Transmission::new(&[gear], &[offset]).unwrap_err();
        assert_eq!(refused, ModelError::NotFinite { field: "transmission" });
    }
}
