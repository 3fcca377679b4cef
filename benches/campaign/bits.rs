//! Samples and times of any bits at all, mixed with good ones so that every state is reached.

use super::flight::{exceeds, is_finite, steps_too_far};
use super::random::Random;
use gravcomp::accelerometer::{Accelerometer, Policy, Reading, Sample, Settings, State};
use gravcomp::{Mounting, STANDARD_GRAVITY};
use nalgebra::{Matrix3, Vector3};

/// What came of a stream of random samples.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bits {
    pub samples: u64,
    pub accepted: u64,
    pub not_finite: u64,
    pub too_far: u64,
    /// Gravity longer than the upper end of the norm window.
    pub too_long: u64,
    /// Cycles in each state, in the order of [`State::ALL`].
    pub in_state: [u64; 6],
}

impl Bits {
    /// Feeds `samples` of them to a chain, in spells of garbage and of a sensor that is all right.
    pub fn feed(samples: u64, policy: Policy, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let mounting = Mounting::new(Matrix3::identity(), Vector3::new(0.3, -0.2, 0.1)).expect("a rotation");
        let settings = Settings { policy, mounting, ..Settings::default() };
        let mut chain = Accelerometer::new(settings).expect("the defaults make sense");
        let mut bits = Self { samples, ..Self::default() };
        let (mut now_ns, mut seq, mut before) = (0_i64, 0_u64, None);
        while seq < samples {
            let garbage = random.within(0.0, 1.0).powi(3);
            let gyro = random.chance(0.7);
            for _ in 0..100.min(samples - seq) {
                seq += 1;
                now_ns = later(now_ns, garbage, &mut random);
                let sample = any_sample(now_ns, seq, gyro, garbage, &mut random);
                let reading = chain.step(now_ns, Some(&sample));
                bits.look(&settings, &reading, before.replace((now_ns, reading)), now_ns);
            }
            if random.chance(0.2) {
                chain.acknowledge();
            }
        }
        Self { accepted: chain.counters().accepted, ..bits }
    }

    fn look(&mut self, settings: &Settings, reading: &Reading, before: Option<(i64, Reading)>, now_ns: i64) {
        self.not_finite += u64::from(!is_finite(reading));
        self.too_long += u64::from(exceeds(reading.gravity.0.norm(), settings.norm.1 * (1.0 + 1e-12)));
        if let Some((then_ns, before)) = before {
            let cycle_ns = now_ns.saturating_sub(then_ns);
            self.too_far += u64::from(steps_too_far(&before, reading, cycle_ns, settings.gravity_rate));
        }
        let state = State::ALL.iter().position(|state| *state == reading.state).expect("all are listed");
        self.in_state[state] += 1;
    }

    pub fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        self.accepted += other.accepted;
        self.not_finite += other.not_finite;
        self.too_far += other.too_far;
        self.too_long += other.too_long;
        for (here, there) in self.in_state.iter_mut().zip(other.in_state) {
            *here += there;
        }
    }
}

/// The next time of a clock that is not always right.
fn later(now_ns: i64, garbage: f64, random: &mut Random) -> i64 {
    if !random.chance(0.01 * garbage) {
        return now_ns.saturating_add(10_000_000);
    }
    match random.below(4) {
        0 => random.bits().cast_signed(),
        1 => now_ns,
        2 => now_ns.saturating_sub(1 << random.below(63)),
        _ => now_ns.saturating_add(1 << random.below(63)),
    }
}

fn any_sample(now_ns: i64, seq: u64, gyro: bool, garbage: f64, random: &mut Random) -> Sample {
    let level = STANDARD_GRAVITY * Vector3::z() + 0.03 * random.normals();
    let mut number = |good: f64| if random.chance(0.3 * garbage) { any_double(random) } else { good };
    let specific_force = level.map(&mut number);
    let rate = Vector3::zeros().map(&mut number);
    Sample {
        seq: if random.chance(0.1 * garbage) { random.bits() } else { seq },
        stamp_ns: if random.chance(0.1 * garbage) {
            random.bits().cast_signed()
        } else {
            now_ns.saturating_sub(1_000_000)
        },
        specific_force,
        angular_velocity: (gyro != random.chance(0.1 * garbage)).then_some(rate),
    }
}

/// Any bits, and those that trip programs up.
fn any_double(random: &mut Random) -> f64 {
    const SPECIAL: [f64; 8] =
        [0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE, 1e300];
    match random.below(4) {
        0 => SPECIAL[random.below(8)],
        1 => random.within(-20.0, 20.0),
        _ => f64::from_bits(random.bits()),
    }
}
