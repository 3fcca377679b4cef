//! `Accelerometer`: the base sensor's chain, fed from any thread without a lock, stepped by the control cycle.

use crate::arrays::{Use, read, required};
use crate::errors::{argument_error, configuration_error, cut, did_you_mean, model_error};
use crate::shared::Shared;
use crate::types::{BaseMotion, Gravity, by_name, choice, matrix, names, real, vector};
use gravcomp::accelerometer::{Calibration, Fault, LikelyUnit, Policy, Sample, Settings, SettingsError};
use gravcomp::{Mounting, Reading, Slot};
use nalgebra::{Matrix3, Vector3};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyString, PyTuple};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// A sample as words: number, stamp, specific force, whether there is an angular velocity, and that.
const WORDS: usize = 9;

/// The base's accelerometer as a monitored signal: gate, calibration, mounting, lever arm, filter, and how far to trust it.
///
/// Settings, all optional (defaults: the paper's BMA180 at 100 Hz on a base that is rocked by 10-20 degrees at 1 Hz):
///
/// sensor: rate_hz (100), range (19.6 m/s^2 per axis), gyro_range (35 rad/s), bandwidth_hz, unit ("m/s^2"; "g", "mg",
/// "cm/s^2"), bias (3,) m/s^2, correction (3, 3) with f = correction @ (sent - bias), gyro_bias (3,) rad/s;
/// mounting: rotation (3, 3) base axes <- sensor axes, position (3,) m in base axes, up (3,) in base axes when level;
/// filter: cutoff_hz (20; None: none), second-order Butterworth;
/// policy: "paper" (nominal until the first sample, then the last value) or "strict" (not armable without a live sensor;
/// held 50 ms, then the slow tilt estimate, then a fault that only `acknowledge` leaves);
/// base: norm ((3, 18) m/s^2), norm_tolerance (0.15), noise (0.03 m/s^2), jerk (150 m/s^3), linear_acceleration
/// (1.5 m/s^2; used where there is a gyroscope), moving_base (False), pose_limit (45 deg, in rad), tilt_limit (15 deg, in
/// rad), tilt_time (5 s);
/// times: max_age_s (0.04), hold_s (0.05), fault_after_s (0.5), no_sensor_s (0.045);
/// counts: stuck_count (8), axis_stuck_count (40), density (4 of the last 32), start_count (20);
/// output: gravity_rate (50 m/s^3), angular_acceleration (100 rad/s^2), angular_jerk (1000 rad/s^3).
///
/// Raises ConfigError for a setting that is unknown or cannot be meant, ModelError for a mirror as rotation.
#[pyclass(frozen, module = "ravengc._core")]
pub struct Accelerometer {
    chain: Shared<gravcomp::Accelerometer>,
    newest: Slot<WORDS>,
    turned_away: AtomicU64,
    steps: AtomicU64,
    unit: f64,
    /// `time.monotonic_ns()` at an instant.
    clock: (i64, Instant),
}

impl std::fmt::Debug for Accelerometer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Accelerometer")
    }
}

impl Accelerometer {
    /// One step of the chain with the newest sample; `time.monotonic_ns()` where no time is given. What the arm gets, and
    /// whether it may be armed on it.
    #[inline(always)]
    pub fn advance(&self, py: Python<'_>, now_ns: Option<i64>) -> (Reading, bool) {
        let now = now_ns.unwrap_or_else(|| self.monotonic_ns());
        let sample = self.newest.take().map(|words| sample_of(&words));
        self.steps.store(self.steps().wrapping_add(1), Ordering::Relaxed);
        self.chain.change(py, |chain| (chain.step(now, sample.as_ref()), chain.armable()))
    }

    /// The base's angular velocity so many seconds after the last step, and whether a trusted gyroscope says so.
    #[inline(always)]
    pub fn turning(&self, py: Python<'_>, ahead_s: f64) -> (Vector3<f64>, bool) {
        self.chain.with(py, |chain| chain.turning(ahead_s))
    }

    /// Steps that were taken.
    pub fn steps(&self) -> u64 {
        self.steps.load(Ordering::Relaxed)
    }

    fn monotonic_ns(&self) -> i64 {
        let (then, instant) = self.clock;
        then.saturating_add(i64::try_from(instant.elapsed().as_nanos()).unwrap_or(i64::MAX))
    }

    fn reading(&self, py: Python<'_>) -> Reading {
        self.chain.with(py, gravcomp::Accelerometer::reading)
    }
}

fn sample_of(words: &[u64; WORDS]) -> Sample {
    let [seq, stamp, fx, fy, fz, turns, wx, wy, wz] = *words;
    let vector = |words: [u64; 3]| Vector3::from(words.map(f64::from_bits));
    Sample {
        seq,
        stamp_ns: stamp.cast_signed(),
        specific_force: vector([fx, fy, fz]),
        angular_velocity: (turns != 0).then(|| vector([wx, wy, wz])),
    }
}

/// Whole nanoseconds of a time in seconds, as far as 64 bits go.
#[allow(clippy::cast_possible_truncation)] // `as` saturates, and the settings' own check follows
fn nanoseconds(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

fn number<T: for<'a, 'py> FromPyObject<'a, 'py>>(x: &Bound<'_, PyAny>, name: &str, kind: &str) -> PyResult<T> {
    x.extract().map_err(|_| {
        let shown = x.repr().map_or_else(|_| "?".into(), |text| cut(&text.to_string()));
        argument_error(x.py(), format!("{name} is {shown}; expected {kind}"))
    })
}

fn sequence(x: &Bound<'_, PyAny>) -> PyResult<u64> {
    number(x, "seq", "a whole number of 0 to 2^64 - 1")
}

fn stamp(x: &Bound<'_, PyAny>) -> PyResult<i64> {
    number(x, "stamp_ns", "whole nanoseconds that fit 64 bits")
}

/// How many m/s² one unit of what the sensor sends is.
fn unit_of(x: &Bound<'_, PyAny>) -> PyResult<f64> {
    let g = gravcomp::STANDARD_GRAVITY;
    let units = [("m/s^2", 1.0), ("g", g), ("mg", g / 1e3), ("cm/s^2", 0.01)];
    choice(x.py(), "unit", &number::<String>(x, "unit", "a text")?, &units)
}

fn policy_of(x: &Bound<'_, PyAny>) -> PyResult<Policy> {
    let policies = [("paper", Policy::Paper), ("strict", Policy::Strict)];
    choice(x.py(), "policy", &number::<String>(x, "policy", "a text")?, &policies)
}

/// What the constructor collects before it is checked as a whole.
struct Given {
    settings: Settings,
    calibration: Calibration,
    rotation: Matrix3<f64>,
    position: Vector3<f64>,
    unit: f64,
}

/// Where a setting goes, and what it is read as.
enum Setting {
    Real(fn(&mut Given) -> &mut f64),
    /// None: it does not apply.
    MaybeReal(fn(&mut Given) -> &mut Option<f64>),
    Seconds(fn(&mut Given) -> &mut i64),
    Count(fn(&mut Given) -> &mut u32),
    Vector(fn(&mut Given) -> &mut Vector3<f64>),
    Matrix(fn(&mut Given) -> &mut Matrix3<f64>),
    Range(fn(&mut Given) -> &mut (f64, f64)),
    Flag(fn(&mut Given) -> &mut bool),
    Policy(fn(&mut Given) -> &mut Policy),
    Unit(fn(&mut Given) -> &mut f64),
}

/// What the constructor takes, in the order of its documentation.
const SETTINGS: [(&str, Setting); 33] = [
    ("rate_hz", Setting::Real(|given| &mut given.settings.sample_rate_hz)),
    ("range", Setting::Real(|given| &mut given.settings.range)),
    ("gyro_range", Setting::Real(|given| &mut given.settings.gyro_range)),
    ("bandwidth_hz", Setting::MaybeReal(|given| &mut given.settings.bandwidth_hz)),
    ("unit", Setting::Unit(|given| &mut given.unit)),
    ("bias", Setting::Vector(|given| &mut given.calibration.bias)),
    ("correction", Setting::Matrix(|given| &mut given.calibration.correction)),
    ("gyro_bias", Setting::Vector(|given| &mut given.calibration.gyro_bias)),
    ("rotation", Setting::Matrix(|given| &mut given.rotation)),
    ("position", Setting::Vector(|given| &mut given.position)),
    ("up", Setting::Vector(|given| &mut given.settings.up)),
    ("cutoff_hz", Setting::MaybeReal(|given| &mut given.settings.cutoff_hz)),
    ("policy", Setting::Policy(|given| &mut given.settings.policy)),
    ("norm", Setting::Range(|given| &mut given.settings.norm)),
    ("norm_tolerance", Setting::Real(|given| &mut given.settings.norm_tolerance)),
    ("noise", Setting::Real(|given| &mut given.settings.noise)),
    ("jerk", Setting::Real(|given| &mut given.settings.jerk)),
    ("linear_acceleration", Setting::Real(|given| &mut given.settings.linear_acceleration)),
    ("moving_base", Setting::Flag(|given| &mut given.settings.moving_base)),
    ("pose_limit", Setting::Real(|given| &mut given.settings.pose_limit)),
    ("tilt_limit", Setting::Real(|given| &mut given.settings.tilt_limit)),
    ("tilt_time", Setting::Real(|given| &mut given.settings.tilt_time)),
    ("max_age_s", Setting::Seconds(|given| &mut given.settings.max_age_ns)),
    ("hold_s", Setting::Seconds(|given| &mut given.settings.hold_ns)),
    ("fault_after_s", Setting::Seconds(|given| &mut given.settings.fault_after_ns)),
    ("no_sensor_s", Setting::Seconds(|given| &mut given.settings.no_sensor_ns)),
    ("stuck_count", Setting::Count(|given| &mut given.settings.stuck_count)),
    ("axis_stuck_count", Setting::Count(|given| &mut given.settings.axis_stuck_count)),
    ("density", Setting::Count(|given| &mut given.settings.density)),
    ("start_count", Setting::Count(|given| &mut given.settings.start_count)),
    ("gravity_rate", Setting::Real(|given| &mut given.settings.gravity_rate)),
    ("angular_acceleration", Setting::Real(|given| &mut given.settings.angular_acceleration)),
    ("angular_jerk", Setting::Real(|given| &mut given.settings.angular_jerk)),
];

impl Setting {
    fn read(&self, given: &mut Given, name: &'static str, x: &Bound<'_, PyAny>) -> PyResult<()> {
        match self {
            Self::Real(place) => *place(given) = real_of(x, name)?,
            Self::MaybeReal(place) => *place(given) = if x.is_none() { None } else { Some(real_of(x, name)?) },
            Self::Seconds(place) => *place(given) = nanoseconds(real_of(x, name)?),
            Self::Count(place) => *place(given) = number(x, name, "a whole number from 0")?,
            Self::Vector(place) => *place(given) = vector(x, name)?,
            Self::Matrix(place) => *place(given) = matrix(x, name)?,
            Self::Range(place) => *place(given) = number(x, name, "two numbers, the lower one first")?,
            Self::Flag(place) => *place(given) = number(x, name, "True or False")?,
            Self::Policy(place) => *place(given) = policy_of(x)?,
            Self::Unit(place) => *place(given) = unit_of(x)?,
        }
        Ok(())
    }
}

impl Given {
    fn new() -> Self {
        Self {
            settings: Settings::default(),
            calibration: Calibration::IDENTITY,
            rotation: Matrix3::identity(),
            position: Vector3::zeros(),
            unit: 1.0,
        }
    }

    fn set(&mut self, name: &str, x: &Bound<'_, PyAny>) -> PyResult<()> {
        let known = SETTINGS.iter().find(|(known, _)| *known == name);
        known.map_or_else(|| Err(unknown_setting(x.py(), name)), |(name, setting)| setting.read(self, name, x))
    }

    fn checked(self, py: Python<'_>) -> PyResult<(gravcomp::Accelerometer, f64)> {
        let mounting = Mounting::new(self.rotation, self.position).map_err(|e| model_error(py, "accelerometer", &e))?;
        let settings = Settings { calibration: self.calibration, mounting, ..self.settings };
        let sensor =
            gravcomp::Accelerometer::new(settings).map_err(|error| configuration_error(py, in_python(&error)))?;
        Ok((sensor, self.unit))
    }
}

/// A declaration of the core that cannot be meant, with the names and units that Python's settings have.
fn in_python(error: &SettingsError) -> String {
    let field = error.field.replace("sample_rate_hz", "rate_hz").replace("_ns", "_s");
    let wanted = error.wanted.replace("_ns", "_s").replace(" (shown in s)", "").replace(" (in s)", "");
    format!("accelerometer: {field} is {:?}; it should be {wanted}", error.value)
}

fn real_of(x: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    let is_none = |error: &PyErr| error.is_instance_of::<PyTypeError>(x.py());
    real(x).or_else(|error| if is_none(&error) { number(x, name, "a number") } else { Err(error) })
}

fn unknown_setting(py: Python<'_>, name: &str) -> PyErr {
    let known: Vec<String> = SETTINGS.iter().map(|(name, _)| (*name).to_string()).collect();
    let near = did_you_mean(py, name, &known);
    configuration_error(
        py,
        format!("accelerometer: unknown setting '{}'{near} (known: {})", cut(name), known.join(", ")),
    )
}

/// `time.monotonic_ns()`.
fn python_clock(py: Python<'_>) -> PyResult<i64> {
    static CLOCK: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let clock = CLOCK.get_or_try_init(py, || py.import("time")?.getattr("monotonic_ns").map(Bound::unbind))?;
    clock.bind(py).call0()?.extract()
}

#[pymethods]
impl Accelerometer {
    #[new]
    #[pyo3(signature = (**settings))]
    fn new(py: Python<'_>, settings: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut given = Given::new();
        for (name, value) in settings.into_iter().flatten() {
            given.set(crate::types::text(name.cast::<PyString>()?)?, &value)?;
        }
        let (sensor, unit) = given.checked(py)?;
        let clock = (python_clock(py)?, Instant::now());
        Ok(Self {
            chain: Shared::new(sensor),
            newest: Slot::new(),
            turned_away: AtomicU64::new(0),
            steps: AtomicU64::new(0),
            unit,
            clock,
        })
    }

    /// Hand in a sample; from any thread, never waiting. Only the newest that no step has taken counts.
    ///
    /// False, and nothing done, while another thread hands one in.
    #[pyo3(signature = (seq, stamp_ns, specific_force, angular_velocity=None))]
    fn push(
        &self,
        #[pyo3(from_py_with = sequence)] seq: u64,
        #[pyo3(from_py_with = stamp)] stamp_ns: i64,
        specific_force: &Bound<'_, PyAny>,
        angular_velocity: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<bool> {
        let f = read::<3>(specific_force, 3, "specific_force")?.0.map(|x| (x * self.unit).to_bits());
        let w = angular_velocity.map(|w| read::<3>(w, 3, "angular_velocity")).transpose()?;
        let [wx, wy, wz] = w.map_or([0.0; 3], |(w, _)| w).map(f64::to_bits);
        let words = [seq, stamp_ns.cast_unsigned(), f[0], f[1], f[2], w.is_some().into(), wx, wy, wz];
        let done = self.newest.put(&words);
        if !done {
            self.turned_away.fetch_add(1, Ordering::Relaxed);
        }
        Ok(done)
    }

    /// One control cycle: take the newest sample, if there is one, and move the output. Nothing that came in can make it fail.
    ///
    /// `now_ns` is the time on the clock of the stamps, `time.monotonic_ns()` by default. `out` (3,) gets the gravity.
    #[pyo3(signature = (now_ns=None, out=None))]
    fn step(&self, py: Python<'_>, now_ns: Option<i64>, out: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let target = out.map(|out| required(out, [3], Use::Output("out"))).transpose()?;
        let (reading, _) = self.advance(py, now_ns);
        if let Some(target) = target {
            target.write(reading.gravity.0.as_slice());
        }
        Ok(())
    }

    /// Somebody has looked at it: leave a latched fault; the output stays on the tilt estimate until the sensor is trusted.
    /// Before any sensor was trusted, alarms whose cause is gone go.
    fn acknowledge(&self, py: Python<'_>) {
        self.chain.change(py, gravcomp::Accelerometer::acknowledge);
    }

    /// Gravity at the base origin as of the last step, base axes, m/s²: finite, whatever the sensor sent.
    #[getter]
    fn gravity(&self, py: Python<'_>) -> Gravity {
        Gravity(self.reading(py).gravity)
    }

    /// The same with the base's turning, where the sensor has a gyroscope.
    #[getter]
    fn base_motion(&self, py: Python<'_>) -> BaseMotion {
        BaseMotion(self.reading(py).base)
    }

    /// Where the output comes from: "no_data", "nominal", "live", "held", "degraded" or "fault".
    #[getter]
    fn state(&self, py: Python<'_>) -> &'static str {
        self.reading(py).state.name()
    }

    /// Age of the last accepted sample, ns; None before the first one. Rejected samples do not make it younger.
    #[getter]
    fn age_ns(&self, py: Python<'_>) -> Option<i64> {
        self.reading(py).age_ns
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let reading = self.reading(py);
        let alarms: Vec<_> = reading.status.alarms.iter().map(Fault::name).collect();
        let standing = if alarms.is_empty() { String::new() } else { format!(", alarms {}", alarms.join(", ")) };
        format!("<Accelerometer: {}{standing}>", reading.state.name())
    }

    /// Status word: alarms in the low 32 bits, what was seen in the last step in the high ones.
    #[getter]
    fn status(&self, py: Python<'_>) -> u64 {
        self.reading(py).status.word()
    }

    /// Names of the alarms that stand, each a key of `FAULTS`.
    #[getter]
    fn alarms<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        names(py, self.reading(py).status.alarms.iter().map(Fault::name))
    }

    /// Names of what was found in the last step.
    #[getter]
    fn seen<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        names(py, self.reading(py).status.seen.iter().map(Fault::name))
    }

    /// The arm may be armed on this sensor: with policy "strict" only while it is live. Never while an alarm stands (but for
    /// the missing sensor of policy "paper") or the output has not come to what the sensor says yet.
    #[getter]
    fn armable(&self, py: Python<'_>) -> bool {
        self.chain.with(py, gravcomp::Accelerometer::armable)
    }

    /// The unit that the sensor seems to send instead of the declared one, or None.
    #[getter]
    fn likely_unit(&self, py: Python<'_>) -> Option<&'static str> {
        self.chain.with(py, |chain| chain.likely_unit().map(LikelyUnit::name))
    }

    /// How often, since the start: "received", "accepted", "turned_away" samples, and every fault by name.
    #[getter]
    fn counters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let counters = self.chain.with(py, |chain| *chain.counters());
        let turned_away = self.turned_away.load(Ordering::Relaxed);
        let all = [("received", counters.received), ("accepted", counters.accepted), ("turned_away", turned_away)];
        by_name(py, all.into_iter().chain(Fault::ALL.map(|fault| (fault.name(), counters.of(fault)))))
    }
}

/// What each fault says about the sensor, by name, in the order of the bits of a status word.
pub fn fault_meanings(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    by_name(py, Fault::ALL.map(|fault| (fault.name(), fault.meaning())))
}
