//! Manipulability: how far a frame is from where a direction is lost, and which way it grows.
//!
//! > m = √det(T Tᵀ), T = P J
//!
//! T. Yoshikawa, "Manipulability of robotic mechanisms", IJRR 4(2), 1985, for a task of k ≤ 6 rows P of the frame's twist.
//!
//! # The gradient without a Hessian
//! ∂m/∂qⱼ = m Σᵢ (bᵢ · ∂vᵢ/∂qⱼ + cᵢ · ∂ωᵢ/∂qⱼ), with the columns (vᵢ, ωᵢ) of J and (bᵢ, cᵢ) of Pᵀ (T Tᵀ)⁻¹ T. Seen from the frame,
//! joint j moves only what is nearer to the base than itself, i < j: there ∂vᵢ/∂qⱼ = ωᵢ × vⱼ − ωⱼ × vᵢ and ∂ωᵢ/∂qⱼ = −ωⱼ × ωᵢ.
//! With the triple products turned round, two running sums serve all joints:
//!
//! > ∂m/∂qⱼ = m (vⱼ · Σ_{i<j} bᵢ × ωᵢ − ωⱼ · Σ_{i<j} (vᵢ × bᵢ + ωᵢ × cᵢ))
//!
//! Triple products are the same in all axes, so J may be written in those of the base. P must be constant in those of the frame;
//! the whole twist and its linear or angular half alone are constant in any.

use crate::box_qp::{Active, Outcome, Problem, ROWS, between, solve, sum};
use crate::coupling::Coupling;
use crate::kinematics::{chain, column_of};
use crate::lanes::{Lanes, Vec3, cross, dot};
use crate::motion::JointsNow;
use crate::robot::{Frame, Robot};
use nalgebra::{ComplexField, Vector3};

/// A pivot of T Tᵀ is zero below this part of its diagonal: a direction is lost.
const LOST: f64 = 1e-14;

/// Rows of a task, or of a Jacobian: one number per joint or coordinate, as many places as there are lanes.
pub(crate) type Rows<const N: usize> = [[f64; N]; ROWS];

/// P, k × 6: what a task takes of the twist, in base axes. Rows beyond the task are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// P, row by row.
    pub rows: [[f64; 6]; ROWS],
    /// k: rows of the task.
    pub count: usize,
}

impl Projection {
    /// The whole twist.
    pub const TWIST: Self = Self::first(6);
    /// The velocity of the frame's origin.
    pub const POSITION: Self = Self::first(3);

    /// The first `count` rows of the twist.
    #[must_use]
    pub const fn first(count: usize) -> Self {
        let mut rows = [[0.0; 6]; ROWS];
        let mut k = 0;
        while k < count && k < ROWS {
            rows[k][k] = 1.0;
            k += 1;
        }
        Self { rows, count: k }
    }
}

/// Manipulability and how it changes with each coordinate. Entries beyond the robot's own are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Manipulability<const N: usize> {
    /// m ≥ 0.
    pub value: f64,
    /// ∂m/∂q; zero where m is.
    pub gradient: [f64; N],
}

/// The columns of the mechanism's Jacobian of `frame` in base axes, before a coupling; zero where a joint does not carry it.
#[inline(always)]
pub(crate) fn mechanism_jacobian<const N: usize, const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<'_, 1, FUSED>,
    frame: &Frame,
) -> Rows<N> {
    let mut J = [[0.0; N]; ROWS];
    let Some(body) = frame.body() else { return J };
    let (mut axis, mut origin) = ([Lanes::ZERO; N], [Lanes::ZERO; N]);
    let tip = chain(robot, now, (frame, body), &mut axis, &mut origin);
    for i in 0..robot.bodies().min(N) {
        let [v, w] = column_of(robot, body, i, (&axis, &origin), &tip);
        for k in 0..3 {
            (J[k][i], J[k + 3][i]) = (v.0[k], w.0[k]);
        }
    }
    J
}

/// m and ∂m/∂q of the task P from the mechanism's Jacobian J.
#[inline(always)]
pub(crate) fn manipulability<const N: usize, const FUSED: bool>(
    J: &Rows<N>,
    coupling: Option<&Coupling>,
    P: &Projection,
) -> Manipulability<N> {
    let T = coupled::<N, FUSED>(&projected::<N, FUSED>(J, P), coupling);
    let Some((value, solved)) = solved::<N, FUSED>(&T, P.count) else {
        return Manipulability { value: 0.0, gradient: [0.0; N] };
    };
    let B = uncoupled::<N, FUSED>(&unprojected(&solved, P), coupling);
    let gradient = gradient::<N, FUSED>(value, J, &B);
    Manipulability { value, gradient: lowered(&gradient, coupling) }
}

/// The running sums of the module's formula.
#[inline(always)]
fn gradient<const N: usize, const FUSED: bool>(m: f64, J: &Rows<N>, B: &Rows<N>) -> [f64; N] {
    let zero: Vec3<1, FUSED> = Vector3::from_element(Lanes::ZERO);
    let (mut turned, mut moved) = (zero, zero);
    let mut gradient = [0.0; N];
    for j in 0..N {
        let (v, w) = twist::<N, FUSED>(J, j);
        let (b, c) = twist::<N, FUSED>(B, j);
        gradient[j] = m * (dot(&v, &turned) - dot(&w, &moved)).0[0];
        turned += cross(&b, &w);
        moved += cross(&v, &b) + cross(&w, &c);
    }
    gradient
}

/// Column j: its linear and angular part.
#[inline(always)]
fn twist<const N: usize, const FUSED: bool>(rows: &Rows<N>, j: usize) -> (Vec3<1, FUSED>, Vec3<1, FUSED>) {
    let part = |k: usize| Vector3::new(Lanes([rows[k][j]]), Lanes([rows[k + 1][j]]), Lanes([rows[k + 2][j]]));
    (part(0), part(3))
}

/// P J.
#[inline(always)]
fn projected<const N: usize, const FUSED: bool>(J: &Rows<N>, P: &Projection) -> Rows<N> {
    let mut T = [[0.0; N]; ROWS];
    for k in 0..P.count.min(ROWS) {
        let mut row = Lanes::<N, FUSED>::ZERO;
        for (p, j) in P.rows[k].iter().zip(J) {
            row = Lanes(*j).mul_add(Lanes::splat(*p), row);
        }
        T[k] = row.0;
    }
    T
}

/// Pᵀ B.
#[inline(always)]
fn unprojected<const N: usize, const FUSED: bool>(B: &[Lanes<N, FUSED>; ROWS], P: &Projection) -> Rows<N> {
    let mut rows = [Lanes::<N, FUSED>::ZERO; ROWS];
    for k in 0..P.count.min(ROWS) {
        for (row, p) in rows.iter_mut().zip(P.rows[k]) {
            *row = B[k].mul_add(Lanes::splat(p), *row);
        }
    }
    let mut plain = [[0.0; N]; ROWS];
    for k in 0..ROWS {
        plain[k] = rows[k].0;
    }
    plain
}

/// T C: rows over coordinates from rows over the mechanism's joints.
#[inline(always)]
fn coupled<const N: usize, const FUSED: bool>(T: &Rows<N>, coupling: Option<&Coupling>) -> Rows<N> {
    let Some(coupling) = coupling else { return *T };
    let mut rows = [[0.0; N]; ROWS];
    for (row, T) in rows.iter_mut().zip(T) {
        *row = lowered(T, Some(coupling));
    }
    rows
}

/// B Cᵀ: rows over the mechanism's joints from rows over coordinates.
#[inline(always)]
fn uncoupled<const N: usize, const FUSED: bool>(B: &Rows<N>, coupling: Option<&Coupling>) -> Rows<N> {
    let Some(coupling) = coupling else { return *B };
    let mut rows = [[0.0; N]; ROWS];
    for (row, B) in rows.iter_mut().zip(B) {
        for (b, column) in B.iter().zip(coupling.columns()) {
            for (x, c) in row.iter_mut().zip(column) {
                *x = Lanes::<1, FUSED>([*b]).mul_add(Lanes([*c]), Lanes([*x])).0[0];
            }
        }
    }
    rows
}

/// Cᵀ x.
#[inline(always)]
fn lowered<const N: usize>(x: &[f64; N], coupling: Option<&Coupling>) -> [f64; N] {
    let Some(coupling) = coupling else { return *x };
    let mut lowered = [0.0; N];
    for (sum, column) in lowered.iter_mut().zip(coupling.columns()) {
        for (x, c) in x.iter().zip(column) {
            *sum += c * x;
        }
    }
    lowered
}

/// √det(T Tᵀ) and (T Tᵀ)⁻¹ T of the first `count` rows, by T Tᵀ = L D Lᵀ; `None` where they are dependent.
#[inline(always)]
fn solved<const N: usize, const FUSED: bool>(T: &Rows<N>, count: usize) -> Option<(f64, [Lanes<N, FUSED>; ROWS])> {
    let (k, mut L, mut D, mut determinant) = (count.min(ROWS), [[0.0; ROWS]; ROWS], [0.0; ROWS], 1.0);
    // Rows made orthogonal to those before them are L⁻¹ T; their squares are D.
    let mut X = [Lanes::<N, FUSED>::ZERO; ROWS];
    for i in 0..k {
        X[i] = Lanes(T[i]);
    }
    for i in 0..k {
        let (square, whole) = (sum(X[i] * X[i]), sum(Lanes::<N, FUSED>(T[i]) * Lanes(T[i])));
        if square.is_nan() || square <= LOST * whole {
            return None;
        }
        determinant *= square;
        D[i] = 1.0 / square;
        for j in i + 1..k {
            L[j][i] = sum(X[j] * X[i]) * D[i];
            X[j] = X[i].neg_mul_add(Lanes::splat(L[j][i]), X[j]);
        }
    }
    for i in (0..k).rev() {
        X[i] *= Lanes::splat(D[i]);
        for j in i + 1..k {
            X[i] = X[j].neg_mul_add(Lanes::splat(L[j][i]), X[i]);
        }
    }
    let value = ComplexField::sqrt(determinant);
    value.is_finite().then_some((value, X))
}

/// How a task is traded for manipulability.
///
/// J. Haviland, P. Corke, "A purely-reactive manipulability-maximising motion controller", arXiv 2002.11901, 2020, with a floor
/// under the progress. Without it, with [`Ascent::progress`] 0, theirs stops for good wherever the way uphill outweighs the task.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ascent {
    /// Y > 0: what rates cost. The smaller, the faster uphill. Theirs is 0.01.
    pub effort: f64,
    /// 1/e > 0: what departing from the task costs; e is how far the goal is, Σ|error|.
    pub slack: f64,
    /// 0 to 1: of the way that the task alone would go in a step, this much is gone whatever manipulability says.
    pub progress: f64,
}

impl Ascent {
    /// Towards a goal at the distance e: the task binds the more the nearer the goal is.
    #[must_use]
    pub fn towards(distance: f64) -> Self {
        Self { effort: 0.003, slack: 1.0 / distance.max(1e-6), progress: 0.5 }
    }
}

/// The rates of a step, and the bounds that hold them: a warm start for the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step<const N: usize> {
    /// Finite and in the box, if there is one.
    pub x: [f64; N],
    /// The bounds of the ascent, and those of the task alone.
    pub active: [Active; 2],
    /// 0 to 1: how much of the ascent was given up for progress.
    pub restrained: f64,
    /// The larger of [`crate::box_qp::Solution::residual`].
    pub residual: f64,
    /// How the two problems ended: the worse of them.
    pub outcome: Outcome,
}

/// Rates x of a task T x = v that climb `gradient`, in the box.
///
/// Their programme is in (x, δ): minimise ½ Y |x|² + ½ (1/e) |δ|² − ∂m·x subject to T x + δ = v and the limits of x. With
/// δ = v − T x put in, it is ½ Y |x − ∂m/Y|² + ½ (1/e) |T x − v|² in the box of x: as many variables as joints, no equations. (Their
/// bound of 10 on δ is not reached at limited rates.) A mean of its solution and of that of the task alone keeps to the box.
#[inline(always)]
pub(crate) fn ascend<const N: usize, const FUSED: bool>(
    T: &Rows<N>,
    v: &[f64; ROWS],
    gradient: &[f64; N],
    ascent: Ascent,
    (lower, upper): ([f64; N], [f64; N]),
    warm: [Active; 2],
) -> Step<N> {
    let alone = Problem {
        rows: *T,
        target: *v,
        row_weight: [ascent.slack; ROWS],
        wish: [0.0; N],
        weight: [ascent.effort; N],
        lower,
        upper,
    };
    let mut uphill = alone;
    for i in 0..N {
        uphill.wish[i] = gradient[i] / ascent.effort;
    }
    let (up, task) = (solve::<N, FUSED>(&uphill, warm[0]), solve::<N, FUSED>(&alone, warm[1]));
    let restrained = restraint(progress::<N, FUSED>(T, v, &up.x), progress::<N, FUSED>(T, v, &task.x), ascent.progress);
    let mut x = up.x;
    for i in 0..N {
        x[i] += restrained * (task.x[i] - up.x[i]);
        x[i] = between(x[i], lower[i], upper[i]);
    }
    let outcome = if up.outcome == Outcome::Solved { task.outcome } else { up.outcome };
    Step { x, active: [up.active, task.active], restrained, residual: up.residual.max(task.residual), outcome }
}

/// How much of the ascent to give up: with this part of the task alone, the step goes `floor` of its way. Both ways are linear
/// in the rates.
#[inline(always)]
fn restraint(up: f64, task: f64, floor: f64) -> f64 {
    let (missing, gained) = (floor * task - up, task - up);
    if missing > 0.0 && gained > 0.0 { (missing / gained).min(1.0) } else { 0.0 }
}

/// v · T x: how far x goes along the task.
#[inline(always)]
fn progress<const N: usize, const FUSED: bool>(T: &Rows<N>, v: &[f64; ROWS], x: &[f64; N]) -> f64 {
    let mut pull = Lanes::<N, FUSED>::ZERO;
    for (row, v) in T.iter().zip(v) {
        pull = Lanes(*row).mul_add(Lanes::splat(*v), pull);
    }
    sum(pull * Lanes(*x))
}
