//! `ResolvedRate`: joint rates from twists and moving targets, with all that it remembers.

use crate::arrays::{Elements, Use, as_double, elements, output, read, read_given, read_joints, required};
use crate::dispatch::kernel;
use crate::errors::{self, argument_error, cut, of_joint};
use crate::rate_cycle::{Given, RateCycle};
use crate::robot::Robot;
use crate::shared::Shared;
use crate::types::{by_name, choice, names, real, text, vector};
use gravcomp::MAX_JOINTS;
use gravcomp::resolved_rate::{
    Damping, Event, Goal, Inputs, Limit, NullSpace, Output, Priority, Settings, SettingsError, TARGET, Task,
};
use pyo3::exceptions::PyTypeError;
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};

type Array<'py> = Bound<'py, PyAny>;

/// Share of the task below which the arm as good as stands.
const STUCK: f64 = 5e-4;

/// Numbers of the longest twist.
pub const TWIST: usize = 6;

/// Resolved-rate motion of one robot; `ravengc.ResolvedRate` says it all.
///
/// Raises ConfigError, LimitError or ArgumentError for what cannot be meant.
#[pyclass(frozen, subclass, module = "ravengc._core")]
pub struct ResolvedRate {
    robot: Py<Robot>,
    pub(crate) n: usize,
    pub(crate) task: Task,
    pub(crate) period: f64,
    shared: Shared<gravcomp::ResolvedRate>,
}

impl std::fmt::Debug for ResolvedRate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ResolvedRate({})", self.task.name())
    }
}

/// A declaration of the core that cannot be meant, in Python's words.
fn refused(py: Python<'_>, error: &SettingsError, settings: &Settings, names: &[String]) -> PyErr {
    let rows = settings.rows.iter().filter(|&&row| row).count();
    let value = match error.field {
        "task" if settings.task == Task::Twist => Some(format!("'twist' of {rows} rows")),
        "task" => Some(format!("'{}'", settings.task.name())),
        "rows" => Some("false for all".to_owned()),
        _ => None,
    };
    errors::refused(py, "resolved rate", error, &of_joint(error, names), value.as_deref())
}

/// A time step, s.
fn seconds(dt: &Array<'_>) -> PyResult<f64> {
    real(dt).map_err(|error| {
        if !error.is_instance_of::<PyTypeError>(dt.py()) {
            return error;
        }
        let kind = dt.get_type().name().map_or_else(|_| "object".into(), |name| name.to_string());
        argument_error(dt.py(), format!("dt is a {kind}; expected a number, in s"))
    })
}

/// The rows of a twist that count.
fn rows_of(x: &Array<'_>) -> PyResult<[bool; TWIST]> {
    Ok(read::<TWIST>(x, TWIST, "rows")?.0.map(|row| row != 0.0))
}

/// The shape of a task's target.
pub fn target_shape(task: Task) -> &'static [usize] {
    match task {
        Task::Twist => &[4, 4],
        Task::Position => &[3],
        Task::Pointing | Task::RemoteCentre => &[6],
    }
}

/// A target's numbers, and where they lie if they were read in place.
fn read_target(x: &Array<'_>, task: Task) -> PyResult<([f64; TARGET], Option<Elements>)> {
    let mut numbers = [0.0; TARGET];
    let Task::Twist = task else { return read::<TARGET>(x, target_shape(task)[0], "target") };
    if let Some(found) = elements(x, [4, 4], Use::Input("target")) {
        found.read(&mut numbers);
        return Ok((numbers, Some(found)));
    }
    let array = as_double(x, "target")?;
    let found = required(&array, [4, 4], Use::Input("target"))?;
    found.read(&mut numbers);
    Ok((numbers, Some(found)))
}

impl ResolvedRate {
    /// One step; the rates go to `out`.
    #[inline(always)]
    pub(crate) fn run(&self, py: Python<'_>, inputs: &Inputs<'_>, out: Elements) {
        self.robot.get().with(py, |robot| {
            self.shared.change(py, |rate| {
                kernel!(resolved_rate(robot, rate, inputs));
                out.write(&rate.output().qd[..self.n]);
            });
        });
    }
}

#[pymethods]
impl ResolvedRate {
    #[new]
    #[pyo3(signature = (
        robot, *, task, frame=None, rows=None, damping, eps, lambda_max, rate_hz, qd_max=None, qdd_max=None, qddd_max=None,
        q_min=None, q_max=None, damper, limits, null_space, null_gain, posture=None, characteristic_length, remote_centre=None,
        pointing_axis=None, gain, turning_gain, speed_max, turning_max, midpoint,
    ))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        robot: &Bound<'_, Robot>,
        task: &Bound<'_, PyString>,
        frame: Option<&Bound<'_, PyString>>,
        rows: Option<&Array<'_>>,
        damping: &Bound<'_, PyString>,
        #[pyo3(from_py_with = real)] eps: f64,
        #[pyo3(from_py_with = real)] lambda_max: f64,
        #[pyo3(from_py_with = real)] rate_hz: f64,
        qd_max: Option<&Array<'_>>,
        qdd_max: Option<&Array<'_>>,
        qddd_max: Option<&Array<'_>>,
        q_min: Option<&Array<'_>>,
        q_max: Option<&Array<'_>>,
        #[pyo3(from_py_with = real)] damper: f64,
        limits: &Bound<'_, PyString>,
        null_space: &Bound<'_, PyString>,
        #[pyo3(from_py_with = real)] null_gain: f64,
        posture: Option<&Array<'_>>,
        #[pyo3(from_py_with = real)] characteristic_length: f64,
        remote_centre: Option<&Array<'_>>,
        pointing_axis: Option<&Array<'_>>,
        #[pyo3(from_py_with = real)] gain: f64,
        #[pyo3(from_py_with = real)] turning_gain: f64,
        #[pyo3(from_py_with = real)] speed_max: f64,
        #[pyo3(from_py_with = real)] turning_max: f64,
        midpoint: bool,
    ) -> PyResult<Self> {
        let (py, inner) = (robot.py(), robot.get());
        let n = inner.n();
        let mut s = Settings {
            task: choice(py, "task", text(task)?, &Task::ALL.map(|task| (task.name(), task)))?,
            damping: choice(py, "damping", text(damping)?, &Damping::ALL.map(|law| (law.name(), law)))?,
            priority: choice(py, "limits", text(limits)?, &Priority::ALL.map(|first| (first.name(), first)))?,
            damper,
            null_space: choice(py, "null_space", text(null_space)?, &NullSpace::ALL.map(|wish| (wish.name(), wish)))?,
            eps,
            lambda_max,
            rate_hz,
            null_gain,
            characteristic_length,
            gain,
            turning_gain,
            speed_max,
            turning_max,
            midpoint,
            ..Settings::of(n)
        };
        if let Some(frame) = frame.filter(|name| text(name).is_ok_and(|name| name != "tool")) {
            s.frame = Some(inner.frame(py, Some(frame))?);
        }
        if let Some(rows) = rows {
            s.rows = rows_of(rows)?;
        }
        for (x, name, into) in [
            (qd_max, "qd_max", &mut s.qd_max),
            (qdd_max, "qdd_max", &mut s.qdd_max),
            (qddd_max, "qddd_max", &mut s.qddd_max),
            (q_min, "q_min", &mut s.limits.0),
            (q_max, "q_max", &mut s.limits.1),
            (posture, "posture", &mut s.posture),
        ] {
            read_given(x, n, name, into)?;
        }
        for (x, name, into) in [
            (remote_centre, "remote_centre", &mut s.remote_centre),
            (pointing_axis, "pointing_axis", &mut s.pointing_axis),
        ] {
            if let Some(x) = x {
                *into = vector(x, name)?;
            }
        }
        let rate = gravcomp::ResolvedRate::new(s).map_err(|error| refused(py, &error, &s, &inner.names().joints))?;
        Ok(Self { robot: robot.clone().unbind(), n, task: s.task, period: 1.0 / s.rate_hz, shared: Shared::new(rate) })
    }

    /// Joint rates (n,) that move the task with `twist`, rad/s or m/s.
    ///
    /// `q` (n,) are the coordinates; `twist` (6,), or (3,) for the task "position", and `base_twist` (6,) are motions in the
    /// world in base axes, linear first; `dt` s. Numbers that are missing give a status, no error. Raises ArgumentError for
    /// arrays of the wrong kind.
    #[pyo3(signature = (q, twist, dt, base_twist=None, out=None))]
    fn step<'py>(
        &self,
        q: &Array<'py>,
        twist: &Array<'py>,
        #[pyo3(from_py_with = seconds)] dt: f64,
        base_twist: Option<&Array<'py>>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (q.py(), self.n);
        let (q, q_at) = read_joints(q, n, "q")?;
        let (twist, twist_at) = read::<TWIST>(twist, self.task.twist_len(), "twist")?;
        let base = base_twist.map(|base| read::<TWIST>(base, TWIST, "base_twist")).transpose()?;
        let base_at = base.as_ref().and_then(|base| base.1);
        let (out, target) = output(py, out, [n], &[q_at, twist_at, base_at])?;
        let base_twist = base.as_ref().map(|base| &base.0);
        self.run(py, &Inputs { q: &q, goal: Goal::Move(&twist), base_twist, base_in_doubt: false, dt }, target);
        Ok(out)
    }

    /// Joint rates (n,) that bring the task to `target` and keep it there while it moves with `target_twist`.
    #[pyo3(signature = (q, target, dt, target_twist=None, base_twist=None, out=None))]
    fn track<'py>(
        &self,
        q: &Array<'py>,
        target: &Array<'py>,
        #[pyo3(from_py_with = seconds)] dt: f64,
        target_twist: Option<&Array<'py>>,
        base_twist: Option<&Array<'py>>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (q.py(), self.n);
        let (q, q_at) = read_joints(q, n, "q")?;
        let (goal, goal_at) = read_target(target, self.task)?;
        let read_twist =
            |x: Option<&Array<'py>>, len, name| x.map_or(Ok(([0.0; TWIST], None)), |x| read::<TWIST>(x, len, name));
        let (twist, twist_at) = read_twist(target_twist, self.task.twist_len(), "target_twist")?;
        let (base, base_at) = read_twist(base_twist, TWIST, "base_twist")?;
        let (out, place) = output(py, out, [n], &[q_at, goal_at, twist_at, base_at])?;
        let base_twist = base_twist.is_some().then_some(&base);
        let goal = Goal::Reach(&goal, &twist);
        self.run(py, &Inputs { q: &q, goal, base_twist, base_in_doubt: false, dt }, place);
        Ok(out)
    }

    /// Bind to arrays: the result's call reads them, computes, and writes `out`.
    ///
    /// Either `twist`, or `target` and, if given, `target_twist`; shapes are those of `step` and `track`. `dt` is 1/rate_hz
    /// where it is not given, 1e-6 to 1 s. `base_twist` may be the base's Accelerometer with a gyroscope: the base turns as its
    /// last step says, carried on to the middle of this one, about `pivot` (3,), m, base axes, the origin if not given;
    /// `base_velocity` (3,), m/s, is an array with the pivot's own motion. Whatever else the sensor feeds steps it, or
    /// `sensor.step()`. A base whose sensor is not trusted, or not stepped for 10 ms, comes to count as still in 50 ms, and
    /// to turn again as slowly; that is the event "base_sensor".
    #[pyo3(signature = (
        *, q, out, twist=None, target=None, target_twist=None, base_twist=None, pivot=None, base_velocity=None, dt=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn bind<'py>(
        slf: &Bound<'py, Self>,
        q: &Array<'py>,
        out: &Array<'py>,
        twist: Option<&Array<'py>>,
        target: Option<&Array<'py>>,
        target_twist: Option<&Array<'py>>,
        base_twist: Option<&Array<'py>>,
        pivot: Option<&Array<'py>>,
        base_velocity: Option<&Array<'py>>,
        dt: Option<&Array<'py>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let given = Given { q, out, twist, target, target_twist, base_twist, pivot, base_velocity };
        Bound::new(slf.py(), RateCycle::new(slf, &given, dt.map(seconds).transpose()?)?)?.into_any().getattr("step")
    }

    /// Somebody has looked at it: what happened since begins anew.
    fn acknowledge(&self, py: Python<'_>) {
        self.shared.change(py, gravcomp::ResolvedRate::acknowledge);
    }

    /// The arm stands still: the next step starts from rest.
    fn reset(&self, py: Python<'_>) {
        self.shared.change(py, gravcomp::ResolvedRate::reset);
    }

    fn __repr__(&self) -> String {
        let name = &self.robot.get().names().robot;
        format!("<ResolvedRate of {name}: {}, {} joints, {} Hz>", self.task.name(), self.n, (1.0 / self.period).round())
    }

    /// Status word: events since the last acknowledgement in the low 32 bits, those of the last step in the high ones.
    #[getter]
    fn status(&self, py: Python<'_>) -> u64 {
        self.shared.with(py, |rate| rate.status().word())
    }

    /// Names of what happened in the last step, each a key of `RATE_EVENTS`.
    #[getter]
    fn seen<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let seen = self.shared.with(py, |rate| rate.status().seen);
        names(py, seen.iter().map(Event::name))
    }

    /// Names of what happened since the last acknowledgement.
    #[getter]
    fn since<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let since = self.shared.with(py, |rate| rate.status().since);
        names(py, since.iter().map(Event::name))
    }

    /// How often, since the start: "cycles", and in how many of them what happened, by name.
    #[getter]
    fn counters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let counters = self.shared.with(py, |rate| *rate.counters());
        let all = [("cycles", counters.cycles)];
        by_name(py, all.into_iter().chain(Event::ALL.map(|event| (event.name(), counters.of(event)))))
    }

    /// Smallest singular value of the task's Jacobian at the last step.
    #[getter]
    fn sigma_min(&self, py: Python<'_>) -> f64 {
        self.shared.with(py, |rate| rate.output().sigma_min)
    }

    /// Damping λ of the last step.
    #[getter]
    fn damping_used(&self, py: Python<'_>) -> f64 {
        self.shared.with(py, |rate| rate.output().damping)
    }

    /// Share of the task that limits of rate and position left in the last step.
    #[getter]
    fn scale(&self, py: Python<'_>) -> f64 {
        self.shared.with(py, |rate| rate.output().scale)
    }

    /// Number of the joint that stood at a limit in the last step, or None: of several, the one that left the task least.
    #[getter]
    fn limiting_joint(&self, py: Python<'_>) -> Option<usize> {
        self.shared.with(py, |rate| rate.output().limiting.map(|(joint, _)| joint))
    }

    /// Which limit that was: "velocity", "position", "acceleration", "jerk", or None.
    #[getter]
    fn limit(&self, py: Python<'_>) -> Option<&'static str> {
        self.shared.with(py, |rate| rate.output().limiting.map(|(_, limit)| limit.name()))
    }

    /// Numbers of all joints that stood at limits in the last step.
    #[getter]
    fn limited_joints<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let at_limits = self.shared.with(py, |rate| rate.output().at_limits);
        PyTuple::new(py, joints_of(at_limits.any()).collect::<Vec<_>>())
    }

    /// Why the last step was not the task's own, in a sentence; empty where it was.
    #[getter]
    fn reason(&self, py: Python<'_>) -> String {
        let (output, seen, rows, priority) =
            self.shared.with(py, |rate| (*rate.output(), rate.status().seen, rate.rows(), rate.settings().priority));
        let (n, names) = (self.n, &self.robot.get().names().joints);
        let said =
            seen.iter().map(|event| match (event, Limit::ALL.into_iter().find(|limit| limit.event() == event)) {
                (Event::Singular, _) => {
                    format!("near a singularity: sigma_min {:.3e}, damping {:.3e}", output.sigma_min, output.damping)
                }
                (Event::Undone, _) => format!(
                    "the task has {rows} rows, the arm {n} coordinates: what they cannot do is left undone; \
                 task 'position' or fewer rows=... ask for less"
                ),
                (event, None) => event.meaning().to_owned(),
                (_, Some(limit)) => at_limit(&output, limit, names, priority),
            });
        said.collect::<Vec<_>>().join("; ")
    }

    /// What it holds, for the garbage collector: a robot may hold what holds it.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.robot)
    }
}

/// The joints whose bits are set.
fn joints_of(bits: u16) -> impl Iterator<Item = usize> {
    (0..MAX_JOINTS).filter(move |joint| bits >> joint & 1 == 1)
}

/// Which joints stand at a limit, and what that leaves of the task.
fn at_limit(output: &Output, limit: Limit, names: &[String], priority: Priority) -> String {
    let joints = joints_of(output.at_limits.of(limit)).filter_map(|joint| names.get(joint));
    let named: Vec<String> = joints.map(|name| format!("'{}'", cut(name))).collect();
    let (kind, percent) = (limit.name(), 100.0 * output.scale);
    let whose = match named.as_slice() {
        [] => "a joint at its".to_owned(),
        [one] => format!("{one} at its"),
        [some @ .., last] => format!("{} and {last} at their", some.join(", ")),
    };
    let plural = if named.len() > 1 { "s" } else { "" };
    let is_stuck = priority == Priority::Direction && limit == Limit::Position && output.scale < STUCK;
    let hint = if is_stuck { " (limits='qp' lets the other joints go on)" } else { "" };
    format!("{whose} {kind} limit{plural}: {percent:.1} % of the task{hint}")
}

/// What each event says, by name, in the order of the bits of a status word.
pub fn event_meanings(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    by_name(py, Event::ALL.map(|event| (event.name(), event.meaning())))
}
