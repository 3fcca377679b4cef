//! The damped inverse: J⁺ = Jᵀ (J Jᵀ + λ² 1)⁻¹, or (Jᵀ J + λ² 1)⁻¹ Jᵀ where there are fewer coordinates than rows.
//!
//! The smallest singular value σ is not computed but tracked, by one step of inverse iteration per cycle with the factors
//! that the task needs anyway (A. Maciejewski, C. Klein, Int. J. Robotics Research 7(6), 1988): from the unit vector u of the
//! last cycle and A w = u comes σ² + λ² = (w·u)/(w·w), and w/|w| is the next u. How well u fits w says whether one step was
//! enough; where it was not (after a jump of the arm), more are taken.

use super::factor::{Factor, Matrix, ROWS};
use super::settings::{Damping, Settings};
use super::task::{Six, product};
use crate::lanes::Lanes;
use nalgebra::ComplexField;

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

/// What the system gives for the task and for what a wish of the joints does to it, with σ and λ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solved<const FUSED: bool> {
    pub task: Six<FUSED>,
    pub wish: Six<FUSED>,
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
    /// u, in halves.
    tracked: [[f64; 4]; 2],
    /// λ² of the last cycle.
    last: f64,
    /// Ones in the rows of the system that are there, in halves.
    there: [[f64; 4]; 2],
    turn: usize,
}

impl Solver {
    /// Of a system with these rows.
    pub(super) fn new(settings: &Settings, [x, y, z, u, v, w]: [f64; ROWS]) -> Self {
        let there = [[x, y, z, 0.0], [u, v, w, 0.0]];
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

    /// Solves the system for the task's side and the wish's, if there is one.
    #[inline(always)]
    pub(super) fn solve<const FUSED: bool>(
        &mut self,
        matrix: &Matrix<FUSED>,
        task: Six<FUSED>,
        wish: Option<Six<FUSED>>,
    ) -> Solved<FUSED> {
        let mut damping = match self.damping {
            Damping::Adaptive => self.last,
            Damping::Constant => self.most,
            _ => 0.0,
        };
        let mut factor = Factor::of(matrix, damping);
        let mut seen = self.look(&factor);
        let (mut steps, mut enough) = (0, ALIGNED);
        while !seen.settles(enough, &factor) && steps < STEPS {
            seen = self.look(&factor);
            (steps, enough) = (steps + 1, SETTLED);
        }
        let mut sigma_squared = seen.beyond(damping);
        self.last = self.law(sigma_squared, &factor);
        if self.is_stale(damping) {
            damping = self.last;
            factor = Factor::of(matrix, damping);
            seen = self.look(&factor);
            sigma_squared = seen.beyond(damping);
            self.last = self.law(sigma_squared, &factor);
        }
        let (mut task, mut wish) = (factor.solve(&task), wish.map(|wish| factor.solve(&wish)));
        if self.damping == Damping::Filtered {
            damping = self.last;
            (task, wish) = (seen.filtered(task, damping), wish.map(|wish| seen.filtered(wish, damping)));
        }
        Solved { task, wish: wish.unwrap_or([Lanes::ZERO; 2]), sigma_squared, damping_squared: damping }
    }

    /// A step of inverse iteration.
    #[inline(always)]
    fn look<const FUSED: bool>(&mut self, factor: &Factor<FUSED>) -> Seen<FUSED> {
        let before = self.tracked.map(Lanes);
        let seen = Seen::of(factor.solve(&before), before);
        self.track(&seen);
        seen
    }

    /// The damping in use is not what σ asks for; where it is filtered, none is in use.
    #[inline(always)]
    fn is_stale(&self, damping: f64) -> bool {
        let tolerance = if self.damping == Damping::Adaptive { STALE * self.most } else { 0.0 };
        let is_other = (self.last - damping).abs() > tolerance || (self.last == 0.0 && damping > 0.0);
        is_other && self.damping != Damping::Filtered
    }

    /// λ² for σ², or for the determinant.
    #[inline(always)]
    fn law<const FUSED: bool>(&self, sigma_squared: f64, factor: &Factor<FUSED>) -> f64 {
        match self.damping {
            Damping::Adaptive | Damping::Filtered if sigma_squared < self.eps_squared => {
                self.most * (1.0 - sigma_squared / self.eps_squared)
            }
            Damping::Manipulability => {
                let short = 1.0 - ComplexField::sqrt(factor.determinant()) / self.eps;
                if short > 0.0 { self.most * short * short } else { 0.0 }
            }
            Damping::Constant => self.most,
            _ => 0.0,
        }
    }

    /// The vector of the next cycle.
    #[inline(always)]
    fn track<const FUSED: bool>(&mut self, seen: &Seen<FUSED>) {
        let [upper, lower] = seen.vector;
        self.tracked = if seen.eigenvalue.is_finite() { [upper.0, lower.0] } else { self.there };
        self.turn = if self.turn + 1 < ROWS { self.turn + 1 } else { 0 };
        let (half, row) = if self.turn < 3 { (0, self.turn) } else { (1, self.turn - 3) };
        self.tracked[half][row] += STIR * self.there[half][row];
    }
}

/// What a step of inverse iteration shows.
#[derive(Clone, Copy, Debug)]
struct Seen<const FUSED: bool> {
    /// w
    solution: Six<FUSED>,
    /// u
    before: Six<FUSED>,
    /// w/|w|
    vector: Six<FUSED>,
    /// (w·u)/(w·w)
    eigenvalue: f64,
    /// (w·u)²/(w·w)(u·u)
    aligned: f64,
}

impl<const FUSED: bool> Seen<FUSED> {
    #[inline(always)]
    fn of(solution: Six<FUSED>, before: Six<FUSED>) -> Self {
        let (ww, wu) = (product(&solution, &solution), product(&solution, &before));
        let uu = product(&before, &before);
        let shrink = 1.0 / ww;
        let unit = Lanes::splat(ComplexField::sqrt(shrink));
        let vector = [solution[0] * unit, solution[1] * unit];
        Self { solution, before, vector, eigenvalue: wu * shrink, aligned: wu * wu * shrink / uu }
    }

    /// One step was enough. No eigenvalue is larger than the smallest pivot, if it is the smallest.
    #[inline(always)]
    fn settles(&self, enough: f64, factor: &Factor<FUSED>) -> bool {
        self.aligned >= enough && self.eigenvalue <= factor.least() * LOOSE
    }

    /// σ²
    #[inline(always)]
    fn beyond(&self, damping: f64) -> f64 {
        (self.eigenvalue - damping).max(0.0)
    }

    /// (A + λ² u uᵀ)⁻¹ b from y = A⁻¹ b (Sherman and Morrison): y − w λ² (u·y) / (u·u + λ² u·w).
    #[inline(always)]
    fn filtered(&self, y: Six<FUSED>, squared: f64) -> Six<FUSED> {
        let (wu, uu) = (product(&self.solution, &self.before), product(&self.before, &self.before));
        let share = Lanes::splat(squared * product(&self.before, &y) / (uu + squared * wu));
        [self.solution[0].neg_mul_add(share, y[0]), self.solution[1].neg_mul_add(share, y[1])]
    }
}
