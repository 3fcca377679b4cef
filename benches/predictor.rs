//! The predictor of a moving target: an update with a sample of a camera, and a prediction of the control cycle.

use criterion::Criterion;
use gravcomp::Predictor;
use gravcomp::predictor::{Method, Point, Settings};
use std::hint::black_box;

/// A predictor that has watched breathing for a minute, and goes on watching.
struct Watch {
    predictor: Predictor,
    sample: u32,
}

impl Watch {
    fn new(method: Method, harmonics: usize) -> Self {
        let settings = Settings { method, harmonics, horizon: 0.077, ..Settings::default() };
        let predictor = Predictor::new(settings).expect("the settings make sense");
        let mut watch = Self { predictor, sample: 0 };
        (0..1800).for_each(|_| watch.update());
        watch
    }

    fn time(&self) -> f64 {
        f64::from(self.sample) / 30.0
    }

    fn update(&mut self) {
        self.sample += 1;
        let t = self.time();
        let depth = 0.015 * (std::f64::consts::PI * t / 4.0).sin().powi(4);
        // Noise that never repeats.
        let noise = Point::new((37.0 * t * t).sin(), (41.0 * t * t).sin(), (43.0 * t * t).sin());
        self.predictor.update(t, &(Point::new(0.95, 0.27, 0.15) * depth + 3e-4 * noise));
    }
}

/// Times updates and predictions.
pub fn bench(criterion: &mut Criterion) {
    for (name, method, harmonics) in [
        ("switch", Method::Switch, 2),
        ("switch, 5 harmonics", Method::Switch, 5),
        ("periodic", Method::Periodic, 2),
        ("autoregressive", Method::Autoregressive, 2),
        ("fourier", Method::Fourier, 2),
        ("hold", Method::Hold, 2),
    ] {
        let mut watch = Watch::new(method, harmonics);
        criterion.bench_function(&format!("predictor/predict/{name}"), |b| {
            let at = watch.time() + 0.077;
            b.iter(|| watch.predictor.predict(black_box(at)));
        });
        criterion.bench_function(&format!("predictor/update/{name}"), |b| b.iter(|| watch.update()));
    }
    let mut lost = Predictor::new(Settings::default()).expect("the settings make sense");
    let mut t = 0.0;
    criterion.bench_function("predictor/update/while cycles are sought", |b| {
        b.iter(|| {
            t += 1.0 / 30.0;
            // Nothing periodic: the search never ends.
            lost.update(t, &Point::new((t * t).sin(), (1.3 * t * t).sin(), (1.7 * t * t).sin()).scale(1e-3))
        });
    });
}
