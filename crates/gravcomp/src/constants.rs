//! Numbers with a name and a source.

/// Standard gravity, m/s² (CGPM 1901, resolution 2).
pub const STANDARD_GRAVITY: f64 = 9.806_65;

/// The most moving bodies a [`Robot`](crate::Robot) can have, and so the most coordinates.
pub const MAX_JOINTS: usize = 16;

/// How far a rotation may be from orthonormal, largest entry of `RᵀR − 1`: nine decimals in a file are enough.
pub const ROTATION_TOLERANCE: f64 = 1e-9;

/// How far principal moments may break the triangle inequality, relative to the largest: rounding of published tables.
pub const INERTIA_TOLERANCE: f64 = 1e-9;
