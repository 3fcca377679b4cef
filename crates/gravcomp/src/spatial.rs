//! Frames and inertias.

use crate::constants::{INERTIA_TOLERANCE, ROTATION_TOLERANCE};
use crate::error::ModelError;
use core::ops::{Add, Mul};
use nalgebra::{Matrix3, Vector3};

/// A frame seen from another: `p_outer = rotation · p_inner + translation`, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
}

impl Default for Pose {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Pose {
    /// The frame itself.
    pub const IDENTITY: Self = Self {
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        translation: Vector3::new(0.0, 0.0, 0.0),
    };

    /// A checked pose; `field` names it in the error.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`], [`ModelError::NotARotation`] or [`ModelError::Mirrored`].
    pub fn new(rotation: Matrix3<f64>, translation: Vector3<f64>, field: &'static str) -> Result<Self, ModelError> {
        if !rotation.iter().chain(&translation).all(|x| x.is_finite()) {
            return Err(ModelError::NotFinite { field });
        }
        let error = (rotation.transpose() * rotation - Matrix3::identity()).amax();
        if error > ROTATION_TOLERANCE {
            return Err(ModelError::NotARotation { field, error });
        }
        if rotation.determinant() < 0.0 {
            return Err(ModelError::Mirrored { field });
        }
        Ok(Self { rotation, translation })
    }

    /// A pose from parts that are right by construction.
    pub(crate) const fn from_parts(rotation: Matrix3<f64>, translation: Vector3<f64>) -> Self {
        Self { rotation, translation }
    }

    /// Columns are the inner frame's axes in the outer frame.
    #[must_use]
    pub const fn rotation(&self) -> &Matrix3<f64> {
        &self.rotation
    }

    /// The inner frame's origin in the outer frame, m.
    #[must_use]
    pub const fn translation(&self) -> &Vector3<f64> {
        &self.translation
    }

    /// The outer frame seen from the inner one.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let back = self.rotation.transpose();
        Self { rotation: back, translation: -(back * self.translation) }
    }
}

impl Mul for Pose {
    type Output = Self;
    fn mul(self, inner: Self) -> Self {
        Self {
            rotation: self.rotation * inner.rotation,
            translation: self.rotation * inner.translation + self.translation,
        }
    }
}

/// The ten inertial parameters of a body about the origin of a frame, in that frame's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inertia {
    mass: f64,
    first_moment: Vector3<f64>,
    second_moment: Matrix3<f64>,
}

impl Inertia {
    /// Nothing there.
    pub const ZERO: Self = Self {
        mass: 0.0,
        first_moment: Vector3::new(0.0, 0.0, 0.0),
        second_moment: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    /// From mass (kg), centre of mass (m) and inertia about the centre of mass (kg·m², order xx xy xz yy yz zz).
    ///
    /// # Errors
    /// [`ModelError::NotFinite`], [`ModelError::NegativeMass`], [`ModelError::InertiaWithoutMass`] or
    /// [`ModelError::ImpossibleInertia`].
    pub fn new(mass: f64, com: Vector3<f64>, about_com: [f64; 6]) -> Result<Self, ModelError> {
        for (field, finite) in [
            ("mass", mass.is_finite()),
            ("com", com.iter().all(|x| x.is_finite())),
            ("inertia", about_com.iter().all(|x| x.is_finite())),
        ] {
            if !finite {
                return Err(ModelError::NotFinite { field });
            }
        }
        if mass < 0.0 {
            return Err(ModelError::NegativeMass { mass });
        }
        let central = symmetric(about_com);
        check_principal_moments(&central, mass)?;
        // Steiner: about the frame's origin, I = I_com + m (|c|² 1 − c cᵀ).
        let second_moment = central + mass * point(&com);
        Ok(Self { mass, first_moment: mass * com, second_moment })
    }

    /// Mass, kg.
    #[must_use]
    pub const fn mass(&self) -> f64 {
        self.mass
    }

    /// Mass times centre of mass, kg·m.
    #[must_use]
    pub const fn first_moment(&self) -> &Vector3<f64> {
        &self.first_moment
    }

    /// Inertia about the frame's origin, kg·m².
    #[must_use]
    pub const fn second_moment(&self) -> &Matrix3<f64> {
        &self.second_moment
    }

    /// `[m, hx, hy, hz, Ixx, Ixy, Ixz, Iyy, Iyz, Izz]`, the order of the regressors' columns.
    #[must_use]
    pub fn parameters(&self) -> [f64; 10] {
        let (h, I) = (&self.first_moment, &self.second_moment);
        [self.mass, h.x, h.y, h.z, I[(0, 0)], I[(0, 1)], I[(0, 2)], I[(1, 1)], I[(1, 2)], I[(2, 2)]]
    }

    /// The same body about the origin of the frame in which `pose` places this one.
    #[must_use]
    pub fn seen_from(&self, pose: &Pose) -> Self {
        let (R, p) = (pose.rotation(), pose.translation());
        let h = R * self.first_moment;
        // x' = R x + p, summed over the body's points in Σ m (|x'|² 1 − x' x'ᵀ).
        let mixed = Matrix3::identity() * (2.0 * h.dot(p)) - h * p.transpose() - p * h.transpose();
        Self {
            mass: self.mass,
            first_moment: h + self.mass * p,
            second_moment: R * self.second_moment * R.transpose() + mixed + self.mass * point(p),
        }
    }
}

impl Add for Inertia {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first_moment: self.first_moment + other.first_moment,
            second_moment: self.second_moment + other.second_moment,
        }
    }
}

/// `|p|² 1 − p pᵀ`: the inertia of a unit point mass.
fn point(p: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * p.norm_squared() - p * p.transpose()
}

/// The symmetric matrix with entries xx xy xz yy yz zz.
fn symmetric([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

fn check_principal_moments(central: &Matrix3<f64>, mass: f64) -> Result<(), ModelError> {
    let scale = central.amax();
    if scale == 0.0 {
        return Ok(());
    }
    if mass == 0.0 {
        return Err(ModelError::InertiaWithoutMass);
    }
    let mut principal: [f64; 3] = central.symmetric_eigenvalues().into();
    principal.sort_unstable_by(f64::total_cmp);
    let [a, b, c] = principal;
    let slack = INERTIA_TOLERANCE * scale;
    if a < -slack || c > a + b + slack {
        return Err(ModelError::ImpossibleInertia { principal });
    }
    Ok(())
}
