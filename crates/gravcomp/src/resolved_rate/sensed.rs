//! A base whose turning a sensor measures: followed while that is trusted, left and taken up again on a ramp.

use nalgebra::Vector3;

/// How long the turning goes from what it was to what it should be, s, when trust is lost or found.
const BLEND_S: f64 = 0.05;

/// How long a sensor may go without a step, s: so long its turning is carried on.
const PATIENCE_S: f64 = 0.01;

/// How a base turns, for those who move against it.
///
/// A base that nobody measures counts as still: what turned may have stopped. Every change of trust goes on from the turning
/// of the moment, ω = (1 − s) ω₀ + s ω_goal.
#[derive(Clone, Copy, Debug)]
pub struct SensedBase {
    turning: Vector3<f64>,
    /// ω₀
    from: Vector3<f64>,
    is_followed: bool,
    /// Since that changed, s.
    blending_s: f64,
    /// Steps of the sensor that were seen, and time since the last of them, s.
    steps: u64,
    unstepped_s: f64,
}

impl SensedBase {
    /// Still; of a sensor that has taken so many steps.
    #[must_use]
    pub fn new(steps: u64) -> Self {
        let still = Vector3::zeros();
        Self { turning: still, from: still, is_followed: false, blending_s: BLEND_S, steps, unstepped_s: 0.0 }
    }

    /// The middle of the next `dt` seconds, s after the last step of a sensor that has taken so many.
    #[must_use]
    pub fn ahead(&mut self, steps: u64, dt: f64) -> f64 {
        self.unstepped_s = if steps == self.steps { self.unstepped_s + dt } else { 0.0 };
        self.steps = steps;
        0.5 * dt + self.unstepped_s.min(PATIENCE_S)
    }

    /// The angular velocity to move against in the next `dt` seconds, rad/s, and whether it is in doubt, from what the sensor
    /// says and whether that is trusted.
    #[must_use]
    pub fn follow(&mut self, said: &Vector3<f64>, is_trusted: bool, dt: f64) -> (Vector3<f64>, bool) {
        let is_followed = is_trusted && self.unstepped_s <= PATIENCE_S;
        if is_followed != self.is_followed {
            (self.is_followed, self.from, self.blending_s) = (is_followed, self.turning, 0.0);
        }
        self.blending_s = (self.blending_s + dt).min(BLEND_S);
        let goal = if is_followed { *said } else { Vector3::zeros() };
        let share = self.blending_s / BLEND_S;
        self.turning = self.from * (1.0 - share) + goal * share;
        (self.turning, !is_followed || share < 1.0)
    }
}
