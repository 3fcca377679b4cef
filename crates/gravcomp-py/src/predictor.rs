//! `Predictor`: where a moving target will be, fed by a camera and asked by the control cycle.

use crate::arrays::{Pinned, Use, output, read};
use crate::cycle::{changed, check_apart};
use crate::errors::configuration_error;
use crate::shared::Shared;
use crate::types::{by_name, choice, names, real, text};
use gravcomp::predictor::{Method, Note, Point, Settings};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};

type Array<'py> = Bound<'py, PyAny>;

/// Methods by the names that Python gives them.
const METHODS: [Method; 7] = [
    Method::Switch,
    Method::Periodic,
    Method::Autoregressive,
    Method::Fourier,
    Method::Hold,
    Method::Velocity,
    Method::Acceleration,
];

/// The lowest and the highest frequency, in any sequence.
fn band(x: &Array<'_>) -> PyResult<(f64, f64)> {
    Ok(read::<2>(x, 2, "band")?.0.into())
}

/// Where a moving target will be: `update` takes a sample of a camera, `predict` is asked in the control cycle.
///
/// rate_hz: samples per second; axes: numbers of a position, 1 to 3; method: "switch" (whichever has lately predicted best),
/// "periodic" (cycles of a learnt shape whose rate and size vary), "autoregressive", "fourier", "velocity", "acceleration" or
/// "hold"; latency_s: what a sample shows is this much older than its stamp; horizon_s: how far after the newest sample
/// predictions are mostly asked for, what methods are tuned for and judged by (None: latency and one and a half periods);
/// band: lowest and highest frequency of the cycles, Hz; noise: standard deviation of a sample, m per axis; harmonics of the
/// cycles, 1 to 5; speed_limit of the target, m/s; jump_m: a sample that moves the
/// prediction further is noted (None: ten times the noise); longest_s: further ahead it is held; start_s: the record that the
/// first guess of the cycles is made from (None: 0.96 periods of the band's lower end).
///
/// Raises ConfigError for what cannot be meant. After that nothing raises but wrong kinds of arguments: whatever the numbers,
/// predictions are finite and within `speed_limit` of the newest sample, and `status` says what was found.
#[pyclass(frozen, module = "ravengc._core")]
pub struct Predictor {
    inner: Shared<gravcomp::Predictor>,
    axes: usize,
}

impl std::fmt::Debug for Predictor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Predictor({} axes)", self.axes)
    }
}

impl Predictor {
    /// Writes the numbers of a point that the target has.
    #[inline(always)]
    fn written<'py>(&self, py: Python<'py>, out: Option<&Array<'py>>, point: Point) -> PyResult<Array<'py>> {
        let (array, elements) = output(py, out, [self.axes], &[])?;
        elements.write(&point.as_slice()[..self.axes]);
        Ok(array)
    }
}

#[pymethods]
impl Predictor {
    #[new]
    #[pyo3(signature = (
        rate_hz, axes=3, method=None, latency_s=0.0, horizon_s=None, band=(0.08, 1.0), noise=3e-4, harmonics=2,
        speed_limit=0.5, jump_m=None, longest_s=1.0, start_s=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        #[pyo3(from_py_with = real)] rate_hz: f64,
        axes: usize,
        method: Option<&Bound<'_, PyString>>,
        #[pyo3(from_py_with = real)] latency_s: f64,
        horizon_s: Option<f64>,
        #[pyo3(from_py_with = band)] band: (f64, f64),
        #[pyo3(from_py_with = real)] noise: f64,
        harmonics: usize,
        #[pyo3(from_py_with = real)] speed_limit: f64,
        jump_m: Option<f64>,
        #[pyo3(from_py_with = real)] longest_s: f64,
        start_s: Option<f64>,
    ) -> PyResult<Self> {
        let names = METHODS.map(|method| (method.name(), method));
        let method = method.map_or(Ok(Method::Switch), |name| choice(py, "predictor: method", text(name)?, &names))?;
        let settings = Settings {
            rate_hz,
            axes,
            method,
            latency: latency_s,
            horizon: horizon_s.unwrap_or(latency_s + 1.5 / rate_hz),
            band,
            noise,
            harmonics,
            speed_limit,
            jump: jump_m.unwrap_or(10.0 * noise),
            longest: longest_s,
            start: start_s.unwrap_or(0.96 / band.0),
        };
        let inner = gravcomp::Predictor::new(settings)
            .map_err(|error| configuration_error(py, format!("predictor: {error}")))?;
        Ok(Self { inner: Shared::new(inner), axes })
    }

    /// Take a sample: its stamp, s, and the position (axes,), m. True when it was used; `status` says why not.
    fn update(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = real)] stamp_s: f64,
        position: &Array<'_>,
    ) -> PyResult<bool> {
        let y = Point::from(read::<3>(position, self.axes, "position")?.0);
        Ok(self.inner.change(py, |inner| inner.update(stamp_s, &y)))
    }

    /// Where the target is at the time `at_s`, s on the samples' clock: (axes,), m.
    #[pyo3(signature = (at_s, out=None))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = real)] at_s: f64,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let point = self.inner.change(py, |inner| inner.predict(at_s));
        self.written(py, out, point)
    }

    /// How fast it moves then: (axes,), m/s.
    #[pyo3(signature = (at_s, out=None))]
    fn velocity<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = real)] at_s: f64,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let point = self.inner.change(py, |inner| inner.velocity(at_s));
        self.written(py, out, point)
    }

    /// Bind to arrays: the result's call with a time `at_s` writes where the target is then into `out` (axes,), m, and how fast
    /// it moves into `velocity` (axes,), m/s.
    #[pyo3(signature = (*, out, velocity=None))]
    fn bind<'py>(
        slf: &Bound<'py, Self>,
        out: &Array<'py>,
        velocity: Option<&Array<'py>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, axes) = (slf.py(), slf.get().axes);
        let cycle = PredictorCycle {
            predictor: slf.clone().unbind(),
            out: Pinned::new(out, [axes], Use::Output("out"))?,
            velocity: velocity.map(|array| Pinned::new(array, [axes], Use::Output("velocity"))).transpose()?,
        };
        check_apart(py, std::iter::empty(), cycle.outputs().map(Pinned::named))?;
        Bound::new(py, cycle)?.into_any().getattr("step")
    }

    /// Mean square of the prediction's error at `at_s`, with that of the samples themselves: (axes, axes), m^2.
    #[pyo3(signature = (at_s, out=None))]
    fn covariance<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = real)] at_s: f64,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (array, elements) = output(py, out, [self.axes, self.axes], &[])?;
        let matrix = self.inner.with(py, |inner| inner.covariance(at_s));
        elements.write_all((0..self.axes * self.axes).map(|i| matrix[(i / self.axes, i % self.axes)]));
        Ok(array)
    }

    /// Forget everything but the counters: another target.
    fn reset(&self, py: Python<'_>) {
        self.inner.change(py, gravcomp::Predictor::reset);
    }

    /// From lowest to highest place of the present cycle: (axes,), m; None before cycles were found.
    #[getter]
    fn amplitude<'py>(&self, py: Python<'py>) -> PyResult<Option<Array<'py>>> {
        let found = self.inner.with(py, gravcomp::Predictor::amplitude);
        found.map(|(size, _)| self.written(py, None, size)).transpose()
    }

    /// How far, at most, the amplitude is off: (axes,), m (two standard deviations).
    #[getter]
    fn amplitude_margin<'py>(&self, py: Python<'py>) -> PyResult<Option<Array<'py>>> {
        let found = self.inner.with(py, gravcomp::Predictor::amplitude);
        found.map(|(_, margin)| self.written(py, None, margin)).transpose()
    }

    /// The method that predictions come from, or have most of their weight from.
    #[getter]
    fn chosen(&self, py: Python<'_>) -> &'static str {
        self.inner.with(py, |inner| inner.chosen().name())
    }

    /// Frequency of the present cycle, Hz; None before cycles were found.
    #[getter]
    fn frequency(&self, py: Python<'_>) -> Option<f64> {
        self.inner.with(py, |inner| inner.frequency().map(|(hz, _)| hz))
    }

    /// How far the frequency may be off, Hz: two standard deviations.
    #[getter]
    fn frequency_margin(&self, py: Python<'_>) -> Option<f64> {
        self.inner.with(py, |inner| inner.frequency().map(|(_, margin)| margin))
    }

    /// What was noted with the newest sample and when a prediction was last asked for, as bits in the order of `NOTES`.
    #[getter]
    fn status(&self, py: Python<'_>) -> u32 {
        self.inner.with(py, |inner| inner.notes().bits())
    }

    /// The same by name, each a key of `NOTES`.
    #[getter]
    fn notes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let notes = self.inner.with(py, gravcomp::Predictor::notes);
        names(py, notes.iter().map(Note::name))
    }

    /// How often, since the start: "received", "accepted" samples, and every note by name.
    #[getter]
    fn counters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let counters = self.inner.with(py, |inner| *inner.counters());
        let all = [("received", counters.received), ("accepted", counters.accepted)];
        by_name(py, all.into_iter().chain(Note::ALL.map(|note| (note.name(), counters.of(note)))))
    }
}

/// A predictor bound to its arrays: `step(at_s)` writes where the target is then, and how fast it moves.
///
/// Nothing is allocated. It raises only if an array was resized, reshaped, retyped or made read-only after it was bound.
#[pyclass(frozen, module = "ravengc._core")]
pub struct PredictorCycle {
    predictor: Py<Predictor>,
    out: Pinned,
    velocity: Option<Pinned>,
}

impl std::fmt::Debug for PredictorCycle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("PredictorCycle")
    }
}

impl PredictorCycle {
    fn outputs(&self) -> impl Iterator<Item = &Pinned> {
        std::iter::once(&self.out).chain(&self.velocity)
    }
}

#[pymethods]
impl PredictorCycle {
    /// Predict for the time `at_s`, write the arrays.
    #[inline(always)]
    fn step(&self, py: Python<'_>, #[pyo3(from_py_with = real)] at_s: f64) -> PyResult<()> {
        if !self.outputs().all(|array| array.unchanged(py)) {
            return Err(changed(py));
        }
        let predictor = self.predictor.get();
        let (position, velocity) = predictor.inner.change(py, |inner| inner.moving(at_s));
        for (array, point) in self.outputs().zip([position, velocity]) {
            array.elements().write(&point.as_slice()[..predictor.axes]);
        }
        Ok(())
    }

    /// What the cycle holds, for the garbage collector.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.predictor)?;
        self.outputs().try_for_each(|array| visit.call(array.array()))
    }
}

/// What each note says, by name, in the order of the bits of a status word.
pub fn note_meanings(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    by_name(py, Note::ALL.map(|note| (note.name(), note.meaning())))
}
