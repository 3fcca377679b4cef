//! Numbers in lanes: one kernel text serves a single cycle (`W = 1`) and batches (`W` configurations side by side).
//!
//! `FUSED` says whether `a·b + c` is rounded once. It is a property of the instantiation, not of the machine: the fused
//! kernels are only reached through functions compiled for a processor that has the instruction.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Mul, MulAssign, Neg, Sub, SubAssign};
use nalgebra::{ComplexField, Matrix3, Vector3};

/// `W` numbers on which arithmetic acts element by element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes<const W: usize, const FUSED: bool>(pub [f64; W]);

/// A vector of three [`Lanes`].
pub type Vec3<const W: usize, const FUSED: bool> = Vector3<Lanes<W, FUSED>>;

impl<const W: usize, const FUSED: bool> Lanes<W, FUSED> {
    /// Zero in every lane.
    pub const ZERO: Self = Self([0.0; W]);

    /// The same number in every lane.
    #[inline(always)]
    #[must_use]
    pub const fn splat(x: f64) -> Self {
        Self([x; W])
    }

    /// `self · b + c`, rounded once if `FUSED`.
    #[inline(always)]
    #[must_use]
    pub fn mul_add(self, b: Self, c: Self) -> Self {
        let mut sum = c;
        for l in 0..W {
            sum.0[l] =
                if FUSED { ComplexField::mul_add(self.0[l], b.0[l], c.0[l]) } else { self.0[l] * b.0[l] + c.0[l] };
        }
        sum
    }

    /// `c − self · b`, rounded once if `FUSED`.
    #[inline(always)]
    #[must_use]
    pub fn neg_mul_add(self, b: Self, c: Self) -> Self {
        (-self).mul_add(b, c)
    }
}

macro_rules! elementwise {
    ($trait:ident $method:ident $assign_trait:ident $assign_method:ident $op:tt) => {
        impl<const W: usize, const FUSED: bool> $trait for Lanes<W, FUSED> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, rhs: Self) -> Self {
                let mut result = self;
                for l in 0..W {
                    result.0[l] = self.0[l] $op rhs.0[l];
                }
                result
            }
        }
        impl<const W: usize, const FUSED: bool> $assign_trait for Lanes<W, FUSED> {
            #[inline(always)]
            fn $assign_method(&mut self, rhs: Self) {
                *self = *self $op rhs;
            }
        }
    };
}
elementwise!(Add add AddAssign add_assign +);
elementwise!(Sub sub SubAssign sub_assign -);
elementwise!(Mul mul MulAssign mul_assign *);

impl<const W: usize, const FUSED: bool> Neg for Lanes<W, FUSED> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let mut negated = self;
        for l in 0..W {
            negated.0[l] = -self.0[l];
        }
        negated
    }
}

impl<const W: usize, const FUSED: bool> From<f64> for Lanes<W, FUSED> {
    #[inline(always)]
    fn from(x: f64) -> Self {
        Self::splat(x)
    }
}

/// Three numbers and a zero: a vector whose components lie side by side.
impl<const FUSED: bool> Lanes<4, FUSED> {
    /// The numbers.
    #[inline(always)]
    #[must_use]
    pub const fn of_three([x, y, z]: [f64; 3]) -> Self {
        Self([x, y, z, 0.0])
    }

    /// `self · b`.
    #[inline(always)]
    #[must_use]
    pub fn dot(self, b: Self) -> f64 {
        let [x, y, z, _] = (self * b).0;
        x + y + z
    }

    /// `self × b`.
    #[inline(always)]
    #[must_use]
    pub fn cross(self, b: Self) -> Self {
        self.mul_add(b.turned(), -(self.turned() * b)).turned()
    }

    /// (y, z, x).
    #[inline(always)]
    fn turned(self) -> Self {
        let [x, y, z, w] = self.0;
        Self([y, z, x, w])
    }
}

/// Leaves values in memory, lane by lane as they were computed: where single numbers of them are wanted next, the compiler
/// would take the lanes apart all the way back.
#[inline(always)]
pub(crate) fn keep_lanes<T>(values: &mut T) {
    core::hint::black_box(values);
}

/// The same vector in every lane.
#[inline(always)]
#[must_use]
pub fn splat3<const W: usize, const FUSED: bool>(v: &Vector3<f64>) -> Vec3<W, FUSED> {
    Vector3::new(v.x.into(), v.y.into(), v.z.into())
}

/// `R v + t` for a constant rotation.
#[inline(always)]
#[must_use]
#[allow(non_snake_case)]
pub fn rotate_add<const W: usize, const FUSED: bool>(
    R: &Matrix3<f64>,
    v: &Vec3<W, FUSED>,
    t: &Vec3<W, FUSED>,
) -> Vec3<W, FUSED> {
    let row = |i: usize, t: Lanes<W, FUSED>| {
        let [x, y, z] = [R[(i, 0)], R[(i, 1)], R[(i, 2)]].map(Lanes::splat);
        x.mul_add(v.x, y.mul_add(v.y, z.mul_add(v.z, t)))
    };
    Vector3::new(row(0, t.x), row(1, t.y), row(2, t.z))
}

/// `R v` for a constant rotation.
#[inline(always)]
#[must_use]
#[allow(non_snake_case)]
pub fn rotate<const W: usize, const FUSED: bool>(R: &Matrix3<f64>, v: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
    let row = |i: usize| {
        let [x, y, z] = [R[(i, 0)], R[(i, 1)], R[(i, 2)]].map(Lanes::splat);
        x.mul_add(v.x, y.mul_add(v.y, z * v.z))
    };
    Vector3::new(row(0), row(1), row(2))
}

/// `Rᵀ v` for a constant rotation.
#[inline(always)]
#[must_use]
#[allow(non_snake_case)]
pub fn unrotate<const W: usize, const FUSED: bool>(R: &Matrix3<f64>, v: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
    let column = |j: usize| {
        let [x, y, z] = [R[(0, j)], R[(1, j)], R[(2, j)]].map(Lanes::splat);
        x.mul_add(v.x, y.mul_add(v.y, z * v.z))
    };
    Vector3::new(column(0), column(1), column(2))
}

/// `Rz(θ) v` from the cosine and sine of θ.
#[inline(always)]
#[must_use]
pub fn turn_z<const W: usize, const FUSED: bool>(
    c: Lanes<W, FUSED>,
    s: Lanes<W, FUSED>,
    v: &Vec3<W, FUSED>,
) -> Vec3<W, FUSED> {
    Vector3::new(s.neg_mul_add(v.y, c * v.x), s.mul_add(v.x, c * v.y), v.z)
}

/// `Rz(θ)ᵀ v` from the cosine and sine of θ.
#[inline(always)]
#[must_use]
pub fn unturn_z<const W: usize, const FUSED: bool>(
    c: Lanes<W, FUSED>,
    s: Lanes<W, FUSED>,
    v: &Vec3<W, FUSED>,
) -> Vec3<W, FUSED> {
    turn_z(c, -s, v)
}

/// `a × b`.
#[inline(always)]
#[must_use]
pub fn cross<const W: usize, const FUSED: bool>(a: &Vec3<W, FUSED>, b: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
    Vector3::new(a.y.mul_add(b.z, -(a.z * b.y)), a.z.mul_add(b.x, -(a.x * b.z)), a.x.mul_add(b.y, -(a.y * b.x)))
}

/// `a · b`.
#[inline(always)]
#[must_use]
pub fn dot<const W: usize, const FUSED: bool>(a: &Vec3<W, FUSED>, b: &Vec3<W, FUSED>) -> Lanes<W, FUSED> {
    a.x.mul_add(b.x, a.y.mul_add(b.y, a.z * b.z))
}

/// `s v`.
#[inline(always)]
#[must_use]
pub fn scale<const W: usize, const FUSED: bool>(s: Lanes<W, FUSED>, v: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
    Vector3::new(s * v.x, s * v.y, s * v.z)
}
