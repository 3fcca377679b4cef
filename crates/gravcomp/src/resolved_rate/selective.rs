//! Selectively damped least squares: each singular direction goes only as fast as it is worth to the task.
//!
//! S. Buss, J. Kim, "Selectively damped least squares for inverse kinematics", J. Graphics Tools 10(3), 2005, with rates in place of
//! steps: along the i-th direction at most γᵢ = q̇_max min(1, Nᵢ/Mᵢ), Mᵢ = σᵢ⁻¹ Σⱼ |vⱼᵢ| |Jⱼ|, Nᵢ = 1, and q̇_max for their sum.

use super::factor::{Matrix, ROWS};
use super::task::{Columns, Six, product};
use crate::lanes::Lanes;
use nalgebra::ComplexField;

/// Sweeps of Jacobi's method; six rows need no more than these for all digits.
const SWEEPS: usize = 8;

/// Singular values below this share of the largest are zero.
const NEGLIGIBLE: f64 = 1e-7;

/// The rates of a task, its smallest singular value, and whether any direction was cut.
pub(super) struct Selected<const N: usize> {
    pub rates: [f64; N],
    pub sigma_squared: f64,
    pub is_cut: bool,
}

/// Rates for the velocity from J by columns and J Jᵀ; rows that are `absent` are ones in its diagonal.
#[inline(always)]
pub(super) fn selected<const N: usize, const FUSED: bool>(
    columns: &Columns<N, FUSED>,
    matrix: &Matrix<FUSED>,
    absent: &[f64; ROWS],
    velocity: &Six<FUSED>,
    rate_max: f64,
) -> Selected<N> {
    let (values, vectors) = eigen(matrix, absent);
    let largest = values.iter().fold(0.0, |most: f64, value| most.max(*value));
    let mut found = Selected { rates: [0.0; N], sigma_squared: f64::INFINITY, is_cut: false };
    for i in 0..ROWS {
        if absent[i] != 0.0 {
            continue;
        }
        let squared = values[i].max(0.0);
        found.sigma_squared = found.sigma_squared.min(squared);
        if squared <= largest * NEGLIGIBLE * NEGLIGIBLE {
            found.is_cut = true;
            continue;
        }
        let half = |k: usize| Lanes([vectors[k][i], vectors[k + 1][i], vectors[k + 2][i], 0.0]);
        let u = [half(0), half(3)];
        let along = product(&u, velocity) / squared;
        let (mut direction, mut reach) = ([0.0; N], 0.0);
        for j in 0..N {
            // σ vⱼ = u · Jⱼ
            direction[j] = product(&u, &columns[j]);
            reach += direction[j].abs() * ComplexField::sqrt(product(&columns[j], &columns[j]));
        }
        let most = rate_max * (squared / reach).min(1.0);
        let largest_rate = along.abs() * direction.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let share = if largest_rate > most { most / largest_rate } else { 1.0 };
        found.is_cut |= share < 1.0;
        for j in 0..N {
            found.rates[j] += share * along * direction[j];
        }
    }
    found
}

/// Six rows of six.
type Square = [[f64; ROWS]; ROWS];

/// Eigenvalues and, by columns, eigenvectors of a symmetric matrix by Jacobi's rotations; the absent rows are apart from the
/// others and stay so.
#[inline(always)]
fn eigen<const FUSED: bool>(matrix: &Matrix<FUSED>, absent: &[f64; ROWS]) -> ([f64; ROWS], Square) {
    let (mut a, mut v) = ([[0.0; ROWS]; ROWS], [[0.0; ROWS]; ROWS]);
    for i in 0..ROWS {
        v[i][i] = 1.0;
        for j in 0..=i {
            (a[i][j], a[j][i]) = (matrix.entry(i, j), matrix.entry(i, j));
        }
    }
    for _ in 0..SWEEPS {
        for p in 0..ROWS {
            for q in p + 1..ROWS {
                if absent[p] == 0.0 && absent[q] == 0.0 {
                    rotate(&mut a, &mut v, p, q);
                }
            }
        }
    }
    let mut values = [0.0; ROWS];
    for i in 0..ROWS {
        values[i] = a[i][i];
    }
    (values, v)
}

/// Makes the entry (p, q) vanish.
#[inline(always)]
fn rotate(a: &mut Square, v: &mut Square, p: usize, q: usize) {
    let off = a[p][q];
    if off == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * off);
    let t = 1.0 / (theta.abs() + ComplexField::sqrt(theta * theta + 1.0));
    let t = if theta < 0.0 { -t } else { t };
    let c = 1.0 / ComplexField::sqrt(t * t + 1.0);
    let s = t * c;
    for k in 0..ROWS {
        let (x, y) = (a[k][p], a[k][q]);
        (a[k][p], a[k][q]) = (c * x - s * y, s * x + c * y);
    }
    for k in 0..ROWS {
        let (x, y) = (a[p][k], a[q][k]);
        (a[p][k], a[q][k]) = (c * x - s * y, s * x + c * y);
        let (x, y) = (v[k][p], v[k][q]);
        (v[k][p], v[k][q]) = (c * x - s * y, s * x + c * y);
    }
    (a[p][q], a[q][p]) = (0.0, 0.0);
}
