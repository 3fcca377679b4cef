//! Weighted least squares in a box: the joint rates that follow a task best without breaking a limit.
//!
//! > minimise ½ Σᵢ dᵢ (xᵢ − pᵢ)² + ½ Σₖ wₖ (Jₖ x − vₖ)² subject to l ≤ x ≤ u
//!
//! A strictly convex quadratic programme with H = diag(d) + Jᵀ W J and c = −d p − Jᵀ W v. It is kept in this form because its
//! gradient d (x − p) + Jᵀ W (J x − v) then keeps its digits in the directions that J does not see, where d alone decides.
//!
//! # Method
//! Block principal pivoting: L. F. Portugal, J. J. Júdice, L. N. Vicente, "A comparison of block pivoting and interior-point
//! algorithms for linear least squares problems with nonnegative variables", Math. Comp. 63, 1994. Every place is free or stands
//! on a bound. The free ones go to their minimum; those that end beyond a bound are put on it, those that a bound holds back from
//! where it is downhill are freed, all at once. Where that has not helped for some rounds, one at a time, the last first
//! (Murty's rule), which cannot go round in circles. The matrix is the tableau of the sweep operator (`tableau`): a place that
//! changes sides costs one pivot, not a factorisation, and a warm start that was right costs none. What has not ended after
//! N + 8 rounds goes on by a method that is slow and always goes down (`crawl`).
//!
//! # Promises
//! Bounded: at most [`rounds`] rounds, whatever comes in. Total: x is finite and in the box, if there is one.

mod crawl;
mod dampers;
mod gradient;
mod tableau;

pub use dampers::{Damper, Limits, velocity_box};
pub(crate) use gradient::sum;

use crate::lanes::Lanes;
use gradient::{Slope, absolute};
use tableau::Tableau;

/// Rows of a task: a twist has six.
pub const ROWS: usize = 6;

/// Rounds of exchanging all that is wrong without fewer of them, before one at a time.
const PATIENCE: u32 = 3;

/// Rounding of a gradient, as a part of the terms that it is the sum of.
const ROUNDING: f64 = 1e-14;

/// Rounds of exchanging before the slow way is taken.
const fn blocks<const N: usize>() -> usize {
    N + 8
}

/// Rounds after which a problem of `N` places is given up.
#[must_use]
pub const fn rounds<const N: usize>() -> usize {
    blocks::<N>() + 8 * N
}

/// What is to be minimised, where. `N` is 4, 8 or 16; places that are not needed stay as in [`Problem::EMPTY`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Problem<const N: usize> {
    /// J, row by row; rows without weight do not count.
    pub rows: [[f64; N]; ROWS],
    /// v: what J x should be.
    pub target: [f64; ROWS],
    /// w ≥ 0.
    pub row_weight: [f64; ROWS],
    /// p: what x would be without rows.
    pub wish: [f64; N],
    /// d > 0. Below 1e-8 of the largest wₖ |Jₖ|² the digits of x that J does not see become few.
    pub weight: [f64; N],
    /// l, may be −∞.
    pub lower: [f64; N],
    /// u, may be ∞.
    pub upper: [f64; N],
}

impl<const N: usize> Problem<N> {
    /// No rows; every x is 0.
    pub const EMPTY: Self = Self {
        rows: [[0.0; N]; ROWS],
        target: [0.0; ROWS],
        row_weight: [0.0; ROWS],
        wish: [0.0; N],
        weight: [1.0; N],
        lower: [0.0; N],
        upper: [0.0; N],
    };

    /// There is a box, and a single minimum in it.
    #[inline(always)]
    fn is_meant<const FUSED: bool>(&self) -> bool {
        // Nothing that is finite leaves a trace here; NaN and infinity leave NaN.
        let mut trace = Lanes::<N, FUSED>(self.weight) * Lanes(self.wish) * Lanes::ZERO;
        let mut good = true;
        for k in 0..ROWS {
            trace = Lanes(self.rows[k]).mul_add(Lanes::ZERO, trace);
            good &= self.row_weight[k] >= 0.0 && (self.row_weight[k] * self.target[k]).is_finite();
        }
        for i in 0..N {
            good &= self.weight[i] > 0.0;
            good &=
                self.lower[i] <= self.upper[i] && self.lower[i] < f64::INFINITY && self.upper[i] > f64::NEG_INFINITY;
        }
        good && sum(trace) == 0.0
    }

    /// `x` moved into the box.
    #[inline(always)]
    fn inside<const FUSED: bool>(&self, x: Lanes<N, FUSED>) -> Lanes<N, FUSED> {
        let mut inside = x;
        for i in 0..N {
            inside.0[i] = between(x.0[i], self.lower[i], self.upper[i]);
        }
        inside
    }
}

/// Which places stand on a bound: bit i is place i.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Active {
    /// Those on l.
    pub lower: u16,
    /// Those on u.
    pub upper: u16,
}

impl Active {
    /// Those on either bound.
    #[must_use]
    pub const fn any(self) -> u16 {
        self.lower | self.upper
    }
}

/// How it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// x is the minimum.
    Solved,
    /// Given up after [`rounds`] rounds: x is in the box, [`Solution::residual`] says how good it is.
    Capped,
    /// A number that is none, a weight that is no weight, or no box: x is the point of the box nearest to rest.
    Refused,
}

/// Where the minimum is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<const N: usize> {
    /// Finite, and in the box where there is one.
    pub x: [f64; N],
    /// The bounds that hold it: a warm start for a problem like this one.
    pub active: Active,
    /// max |x − clamp(x − g/diag H)|, with the gradient g: 0 at the minimum, in units of x.
    pub residual: f64,
    /// Rounds taken: 1 if the bounds were guessed.
    pub rounds: usize,
    /// How it ended.
    pub outcome: Outcome,
}

/// The minimum of `problem`, looked for from the bounds `warm`.
#[inline(always)]
pub(crate) fn solve<const N: usize, const FUSED: bool>(problem: &Problem<N>, warm: Active) -> Solution<N> {
    if !problem.is_meant::<FUSED>() {
        return refused(problem);
    }
    let mut search = Search::<N, FUSED>::from(problem, warm);
    let (mut taken, mut solved) = (0, false);
    while !solved && taken < blocks::<N>() {
        taken += 1;
        search.descend();
        solved = !search.exchange();
    }
    if !solved {
        search.begin_crawl();
    }
    while !solved && taken < rounds::<N>() {
        taken += 1;
        solved = search.crawl();
    }
    let outcome = if solved { Outcome::Solved } else { Outcome::Capped };
    // Once more, for the digits that the tableau has lost.
    search.descend();
    let x = problem.inside(search.x);
    let residual = search.residual(x);
    let solution = Solution { x: x.0, active: search.active, residual, rounds: taken, outcome };
    // Finite numbers whose squares are not.
    if residual.is_finite() { solution } else { refused(problem) }
}

/// At rest, or as near to it as the box allows.
#[cold]
#[inline(never)]
fn refused<const N: usize>(problem: &Problem<N>) -> Solution<N> {
    let mut x = [0.0; N];
    for i in 0..N {
        let rest = between(0.0, problem.lower[i], problem.upper[i]);
        x[i] = if problem.lower[i] <= problem.upper[i] && rest.is_finite() { rest } else { 0.0 };
    }
    Solution { x, active: Active::default(), residual: f64::NAN, rounds: 0, outcome: Outcome::Refused }
}

/// A problem on the way to its solution.
struct Search<'p, const N: usize, const FUSED: bool> {
    problem: &'p Problem<N>,
    slope: Slope<'p, N, FUSED>,
    tableau: Tableau<N, FUSED>,
    diagonal: Lanes<N, FUSED>,
    /// Σⱼ |Hᵢⱼ|.
    reach: Lanes<N, FUSED>,
    x: Lanes<N, FUSED>,
    g: Lanes<N, FUSED>,
    active: Active,
    /// 1 at free places, 0 at those on a bound.
    free: Lanes<N, FUSED>,
    /// Places whose bounds are one: never freed.
    fixed: u16,
    fewest: u32,
    patience: u32,
}

impl<'p, const N: usize, const FUSED: bool> Search<'p, N, FUSED> {
    /// On the bounds `warm`, as far as there are such.
    #[inline(always)]
    fn from(problem: &'p Problem<N>, warm: Active) -> Self {
        let (mut fixed, mut active) = (0, Active::default());
        let mut x = Lanes(problem.wish);
        for i in 0..N {
            let (l, u) = (problem.lower[i], problem.upper[i]);
            let same = l == u;
            let low = same || (warm.lower >> i & 1 == 1 && l > -f64::INFINITY);
            let high = !low && warm.upper >> i & 1 == 1 && u < f64::INFINITY;
            fixed |= u16::from(same) << i;
            active.lower |= u16::from(low) << i;
            active.upper |= u16::from(high) << i;
            x.0[i] = if low { l } else { x.0[i] };
            x.0[i] = if high { u } else { x.0[i] };
        }
        let slope = Slope::of(problem);
        let rows = slope.curvature();
        let (mut diagonal, mut reach) = (Lanes::ZERO, Lanes::ZERO);
        for i in 0..N {
            diagonal.0[i] = rows[i].0[i];
            reach += absolute(rows[i]);
        }
        let mut tableau = Tableau::new(rows, problem.weight);
        let free = free(active);
        for i in 0..N {
            if free.0[i] > 0.0 {
                tableau.pivot(i);
            }
        }
        let g = slope.at(x);
        Self {
            problem,
            slope,
            tableau,
            diagonal,
            reach,
            x,
            g,
            active,
            free,
            fixed,
            fewest: u32::MAX,
            patience: PATIENCE,
        }
    }

    /// −H⁻¹ g of the free places: to where, with the others as they are, the gradient ends.
    #[inline(always)]
    fn step(&self) -> Lanes<N, FUSED> {
        let (downhill, mut step) = (self.g * self.free, Lanes::ZERO);
        for i in 0..N {
            step = self.tableau.row(i).mul_add(Lanes::splat(downhill.0[i]), step);
        }
        step * self.free
    }

    /// The free places to there.
    #[inline(always)]
    fn descend(&mut self) {
        self.x += self.step();
        self.g = self.slope.at(self.x);
    }

    /// Frees what is held back and binds what is beyond, or one of it; false where nothing is.
    #[inline(always)]
    fn exchange(&mut self) -> bool {
        let (below, above, held) = self.wrong();
        let wrong = below | above | held;
        if wrong == 0 {
            return false;
        }
        let change = self.choose(wrong);
        self.active.lower = (self.active.lower & !(held & change)) | (below & change);
        self.active.upper = (self.active.upper & !(held & change)) | (above & change);
        self.free = free(self.active);
        for i in 0..N {
            if change >> i & 1 == 1 {
                self.tableau.pivot(i);
            }
        }
        // What is free was inside, what is bound has gone to its bound.
        self.x = self.problem.inside(self.x);
        self.g = self.slope.at(self.x);
        true
    }

    /// Free places below l, above u, and those that a bound holds back from going downhill.
    #[inline(always)]
    fn wrong(&self) -> (u16, u16, u16) {
        let (mut below, mut above, mut up, mut down) = (0, 0, 0, 0);
        let noise = self.noise();
        for i in 0..N {
            below |= u16::from(self.x.0[i] < self.problem.lower[i]) << i;
            above |= u16::from(self.x.0[i] > self.problem.upper[i]) << i;
            up |= u16::from(self.g.0[i] < -noise.0[i]) << i;
            down |= u16::from(self.g.0[i] > noise.0[i]) << i;
        }
        let free = !self.active.any();
        let held = (self.active.lower & up | self.active.upper & down) & !self.fixed;
        (below & free, above & free, held)
    }

    /// How far from zero rounding alone can carry the gradient.
    #[inline(always)]
    fn noise(&self) -> Lanes<N, FUSED> {
        let farthest = largest(absolute(self.x));
        (self.reach.mul_add(Lanes::splat(farthest), self.slope.constant)) * Lanes::splat(ROUNDING)
    }

    /// How far from x each place by itself would go, the longest.
    #[inline(always)]
    fn residual(&self, x: Lanes<N, FUSED>) -> f64 {
        let (g, mut alone) = (self.slope.at(x), x);
        for i in 0..N {
            alone.0[i] -= g.0[i] / self.diagonal.0[i];
        }
        largest(absolute(self.problem.inside(alone) - x))
    }

    /// All of `wrong` while that helps, else the last.
    #[inline(always)]
    fn choose(&mut self, wrong: u16) -> u16 {
        let count = wrong.count_ones();
        if count < self.fewest {
            (self.fewest, self.patience) = (count, PATIENCE);
            return wrong;
        }
        self.patience = self.patience.saturating_sub(1);
        if self.patience > 0 { wrong } else { 1 << wrong.ilog2() }
    }
}

/// 1 at the places that stand on no bound.
#[inline(always)]
fn free<const N: usize, const FUSED: bool>(active: Active) -> Lanes<N, FUSED> {
    let mut free = Lanes::ZERO;
    for i in 0..N {
        free.0[i] = f64::from(!active.any() >> i & 1);
    }
    free
}

/// The largest; NaN if there is one.
#[inline(always)]
fn largest<const N: usize, const FUSED: bool>(x: Lanes<N, FUSED>) -> f64 {
    let mut largest = x.0[0];
    for x in x.0 {
        largest = if x <= largest { largest } else { x };
    }
    largest
}

/// `x` moved to within `low` ≤ `high`.
#[inline(always)]
pub(crate) fn between(x: f64, low: f64, high: f64) -> f64 {
    let raised = if x < low { low } else { x };
    if raised > high { high } else { raised }
}
