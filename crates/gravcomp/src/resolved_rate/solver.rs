//! The damped inverse: J⁺ = Jᵀ (J Jᵀ + λ² 1)⁻¹, or (Jᵀ J + λ² 1)⁻¹ Jᵀ where there are fewer coordinates than rows.
//!
//! The smallest singular value σ is not computed but tracked, by one step of inverse iteration per cycle with the factors
//! that the task needs anyway (A. Maciejewski, C. Klein, Int. J. Robotics Research 7(6), 1988): from the unit vector u of the
//! last cycle and A w = u comes σ² + λ² = (w·u)/(w·w), and w/|w| is the next u. How well u fits w says whether one step was
//! enough; where it was not (after a jump of the arm), more are taken.

use super::factor::{Factor, Matrix, ROWS, Sides};
use super::settings::{Damping, Settings};
use crate::lanes::Lanes;
use nalgebra::ComplexField;

/// Places of the right-hand sides: the task's, the tracked vector, and what a wish of the joints does to the task.
pub(super) const TASK: usize = 0;
pub(super) const TRACKED: usize = 1;
pub(super) const WISH: usize = 2;

/// cos² of the angle by which the tracked vector may turn in a cycle before more steps are taken.
const ALIGNED: f64 = 0.95;

/// cos² with which they end.
const SETTLED: f64 = 1.0 - 1e-6;

/// What an estimate may be beyond a bound that it does not exceed.
const LOOSE: f64 = 1.001;

/// Most steps.
const STEPS: usize = 12;

/// What is added to the tracked vector along one row per cycle: a smaller singular value in a direction that the rows keep
/// apart is found though rounding never mixes them; σ changes by 5e-7 of itself.
const STIR: f64 = 1e-3;

/// Share of λ_max² by which the damping in use may differ from that of σ as it is found.
const STALE: f64 = 0.05;

/// σ, λ and the task's own measure.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Condition {
    /// σ²
    pub sigma_squared: f64,
    /// λ²
    pub damping_squared: f64,
}

/// What the damped inverse remembers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solver {
    damping: Damping,
    eps_squared: f64,
    eps: f64,
    most: f64,
    /// u
    tracked: [f64; ROWS],
    /// λ² of the last cycle.
    last: f64,
    /// Ones in the rows of the system that are there.
    there: [f64; ROWS],
    turn: usize,
}

impl Solver {
    /// Of a system with these rows.
    pub(super) fn new(settings: &Settings, there: [f64; ROWS]) -> Self {
        Self {
            damping: settings.damping,
            eps: settings.eps,
            eps_squared: settings.eps * settings.eps,
            most: settings.lambda_max * settings.lambda_max,
            tracked: there,
            last: 0.0,
            there,
            turn: 0,
        }
    }

    /// Solves the system for all sides, of which that of the tracked vector is filled in here.
    #[inline(always)]
    pub(super) fn solve<const FUSED: bool>(&mut self, matrix: &Matrix, sides: &mut Sides<FUSED>) -> Condition {
        let given = *sides;
        let mut damping = match self.damping {
            Damping::Adaptive => self.last,
            Damping::Constant => self.most,
            _ => 0.0,
        };
        let mut factor = Factor::of::<FUSED>(matrix, damping);
        let (mut steps, mut enough) = (0, ALIGNED);
        loop {
            *sides = given;
            for r in 0..ROWS {
                sides[r].0[TRACKED] = self.tracked[r];
            }
            factor.solve(sides);
            let seen = Seen::of(sides, &self.tracked);
            // No eigenvalue is larger than the smallest pivot, if it is the smallest.
            let aligned = seen.aligned >= enough && seen.eigenvalue <= factor.least * LOOSE;
            self.track(&seen);
            if !aligned && steps < STEPS {
                (steps, enough) = (steps + 1, SETTLED);
                continue;
            }
            let sigma_squared = (seen.eigenvalue - damping).max(0.0);
            let wanted = self.law(sigma_squared, factor.determinant);
            self.last = wanted;
            if self.damping == Damping::Filtered {
                filter(sides, &seen, wanted);
                return Condition { sigma_squared, damping_squared: wanted };
            }
            let stale = (wanted - damping).abs() > STALE * self.most || (wanted == 0.0 && damping > 0.0);
            if !stale || steps > STEPS {
                return Condition { sigma_squared, damping_squared: damping };
            }
            damping = wanted;
            factor = Factor::of::<FUSED>(matrix, damping);
            steps = STEPS + 1;
        }
    }

    /// λ² for σ², or for the determinant.
    #[inline(always)]
    fn law(&self, sigma_squared: f64, determinant: f64) -> f64 {
        match self.damping {
            Damping::Adaptive | Damping::Filtered if sigma_squared < self.eps_squared => {
                self.most * (1.0 - sigma_squared / self.eps_squared)
            }
            Damping::Manipulability if determinant < self.eps_squared => {
                let short = 1.0 - ComplexField::sqrt(determinant) / self.eps;
                self.most * short * short
            }
            Damping::Constant => self.most,
            _ => 0.0,
        }
    }

    /// The vector of the next cycle.
    #[inline(always)]
    fn track(&mut self, seen: &Seen) {
        let sum: f64 = seen.vector.iter().sum();
        self.tracked = if sum.is_finite() { seen.vector } else { self.there };
        self.turn = if self.turn + 1 < ROWS { self.turn + 1 } else { 0 };
        self.tracked[self.turn] += STIR * self.there[self.turn];
    }
}

/// What a step of inverse iteration shows.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// w
    solution: [f64; ROWS],
    /// u
    before: [f64; ROWS],
    /// w/|w|
    vector: [f64; ROWS],
    /// (w·u)/(w·w)
    eigenvalue: f64,
    /// (w·u)²/(w·w)(u·u)
    aligned: f64,
}

impl Seen {
    #[inline(always)]
    fn of<const FUSED: bool>(sides: &Sides<FUSED>, u: &[f64; ROWS]) -> Self {
        let mut solution = [0.0; ROWS];
        let (mut ww, mut wu, mut uu) = (Lanes::<1, FUSED>::ZERO, Lanes::ZERO, Lanes::ZERO);
        for r in 0..ROWS {
            let (w, u) = (sides[r].0[TRACKED], Lanes([u[r]]));
            solution[r] = w;
            let w = Lanes([w]);
            ww = w.mul_add(w, ww);
            wu = w.mul_add(u, wu);
            uu = u.mul_add(u, uu);
        }
        let ([ww], [wu], [uu]) = (ww.0, wu.0, uu.0);
        let shrink = 1.0 / ww;
        let unit = ComplexField::sqrt(shrink);
        let mut vector = solution;
        for x in &mut vector {
            *x *= unit;
        }
        Self { solution, before: *u, vector, eigenvalue: wu * shrink, aligned: wu * wu * shrink / uu }
    }
}

/// (A + λ² u uᵀ)⁻¹ from A⁻¹ (Sherman and Morrison): y − w λ² (u·y) / (1 + λ² u·w) for each side y.
#[inline(always)]
fn filter<const FUSED: bool>(sides: &mut Sides<FUSED>, seen: &Seen, squared: f64) {
    let mut along = Lanes::ZERO;
    let (mut wu, mut uu) = (0.0, 0.0);
    for r in 0..ROWS {
        along = sides[r].mul_add(seen.before[r].into(), along);
        wu += seen.solution[r] * seen.before[r];
        uu += seen.before[r] * seen.before[r];
    }
    let share = squared / (uu + squared * wu);
    for r in 0..ROWS {
        sides[r] = along.neg_mul_add((seen.solution[r] * share).into(), sides[r]);
    }
}
