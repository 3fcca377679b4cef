//! What a gyroscope adds to the trust in an accelerometer, and what a bad one must not do to it.

use crate::accelerometer::{Feed, PERIOD_NS, tilted};
use crate::scale::cases;
use gravcomp::accelerometer::{Fault, Policy, Reading, Settings, State};
use gravcomp::{Mounting, STANDARD_GRAVITY};
use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::prelude::*;
use std::f64::consts::TAU;

const POLICIES: [Policy; 2] = [Policy::Paper, Policy::Strict];

/// A sensor with a gyroscope at `position`, trusted for `samples` on a base at rest.
fn live(policy: Policy, position: Vector3<f64>, samples: u32) -> Feed {
    let mounting = Mounting::new(Matrix3::identity(), position).expect("a rotation");
    let mut feed = Feed::new(&Settings { policy, mounting, ..Settings::default() });
    feed.rate = Some(Vector3::zeros());
    assert_eq!(feed.feel(tilted(15.0), samples).state, State::Live);
    feed
}

/// A base that rocks by `amplitude` about `axis` and shakes by `shake` m/s² at 1 Hz: the angular velocity, rad/s, and the
/// specific force, m/s², of its origin at time `t`, s.
fn rocking(axis: &Vector3<f64>, amplitude: f64, shake: &Vector3<f64>, t: f64) -> (Vector3<f64>, Vector3<f64>) {
    let (sin, cos) = (TAU * t).sin_cos();
    let turned = Rotation3::new(axis * -(amplitude * sin));
    (axis * (amplitude * TAU * cos), turned * (STANDARD_GRAVITY * Vector3::z() + shake * (TAU * t + 1.0).sin()))
}

/// Feeds so many samples of a rocking base through what the sensor makes of them; the first reading with an alarm.
fn rock(
    feed: &mut Feed,
    samples: u32,
    motion: impl Fn(f64) -> (Vector3<f64>, Vector3<f64>),
    sensor: impl Fn(Vector3<f64>, Vector3<f64>) -> (Vector3<f64>, Vector3<f64>),
) -> Option<(u32, Reading)> {
    (0..samples).find_map(|k| {
        let t = f64::from(u32::try_from(feed.seq).expect("a short test")) * 0.01;
        let (w, f) = motion(t);
        let (w, f) = sensor(w, f);
        feed.rate = Some(w);
        let reading = feed.feel(f, 1);
        reading.status.is_alarm().then_some((k, reading))
    })
}

proptest! {
    #![proptest_config(cases(60))]

    /// However the base turns and shakes within what is declared, and with a gyroscope that is a little off: no alarm.
    #[test]
    fn a_base_that_turns_as_its_gyroscope_says_is_trusted(
        heading in 0.0..TAU,
        amplitude in 0.0..0.3_f64,
        shake in prop::array::uniform3(-0.8..0.8_f64),
        bias in prop::array::uniform3(-0.005..0.005_f64),
    ) {
        let axis = Vector3::new(heading.cos(), heading.sin(), 0.0);
        let mut feed = Feed::of(Policy::Strict);
        let alarm = rock(
            &mut feed,
            1500,
            |t| rocking(&axis, amplitude, &shake.into(), t),
            |w, f| (w + Vector3::from(bias), f),
        );
        prop_assert!(alarm.is_none(), "{alarm:?}");
        prop_assert_eq!(feed.step(None).state, State::Live);
    }

    /// Whatever a gyroscope says: a base at rest does not seem to fall over.
    #[test]
    fn no_gyroscope_throws_the_output(
        policy in prop_oneof![Just(Policy::Paper), Just(Policy::Strict)],
        position in prop::array::uniform3(-0.5..0.5_f64),
        rates in prop::collection::vec(rates(), 1..60),
    ) {
        let mut feed = live(policy, position.into(), 100);
        for rate in rates {
            feed.rate = rate;
            let error = (feed.feel(tilted(15.0), 1).gravity.0 + tilted(15.0)).norm();
            prop_assert!(error < 7.0, "{error}");
        }
    }
}

/// What a gyroscope may come to say: nothing, any bits, a jump, or a turn that is none.
fn rates() -> impl Strategy<Value = Option<Vector3<f64>>> {
    let number = prop_oneof![
        1 => any::<u64>().prop_map(f64::from_bits),
        4 => -40.0..40.0_f64,
        20 => -1.5..1.5_f64,
    ];
    proptest::option::weighted(0.95, prop::array::uniform3(number).prop_map(Vector3::from))
}

/// Exchanged while both are level, so that nothing jumps: what follows is not what the gyroscope says.
#[test]
fn axes_exchanged_at_a_level_moment_are_an_alarm() {
    let (axis, amplitude) = (Vector3::x(), 0.3);
    for policy in POLICIES {
        for exchange in [|f: Vector3<f64>| f.yxz(), |f: Vector3<f64>| Vector3::new(f.x, -f.y, f.z)] {
            let mut feed = Feed::of(policy);
            let motion = |t| rocking(&axis, amplitude, &Vector3::zeros(), t);
            assert!(rock(&mut feed, 650, motion, |w, f| (w, f)).is_none());
            let (samples, reading) = rock(&mut feed, 100, motion, |w, f| (w, exchange(f))).expect("an alarm");
            assert!(reading.status.alarms.has(Fault::Turn) && !reading.status.alarms.has(Fault::Jerk));
            assert!(samples < 40, "{samples}");
            let again = rock(&mut feed, 20, motion, |w, f| (w, exchange(f))).expect("it stays");
            assert_ne!(again.1.state, State::Live);
        }
    }
}

/// Twenty samples that agree with each other do not bring back a sensor that the gyroscope still contradicts.
#[test]
fn what_the_gyroscope_contradicts_is_not_trusted_again() {
    let mut feed = live(Policy::Paper, Vector3::zeros(), 600);
    feed.rate = Some(Vector3::new(0.4, 0.0, 0.0));
    while feed.feel(tilted(15.0), 1).state == State::Live {}
    feed.rate = Some(Vector3::zeros());
    assert_eq!(feed.feel(tilted(15.0), 100).state, State::Held);
    assert!(feed.chain.counters().of(Fault::Turn) >= 1);
    feed.chain.acknowledge();
    assert_eq!(feed.feel(tilted(15.0), 20).state, State::Live, "somebody says which of the two is right");
}

#[test]
fn a_gyroscope_that_falls_silent_is_an_alarm() {
    for policy in POLICIES {
        let mut feed = live(policy, Vector3::new(0.3, 0.0, 0.0), 100);
        feed.rate = None;
        assert!(!feed.feel(tilted(15.0), 2).status.is_alarm());
        let reading = feed.feel(tilted(15.0), 1);
        assert!(reading.status.alarms.has(Fault::Gyro) && reading.state != State::Live);
        assert_eq!(feed.chain.counters().of(Fault::Gyro), 3);
        assert_eq!(feed.feel(tilted(15.0), 20).state, State::Live, "without one it is a sensor like any other");
    }
}

#[test]
fn one_spike_of_the_gyroscope_is_dropped_and_no_alarm() {
    for spike in [Vector3::new(0.0, 20.0, 0.0), Vector3::new(1.2, 0.0, 0.0), Vector3::new(0.0, f64::NAN, 0.0)] {
        let mut feed = live(Policy::Strict, Vector3::new(0.0, 0.5, 0.0), 100);
        let before = feed.step(None).gravity.0;
        feed.rate = Some(spike);
        let reading = feed.feel(tilted(15.0), 1);
        feed.rate = Some(Vector3::zeros());
        let after = feed.feel(tilted(15.0), 5);
        assert!(!reading.status.is_alarm() && !after.status.is_alarm(), "{spike}");
        assert!((after.gravity.0 - before).norm() < 0.1, "{spike}");
    }
}

/// A jump that the angular acceleration allows is still none that the lever arm allows: 1 rad/s in 10 ms, half a metre out.
#[test]
fn a_step_of_the_gyroscope_does_not_become_gravity() {
    for policy in POLICIES {
        let mut feed = live(policy, Vector3::new(0.5, 0.0, 0.0), 100);
        feed.rate = Some(Vector3::new(0.0, 1.0, 0.0));
        for _ in 0..100 {
            let error = (feed.feel(tilted(15.0), 1).gravity.0 + tilted(15.0)).norm();
            assert!(error < 4.0, "{error}");
        }
        assert!(feed.chain.counters().of(Fault::Gyro) >= 3);
    }
}

/// A filter that begins anew knows no angular acceleration yet: the lever arm's share is not gravity that turns otherwise.
#[test]
fn a_sensor_far_out_on_a_rocking_base_is_trusted_at_once_and_again() {
    let far = [Vector3::new(0.0, 0.0, 2.0), Vector3::new(0.0, 1.9, 0.0), Vector3::new(0.0, -1.5, 1.5)];
    let cutoffs = [Some(20.0), Some(5.0), None];
    for (r, cutoff_hz) in far.into_iter().flat_map(|r| cutoffs.map(|cutoff_hz| (r, cutoff_hz))) {
        let mounting = Mounting::new(Matrix3::identity(), r).expect("a rotation");
        let mut feed = Feed::new(&Settings { mounting, cutoff_hz, ..Settings::default() });
        let amplitude = 0.08;
        let motion = |t: f64| {
            let (w, f) = rocking(&Vector3::x(), amplitude, &Vector3::zeros(), t);
            let dw = Vector3::x() * (-amplitude * TAU * TAU * (TAU * t).sin());
            (w, f + dw.cross(&r) + w.cross(&w.cross(&r)))
        };
        feed.seq = 15; // ten samples before the angular acceleration is largest
        let alarm = rock(&mut feed, 610, motion, |w, f| (w, f));
        assert!(alarm.is_none(), "{r} {cutoff_hz:?}: {alarm:?}");
        assert_eq!(feed.step(None).state, State::Live, "{r} {cutoff_hz:?}");
        rock(&mut feed, 4, motion, |w, f| (w, f + 10.0 * Vector3::x())).expect("an alarm");
        rock(&mut feed, 1, motion, |w, f| (w, f));
        let restart = feed.seq;
        while feed.step(None).state != State::Live {
            rock(&mut feed, 1, motion, |w, f| (w, f));
            assert!(feed.seq < restart + 100, "{r} {cutoff_hz:?}: not trusted again");
        }
        assert_eq!(feed.chain.counters().of(Fault::Turn), 0, "{r} {cutoff_hz:?}");
    }
}

/// White noise of a poor gyroscope, differentiated, half a metre out.
#[test]
fn gyroscope_noise_hardly_moves_the_output() {
    let mut feed = live(Policy::Strict, Vector3::new(0.5, 0.0, 0.0), 100);
    let mut square = 0.0;
    for k in 0..1000_u32 {
        // Weyl's sequence: as even as it gets, and no two alike.
        let even = |irrational: f64| (f64::from(k) * irrational).fract() - 0.5;
        let noise = 0.003 * 12_f64.sqrt() * Vector3::new(even(2_f64.sqrt()), even(3_f64.sqrt()), even(5_f64.sqrt()));
        feed.rate = Some(noise);
        square += (feed.feel(tilted(15.0), 1).gravity.0 + tilted(15.0)).norm_squared();
    }
    assert!((square / 1000.0).sqrt() < 0.2, "{}", (square / 1000.0).sqrt());
    assert_eq!(feed.step(None).status.word(), 0);
}

/// The mean is carried from stamp to stamp: a clock that jumps back must not carry it for minus an hour.
#[test]
fn a_clock_that_jumps_back_while_the_base_turns_is_survived() {
    let motion = |t| rocking(&Vector3::y(), 0.2, &Vector3::zeros(), t);
    for jump in [PERIOD_NS, 3_600_000_000_000, i64::MAX] {
        let mut feed = Feed::of(Policy::Paper);
        assert!(rock(&mut feed, 600, motion, |w, f| (w, f)).is_none());
        feed.now_ns -= jump;
        rock(&mut feed, 1, motion, |w, f| (w, f)).expect("an alarm");
        while feed.step(None).state != State::Live {
            rock(&mut feed, 1, motion, |w, f| (w, f));
            assert!(feed.seq < 640, "it does not come back");
        }
        assert_eq!(feed.chain.counters().of(Fault::Turn), 0);
        assert!(rock(&mut feed, 600, motion, |w, f| (w, f)).is_none());
    }
}
