//! Streams as they come: gaps, spikes, repeated and backward stamps, numbers that are none. Never a panic, never an infinite
//! prediction, never a jump that is not noted.

use crate::predictor::Dice;
use gravcomp::Predictor;
use gravcomp::predictor::{Method, Note, Notes, Point, Settings};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn place(t: f64) -> Point {
    Point::new(0.010, 0.004, -0.002) * (TAU * 0.25 * t).sin()
}

/// A predictor that has seen 30 s of a breathing target at 30 Hz.
fn taught(method: Method) -> Predictor {
    let mut predictor = Predictor::new(Settings { method, ..Settings::default() }).expect("settings");
    let mut dice = Dice(3);
    for k in 0..900 {
        let t = f64::from(k) / 30.0;
        let noise = Point::new(dice.normal(), dice.normal(), dice.normal()) * 2e-4;
        predictor.update(t, &(place(t) + noise));
    }
    predictor
}

const METHODS: [Method; 4] = [Method::Switch, Method::Periodic, Method::Autoregressive, Method::Velocity];

#[test]
fn what_is_refused_changes_nothing() {
    for method in METHODS {
        let mut predictor = taught(method);
        let before = predictor.predict(30.07);
        let newest = 899.0 / 30.0;
        let nan = Point::new(0.0, f64::NAN, 0.0);
        for (stamp, y, note) in [
            (newest, place(newest), Note::Repeated),
            (newest - 0.5, place(newest), Note::Backward),
            (f64::NAN, place(30.0), Note::NotFinite),
            (f64::INFINITY, place(30.0), Note::NotFinite),
            (30.0, nan, Note::NotFinite),
            (30.0, Point::new(1e9, 0.0, 0.0), Note::NotFinite),
            (30.0, Point::new(0.1, 0.0, 0.0), Note::Spike),
            (155.0, place(155.0), Note::Gap),
        ] {
            assert!(!predictor.update(stamp, &y));
            assert!(predictor.notes().has(note), "{note:?}");
            assert_eq!(predictor.predict(30.07), before, "{method:?} after {note:?}");
        }
    }
}

#[test]
fn a_step_is_followed_from_its_second_sample_on() {
    for method in METHODS {
        let (mut predictor, step) = (taught(method), Point::new(0.0, 0.1, 0.0));
        assert!(!predictor.update(30.0, &(place(30.0) + step)));
        assert!(predictor.update(30.033, &(place(30.033) + step)));
        assert!(predictor.notes().has(Note::Moved) && predictor.notes().has(Note::Jump));
        for k in 2..90 {
            let t = 30.0 + f64::from(k) / 30.0;
            predictor.update(t, &(place(t) + step));
        }
        let off = predictor.predict(33.05) - place(33.05) - step;
        assert!(off.norm() < 2e-3, "{method:?}: {off}");
    }
}

#[test]
fn a_target_that_starts_fast_after_a_long_rest_is_found_again() {
    // So still that a sample is expected within a tenth of a millimetre, then within the declared speed, but never slow again.
    for (rate, speed) in [(30.0, 0.15), (30.0, 0.45), (5.0, 0.1), (5.0, 0.4)] {
        let settings = Settings { rate_hz: rate, noise: 1e-4, ..Settings::default() };
        let mut predictor = Predictor::new(settings).expect("settings");
        let (mut used, mut off) = (0, 0.0);
        for k in 0..2400 {
            let t = f64::from(k) / rate;
            let place = Point::new(speed * (t - 600.0 / rate).max(0.0), 0.0, 0.0);
            let is_used = predictor.update(t, &place);
            if k > 2000 {
                used += u32::from(is_used);
                off = (predictor.predict(t) - place).norm().max(off);
            }
        }
        assert!(used > 380 && off < 1e-4, "{rate} Hz, {speed} m/s: {used} of 399 used, {off}");
    }
}

#[test]
fn after_a_gap_a_target_at_full_speed_is_found_again() {
    for method in METHODS {
        let mut predictor = taught(method);
        let place = |t: f64| Point::new(0.4 * t, 0.0, 0.0);
        let used = (0..30).map(|k| 33.0 + f64::from(k) / 30.0).filter(|t| predictor.update(*t, &place(*t))).count();
        assert!(used > 25, "{method:?}: {used} of 30 used");
    }
}

#[test]
fn a_clock_that_was_set_is_believed_the_third_time() {
    let mut predictor = taught(Method::Switch);
    for k in 0..60 {
        let t = 2.0 + f64::from(k) / 30.0;
        assert_eq!(predictor.update(t, &place(t)), k >= 2);
        assert_eq!(predictor.notes().has(Note::Restarted), k == 2);
    }
    assert!((predictor.predict(4.0) - place(4.0)).norm() < 3e-3);
}

#[test]
fn one_wrong_stamp_of_many_is_passed_over() {
    // As in a recording of chest markers: one stamp far off, then on as before.
    for wrong in [-125.0, 125.0] {
        let mut predictor = taught(Method::Switch);
        assert!(!predictor.update(30.0 + wrong, &place(30.0)));
        assert!(predictor.update(30.033, &place(30.033)));
        assert!((predictor.predict(30.1) - place(30.1)).norm() < 1e-3);
        assert_eq!(predictor.counters().of(Note::Restarted), 0);
    }
}

#[test]
fn the_cycles_go_on_through_a_gap() {
    let mut predictor = taught(Method::Periodic);
    assert!(!predictor.update(33.0, &place(33.0)));
    assert!(predictor.update(33.033, &place(33.033)));
    assert!(predictor.notes().has(Note::Moved) && predictor.notes().has(Note::Dropped));
    assert!((predictor.predict(33.133) - place(33.133)).norm() < 1.5e-3);
}

#[test]
fn half_of_the_samples_do() {
    let (mut dice, mut sum, mut count) = (Dice(5), 0.0, 0.0);
    let mut predictor = Predictor::new(Settings::default()).expect("settings");
    for k in 0..1800 {
        let t = f64::from(k) / 30.0 + 0.005 * dice.uniform();
        if dice.uniform() < 0.5 {
            predictor.update(t, &place(t));
        }
        if t > 30.0 {
            sum += (predictor.predict(t + 0.1) - place(t + 0.1)).norm_squared();
            count += 1.0;
        }
    }
    assert!((sum / count).sqrt() < 5e-4, "{}", (sum / count).sqrt());
}

#[test]
fn before_the_first_sample_the_answer_is_zero_and_says_so() {
    let mut predictor = Predictor::new(Settings::default()).expect("settings");
    assert_eq!(predictor.predict(1.0), Point::zeros());
    assert!(predictor.notes().has(Note::NoData));
    predictor.update(f64::NAN, &Point::zeros());
    assert!(predictor.notes().has(Note::NoData));
    assert_eq!((predictor.frequency(), predictor.amplitude()), (None, None));
}

#[test]
fn a_time_that_is_none_gets_the_last_answer_and_a_far_one_a_standing_target() {
    let mut predictor = taught(Method::Periodic);
    let last = predictor.predict(30.1);
    assert_eq!(predictor.predict(f64::NAN), last);
    assert!(predictor.notes().has(Note::NoTime));
    let standing = predictor.predict(1e6);
    assert!(predictor.notes().has(Note::TooFar));
    assert_eq!(predictor.predict(2e6), standing);
    assert_eq!(predictor.velocity(1e6), Point::zeros());
}

#[test]
fn a_target_without_cycles_in_the_band_is_said_to_have_none() {
    let mut predictor = Predictor::new(Settings::default()).expect("settings");
    let mut dice = Dice(9);
    for k in 0..1800 {
        predictor.update(f64::from(k) / 30.0, &Point::new(dice.normal(), dice.normal(), dice.normal()).scale(1e-3));
    }
    assert!(predictor.notes().has(Note::OutOfBand));
    assert_eq!(predictor.frequency(), None);
}

#[test]
fn cycles_too_fast_for_the_record_or_outside_the_band_are_not_taken_for_others() {
    // A record in bins of 0.19 s shows 5 Hz and 4.2 Hz as something slow; 2.3 Hz is above all that two
    // harmonics of the band reach, and 1.3 to 1.8 Hz are the second harmonic of what is within.
    let wide = [5.0, 4.2].map(|hz| (hz, (0.1, 10.0)));
    let breath = [2.3, 1.8, 1.5, 1.3, 0.06, 0.05].map(|hz| (hz, (0.08, 1.0)));
    for (hz, band) in wide.into_iter().chain(breath).chain([(0.05, (0.2, 1.0))]) {
        let (sine, peaks) = (|t: f64| (TAU * hz * t).sin(), |t: f64| 2.0 * (PI * hz * t).sin().powi(4));
        for (found, notes) in watched(band, sine).into_iter().chain(watched(band, peaks)) {
            let is_right = found.is_some_and(|(found, margin)| (found - hz).abs() <= margin);
            assert!(is_right || notes.has(Note::OutOfBand), "{hz} Hz in {band:?}: {found:?}, {notes:?}");
        }
    }
}

#[test]
fn cycles_within_the_band_are_not_said_to_be_outside() {
    for hz in [0.12, 0.25, 0.45, 0.75] {
        let (sine, peaks) = (|t: f64| (TAU * hz * t).sin(), |t: f64| 2.0 * (PI * hz * t).sin().powi(4));
        for (found, notes) in watched((0.08, 1.0), sine).into_iter().chain(watched((0.08, 1.0), peaks)) {
            assert!(!notes.has(Note::OutOfBand), "{hz} Hz: {found:?}, {notes:?}");
        }
    }
}

/// What is said of cycles, by the centimetre and at 30 Hz, second by second from the fortieth on: frequency and notes.
fn watched(band: (f64, f64), cycles: impl Fn(f64) -> f64) -> Vec<(Option<(f64, f64)>, Notes)> {
    let settings = Settings { band, start: 12.0, ..Settings::default() };
    let (mut predictor, mut dice, mut said) = (Predictor::new(settings).expect("settings"), Dice(7), Vec::new());
    for k in 0..2400 {
        let t = f64::from(k) / 30.0;
        let noise = Point::new(dice.normal(), dice.normal(), dice.normal()) * 2e-4;
        predictor.update(t, &(Point::new(0.01 * cycles(t), 0.0, 0.0) + noise));
        if k >= 1200 && k % 30 == 0 {
            said.push((predictor.frequency(), predictor.notes()));
        }
    }
    said
}

/// A stamp's step or a coordinate: mostly sane, sometimes anything.
fn wild(sane: std::ops::Range<f64>) -> impl Strategy<Value = f64> {
    prop_oneof![20 => sane, 1 => any::<f64>(), 1 => Just(f64::NAN), 1 => Just(0.0), 1 => -1.0..1.0, 1 => -1e3..1e3]
}

fn methods() -> impl Strategy<Value = Method> {
    prop_oneof![
        Just(Method::Hold),
        Just(Method::Velocity),
        Just(Method::Acceleration),
        Just(Method::Periodic),
        Just(Method::Autoregressive),
        Just(Method::Fourier),
        Just(Method::Switch)
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn whatever_comes_predictions_are_finite_near_and_noted(
        method in methods(),
        harmonics in 1_usize..=5,
        rate in 2.0..200.0,
        samples in prop::collection::vec(
            (wild(0.9..1.1), wild(-0.01..0.01), wild(-0.01..0.01), wild(0.0..0.3)), 1..700),
    ) {
        let settings = Settings { method, harmonics, rate_hz: rate, start: 10.0, ..Settings::default() };
        let mut predictor = Predictor::new(settings).expect("settings");
        let (mut t, mut newest) = (0.0, None);
        for (step, x, y, ahead) in samples {
            t = if (t + step / rate).is_finite() { t + step / rate } else { 0.0 };
            let (at, position) = (t + settings.horizon, Point::new(x, y, -x));
            let before = predictor.predict(at);
            let limited = predictor.notes().has(Note::Limited) || predictor.notes().has(Note::TooFar);
            let accepted = predictor.update(t, &position);
            let notes = predictor.notes();
            prop_assert_eq!(accepted, notes.common(Notes::REFUSED).is_empty());
            let had = newest;
            if accepted {
                newest = Some((t, position));
            }
            let after = predictor.predict(at);
            let limited = limited || predictor.notes().has(Note::Limited) || predictor.notes().has(Note::TooFar);
            if had.is_some() && accepted && !limited {
                prop_assert!((after - before).norm() <= settings.jump * (1.0 + 1e-9) || notes.has(Note::Jump));
            }
            for asked in [t + ahead, t - ahead, ahead * 1e6, f64::INFINITY] {
                let found = predictor.predict(asked);
                prop_assert!(found.iter().all(|x| x.is_finite()));
                prop_assert!(predictor.velocity(asked).norm() <= settings.speed_limit * (1.0 + 1e-9));
                prop_assert!(predictor.covariance(asked).iter().all(|x| x.is_finite()));
                if let (Some((_, place)), true) = (newest, asked.is_finite()) {
                    let reach = settings.speed_limit * settings.longest + 10.0 * settings.noise;
                    prop_assert!((found - place).norm() <= reach * (1.0 + 1e-9));
                }
            }
        }
    }
}
