//! Where the target was: the last samples, and what lies between them.

use super::Point;

/// Samples that are kept: a power of two, so that an index wraps without a division.
const RING: usize = 128;

#[derive(Clone, Copy, Debug)]
struct Place {
    t: f64,
    y: Point,
    /// 1/(time since the sample before), 1/s
    pace: f64,
}

/// A ring of samples in order of time.
#[derive(Clone, Debug)]
pub(super) struct Past {
    places: [Place; RING],
    newest: usize,
    count: usize,
}

/// A sample of the past, by how many came after it.
pub(super) type Back = usize;

impl Past {
    pub(super) const fn new() -> Self {
        let none = Place { t: 0.0, y: Point::new(0.0, 0.0, 0.0), pace: 0.0 };
        Self { places: [none; RING], newest: 0, count: 0 }
    }

    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    pub(super) fn push(&mut self, t: f64, y: &Point) {
        let pace = 1.0 / (t - self.place(0).t);
        self.newest = (self.newest + 1) % RING;
        self.places[self.newest] = Place { t, y: *y, pace };
        self.count = (self.count + 1).min(RING);
    }

    #[inline(always)]
    const fn place(&self, back: Back) -> &Place {
        &self.places[self.newest.wrapping_sub(back) % RING]
    }

    /// Time and place of a sample, if there were so many.
    pub(super) fn sample(&self, back: Back) -> Option<(f64, Point)> {
        let place = self.place(back);
        (back < self.count).then_some((place.t, place.y))
    }

    /// The newest sample that is not younger than `t`, or none.
    pub(super) fn until(&self, t: f64) -> Option<Back> {
        (0..self.count).find(|back| self.place(*back).t <= t)
    }

    /// The place at `t`, on the straight line between the samples around it, sought from `from` backwards; where the search
    /// ended, to go on from there for an earlier time. None before the first sample.
    #[inline(always)]
    pub(super) fn at(&self, t: f64, from: Back) -> Option<(Point, Back)> {
        let (mut back, mut after) = (from, self.place(from));
        while back + 1 < self.count {
            let before = self.place(back + 1);
            if before.t <= t {
                let share = ((t - before.t) * after.pace).min(1.0);
                return Some((before.y + (after.y - before.y) * share, back));
            }
            (back, after) = (back + 1, before);
        }
        None
    }
}
