//! Newton and Euler on a base that moves: inverse dynamics, base wrench, mass matrix, forward dynamics.
//!
//! The recursion starts at the root with the base's own motion (Luh, Walker & Paul 1980 with a moving root): its specific
//! force f₀ = a₀ − g takes the place of gravity, its ω and dω that of a base at rest. Everything is expressed in the axes of
//! the body it belongs to, wrenches act at the body's origin.

use crate::constants::MAX_JOINTS;
use crate::kinematics::Seat;
use crate::lanes::{Lanes, Vec3, cross, dot, rotate, rotate_add, scale, splat3};
use crate::motion::{JointsNow, PerJoint, to_coordinates};
use crate::robot::Robot;
use crate::spatial::Inertia;
use crate::sweep;
use core::ops::AddAssign;
use nalgebra::{ComplexField, Matrix3, Vector3};

/// Angular velocity w, angular acceleration dw and specific force f of a frame's origin, in the frame's axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion<const W: usize, const FUSED: bool> {
    pub w: Vec3<W, FUSED>,
    pub dw: Vec3<W, FUSED>,
    pub f: Vec3<W, FUSED>,
}

impl<const W: usize, const FUSED: bool> Motion<W, FUSED> {
    /// `(S(dw) + S(w)²) r`: how much more a point at r accelerates than the origin, dw × r + w × (w × r).
    #[inline(always)]
    pub fn relative(&self) -> Relative<W, FUSED> {
        let (w, dw) = (&self.w, &self.dw);
        let (xx, yy, zz) = (w.x * w.x, w.y * w.y, w.z * w.z);
        let (xy, xz, yz) = (w.x * w.y, w.x * w.z, w.y * w.z);
        Relative {
            x: Vector3::new(-(yy + zz), xy - dw.z, xz + dw.y),
            y: Vector3::new(xy + dw.z, -(xx + zz), yz - dw.x),
            z: Vector3::new(xz - dw.y, yz + dw.x, -(xx + yy)),
        }
    }
}

/// The matrix `S(dw) + S(w)²`, row by row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Relative<const W: usize, const FUSED: bool> {
    x: Vec3<W, FUSED>,
    y: Vec3<W, FUSED>,
    z: Vec3<W, FUSED>,
}

impl<const W: usize, const FUSED: bool> Relative<W, FUSED> {
    /// The matrix times r, plus f.
    #[inline(always)]
    pub fn at(&self, r: &Vec3<W, FUSED>, f: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
        let row =
            |row: &Vec3<W, FUSED>, f: Lanes<W, FUSED>| row.x.mul_add(r.x, row.y.mul_add(r.y, row.z.mul_add(r.z, f)));
        Vector3::new(row(&self.x, f.x), row(&self.y, f.y), row(&self.z, f.z))
    }
}

/// A force and a moment at the same point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wrench<const W: usize, const FUSED: bool> {
    pub force: Vec3<W, FUSED>,
    pub moment: Vec3<W, FUSED>,
}

impl<const W: usize, const FUSED: bool> Wrench<W, FUSED> {
    pub const ZERO: Self = {
        let zero = Vector3::new(Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);
        Self { force: zero, moment: zero }
    };
}

impl<const W: usize, const FUSED: bool> AddAssign for Wrench<W, FUSED> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.force += other.force;
        self.moment += other.moment;
    }
}

/// What the rigid body with mass m, first moment h and second moment I about the origin needs to move so.
///
/// F = m f + dw × h + w × (w × h),  N = h × f + I dw + w × (I w).
#[inline(always)]
pub(crate) fn newton_euler<const W: usize, const FUSED: bool>(
    m: f64,
    h: &Vector3<f64>,
    I: &Matrix3<f64>,
    motion: &Motion<W, FUSED>,
    relative: &Relative<W, FUSED>,
) -> Wrench<W, FUSED> {
    let h = splat3(h);
    let Motion { w, dw, f } = motion;
    let moment = rotate_add(I, dw, &cross(&h, f)) + cross(w, &rotate(I, w));
    Wrench { force: relative.at(&h, &scale(m.into(), f)), moment }
}

/// From the parent's motion to the body's: ω += ẑ q̇, dω += ω × ẑ q̇ + ẑ q̈ (turning); f += 2 ω × ẑ q̇ + ẑ q̈ (sliding).
#[inline(always)]
fn outward<const W: usize, const FUSED: bool>(
    body: &Seat<'_, W, FUSED>,
    parent: &(Motion<W, FUSED>, Relative<W, FUSED>),
    slides: bool,
    qd: Lanes<W, FUSED>,
    qdd: Lanes<W, FUSED>,
) -> Motion<W, FUSED> {
    let (motion, relative) = parent;
    let (mut w, mut dw) = (body.unrotate(&motion.w), body.unrotate(&motion.dw));
    let mut f = body.unrotate(&relative.at(&body.origin, &motion.f));
    // ω × ẑ = (ω_y, −ω_x, 0)
    if slides {
        let twice = qd + qd;
        // 0 q̇ is 0, or NaN where the rate is no number.
        let nothing = Lanes::ZERO * qd;
        f = Vector3::new(w.y.mul_add(twice, f.x), w.x.neg_mul_add(twice, f.y), f.z + (qdd + nothing));
    } else {
        dw = Vector3::new(w.y.mul_add(qd, dw.x), w.x.neg_mul_add(qd, dw.y), dw.z + qdd);
        w.z += qd;
    }
    Motion { w, dw, f }
}

/// A wrench at the body's origin, in its axes, as the parent carries it at its own: (R F, R N + p × R F).
#[inline(always)]
pub(crate) fn inward<const W: usize, const FUSED: bool>(
    body: &Seat<'_, W, FUSED>,
    wrench: &Wrench<W, FUSED>,
) -> Wrench<W, FUSED> {
    let force = body.rotate(&wrench.force);
    Wrench { force, moment: body.rotate(&wrench.moment) + cross(&body.origin, &force) }
}

/// The share of a wrench that the joint's actuator carries.
#[inline(always)]
pub(crate) fn effort<const W: usize, const FUSED: bool>(
    robot: &Robot,
    i: usize,
    wrench: &Wrench<W, FUSED>,
) -> Lanes<W, FUSED> {
    if robot.loads[i].slides { wrench.force.z } else { wrench.moment.z }
}

/// Visits the bodies parents first with the motion that the mechanism's rates qd, qdd give each.
#[inline(always)]
pub(crate) fn each_motion<const W: usize, const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<'_, W, FUSED>,
    qd: &PerJoint<W>,
    qdd: &PerJoint<W>,
    base: &Motion<W, FUSED>,
    mut visit: impl FnMut(usize, &Motion<W, FUSED>, &Relative<W, FUSED>),
) {
    sweep::outward(
        robot,
        (*base, base.relative()),
        #[inline(always)]
        |i, above| {
            let motion = outward(&Seat::of(robot, now, i), above, robot.loads[i].slides, Lanes(qd[i]), Lanes(qdd[i]));
            let relative = motion.relative();
            visit(i, &motion, &relative);
            (motion, relative)
        },
    );
}

/// Writes the efforts at the coordinates, for mechanism rates, into `tau`; returns the wrench that the base passes to the
/// arm at the base origin.
#[inline(always)]
pub(crate) fn inverse_dynamics<const W: usize, const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<'_, W, FUSED>,
    qd: &PerJoint<W>,
    qdd: &PerJoint<W>,
    base: &Motion<W, FUSED>,
    tau: &mut PerJoint<W>,
) -> Wrench<W, FUSED> {
    let zero = Vector3::from_element(Lanes::ZERO);
    // Two small arrays are cleared in place, one large one by a call.
    let (mut forces, mut moments) = ([zero; MAX_JOINTS], [zero; MAX_JOINTS]);
    each_motion(
        robot,
        now,
        qd,
        qdd,
        base,
        #[inline(always)]
        |i, motion, relative| {
            let (load, link) = (&robot.loads[i], &robot.links[i]);
            let own = newton_euler(link.mass, &load.first_moment, &link.second_moment, motion, relative);
            (forces[i], moments[i]) = (own.force, own.moment);
        },
    );
    let root = sweep::inward(
        robot,
        Wrench::ZERO,
        #[inline(always)]
        |i, beyond| {
            let wrench = Wrench { force: forces[i] + beyond.force, moment: moments[i] + beyond.moment };
            tau[i] = effort(robot, i, &wrench).0;
            inward(&Seat::of(robot, now, i), &wrench)
        },
    );
    to_coordinates::<W, FUSED>(robot, tau);
    root
}

/// The base wrench including what is fixed to the base.
#[inline(always)]
pub(crate) fn with_base_inertia<const W: usize, const FUSED: bool>(
    robot: &Robot,
    wrench: &Wrench<W, FUSED>,
    base: &Motion<W, FUSED>,
) -> Wrench<W, FUSED> {
    let fixed: Inertia = robot.base_inertia();
    let mut total = newton_euler(fixed.mass(), fixed.first_moment(), fixed.second_moment(), base, &base.relative());
    total += *wrench;
    total
}

/// Writes M(q), coordinates × coordinates, into `out`, which has exactly this size.
///
/// Column i is the effort at every joint that a unit acceleration of joint i needs, by composite rigid bodies: all that
/// joint i carries moves as one body, and the wrench it needs is felt by joint i and those that carry it.
#[inline(always)]
pub(crate) fn mass_matrix<const FUSED: bool>(robot: &Robot, now: &JointsNow<'_, 1, FUSED>, out: &mut [f64]) {
    congruent::<FUSED>(
        robot,
        out,
        #[inline(always)]
        |matrix| {
            sweep::inward(
                robot,
                Composite::ZERO,
                #[inline(always)]
                |i, beyond| {
                    let mut composite = Composite::own(robot, i);
                    composite += beyond;
                    let mut wrench = composite.unit_acceleration(robot.loads[i].slides);
                    let mut j = i;
                    loop {
                        matrix.put(i, j, effort(robot, j, &wrench));
                        if robot.parents[j] == j {
                            break;
                        }
                        wrench = inward(&Seat::of(robot, now, j), &wrench);
                        j = robot.parents[j];
                    }
                    composite.seen_from_parent(&Seat::of(robot, now, i))
                },
            );
        },
    );
}

/// A symmetric matrix with a row and a column per joint of the mechanism, row-major.
#[derive(Debug)]
pub(crate) struct Symmetric<'a> {
    entries: &'a mut [f64],
    width: usize,
}

impl Symmetric<'_> {
    /// Sets the entries (i, j) and (j, i).
    #[inline(always)]
    pub fn put<const FUSED: bool>(&mut self, i: usize, j: usize, x: Lanes<1, FUSED>) {
        for at in [i * self.width + j, j * self.width + i] {
            if let Some(entry) = self.entries.get_mut(at) {
                *entry = x.0[0];
            }
        }
    }
}

/// Writes the matrix A whose entries `fill` puts (others are zero) into `out`; with a coupling, Cᵀ A C.
#[inline(always)]
pub(crate) fn congruent<const FUSED: bool>(robot: &Robot, out: &mut [f64], fill: impl Fn(&mut Symmetric<'_>)) {
    let width = robot.bodies();
    if robot.coupling().is_none() {
        out.fill(0.0);
        return fill(&mut Symmetric { entries: out, width });
    }
    let mut mechanism = [0.0; MAX_JOINTS * MAX_JOINTS];
    fill(&mut Symmetric { entries: &mut mechanism, width });
    let mut half = [[[0.0]; MAX_JOINTS]; MAX_JOINTS];
    for (half, row) in half.iter_mut().zip(mechanism.chunks_exact(width)) {
        for (entry, &x) in half.iter_mut().zip(row) {
            *entry = [x];
        }
        to_coordinates::<1, FUSED>(robot, half);
    }
    let mut whole = Symmetric { entries: out, width: robot.coordinates() };
    for j in 0..robot.coordinates() {
        let mut column = half.map(|row| row[j]);
        to_coordinates::<1, FUSED>(robot, &mut column);
        // Both halves from one sum: symmetric to the last bit.
        for i in 0..=j {
            whole.put(i, j, Lanes::<1, FUSED>(column[i]));
        }
    }
}

/// Mass, first and second moment of everything a joint carries, about the body's origin; the second by columns.
#[derive(Clone, Copy, Debug)]
struct Composite<const FUSED: bool> {
    mass: Lanes<1, FUSED>,
    h: Vec3<1, FUSED>,
    I: [Vec3<1, FUSED>; 3],
}

impl<const FUSED: bool> AddAssign for Composite<FUSED> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.mass += other.mass;
        self.h += other.h;
        for k in 0..3 {
            self.I[k] += other.I[k];
        }
    }
}

impl<const FUSED: bool> Composite<FUSED> {
    const ZERO: Self = {
        let zero = Vector3::new(Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);
        Self { mass: Lanes::ZERO, h: zero, I: [zero; 3] }
    };

    /// Body i alone.
    #[inline(always)]
    fn own(robot: &Robot, i: usize) -> Self {
        let (load, link) = (&robot.loads[i], &robot.links[i]);
        let column = |k: usize| splat3(&link.second_moment.column(k).into_owned());
        Self { mass: link.mass.into(), h: splat3(&load.first_moment), I: [column(0), column(1), column(2)] }
    }

    /// The wrench for a unit acceleration along z (F = m ẑ, N = h × ẑ) or about it (F = ẑ × h, N = I ẑ).
    #[inline(always)]
    fn unit_acceleration(&self, slides: bool) -> Wrench<1, FUSED> {
        let (h, zero) = (&self.h, Lanes::ZERO);
        if slides {
            Wrench { force: Vector3::new(zero, zero, self.mass), moment: Vector3::new(h.y, -h.x, zero) }
        } else {
            Wrench { force: Vector3::new(-h.y, h.x, zero), moment: self.I[2] }
        }
    }

    /// About the parent's origin in its axes: x' = R x + p in Σ m (|x'|² 1 − x' x'ᵀ).
    #[inline(always)]
    fn seen_from_parent(&self, body: &Seat<'_, 1, FUSED>) -> Self {
        let p = body.origin;
        let h = body.rotate(&self.h);
        let half: [Vec3<1, FUSED>; 3] = [body.rotate(&self.I[0]), body.rotate(&self.I[1]), body.rotate(&self.I[2])];
        let row = |k: usize| body.rotate(&Vector3::new(half[0][k], half[1][k], half[2][k]));
        let rotated = [row(0), row(1), row(2)];
        let shifted_h = h + scale(self.mass, &p);
        // 2 h·p 1 − h pᵀ − p hᵀ + m (|p|² 1 − p pᵀ) = (h + h')·p 1 − h' pᵀ − p hᵀ with h' = h + m p.
        let diagonal = dot(&(h + shifted_h), &p);
        let column = |k: usize| {
            let mut column = rotated[k] - scale(p[k], &shifted_h) - scale(h[k], &p);
            column[k] += diagonal;
            column
        };
        Self { mass: self.mass, h: shifted_h, I: [column(0), column(1), column(2)] }
    }
}

/// Solves M x = b in place of both, by Cholesky's factorisation; NaN where M is not positive definite (massless tips).
#[inline(always)]
pub(crate) fn solve<const FUSED: bool>(M: &mut [f64], x: &mut [f64]) {
    let n = x.len();
    let less = |sum: f64, (a, b): (&f64, &f64)| Lanes::<1, FUSED>([*a]).neg_mul_add(Lanes([*b]), Lanes([sum])).0[0];
    for j in 0..n {
        let (upper, lower) = M.split_at_mut((j + 1) * n);
        let pivot_row = &mut upper[j * n..];
        let (left, right) = pivot_row.split_at_mut(j);
        let pivot = left.iter().zip(&*left).fold(right[0], less);
        // A pivot that rounding could have made is none: NaN, and so is everything that follows from it.
        let root = if pivot > 16.0 * f64::EPSILON * right[0] { ComplexField::sqrt(pivot) } else { f64::NAN };
        right[0] = root;
        for row in lower.chunks_exact_mut(n) {
            row[j] = row.iter().zip(&*left).fold(row[j], less) / root;
        }
        x[j] = left.iter().zip(&*x).fold(x[j], less) / root;
    }
    for j in (0..n).rev() {
        let column = M[(j + 1) * n..].iter().skip(j).step_by(n);
        x[j] = column.zip(&x[j + 1..]).fold(x[j], less) / M[j * n + j];
    }
}
