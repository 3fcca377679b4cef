//! Whether gravity turns as the gyroscope says.
//!
//! The mean of the specific force f = a − g, carried along with the turning base, is gravity and a mean of the base's own
//! acceleration a. While no |a| is larger than A, f is never further than 2A from it, however the base moves and however
//! young the mean is.

use super::carried::Carried;
use super::clock::seconds;
use super::settings::Settings;
use crate::base::BaseMotion;

/// Samples in a row that contradict the gyroscope.
const CONTRADICTIONS: u32 = 3;

/// The mean over the time in which there was a gyroscope.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Turning {
    mean: Option<Carried>,
    /// Stamp of the last sample, ns.
    last_ns: i64,
    /// Time since trust was lost, s: what is doubted must not change what it is measured by.
    doubted: Option<f64>,
    apart: u32,
}

impl Turning {
    /// Takes the motion that the chain made of a sample; none without a gyroscope. True when three in a row, of a filter that
    /// has settled, were too far from where the gyroscope had carried gravity.
    pub(super) fn contradicts(
        &mut self,
        stamp_ns: i64,
        motion: Option<&BaseMotion>,
        settled: bool,
        settings: &Settings,
    ) -> bool {
        let elapsed_ns = stamp_ns.saturating_sub(self.last_ns);
        self.last_ns = stamp_ns;
        if motion.is_none() || !(1..=settings.max_age_ns).contains(&elapsed_ns) {
            (self.mean, self.doubted, self.apart) = (None, None, 0);
        }
        motion.is_some_and(|motion| self.compare(motion, seconds(elapsed_ns), settled, settings))
    }

    fn compare(&mut self, motion: &BaseMotion, dt: f64, settled: bool, settings: &Settings) -> bool {
        let f = motion.specific_force.0;
        if let Some(mean) = &mut self.mean {
            mean.turn(&motion.angular_velocity, dt);
        }
        self.doubted = self.doubted.map(|time| time + dt);
        if self.doubted.is_some_and(|time| time > settings.tilt_time) {
            (self.mean, self.doubted) = (None, None);
        }
        if !settled {
            return false;
        }
        let mean = self.mean.get_or_insert(Carried::new(f, 0.0));
        let is_apart = (f - mean.mean()).norm() > settings.apart();
        self.apart = if is_apart { self.apart.saturating_add(1) } else { 0 };
        if self.doubted.is_none() {
            mean.mix(&f, dt.min(seconds(settings.max_age_ns)), settings.tilt_time);
        }
        self.apart >= CONTRADICTIONS
    }

    /// A run begins: anew, unless a trusted sensor was before it.
    pub(super) fn begin(&mut self) {
        if self.doubted.is_none() {
            self.mean = None;
        }
    }

    /// Trust is lost: from now on the mean is only carried, for as long as it would reach back.
    pub(super) fn doubt(&mut self) {
        self.doubted = self.mean.map(|_| 0.0);
    }

    /// Trust is regained.
    pub(super) fn trust(&mut self) {
        self.doubted = None;
    }
}
