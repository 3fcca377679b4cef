//! What a sample must be by itself before anybody looks at what it says.

use super::fault::{Fault, Faults};
use super::sample::Sample;
use super::settings::Settings;
use nalgebra::Vector3;

/// Share of the full scale from which on an axis counts as saturated.
const SATURATED: f64 = 0.989;

/// How far in the future a stamp may lie, ns: two threads read one clock.
const FUTURE_NS: i64 = 2_000_000;

/// From this age on a stamp is not late but from another clock, ns.
const FOREIGN_NS: i64 = 1_000_000_000;

/// A sample that may be true, calibrated, in the sensor's axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Felt {
    pub(super) seq: u64,
    pub(super) stamp_ns: i64,
    /// m/s²
    pub(super) force: Vector3<f64>,
    /// rad/s
    pub(super) rate: Option<Vector3<f64>>,
}

/// Remembers what the sensor sent last, to see when it repeats itself.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gate {
    previous: Option<Vector3<f64>>,
    /// Repetitions in a row, of all three axes at once and of each.
    repeats: u32,
    axis_repeats: [u32; 3],
}

impl Gate {
    /// What is wrong with the stamp.
    pub(super) fn stamp(settings: &Settings, now_ns: i64, stamp_ns: i64) -> Faults {
        let age = now_ns.saturating_sub(stamp_ns);
        let foreign = age < -FUTURE_NS || age > FOREIGN_NS.max(2 * settings.max_age_ns);
        Faults::when(foreign, Fault::Clock).and(Faults::when(!foreign && age > settings.max_age_ns, Fault::Late))
    }

    /// The sample as it was felt; or what is wrong with its numbers.
    pub(super) fn felt(&mut self, settings: &Settings, sample: &Sample) -> Result<Felt, Faults> {
        let rate = sample.angular_velocity;
        let sent = sample.specific_force.iter().chain(rate.iter().flatten());
        if !sent.clone().all(|x| x.is_finite()) {
            return Err(Faults::only(Fault::NotFinite));
        }
        let stuck = Faults::when(self.is_stuck(settings, sample.specific_force), Fault::Stuck);
        if saturated(&sample.specific_force, settings.range) || rate.is_some_and(|w| saturated(&w, settings.gyro_range))
        {
            return Err(stuck.and(Faults::only(Fault::Range)));
        }
        let force = settings.calibration.specific_force(&sample.specific_force);
        let (norm, (low, high)) = (force.norm(), settings.norm);
        let falls = Faults::when(norm < low && !settings.moving_base, Fault::LowG);
        let faults = stuck.and(falls).and(Faults::when(norm > high, Fault::Norm));
        let rate = rate.map(|w| settings.calibration.angular_velocity(&w));
        let felt = Felt { seq: sample.seq, stamp_ns: sample.stamp_ns, force, rate };
        if faults.is_empty() { Ok(felt) } else { Err(faults) }
    }

    /// Real sensors have noise: the same bits again and again are no measurement.
    fn is_stuck(&mut self, settings: &Settings, sent: Vector3<f64>) -> bool {
        let before = self.previous.replace(sent);
        let same = |i: usize| before.is_some_and(|before| before[i] == sent[i]);
        for i in 0..3 {
            again(&mut self.axis_repeats[i], same(i));
        }
        again(&mut self.repeats, (0..3).all(same));
        let reached = |repeats: u32, count: u32| count > 0 && repeats + 1 >= count;
        reached(self.repeats, settings.stuck_count)
            || self.axis_repeats.iter().any(|axis| reached(*axis, settings.axis_stuck_count))
    }
}

fn saturated(sent: &Vector3<f64>, full_scale: f64) -> bool {
    sent.amax() >= SATURATED * full_scale
}

/// One more repetition, or none.
fn again(count: &mut u32, same: bool) {
    *count = if same { count.saturating_add(1).min(u32::MAX - 1) } else { 0 };
}
