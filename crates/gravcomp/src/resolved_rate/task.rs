//! The rows of a task: how the joints move what is to be moved, and how fast that should move.
//!
//! A task is three linear rows and three more, each a functional of the frame's motion; rows it has not are zeros.

use super::factor::{Matrix, ROWS};
use super::settings::{Settings, Task};
use crate::kinematics::Axes;
use crate::lanes::{Lanes, keep_lanes};
use crate::manipulability::Projection;
use nalgebra::{ComplexField, Vector3};

/// Three numbers and a zero.
pub(super) type Vector<const FUSED: bool> = Lanes<4, FUSED>;

/// Six rows, or a motion: linear, then angular.
pub(super) type Six<const FUSED: bool> = [Vector<FUSED>; 2];

/// A Jacobian by columns.
pub(super) type Columns<const N: usize, const FUSED: bool> = [Six<FUSED>; N];

/// What of a task is the same at every pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    task: Task,
    /// 1/L where the row is there, else 0.
    linear: [f64; 4],
    /// 1 where the row is there, else 0.
    angular: [f64; 4],
    /// 1 where a row is not there, else 0.
    pub absent: [f64; ROWS],
    /// J Jᵀ without any joint: those on the diagonal.
    pub empty: Matrix<false>,
    /// The pointing axis and two across it, in the frame's axes.
    pub axis: [f64; 3],
    across: [[f64; 3]; 2],
    /// 1/L
    scale: f64,
    /// Rows that are there.
    pub rows: usize,
}

impl Shape {
    /// Of a task that was checked.
    pub(super) fn of(settings: &Settings) -> Self {
        let there = match settings.task {
            Task::Twist => settings.rows,
            Task::Position => [true, true, true, false, false, false],
            Task::Pointing | Task::RemoteCentre => [true, true, true, true, true, false],
        };
        let ones = there.map(|there| if there { 1.0 } else { 0.0 });
        let scale = 1.0 / settings.characteristic_length;
        let [x, y, z, u, v, w] = ones;
        let axis = settings.pointing_axis.normalize();
        let first = axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize();
        Self {
            task: settings.task,
            linear: [x * scale, y * scale, z * scale, 0.0],
            angular: [u, v, w, 0.0],
            absent: ones.map(|one| 1.0 - one),
            empty: Matrix::diagonal(ones.map(|one| 1.0 - one)),
            axis: axis.into(),
            across: [first.into(), axis.cross(&first).into()],
            scale,
            rows: there.iter().filter(|&&there| there).count(),
        }
    }
}

/// What a task makes of a motion: linear rows in units of the characteristic length, and what the other rows are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rows<const FUSED: bool> {
    task: Task,
    linear: Vector<FUSED>,
    angular: Vector<FUSED>,
    /// M, by columns: the other rows are M w, or M times the motion of a point of the shaft.
    further: [Vector<FUSED>; 3],
    /// h z: from the tip to the shaft's point nearest the trocar.
    shaft: Vector<FUSED>,
}

impl<const FUSED: bool> Rows<FUSED> {
    /// With the tip where it is, and the trocar.
    #[inline(always)]
    pub(super) fn at(shape: &Shape, tip: &Axes<FUSED>, trocar: Vector<FUSED>) -> Self {
        let mut rows = Self {
            task: shape.task,
            linear: Lanes(shape.linear),
            angular: Lanes(shape.angular),
            further: [Lanes::ZERO; 3],
            shaft: Lanes::ZERO,
        };
        match shape.task {
            Task::Twist | Task::Position => {}
            Task::Pointing => rows.further = across(shape, tip, 1.0),
            Task::RemoteCentre => {
                let axis = tip.rotate(shape.axis);
                rows.shaft = axis * Lanes::splat(axis.dot(trocar - tip.origin));
                rows.further = across(shape, tip, shape.scale);
            }
        }
        rows
    }

    /// From the tip to the shaft's point nearest the trocar, m.
    #[inline(always)]
    pub(super) fn shaft(&self) -> Vector<FUSED> {
        self.shaft
    }

    /// How far along the shaft that is, m.
    #[inline(always)]
    pub(super) fn depth(&self) -> f64 {
        ComplexField::sqrt(self.shaft.dot(self.shaft))
    }

    /// The task's velocity: of the frame's linear motion, and of its angular motion or that of the trocar.
    #[inline(always)]
    pub(super) fn velocity(&self, [linear, second]: Six<FUSED>) -> Six<FUSED> {
        let further = match self.task {
            Task::Twist | Task::Position => self.angular * second,
            Task::Pointing | Task::RemoteCentre => self.map(second),
        };
        [self.linear * linear, further]
    }

    /// What the task has of a column of the frame's Jacobian.
    #[inline(always)]
    pub(super) fn column(&self, [linear, angular]: Six<FUSED>) -> Six<FUSED> {
        let further = match self.task {
            Task::Twist | Task::Position => self.angular * angular,
            Task::Pointing => self.map(angular),
            Task::RemoteCentre => self.map(linear + angular.cross(self.shaft)),
        };
        [self.linear * linear, further]
    }

    /// What the task takes of the frame's twist, in base axes.
    #[inline(always)]
    pub(super) fn projection(&self, count: usize) -> Projection {
        let mut rows = [[0.0; 6]; ROWS];
        for r in 0..3 {
            rows[r][r] = self.linear.0[r];
            for c in 0..3 {
                rows[r + 3][c + 3] = match self.task {
                    Task::Twist | Task::Position if r == c => self.angular.0[r],
                    Task::Twist | Task::Position => 0.0,
                    Task::Pointing | Task::RemoteCentre => self.further[c].0[r],
                };
            }
        }
        Projection { rows, count }
    }

    /// M v, three products.
    #[inline(always)]
    fn map(&self, v: Vector<FUSED>) -> Vector<FUSED> {
        let [x, y, z, _] = v.0;
        self.further[0].mul_add(x.into(), self.further[1].mul_add(y.into(), self.further[2] * z.into()))
    }
}

/// Two rows across the pointing axis, by columns.
#[inline(always)]
fn across<const FUSED: bool>(shape: &Shape, tip: &Axes<FUSED>, scale: f64) -> [Vector<FUSED>; 3] {
    let [first, second] = shape.across;
    let (first, second) = (tip.rotate(first) * scale.into(), tip.rotate(second) * scale.into());
    let mut columns = [Lanes::ZERO; 3];
    for l in 0..3 {
        columns[l] = Lanes([first.0[l], second.0[l], 0.0, 0.0]);
    }
    columns
}

/// J Jᵀ, with ones in place of the rows that are not there.
#[inline(always)]
pub(super) fn of_rows<const FUSED: bool>(columns: &[Six<FUSED>], shape: &Shape) -> Matrix<FUSED> {
    let mut matrix = Matrix::like(&shape.empty);
    for [linear, further] in columns {
        for r in 0..3 {
            let (l, f) = (linear.0[r].into(), further.0[r].into());
            matrix.upper[r] = linear.mul_add(l, matrix.upper[r]);
            matrix.lower[r] = further.mul_add(l, matrix.lower[r]);
            matrix.lower[r + 3] = further.mul_add(f, matrix.lower[r + 3]);
        }
    }
    keep_lanes(&mut matrix);
    matrix
}

/// Jᵀ J of fewer coordinates than rows, with ones beyond them.
#[inline(always)]
pub(super) fn of_coordinates<const N: usize, const FUSED: bool>(
    columns: &Columns<N, FUSED>,
    n: usize,
) -> Matrix<FUSED> {
    let mut matrix = Matrix::diagonal([1.0; ROWS]);
    for i in 0..n.min(N).min(ROWS) {
        for j in 0..=i {
            matrix.set(i, j, product(&columns[i], &columns[j]));
        }
    }
    matrix
}

/// The product of two columns, or of a column and what belongs to the rows.
#[inline(always)]
pub(super) fn product<const FUSED: bool>(a: &Six<FUSED>, b: &Six<FUSED>) -> f64 {
    let [x, y, z, _] = a[0].mul_add(b[0], a[1] * b[1]).0;
    x + y + z
}

/// Jᵀ y, all joints side by side: the last row first, as y comes from a solution that knows its last number first.
#[inline(always)]
pub(super) fn products<const N: usize, const FUSED: bool>(columns: &Columns<N, FUSED>, y: &Six<FUSED>) -> [f64; N] {
    let ([x, y, z, _], [u, v, w, _]) = (y[0].0, y[1].0);
    let (rows, y) = (by_rows(columns), [x, y, z, u, v, w]);
    let mut products = Lanes::<N, FUSED>::ZERO;
    for r in (0..ROWS).rev() {
        products = Lanes(rows[r]).mul_add(y[r].into(), products);
    }
    products.0
}

/// The columns as rows.
#[inline(always)]
pub(super) fn by_rows<const N: usize, const FUSED: bool>(columns: &Columns<N, FUSED>) -> [[f64; N]; ROWS] {
    let mut rows = [[0.0; N]; ROWS];
    for j in 0..N {
        for r in 0..3 {
            (rows[r][j], rows[r + 3][j]) = (columns[j][0].0[r], columns[j][1].0[r]);
        }
    }
    rows
}
