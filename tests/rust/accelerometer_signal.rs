//! What a trusted accelerometer's signal becomes: calibrated, filtered, turned and moved to the base origin.

use crate::accelerometer::{Feed, tilted};
use crate::scale::cases;
use gravcomp::accelerometer::{Calibration, Policy, Sample, Settings, SettingsError, State};
use gravcomp::{Accelerometer, BaseMotion, ImuSample, Mounting, STANDARD_GRAVITY};
use nalgebra::{Complex, Matrix3, Rotation3, Vector2, Vector3};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

/// Lets everything through at once, so that the filter alone is seen.
fn open() -> Settings {
    Settings {
        gravity_rate: 1e6,
        angular_acceleration: 1e6,
        angular_jerk: 1e7,
        jerk: 1e6,
        stuck_count: 0,
        axis_stuck_count: 0,
        ..Settings::default()
    }
}

/// Feeds `force(t)` and `rate(t)` at these times (s), a step each; the readings.
fn run(
    settings: &Settings,
    times: &[f64],
    sensed: impl Fn(f64) -> (Vector3<f64>, Option<Vector3<f64>>),
) -> Vec<BaseMotion> {
    let mut chain = Accelerometer::new(*settings).expect("settings that make sense");
    let mut last = State::Nominal;
    let readings = (0_u64..)
        .zip(times)
        .map(|(seq, t)| {
            #[allow(clippy::cast_possible_truncation)]
            let stamp_ns = (t * 1e9).round() as i64;
            let (specific_force, angular_velocity) = sensed(*t);
            let reading = chain.step(stamp_ns, Some(&Sample { seq, stamp_ns, specific_force, angular_velocity }));
            last = reading.state;
            reading.base
        })
        .collect();
    assert_eq!(last, State::Live);
    readings
}

/// Times of a sensor that keeps its rate.
fn regular(rate_hz: f64, count: u32) -> Vec<f64> {
    (0..count).map(|k| f64::from(k) / rate_hz).collect()
}

const UP: Vector3<f64> = Vector3::new(0.0, 0.0, STANDARD_GRAVITY);

/// H(f) = ω² / (s² + √2 ω s + ω²), s = 2πjf.
fn butterworth(f: f64, cutoff: f64) -> Complex<f64> {
    let (s, w) = (Complex::new(0.0, TAU * f), TAU * cutoff);
    Complex::from(w * w) / (s * s + s * (2_f64.sqrt() * w) + w * w)
}

/// The response of samples → straight lines → Butterworth → samples. A straight line between samples has the spectrum sinc²;
/// sampling folds every f + m fs onto f.
fn sampled_response(f: f64, cutoff: f64, rate: f64) -> Complex<f64> {
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    (-200..=200).map(|m| f + f64::from(m) * rate).map(|f| butterworth(f, cutoff) * sinc(f / rate).powi(2)).sum()
}

/// Gain and phase of the chain at `f`, Hz: what of sin and cos is in the output once it has settled.
fn measured_response(f: f64, cutoff: f64, rate: f64) -> Complex<f64> {
    let settings = Settings { sample_rate_hz: rate, cutoff_hz: Some(cutoff), ..open() };
    let times = regular(rate, 6000);
    let base = run(&settings, &times, |t| (UP + Vector3::new(0.1 * (TAU * f * t).sin(), 0.0, 0.0), None));
    let (mut normal, mut right) = (nalgebra::Matrix2::zeros(), Vector2::zeros());
    for (t, base) in times.iter().zip(&base).skip(3000) {
        let row = Vector2::new((TAU * f * t).sin(), (TAU * f * t).cos());
        normal += row * row.transpose();
        right += row * base.specific_force.0.x;
    }
    let [sin, cos] = normal.try_inverse().map(|inverse| inverse * right / 0.1).expect("sin and cos differ").into();
    Complex::new(sin, cos)
}

#[test]
fn the_filter_responds_as_butterworths_does() {
    for (cutoff, rate) in [(20.0, 100.0), (5.0, 100.0), (20.0, 1000.0), (100.0, 1000.0), (50.0, 100.0)] {
        for share in [0.01, 0.05, 0.1, 0.2, 0.3, 0.45] {
            let f = share * rate;
            let (found, wanted) = (measured_response(f, cutoff, rate), sampled_response(f, cutoff, rate));
            assert!((found - wanted).norm() < 2e-4, "{f} Hz, {cutoff} of {rate}: {found}, not {wanted}");
        }
    }
}

/// Far below the sample rate the sampling does not show: −3 dB at the cut-off, 12 dB per octave above.
#[test]
fn the_cut_off_is_the_declared_one() {
    for (f, gain) in [(2.0, 1.0), (20.0, 0.5_f64.sqrt()), (40.0, 1.0 / 17_f64.sqrt()), (80.0, 1.0 / 257_f64.sqrt())] {
        let found = measured_response(f, 20.0, 1000.0).norm();
        assert!((found / gain - 1.0).abs() < 0.03, "{f} Hz: {found}, not {gain}");
    }
}

proptest! {
    #![proptest_config(cases(100))]

    /// On a ramp the filter lags by √2/ω, whenever the samples come.
    #[test]
    fn irregular_samples_make_no_difference(gaps in prop::collection::vec(0.002..0.02_f64, 300), slope in -1.0..1.0_f64) {
        let times: Vec<f64> = gaps.iter().scan(0.0, |t, gap| { *t += gap; Some(*t) }).collect();
        let base = run(&open(), &times, |t| (UP + Vector3::new(slope * t, 0.0, 0.0), None));
        let lag = 2_f64.sqrt() / (TAU * 20.0);
        for (t, base) in times.iter().zip(&base).skip(200) {
            prop_assert!((base.specific_force.0.x - slope * (t - lag)).abs() < 1e-6);
        }
    }

    /// A base that spins up evenly, and its sensor anywhere: the chain knows no more than one sample and its slope.
    #[test]
    fn the_lever_arm_is_that_of_an_inertial_sample(
        r in prop::array::uniform3(-0.5..0.5_f64),
        mounting in prop::array::uniform3(-3.0..3.0_f64),
        w0 in prop::array::uniform3(-0.5..0.5_f64),
        dw in prop::array::uniform3(-0.2..0.2_f64),
    ) {
        let R = Rotation3::new(Vector3::from(mounting)).into_inner();
        let mounting = Mounting::new(R, r.into()).expect("a rotation");
        let (r, w0, dw) = (Vector3::from(r), Vector3::from(w0), Vector3::from(dw));
        let imu = |t: f64| {
            let w = w0 + dw * t;
            let felt = UP + dw.cross(&r) + w.cross(&w.cross(&r));
            ImuSample {
                specific_force: R.transpose() * felt,
                angular_velocity: R.transpose() * w,
                angular_acceleration: R.transpose() * dw,
            }
        };
        let times = regular(100.0, 300);
        // Up stays up although the base turns: only a base that accelerates feels that.
        let settings = Settings { mounting, cutoff_hz: None, moving_base: true, ..open() };
        let base = run(&settings, &times, |t| (imu(t).specific_force, Some(imu(t).angular_velocity)));
        for (t, base) in times.iter().zip(&base).skip(200) {
            let wanted = BaseMotion::from_imu(&imu(*t), &mounting);
            prop_assert!((base.specific_force.0 - wanted.specific_force.0).norm() < 1e-6);
            prop_assert!((base.specific_force.0 - UP).norm() < 1e-6, "at the origin nothing of the spin is felt");
            prop_assert!((base.angular_velocity - wanted.angular_velocity).norm() < 1e-6);
            prop_assert!((base.angular_acceleration - wanted.angular_acceleration).norm() < 1e-6);
        }
    }

    /// What the sensor gets wrong, the calibration takes back: s = S⁻¹ f + b.
    #[test]
    fn the_calibration_is_undone(
        bias in prop::array::uniform3(-0.5..0.5_f64),
        off in prop::array::uniform9(-0.05..0.05_f64),
        gyro_bias in prop::array::uniform3(-0.1..0.1_f64),
    ) {
        let correction = Matrix3::identity() + Matrix3::from_iterator(off);
        let calibration = Calibration { bias: bias.into(), correction, gyro_bias: gyro_bias.into() };
        let distort = correction.try_inverse().expect("close to the identity");
        let settings = Settings { calibration, cutoff_hz: None, ..open() };
        let base = run(&settings, &regular(100.0, 50), |t| {
            (distort * tilted(10.0 * t) + calibration.bias, Some(calibration.gyro_bias))
        });
        prop_assert!((base[49].specific_force.0 - tilted(4.9)).norm() < 1e-9);
        prop_assert!(base[49].angular_velocity.norm() < 1e-9);
    }

    /// Settings of any bits: refused with a field's name, or a chain that runs, whatever its sensor says.
    #[test]
    fn any_settings_are_refused_or_run(
        field in 0..32_usize,
        bits in prop_oneof![any::<u64>().prop_map(f64::from_bits), -100.0..100.0_f64, -1e4..1e4_f64],
        strict in any::<bool>(),
        rates in proptest::option::of(prop::collection::vec(prop::array::uniform3(-40.0..40.0_f64), 1..40)),
    ) {
        let policy = if strict { Policy::Strict } else { Policy::Paper };
        match Accelerometer::new(Settings { policy, ..with_number(field, bits) }) {
            Ok(chain) => {
                let mut feed = Feed::of(policy);
                feed.chain = chain;
                feed.rate = rates.as_ref().map(|_| Vector3::zeros());
                feed.feel(tilted(15.0), 30);
                for rate in rates.into_iter().flatten() {
                    feed.rate = Some(rate.into());
                    feed.feel(tilted(15.0), 1);
                }
                feed.silence(10);
                feed.chain.acknowledge();
                feed.feel(tilted(20.0), 30);
            }
            Err(error) => prop_assert!(error.to_string().contains("should be"), "{error}"),
        }
    }
}

/// A sensor at (`x`, `y`, 0).
fn far(x: f64, y: f64) -> Mounting {
    Mounting::new(Matrix3::identity(), Vector3::new(x, y, 0.0)).unwrap_or_default()
}

/// The defaults with one number replaced.
fn with_number(field: usize, x: f64) -> Settings {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let (count, ns) = (x as u32, (x * 1e9) as i64);
    let mut settings = Settings::default();
    match field {
        0 => settings.sample_rate_hz = x,
        1 => settings.range = x,
        2 => settings.gyro_range = x,
        3 => settings.cutoff_hz = Some(x),
        4 => settings.bandwidth_hz = Some(x),
        5 => settings.up.x = x,
        6 => settings.norm.0 = x,
        7 => settings.norm.1 = x,
        8 => settings.norm_tolerance = x,
        9 => settings.jerk = x,
        10 => settings.pose_limit = x,
        11 => settings.tilt_limit = x,
        12 => settings.tilt_time = x,
        13 => settings.gravity_rate = x,
        14 => settings.max_age_ns = ns,
        15 => settings.hold_ns = ns,
        16 => settings.fault_after_ns = ns,
        17 => settings.no_sensor_ns = ns,
        18 => settings.stuck_count = count,
        19 => settings.density = count,
        20 => settings.start_count = count,
        21 => settings.angular_jerk = x,
        22 => settings.calibration.bias.y = x,
        23 => settings.noise = x,
        24 => settings.linear_acceleration = x,
        25 => settings.angular_acceleration = x,
        26 => settings.axis_stuck_count = count,
        27 => settings.calibration.gyro_bias.z = x,
        28 => settings.calibration.correction[(2, 2)] = x,
        29 => settings.mounting = far(x, 0.0),
        30 => settings.mounting = far(0.3, x),
        _ => settings.calibration.correction[(1, 2)] = x,
    }
    settings
}

#[test]
fn a_wrong_setting_is_named_with_its_value_and_what_is_right() {
    let refused = |settings: Settings| settings.checked().expect_err("wrong").to_string();
    let aliasing = refused(Settings { bandwidth_hz: Some(150.0), ..Settings::default() });
    assert_eq!(aliasing, "bandwidth_hz is 150.0; it should be at least 1e-3 Hz and at most half the rate");
    let slow = refused(Settings { sample_rate_hz: 20.0, ..Settings::default() });
    assert_eq!(slow, "cutoff_hz is 20.0; it should be at least 1e-3 Hz and at most half the rate");
    let slow = refused(Settings { sample_rate_hz: 40.0, ..Settings::default() });
    assert_eq!(slow, "max_age_ns is 0.04; it should be at least two sample periods (shown in s)");
    let far = Mounting::new(Matrix3::identity(), Vector3::new(0.0, 1e200, 0.0)).expect("a rotation");
    let SettingsError { field, .. } = Settings { mounting: far, ..Settings::default() }.checked().expect_err("too far");
    assert_eq!(field, "mounting (position)");
}

/// An arm on a wall, the sensor on the arm's base: up is x, and so is nominal gravity.
#[test]
fn up_is_what_is_declared() {
    let mut feed = Feed::new(&Settings { up: Vector3::new(2.0, 0.0, 0.0), ..Settings::default() });
    assert_eq!(feed.silence(1).gravity.0, Vector3::new(-STANDARD_GRAVITY, 0.0, 0.0));
    let on_the_wall = Vector3::new(STANDARD_GRAVITY, 0.1, 0.0);
    assert_eq!(feed.feel(on_the_wall, 20).state, State::Live);
}
