//! Newton and Euler on a base that moves: inverse dynamics, base wrench, mass matrix, forward dynamics.
//!
//! The recursion starts at the root with the base's own motion (Luh, Walker & Paul 1980 with a moving root): its specific
//! force f₀ = a₀ − g takes the place of gravity, its ω and dω that of a base at rest. Everything is expressed in the axes of
//! the body it belongs to, wrenches act at the body's origin.

use crate::constants::MAX_JOINTS;
use crate::lanes::{Lanes, Vec3, cross, rotate, rotate_add, scale, splat3, turn_z, unrotate, unturn_z};
use crate::motion::{JointsNow, to_coordinates};
use crate::robot::Robot;
use crate::spatial::Inertia;
use nalgebra::Vector3;

/// Angular velocity w, angular acceleration dw and specific force f of a frame's origin, in the frame's axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion<const W: usize, const FUSED: bool> {
    pub w: Vec3<W, FUSED>,
    pub dw: Vec3<W, FUSED>,
    pub f: Vec3<W, FUSED>,
}

impl<const W: usize, const FUSED: bool> Motion<W, FUSED> {
    pub const ZERO: Self = {
        let zero = Vector3::new(Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);
        Self { w: zero, dw: zero, f: zero }
    };

    /// Specific force at p: f + dw × p + w × (w × p).
    #[inline(always)]
    pub fn at(&self, p: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
        self.f + cross(&self.dw, p) + cross(&self.w, &cross(&self.w, p))
    }
}

/// A force and a moment at the same point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wrench<const W: usize, const FUSED: bool> {
    pub force: Vec3<W, FUSED>,
    pub moment: Vec3<W, FUSED>,
}

impl<const W: usize, const FUSED: bool> Wrench<W, FUSED> {
    pub const ZERO: Self = Self { force: Motion::<W, FUSED>::ZERO.f, moment: Motion::<W, FUSED>::ZERO.f };

    #[inline(always)]
    fn add(&mut self, other: &Self) {
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
    I: &nalgebra::Matrix3<f64>,
    motion: &Motion<W, FUSED>,
) -> Wrench<W, FUSED> {
    let h = splat3(h);
    let Motion { w, dw, f } = motion;
    let force = scale(m.into(), f) + cross(dw, &h) + cross(w, &cross(w, &h));
    let moment = cross(&h, f) + rotate(I, dw) + cross(w, &rotate(I, w));
    Wrench { force, moment }
}

/// Rates of one joint: about its axis if it turns, along it if it slides; the other pair is zero.
#[derive(Clone, Copy, Debug)]
struct Rates<const W: usize, const FUSED: bool> {
    turn: Lanes<W, FUSED>,
    turn_rate: Lanes<W, FUSED>,
    slide: Lanes<W, FUSED>,
    slide_rate: Lanes<W, FUSED>,
}

/// From the parent's motion to the body's.
#[inline(always)]
fn outward<const W: usize, const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<W, FUSED>,
    i: usize,
    parent: &Motion<W, FUSED>,
    rates: &Rates<W, FUSED>,
) -> Motion<W, FUSED> {
    let (load, link) = (&robot.loads[i], &robot.links[i]);
    // The joint's frame first, unturned: w and dw of the parent, f at the body's origin, which sliding moves along z.
    let mut in_joint = Motion {
        w: unrotate(&load.rotation, &parent.w),
        dw: unrotate(&load.rotation, &parent.dw),
        f: unrotate(&load.rotation, &parent.at(&splat3(&link.position))),
    };
    let shift = Vector3::new(Lanes::ZERO, Lanes::ZERO, now.d[i]);
    in_joint.f = in_joint.at(&shift);
    let w = unturn_z(now.c[i], now.s[i], &in_joint.w);
    let dw = unturn_z(now.c[i], now.s[i], &in_joint.dw);
    let f = unturn_z(now.c[i], now.s[i], &in_joint.f);
    // dw += w × ẑ q̇ + ẑ q̈ (turning), f += 2 w × ẑ q̇ + ẑ q̈ (sliding); w × ẑ = (w_y, −w_x, 0).
    let coriolis = rates.slide + rates.slide;
    Motion {
        w: Vector3::new(w.x, w.y, w.z + rates.turn),
        dw: Vector3::new(w.y.mul_add(rates.turn, dw.x), w.x.neg_mul_add(rates.turn, dw.y), dw.z + rates.turn_rate),
        f: Vector3::new(w.y.mul_add(coriolis, f.x), w.x.neg_mul_add(coriolis, f.y), f.z + rates.slide_rate),
    }
}

/// A wrench at the body's origin, in its axes, as the parent carries it at its own.
#[inline(always)]
pub(crate) fn inward<const W: usize, const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<W, FUSED>,
    i: usize,
    wrench: &Wrench<W, FUSED>,
) -> Wrench<W, FUSED> {
    let (load, link) = (&robot.loads[i], &robot.links[i]);
    let turned = turn_z(now.c[i], now.s[i], &wrench.force);
    let mut moment = turn_z(now.c[i], now.s[i], &wrench.moment);
    // ẑ d × F
    moment.x = now.d[i].neg_mul_add(turned.y, moment.x);
    moment.y = now.d[i].mul_add(turned.x, moment.y);
    let force = rotate(&load.rotation, &turned);
    let lever = cross(&splat3(&link.position), &force);
    Wrench { force, moment: rotate_add(&load.rotation, &moment, &lever) }
}

/// The share of a wrench that the joint's actuator carries.
#[inline(always)]
pub(crate) fn effort<const W: usize, const FUSED: bool>(robot: &Robot, i: usize, wrench: &Wrench<W, FUSED>) -> Lanes<W, FUSED> {
    let turning = robot.loads[i].turning;
    Lanes::splat(turning).mul_add(wrench.moment.z, Lanes::splat(1.0 - turning) * wrench.force.z)
}

/// Motions of all bodies for mechanism rates qd, qdd.
#[inline(always)]
pub(crate) fn motions<const W: usize, const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<W, FUSED>,
    qd: &[Lanes<W, FUSED>; MAX_JOINTS],
    qdd: &[Lanes<W, FUSED>; MAX_JOINTS],
    base: &Motion<W, FUSED>,
) -> [Motion<W, FUSED>; MAX_JOINTS] {
    let mut motion = [Motion::ZERO; MAX_JOINTS];
    for i in 0..robot.bodies() {
        let turning = Lanes::splat(robot.loads[i].turning);
        let sliding = Lanes::splat(1.0 - robot.loads[i].turning);
        let rates = Rates {
            turn: turning * qd[i],
            turn_rate: turning * qdd[i],
            slide: sliding * qd[i],
            slide_rate: sliding * qdd[i],
        };
        let parent = robot.parents[i];
        let above = if parent == i { base } else { &motion[parent] };
        motion[i] = outward(robot, now, i, above, &rates);
    }
    motion
}

/// Efforts at the coordinates and the wrench that the base passes to the arm at the base origin, for mechanism rates.
#[inline(always)]
pub(crate) fn inverse_dynamics<const W: usize, const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<W, FUSED>,
    qd: &[Lanes<W, FUSED>; MAX_JOINTS],
    qdd: &[Lanes<W, FUSED>; MAX_JOINTS],
    base: &Motion<W, FUSED>,
) -> ([Lanes<W, FUSED>; MAX_JOINTS], Wrench<W, FUSED>) {
    let motion = motions(robot, now, qd, qdd, base);
    let mut tau = [Lanes::ZERO; MAX_JOINTS];
    let mut carried = [Wrench::ZERO; MAX_JOINTS];
    let mut root = Wrench::ZERO;
    for i in (0..robot.bodies()).rev() {
        let (load, link) = (&robot.loads[i], &robot.links[i]);
        let mut wrench = newton_euler(link.mass, &load.first_moment, &link.second_moment, &motion[i]);
        wrench.add(&carried[i]);
        tau[i] = effort(robot, i, &wrench);
        let above = inward(robot, now, i, &wrench);
        let parent = robot.parents[i];
        if parent == i { root.add(&above) } else { carried[parent].add(&above) }
    }
    (to_coordinates(robot, &tau), root)
}

/// The base wrench including what is fixed to the base.
#[inline(always)]
pub(crate) fn with_base_inertia<const W: usize, const FUSED: bool>(
    robot: &Robot,
    wrench: &Wrench<W, FUSED>,
    base: &Motion<W, FUSED>,
) -> Wrench<W, FUSED> {
    let fixed: Inertia = robot.base_inertia();
    let mut total = newton_euler(fixed.mass(), fixed.first_moment(), fixed.second_moment(), base);
    total.add(wrench);
    total
}

/// A square matrix with room for [`MAX_JOINTS`] rows.
pub(crate) type Square<const W: usize, const FUSED: bool> = [[Lanes<W, FUSED>; MAX_JOINTS]; MAX_JOINTS];

/// M(q) in coordinates: Cᵀ M_mechanism C.
///
/// Column i is the effort at every joint that a unit acceleration of joint i needs, by composite rigid bodies: all that
/// joint i carries moves as one body, and the wrench it needs is felt by joint i and those that carry it.
#[inline(always)]
pub(crate) fn mass_matrix<const FUSED: bool>(robot: &Robot, now: &JointsNow<1, FUSED>) -> Square<1, FUSED> {
    let n = robot.bodies();
    let mut composite = [Composite::ZERO; MAX_JOINTS];
    let mut matrix = [[Lanes::ZERO; MAX_JOINTS]; MAX_JOINTS];
    for i in (0..n).rev() {
        composite[i].add_own(robot, i);
        let mut wrench = composite[i].unit_acceleration(robot.loads[i].turning);
        let mut j = i;
        loop {
            matrix[i][j] = effort(robot, j, &wrench);
            matrix[j][i] = matrix[i][j];
            if robot.parents[j] == j {
                break;
            }
            wrench = inward(robot, now, j, &wrench);
            j = robot.parents[j];
        }
        if robot.parents[i] != i {
            let seen = composite[i].seen_from_parent(robot, now, i);
            composite[robot.parents[i]].add(&seen);
        }
    }
    congruent(robot, &matrix)
}

/// Cᵀ A C.
#[inline(always)]
pub(crate) fn congruent<const FUSED: bool>(robot: &Robot, matrix: &Square<1, FUSED>) -> Square<1, FUSED> {
    if robot.coupling().is_none() {
        return *matrix;
    }
    let mut half = [[Lanes::ZERO; MAX_JOINTS]; MAX_JOINTS];
    for i in 0..robot.bodies() {
        half[i] = to_coordinates(robot, &matrix[i]);
    }
    let mut whole = [[Lanes::ZERO; MAX_JOINTS]; MAX_JOINTS];
    for j in 0..robot.coordinates() {
        whole[j] = to_coordinates(robot, &core::array::from_fn(|i| half[i][j]));
    }
    whole
}

/// Mass, first and second moment of everything a joint carries, about the body's origin; the second by columns.
#[derive(Clone, Copy, Debug)]
struct Composite<const FUSED: bool> {
    mass: Lanes<1, FUSED>,
    h: Vec3<1, FUSED>,
    I: [Vec3<1, FUSED>; 3],
}

impl<const FUSED: bool> Composite<FUSED> {
    const ZERO: Self = {
        let zero = Vector3::new(Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);
        Self { mass: Lanes::ZERO, h: zero, I: [zero; 3] }
    };

    #[inline(always)]
    fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.h += other.h;
        for k in 0..3 {
            self.I[k] += other.I[k];
        }
    }

    #[inline(always)]
    fn add_own(&mut self, robot: &Robot, i: usize) {
        let (load, link) = (&robot.loads[i], &robot.links[i]);
        let column = |k: usize| splat3(&link.second_moment.column(k).into_owned());
        self.add(&Self { mass: link.mass.into(), h: splat3(&load.first_moment), I: [column(0), column(1), column(2)] });
    }

    /// The wrench for a unit acceleration about z (turning 1: F = ẑ × h, N = I ẑ) or along z (0: F = m ẑ, N = h × ẑ).
    #[inline(always)]
    fn unit_acceleration(&self, turning: f64) -> Wrench<1, FUSED> {
        let (t, s) = (Lanes::splat(turning), Lanes::splat(1.0 - turning));
        let zero = Lanes::ZERO;
        let about = Wrench { force: Vector3::new(-self.h.y, self.h.x, zero), moment: self.I[2] };
        let along = Wrench { force: Vector3::new(zero, zero, self.mass), moment: Vector3::new(self.h.y, -self.h.x, zero) };
        Wrench {
            force: scale(t, &about.force) + scale(s, &along.force),
            moment: scale(t, &about.moment) + scale(s, &along.moment),
        }
    }

    /// About the parent's origin in its axes: x' = R x + p in Σ m (|x'|² 1 − x' x'ᵀ).
    #[inline(always)]
    fn seen_from_parent(&self, robot: &Robot, now: &JointsNow<1, FUSED>, i: usize) -> Self {
        let (load, link) = (&robot.loads[i], &robot.links[i]);
        let turn = |v: &Vec3<1, FUSED>| rotate(&load.rotation, &turn_z(now.c[i], now.s[i], v));
        let shift = Vector3::new(Lanes::ZERO, Lanes::ZERO, now.d[i]);
        let p = rotate_add(&load.rotation, &shift, &splat3(&link.position));
        let h = turn(&self.h);
        let half: [Vec3<1, FUSED>; 3] = self.I.map(|column| turn(&column));
        let row = |k: usize| turn(&Vector3::new(half[0][k], half[1][k], half[2][k]));
        let rotated = [row(0), row(1), row(2)];
        let shifted_h = h + scale(self.mass, &p);
        // 2 h·p 1 − h pᵀ − p hᵀ + m (|p|² 1 − p pᵀ) = (h + h')·p 1 − h' pᵀ − p hᵀ with h' = h + m p.
        let diagonal = crate::lanes::dot(&(h + shifted_h), &p);
        let column = |k: usize| {
            let mut column = rotated[k] - scale(p[k], &shifted_h) - scale(h[k], &p);
            column[k] += diagonal;
            column
        };
        Self { mass: self.mass, h: shifted_h, I: [column(0), column(1), column(2)] }
    }
}

/// q̈ for which M q̈ + bias = τ, by Cholesky's factorisation; NaN where M is not positive definite (massless tips).
#[inline(always)]
pub(crate) fn solve<const FUSED: bool>(
    matrix: &Square<1, FUSED>,
    right: &[Lanes<1, FUSED>; MAX_JOINTS],
    n: usize,
) -> [Lanes<1, FUSED>; MAX_JOINTS] {
    let mut L = *matrix;
    let mut x = *right;
    for j in 0..n {
        let mut pivot = L[j][j];
        for k in 0..j {
            pivot = L[j][k].neg_mul_add(L[j][k], pivot);
        }
        // A pivot that rounding could have made is none: NaN, and so is everything that follows from it.
        let root = if pivot.0[0] > 16.0 * f64::EPSILON * matrix[j][j].0[0] { nalgebra::ComplexField::sqrt(pivot.0[0]) } else { f64::NAN };
        L[j][j] = Lanes([root]);
        for i in j + 1..n {
            let mut sum = L[i][j];
            for k in 0..j {
                sum = L[i][k].neg_mul_add(L[j][k], sum);
            }
            L[i][j] = Lanes([sum.0[0] / root]);
        }
        for k in 0..j {
            x[j] = L[j][k].neg_mul_add(x[k], x[j]);
        }
        x[j] = Lanes([x[j].0[0] / root]);
    }
    for j in (0..n).rev() {
        for k in j + 1..n {
            x[j] = L[k][j].neg_mul_add(x[k], x[j]);
        }
        x[j] = Lanes([x[j].0[0] / L[j][j].0[0]]);
    }
    x
}
