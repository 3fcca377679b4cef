//! Where frames are.

use crate::lanes::{Lanes, Vec3, dot, splat3};
use crate::motion::JointsNow;
use crate::robot::{Carrier, Frame, Robot};
use nalgebra::{Matrix3, Vector3};

/// A column of a homogeneous matrix, its four rows side by side.
pub(crate) type Column<const FUSED: bool> = Lanes<4, FUSED>;

/// A frame in the base frame B: the columns x, y, z, o of its homogeneous matrix T.
///
/// In a product T A the rows of T do not mix: with rows in lanes, each number of A serves four of them at once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axes<const FUSED: bool> {
    pub x: Column<FUSED>,
    pub y: Column<FUSED>,
    pub z: Column<FUSED>,
    pub origin: Column<FUSED>,
}

impl<const FUSED: bool> Axes<FUSED> {
    /// The base frame B in itself.
    pub const BASE: Self = Self {
        x: Lanes([1.0, 0.0, 0.0, 0.0]),
        y: Lanes([0.0, 1.0, 0.0, 0.0]),
        z: Lanes([0.0, 0.0, 1.0, 0.0]),
        origin: Lanes([0.0, 0.0, 0.0, 1.0]),
    };

    /// A constant frame.
    #[inline(always)]
    pub fn constant(R: &Matrix3<f64>, p: &Vector3<f64>) -> Self {
        let axis = |j: usize| Lanes([R[(0, j)], R[(1, j)], R[(2, j)], 0.0]);
        Self { x: axis(0), y: axis(1), z: axis(2), origin: Lanes([p.x, p.y, p.z, 1.0]) }
    }

    /// `x v_x + y v_y + z v_z`: the vector v of this frame in base axes.
    #[inline(always)]
    pub fn rotate(&self, [x, y, z]: [f64; 3]) -> Column<FUSED> {
        self.x.mul_add(x.into(), self.y.mul_add(y.into(), self.z * z.into()))
    }

    /// The point p of this frame in B.
    #[inline(always)]
    pub fn place(&self, [x, y, z]: [f64; 3]) -> Column<FUSED> {
        self.x.mul_add(x.into(), self.y.mul_add(y.into(), self.z.mul_add(z.into(), self.origin)))
    }

    /// The frame that the constant (R, p) is in this one.
    #[inline(always)]
    pub fn then(&self, R: &Matrix3<f64>, p: &Vector3<f64>) -> Self {
        let axis = |j: usize| self.rotate([R[(0, j)], R[(1, j)], R[(2, j)]]);
        Self { x: axis(0), y: axis(1), z: axis(2), origin: self.place([p.x, p.y, p.z]) }
    }

    /// The axes of body i from those of its parent, these: constants first, then the joint's own motion.
    #[inline(always)]
    pub fn carry(&self, robot: &Robot, now: &JointsNow<'_, 1, FUSED>, i: usize) -> Self {
        let (F, p) = (&robot.loads[i].rotation, &robot.links[i].position);
        let unmoved = self.then(F, p);
        if robot.loads[i].slides {
            let Lanes([d]) = now.slide(i);
            return Self { origin: unmoved.z.mul_add(d.into(), unmoved.origin), ..unmoved };
        }
        let (c, s) = (Lanes::splat(now.c[i].0[0]), Lanes::splat(now.s[i].0[0]));
        Self { x: c.mul_add(unmoved.x, s * unmoved.y), y: s.neg_mul_add(unmoved.x, c * unmoved.y), ..unmoved }
    }
}

/// The first three rows of a column.
#[inline(always)]
pub(crate) fn vector<const FUSED: bool>(column: &Column<FUSED>) -> Vec3<1, FUSED> {
    let [x, y, z, _] = column.0;
    Vector3::new(Lanes([x]), Lanes([y]), Lanes([z]))
}

/// Visits the bodies from the base to `body` with their axes; returns those of `body`.
#[inline(always)]
fn along<const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<'_, 1, FUSED>,
    body: usize,
    mut visit: impl FnMut(usize, &Axes<FUSED>),
) -> Axes<FUSED> {
    let mut at = Axes::BASE;
    for i in 0..=body {
        if robot.carries(i, body) {
            at = at.carry(robot, now, i);
            visit(i, &at);
        }
    }
    at
}

/// The pose of `frame` in the base frame B.
#[inline(always)]
pub(crate) fn pose<const FUSED: bool>(robot: &Robot, now: &JointsNow<'_, 1, FUSED>, frame: &Frame) -> Axes<FUSED> {
    let carrier = match frame.carrier {
        Carrier::Base => Axes::BASE,
        Carrier::Root => Axes::constant(robot.base().rotation(), robot.base().translation()),
        Carrier::Body(body) => along(robot, now, body, |_, _| ()),
    };
    carrier.then(frame.pose.rotation(), frame.pose.translation())
}

/// The first `N` joints of a mechanism as lines in B, where they carry a frame: their axes, and their origins.
///
/// Two arrays on their own, not parts of one value: that is copied, these stay where they are.
pub(crate) type Lines<'a, const N: usize, const FUSED: bool> = (&'a [Column<FUSED>; N], &'a [Column<FUSED>; N]);

/// Out to `frame`, which `body` carries, with the joints where they are now: one sweep gives the frame, and the axes and
/// origins on the way to it.
#[inline(always)]
pub(crate) fn chain<const N: usize, const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<'_, 1, FUSED>,
    (frame, body): (&Frame, usize),
    axis: &mut [Column<FUSED>; N],
    origin: &mut [Column<FUSED>; N],
) -> Axes<FUSED> {
    let last = along(
        robot,
        now,
        body,
        #[inline(always)]
        |i, at| {
            if i < N {
                (axis[i], origin[i]) = (at.z, at.origin);
            }
        },
    );
    last.then(frame.pose.rotation(), frame.pose.translation())
}

/// How joint i moves a frame that `body` carries, its origin's velocity and its angular velocity in B: z × (p − o) and z if it
/// turns, with its axis z and origin o and the frame's origin p, or z and nothing if it slides; nothing if it does not carry it.
#[inline(always)]
pub(crate) fn column_of<const N: usize, const FUSED: bool>(
    robot: &Robot,
    body: usize,
    i: usize,
    (axis, origin): Lines<'_, N, FUSED>,
    tip: &Axes<FUSED>,
) -> [Column<FUSED>; 2] {
    if !robot.carries(i, body) {
        return [Lanes::ZERO; 2];
    }
    let z = axis[i];
    if robot.loads[i].slides {
        return [z, Lanes::ZERO];
    }
    [z.cross(tip.origin - origin[i]), z]
}

/// Where a body sits in its parent: turned by R = F Rz(q), at p, or slid to p + F ẑ q.
///
/// R is multiplied out first: a rotation is then three operations deep instead of five, and depth is what sweeps wait for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seat<'r, const W: usize, const FUSED: bool> {
    x: Vec3<W, FUSED>,
    y: Vec3<W, FUSED>,
    F: &'r Matrix3<f64>,
    pub origin: Vec3<W, FUSED>,
}

impl<'r, const W: usize, const FUSED: bool> Seat<'r, W, FUSED> {
    /// Of body i, with the joints where they are now.
    #[inline(always)]
    pub fn of(robot: &'r Robot, now: &JointsNow<'_, W, FUSED>, i: usize) -> Self {
        let (F, p) = (&robot.loads[i].rotation, &robot.links[i].position);
        let (fx, fy) = (column(F, 0), column(F, 1));
        if robot.loads[i].slides {
            let slid = |k: usize| now.slide(i).mul_add(F[(k, 2)].into(), p[k].into());
            return Self { x: fx, y: fy, F, origin: Vector3::new(slid(0), slid(1), slid(2)) };
        }
        let (c, s) = (now.c[i], now.s[i]);
        Self { x: mixed(c, &fx, s, &fy), y: mixed(c, &fy, -s, &fx), F, origin: splat3(p) }
    }

    /// The same for `V` vectors side by side.
    #[inline(always)]
    pub fn wide<const V: usize>(&self) -> Seat<'r, V, FUSED> {
        let wide = |v: &Vec3<W, FUSED>| v.map(|x| Lanes::splat(x.0[0]));
        Seat { x: wide(&self.x), y: wide(&self.y), F: self.F, origin: wide(&self.origin) }
    }

    /// From the body's axes to the parent's.
    #[inline(always)]
    pub fn rotate(&self, v: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
        let row = |k: usize| self.x[k].mul_add(v.x, self.y[k].mul_add(v.y, Lanes::splat(self.F[(k, 2)]) * v.z));
        Vector3::new(row(0), row(1), row(2))
    }

    /// From the parent's axes to the body's.
    #[inline(always)]
    pub fn unrotate(&self, v: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
        Vector3::new(dot(&self.x, v), dot(&self.y, v), dot(&column(self.F, 2), v))
    }
}

/// `c a + s b`.
#[inline(always)]
fn mixed<const W: usize, const FUSED: bool>(
    c: Lanes<W, FUSED>,
    a: &Vec3<W, FUSED>,
    s: Lanes<W, FUSED>,
    b: &Vec3<W, FUSED>,
) -> Vec3<W, FUSED> {
    let mixed = |k: usize| c.mul_add(a[k], s * b[k]);
    Vector3::new(mixed(0), mixed(1), mixed(2))
}

#[inline(always)]
fn column<const W: usize, const FUSED: bool>(R: &Matrix3<f64>, j: usize) -> Vec3<W, FUSED> {
    Vector3::new(R[(0, j)].into(), R[(1, j)].into(), R[(2, j)].into())
}
