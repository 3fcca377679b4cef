//! The slow way that always goes down: a primal active set, one bound at a time, never out of the box.
//!
//! J. Nocedal, S. J. Wright, "Numerical Optimization", 2nd ed., 2006, section 16.5. Exchanging blocks can take very many rounds
//! (about one problem in 10⁴ of those drawn to be bad); from where it was given up, this takes a few.

use super::{Search, between};
use crate::lanes::Lanes;

impl<const N: usize, const FUSED: bool> Search<'_, N, FUSED> {
    /// Into the box, before the first step.
    #[inline(always)]
    pub(super) fn begin_crawl(&mut self) {
        self.x = self.problem.inside(self.x);
        self.g = self.slope.at(self.x);
    }

    /// The free places towards their minimum, as far as the first bound, which binds; or there, and the place is freed that is
    /// held back most. True where there is none.
    #[inline(always)]
    pub(super) fn crawl(&mut self) -> bool {
        let step = self.step();
        let (nearest, room) = self.first_bound(&step);
        if room < 1.0 {
            self.x = step.mul_add(Lanes::splat(room), self.x);
            self.bind(nearest, step.0[nearest] > 0.0);
        } else {
            self.descend();
            self.x = self.problem.inside(self.x);
            let held = self.wrong().2;
            if held == 0 {
                return true;
            }
            self.release(self.worst(held));
        }
        self.begin_crawl();
        false
    }

    /// The free place that meets its bound first, and after which part of the step.
    #[inline(always)]
    fn first_bound(&self, step: &Lanes<N, FUSED>) -> (usize, f64) {
        let (mut nearest, mut least) = (0, f64::INFINITY);
        for i in 0..N {
            let (x, step) = (self.x.0[i], step.0[i]);
            let bound = if step > 0.0 { self.problem.upper[i] } else { self.problem.lower[i] };
            let room = if step == 0.0 { f64::INFINITY } else { (bound - x) / step };
            if room < least {
                (nearest, least) = (i, room);
            }
        }
        (nearest, between(least, 0.0, f64::INFINITY))
    }

    /// Among `held`, the one that would go farthest by itself.
    #[inline(always)]
    fn worst(&self, held: u16) -> usize {
        let (mut worst, mut farthest) = (0, 0.0);
        for i in 0..N {
            let far = (self.g.0[i] / self.diagonal.0[i]).abs();
            if held >> i & 1 == 1 && far > farthest {
                (worst, farthest) = (i, far);
            }
        }
        worst
    }

    #[inline(always)]
    fn bind(&mut self, i: usize, above: bool) {
        self.x.0[i] = if above { self.problem.upper[i] } else { self.problem.lower[i] };
        self.active.upper |= u16::from(above) << i;
        self.active.lower |= u16::from(!above) << i;
        self.free.0[i] = 0.0;
        self.tableau.pivot(i);
    }

    #[inline(always)]
    fn release(&mut self, i: usize) {
        self.active.upper &= !(1 << i);
        self.active.lower &= !(1 << i);
        self.free.0[i] = 1.0;
        self.tableau.pivot(i);
    }
}
