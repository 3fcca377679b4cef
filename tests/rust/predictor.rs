//! Prediction: what every method owes to a target of its kind, and that what it says of itself is true.

use gravcomp::Predictor;
use gravcomp::predictor::{Method, Point, Settings};
use nalgebra::Matrix3;
use std::f64::consts::{PI, TAU};

const METHODS: [Method; 7] = [
    Method::Hold,
    Method::Velocity,
    Method::Acceleration,
    Method::Periodic,
    Method::Autoregressive,
    Method::Fourier,
    Method::Switch,
];

/// Numbers that look random (splitmix64), and normal ones by Box and Muller.
#[derive(Clone, Debug)]
pub struct Dice(pub u64);

impl Dice {
    /// From 0 to 1.
    #[allow(clippy::cast_precision_loss)] // 53 bits
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (TAU * self.uniform()).cos()
    }

    fn point(&mut self, deviation: f64) -> Point {
        Point::new(self.normal(), self.normal(), self.normal()) * deviation
    }
}

/// Breaths after Lujan: A sin⁴(π (t − t_k)/T_k), each with a size and a length of its own.
struct Breaths(Vec<(f64, f64, f64)>);

impl Breaths {
    fn new(dice: &mut Dice, until: f64, spread: f64) -> Self {
        let (mut breaths, mut t) = (Vec::new(), 0.0);
        while t < until {
            let mut vary = |mean: f64| mean * (1.0 + spread * dice.normal().clamp(-2.5, 2.5));
            let (size, length) = (vary(0.015), vary(4.0));
            breaths.push((t, size, length));
            t += length;
        }
        Self(breaths)
    }

    /// The breath at `t`: its beginning, size and length.
    fn breath(&self, t: f64) -> (f64, f64, f64) {
        self.0[self.0.partition_point(|breath| breath.0 <= t).saturating_sub(1)]
    }

    fn place(&self, t: f64) -> Point {
        let (begin, size, length) = self.breath(t);
        DIRECTION * (size * (PI * (t - begin) / length).sin().powi(4))
    }
}

const DIRECTION: Point = Point::new(0.95, 0.27, 0.15);

fn predictor(method: Method, horizon: f64) -> Predictor {
    Predictor::new(Settings { method, horizon, ..Settings::default() }).expect("the settings make sense")
}

/// Root mean square error of predictions `horizon` ahead from 25 s on of a target at `place`, seen at 30 Hz for `seconds`.
fn error(method: Method, horizon: f64, seconds: u32, noise: f64, dice: &mut Dice, place: impl Fn(f64) -> Point) -> f64 {
    let (mut predictor, mut sum, mut count) = (predictor(method, horizon), 0.0, 0.0);
    for k in 0..30 * seconds {
        let t = f64::from(k) / 30.0;
        assert!(predictor.update(t, &(place(t) + dice.point(noise))));
        if t > 25.0 {
            sum += (predictor.predict(t + horizon) - place(t + horizon)).norm_squared();
            count += 1.0;
        }
    }
    (sum / count).sqrt()
}

#[test]
fn a_still_target_is_held_exactly_by_every_method() {
    let place = Point::new(0.1, -0.2, 0.3);
    for method in METHODS {
        let mut predictor = predictor(method, 0.1);
        for k in 0..1000 {
            let t = f64::from(k) / 30.0;
            predictor.update(t, &place);
            assert!((predictor.predict(t + 0.1) - place).norm() < 1e-12, "{method:?} at {t}");
            assert!(predictor.velocity(t + 0.1).norm() < 1e-9, "{method:?} at {t}");
        }
    }
}

#[test]
fn a_sine_is_predicted_ever_better_by_the_methods_that_can() {
    for hz in [0.11, 0.2, 0.37, 0.8] {
        let place = |t: f64| Point::new(0.010, -0.004, 0.002) * (TAU * hz * t).sin();
        for (method, limit) in [(Method::Periodic, 2e-5), (Method::Autoregressive, 1e-4), (Method::Switch, 1e-4)] {
            let found = error(method, 0.1, 60, 0.0, &mut Dice(1), place);
            assert!(found < limit, "{method:?} at {hz} Hz: {found}");
        }
    }
}

#[test]
fn a_straight_line_is_predicted_by_constant_velocity_and_a_parabola_by_constant_acceleration() {
    let speed = Point::new(0.01, 0.002, -0.003);
    assert!(error(Method::Velocity, 0.2, 40, 0.0, &mut Dice(1), |t| speed * t) < 1e-6);
    assert!(error(Method::Acceleration, 0.2, 40, 0.0, &mut Dice(1), |t| speed * (0.05 * t * t)) < 1e-5);
}

#[test]
fn breathing_seen_late_and_in_noise_is_predicted_to_less_than_the_noise() {
    for seed in 0..5 {
        let mut dice = Dice(seed);
        let breaths = Breaths::new(&mut dice, 120.0, 0.1);
        let errors = [Method::Hold, Method::Periodic, Method::Switch]
            .map(|method| error(method, 0.077, 90, 3e-4, &mut dice.clone(), |t| breaths.place(t)));
        assert!(errors[1] < 2.6e-4 && errors[2] < 2.6e-4 && errors[0] > 7e-4, "seed {seed}: {errors:?}");
    }
}

#[test]
fn frequency_and_amplitude_are_within_their_margins() {
    let (mut count, mut rate, mut size, mut narrow) = (0.0, 0.0, 0.0, 0.0);
    for seed in 0..12 {
        let mut dice = Dice(100 + seed);
        let breaths = Breaths::new(&mut dice, 120.0, 0.1);
        let mut predictor = predictor(Method::Periodic, 0.077);
        for k in 0..30 * 90 {
            let t = f64::from(k) / 30.0;
            predictor.update(t, &(breaths.place(t) + dice.point(3e-4)));
            if t > 25.0 {
                let (hz, margin) = predictor.frequency().expect("cycles were found");
                let (amplitude, doubt) = predictor.amplitude().expect("cycles were found");
                let (_, real, length) = breaths.breath(t);
                count += 1.0;
                rate += f64::from((hz - 1.0 / length).abs() <= margin);
                size += f64::from((amplitude[0] - real * DIRECTION.x).abs() <= doubt[0]);
                narrow += f64::from(margin < 0.05);
            }
        }
    }
    println!("within: frequency {:.3}, amplitude {:.3}; narrow {:.3}", rate / count, size / count, narrow / count);
    assert!(rate / count >= 0.95 && size / count >= 0.95);
    assert!(narrow / count > 0.5);
}

#[test]
fn the_covariance_covers_the_error() {
    let (mut count, mut inside) = (0.0, 0.0);
    for seed in 0..6 {
        let mut dice = Dice(200 + seed);
        let breaths = Breaths::new(&mut dice, 120.0, 0.1);
        let mut predictor = predictor(Method::Switch, 0.1);
        for k in 0..30 * 60 {
            let t = f64::from(k) / 30.0;
            predictor.update(t, &(breaths.place(t) + dice.point(3e-4)));
            let covariance = predictor.covariance(t + 0.1);
            assert_eq!(covariance, covariance.transpose());
            assert!(covariance.symmetric_eigenvalues().min() > -1e-12);
            assert!(predictor.covariance(t + 0.5).trace() > covariance.trace());
            if t > 25.0 {
                let off = predictor.predict(t + 0.1) - breaths.place(t + 0.1);
                for axis in 0..3 {
                    count += 1.0;
                    inside += f64::from(off[axis].abs() <= 2.0 * covariance[(axis, axis)].sqrt());
                }
            }
        }
    }
    assert!(inside / count >= 0.95, "{}", inside / count);
}

#[test]
fn samples_lie_about_the_predictions_as_the_covariance_says() {
    // The square of the distance to a sample in units of the covariance, per axis: 1 on average.
    for (axes, method) in [(1_u8, Method::Switch), (2, Method::Switch), (3, Method::Switch), (3, Method::Velocity)] {
        let (mut sum, mut count) = (0.0, 0.0);
        for seed in 0..4 {
            let mut dice = Dice(300 + seed);
            let breaths = Breaths::new(&mut dice, 120.0, 0.1);
            let settings = Settings { method, axes: axes.into(), ..Settings::default() };
            let (mut predictor, mut said) = (Predictor::new(settings).expect("settings"), None);
            for k in 0..30 * 90 {
                let t = f64::from(k) / 30.0;
                let y = breaths.place(t) + dice.point(3e-4);
                if let Some((_, place, inverse)) =
                    said.filter(|(about, ..): &(f64, Point, Matrix3<f64>)| about - t < 1e-6)
                {
                    let off: Point = y - place;
                    sum += off.dot(&(inverse * off));
                    count += f64::from(axes);
                    said = None;
                }
                predictor.update(t, &y);
                if t > 25.0 && said.is_none() {
                    let mut covariance = predictor.covariance(t + 0.1);
                    // Those that the target does not have do not count.
                    (axes.into()..3).for_each(|i| covariance[(i, i)] = 1e12);
                    said = Some((t + 0.1, predictor.predict(t + 0.1), covariance.try_inverse().expect("positive")));
                }
            }
        }
        println!("{axes} axes, {method:?}: {:.2}", sum / count);
        assert!((0.8..1.6).contains(&(sum / count)), "{axes} axes, {method:?}: {}", sum / count);
    }
}

#[test]
fn a_stamp_of_a_day_or_of_an_epoch_is_as_good_as_one_of_now() {
    let mut dice = Dice(8);
    let breaths = Breaths::new(&mut dice, 60.0, 0.1);
    let samples: Vec<_> =
        (0..30 * 40).map(|k| f64::from(k) / 30.0).map(|t| (t, breaths.place(t) + dice.point(3e-4))).collect();
    for method in METHODS {
        let errors = [0.0, 86_400.0, 1.7e9].map(|zero| {
            let mut predictor = predictor(method, 0.1);
            let mut sum = 0.0;
            for (t, y) in &samples {
                predictor.update(zero + t, y);
                sum += (predictor.predict(zero + t + 0.1) - breaths.place(t + 0.1)).norm_squared();
            }
            (sum / 1200.0_f64).sqrt()
        });
        assert!(errors.iter().all(|error| (error - errors[0]).abs() < 0.02 * errors[0]), "{method:?}: {errors:?}");
    }
}

#[test]
fn neither_the_origin_nor_the_clocks_zero_nor_a_known_latency_matters() {
    let (far, late) = (Point::new(1.0, -2.0, 0.5), 0.06);
    let mut dice = Dice(7);
    let breaths = Breaths::new(&mut dice, 60.0, 0.1);
    for method in METHODS {
        let settings = Settings { method, ..Settings::default() };
        let mut here = Predictor::new(settings).expect("settings");
        let mut there = Predictor::new(Settings { latency: late, ..settings }).expect("settings");
        for k in 0..30 * 40 {
            let t = f64::from(k) / 30.0;
            let y = breaths.place(t) + dice.point(3e-4);
            here.update(t, &y);
            there.update(t + 512.0 + late, &(y + far));
            let apart = there.predict(t + 512.1) - far - here.predict(t + 0.1);
            assert!(apart.norm() < 1e-6, "{method:?} at {t}: {apart}");
        }
    }
}

#[test]
fn axes_that_a_target_does_not_have_are_left_out() {
    let mut one = Predictor::new(Settings { axes: 1, ..Settings::default() }).expect("settings");
    for k in 0..900 {
        let t = f64::from(k) / 30.0;
        one.update(t, &Point::new((TAU * 0.3 * t).sin() * 0.01, f64::NAN, 1e9));
    }
    let found = one.predict(30.1);
    assert!((found.x - (TAU * 0.3 * 30.1).sin() * 0.01).abs() < 1e-4);
    assert_eq!((found.y, found.z), (0.0, 0.0));
}

#[test]
fn settings_that_cannot_be_meant_are_refused_by_name() {
    type Change = fn(&mut Settings);
    let cases: [(&str, Change); 11] = [
        ("rate_hz", |s| s.rate_hz = f64::NAN),
        ("axes", |s| s.axes = 4),
        ("latency_s", |s| s.latency = -0.1),
        ("horizon_s", |s| s.horizon = 0.0),
        ("longest_s", |s| s.longest = 0.05),
        ("band (lower end)", |s| s.band.0 = 0.0),
        ("band (upper end)", |s| s.band.1 = 20.0),
        ("noise", |s| s.noise = 0.0),
        ("harmonics", |s| s.harmonics = 6),
        ("speed_limit", |s| s.speed_limit = f64::INFINITY),
        ("start_s", |s| s.start = 1.0),
    ];
    for (field, change) in cases {
        let mut settings = Settings::default();
        change(&mut settings);
        let error = settings.checked().expect_err(field);
        assert_eq!(error.field, field);
    }
}
