//! Where the target was: the last samples, and what lies between them.

use super::Point;

/// Samples that are kept.
const RING: usize = 160;

/// A ring of samples in order of time.
#[derive(Clone, Debug)]
pub(super) struct Past {
    times: [f64; RING],
    places: [Point; RING],
    newest: usize,
    count: usize,
}

/// A sample of the past, by how many came after it.
pub(super) type Back = usize;

impl Past {
    pub(super) const fn new() -> Self {
        let none = Point::new(0.0, 0.0, 0.0);
        Self { times: [0.0; RING], places: [none; RING], newest: 0, count: 0 }
    }

    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    pub(super) fn push(&mut self, t: f64, y: &Point) {
        self.newest = (self.newest + 1) % RING;
        (self.times[self.newest], self.places[self.newest]) = (t, *y);
        self.count = (self.count + 1).min(RING);
    }

    fn slot(&self, back: Back) -> usize {
        (self.newest + RING - back % RING) % RING
    }

    /// Time and place of a sample, if there were so many.
    pub(super) fn sample(&self, back: Back) -> Option<(f64, Point)> {
        let slot = self.slot(back);
        (back < self.count).then(|| (self.times[slot], self.places[slot]))
    }

    /// The newest sample that is not younger than `t`, or none.
    pub(super) fn until(&self, t: f64) -> Option<Back> {
        (0..self.count).find(|back| self.times[self.slot(*back)] <= t)
    }

    /// The place at `t`, on the straight line between the samples around it, sought from `from` backwards; where the search
    /// ended, to go on from there for an earlier time. None before the first sample.
    pub(super) fn at(&self, t: f64, from: Back) -> Option<(Point, Back)> {
        let mut back = from;
        while back + 1 < self.count {
            let (before, after) = (self.slot(back + 1), self.slot(back));
            if self.times[before] <= t {
                let share = (t - self.times[before]) / (self.times[after] - self.times[before]);
                return Some((self.places[before].lerp(&self.places[after], share.min(1.0)), back));
            }
            back += 1;
        }
        None
    }
}
