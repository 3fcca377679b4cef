//! `Controller`: a control law with all that it remembers, and the cycle that steps it.

use crate::arrays::{Pinned, Use, read_joints};
use crate::cycle::{Source, changed, check_apart, vector};
use crate::dispatch::kernels;
use crate::errors::{argument_error, configuration_error, cut, limit_error};
use crate::robot::Robot;
use crate::shared::Shared;
use crate::types::{choice, meanings, real, text};
use gravcomp::control::{Event, Inputs, Law, OnFault, Settings, SettingsError, Side};
use gravcomp::{BaseMotion, Gravity, Joints, MAX_JOINTS, SpecificForce};
use nalgebra::Vector3;
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};

type Array<'py> = Bound<'py, PyAny>;

/// A control law for one robot, with limits, ramps, checks and a latched fault; `ravengc.control.Controller` says it all.
///
/// Arrays (n,) stand at the side they belong to. Raises ConfigError, LimitError or ArgumentError for what cannot be meant.
#[pyclass(frozen, module = "ravengc._core")]
pub struct Controller {
    robot: Py<Robot>,
    n: usize,
    law: Law,
    shared: Shared<gravcomp::Controller>,
}

impl std::fmt::Debug for Controller {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Controller({})", self.law.name())
    }
}

/// The value that a text names.
fn named<T: Copy>(x: &Bound<'_, PyString>, what: &str, options: &[(&str, T)]) -> PyResult<T> {
    choice(x.py(), what, text(x)?, options)
}

fn side_of(x: &Bound<'_, PyString>, what: &str) -> PyResult<Side> {
    named(x, what, &[("joint", Side::Joint), ("motor", Side::Motor)])
}

/// A declaration of the core that cannot be meant, in Python's words.
fn refused(py: Python<'_>, error: &SettingsError, settings: &Settings, names: &[String]) -> PyErr {
    let (field, wanted) = (error.field, error.wanted);
    let side = if field.starts_with("tau") { settings.output } else { settings.feedback };
    let at_motor = side == Side::Motor && !field.starts_with("limits");
    let whose = match error.joint {
        Some(motor) if at_motor => format!(" of motor {motor} (from 0)"),
        Some(joint) => names.get(joint).map_or_else(String::new, |name| format!(" of '{}'", cut(name))),
        None => String::new(),
    };
    let value = if error.value.is_nan() && error.joint.is_none() && wanted.starts_with("at the joints") {
        "'motor'".to_owned()
    } else {
        format!("{:?}", error.value)
    };
    let message = format!("controller: {field}{whose} is {value}; it should be {wanted}");
    let is_limit = field.starts_with("tau") || field.starts_with("limits");
    if is_limit { limit_error(py, message) } else { configuration_error(py, message) }
}

/// One number per coordinate, motor or encoder, where given.
fn numbers(x: Option<&Array<'_>>, n: usize, name: &'static str, into: &mut Joints) -> PyResult<()> {
    if let Some(x) = x {
        *into = read_joints(x, n, name)?.0;
    }
    Ok(())
}

#[pymethods]
impl Controller {
    #[new]
    #[pyo3(signature = (
        robot, law, *, kp, kd, rate_hz=1000.0, tau_max=None, tau_rate_max=None, lower=None, upper=None, jump=None, wrap=None,
        ramp_s=1.0, hold_s=0.05, feedback=None, output=None, on_fault=None,
    ))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        robot: &Bound<'_, Robot>,
        law: &Bound<'_, PyString>,
        kp: &Array<'_>,
        kd: &Array<'_>,
        #[pyo3(from_py_with = real)] rate_hz: f64,
        tau_max: Option<&Array<'_>>,
        tau_rate_max: Option<&Array<'_>>,
        lower: Option<&Array<'_>>,
        upper: Option<&Array<'_>>,
        jump: Option<&Array<'_>>,
        wrap: Option<&Array<'_>>,
        #[pyo3(from_py_with = real)] ramp_s: f64,
        #[pyo3(from_py_with = real)] hold_s: f64,
        feedback: Option<&Bound<'_, PyString>>,
        output: Option<&Bound<'_, PyString>>,
        on_fault: Option<&Bound<'_, PyString>>,
    ) -> PyResult<Self> {
        let (py, inner) = (robot.py(), robot.get());
        let n = inner.n();
        let mut s = Settings {
            rate_hz,
            ramp_s,
            hold_s,
            ..Settings::of(named(law, "law", &Law::ALL.map(|law| (law.name(), law)))?, n)
        };
        numbers(Some(kp), n, "kp", &mut s.kp)?;
        numbers(Some(kd), n, "kd", &mut s.kd)?;
        numbers(tau_max, n, "tau_max", &mut s.tau_max)?;
        numbers(tau_rate_max, n, "tau_rate_max", &mut s.tau_rate_max)?;
        numbers(lower, n, "limits (lower)", &mut s.limits.0)?;
        numbers(upper, n, "limits (upper)", &mut s.limits.1)?;
        numbers(jump, n, "jump", &mut s.jump)?;
        numbers(wrap, n, "wrap", &mut s.modulus)?;
        s.feedback = feedback.map_or(Ok(Side::Joint), |side| side_of(side, "feedback"))?;
        s.output = output.map_or(Ok(s.feedback), |side| side_of(side, "output"))?;
        let fault = [("gravity", OnFault::Gravity), ("decay", OnFault::Decay)];
        s.on_fault = on_fault.map_or(Ok(OnFault::Gravity), |end| named(end, "on_fault", &fault))?;
        s.transmission = inner.transmission().copied();
        let law =
            gravcomp::Controller::new(s, kernels()).map_err(|error| refused(py, &error, &s, &inner.names().joints))?;
        Ok(Self { robot: robot.clone().unbind(), n, law: s.law, shared: Shared::new(law) })
    }

    /// Bind the law to arrays: the result's call reads them, computes, and writes the outputs.
    ///
    /// `q` (n,) and, if given, `qd` (n,) at the side of the feedback; `q_desired` (n,) and, if given, `qd_desired` (n,), of the
    /// coordinates, which every law but "passive" needs. `gravity` is an array (3,) or an Accelerometer that each call
    /// steps too; or `specific_force` (3,) instead. "pd+bm" also takes `angular_velocity` and `angular_acceleration` (3,)
    /// where an array is given. `out`, `tau_pd` and `tau_gravity` (n,) are written.
    #[pyo3(signature = (
        *, q, out, gravity=None, specific_force=None, angular_velocity=None, angular_acceleration=None, qd=None,
        q_desired=None, qd_desired=None, tau_pd=None, tau_gravity=None,
    ))]
    #[allow(clippy::too_many_arguments)]
    fn bind<'py>(
        slf: &Bound<'py, Self>,
        q: &Array<'py>,
        out: &Array<'py>,
        gravity: Option<&Array<'py>>,
        specific_force: Option<&Array<'py>>,
        angular_velocity: Option<&Array<'py>>,
        angular_acceleration: Option<&Array<'py>>,
        qd: Option<&Array<'py>>,
        q_desired: Option<&Array<'py>>,
        qd_desired: Option<&Array<'py>>,
        tau_pd: Option<&Array<'py>>,
        tau_gravity: Option<&Array<'py>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, n) = (slf.py(), slf.get().n);
        if q_desired.is_none() && slf.get().law.has_pd() {
            let message = format!("q_desired is missing: the law '{}' follows a target", slf.get().law.name());
            return Err(argument_error(py, message));
        }
        let held = |x: Option<&Array<'py>>, name| x.map(|x| Pinned::new(x, [n], Use::Held(name))).transpose();
        let written = |x: Option<&Array<'py>>, name| x.map(|x| Pinned::new(x, [n], Use::Output(name))).transpose();
        let cycle = ControlCycle {
            controller: slf.clone().unbind(),
            base: Base::new(py, gravity, specific_force, angular_velocity, angular_acceleration)?,
            q: Pinned::new(q, [n], Use::Held("q"))?,
            qd: held(qd, "qd")?,
            q_desired: held(q_desired, "q_desired")?,
            qd_desired: held(qd_desired, "qd_desired")?,
            out: Pinned::new(out, [n], Use::Output("out"))?,
            tau_pd: written(tau_pd, "tau_pd")?,
            tau_gravity: written(tau_gravity, "tau_gravity")?,
        };
        check_apart(py, cycle.inputs(), cycle.outputs())?;
        Bound::new(py, cycle)?.into_any().getattr("step")
    }

    /// Ask for the arm to be driven: on a ramp, from the next cycle on that has a good joint state.
    fn arm(&self, py: Python<'_>) {
        self.shared.change(py, gravcomp::Controller::arm);
    }

    /// Ask for no torque, on a ramp. A latched fault stays latched, without torque.
    fn disarm(&self, py: Python<'_>) {
        self.shared.change(py, gravcomp::Controller::disarm);
    }

    /// Somebody has looked at it: the next cycle leaves a latched fault, on a ramp, if it has a good joint state.
    fn acknowledge(&self, py: Python<'_>) {
        self.shared.change(py, gravcomp::Controller::acknowledge);
    }

    /// So many cycles passed without a step: the last good pose is that much older.
    fn skip(&self, py: Python<'_>, cycles: u32) {
        self.shared.change(py, |law| law.skip(cycles));
    }

    /// "disarmed", "ramping", "armed" or "fault".
    #[getter]
    fn state(&self, py: Python<'_>) -> &'static str {
        self.shared.with(py, |law| law.state().name())
    }

    /// Status word: events since the last acknowledgement in the low 32 bits, those of the last cycle in the high ones.
    #[getter]
    fn status(&self, py: Python<'_>) -> u64 {
        self.shared.with(py, |law| law.status().word())
    }

    /// Names of what happened in the last cycle, each a key of `EVENTS`.
    #[getter]
    fn seen<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let seen = self.shared.with(py, |law| law.status().seen);
        PyTuple::new(py, seen.iter().map(Event::name).collect::<Vec<_>>())
    }

    /// Names of what happened since the last acknowledgement.
    #[getter]
    fn since<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let since = self.shared.with(py, |law| law.status().since);
        PyTuple::new(py, since.iter().map(Event::name).collect::<Vec<_>>())
    }

    /// How often, since the start: "cycles", and in how many of them what happened, by name.
    #[getter]
    fn counters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let counters = self.shared.with(py, |law| *law.counters());
        let named = PyDict::new(py);
        named.set_item("cycles", counters.cycles)?;
        for event in Event::ALL {
            named.set_item(event.name(), counters.of(event))?;
        }
        Ok(named)
    }

    /// What the controller holds, for the garbage collector.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.robot)
    }
}

/// Where the base's motion comes from.
struct Base {
    source: Source,
    /// The array holds the specific force, f = −g.
    is_force: bool,
    /// ω and dω, where arrays hold them.
    turning: Option<[Pinned; 2]>,
}

impl Base {
    fn new(
        py: Python<'_>,
        gravity: Option<&Array<'_>>,
        force: Option<&Array<'_>>,
        w: Option<&Array<'_>>,
        dw: Option<&Array<'_>>,
    ) -> PyResult<Self> {
        let vector = |x, name| Pinned::new(x, [3], Use::Held(name));
        let (source, is_force) = match (gravity, force) {
            (Some(gravity), None) => (Source::new(gravity)?, false),
            (None, Some(force)) => (Source::Array(vector(force, "specific_force")?), true),
            _ => return Err(argument_error(py, "give either gravity or specific_force".to_owned())),
        };
        let turning = match (w, dw, source.sensor()) {
            (None, None, _) => None,
            (_, _, Some(_)) => {
                let message = "the Accelerometer says how the base turns; leave out angular_velocity and \
                               angular_acceleration";
                return Err(argument_error(py, message.to_owned()));
            }
            (Some(w), Some(dw), None) => Some([vector(w, "angular_velocity")?, vector(dw, "angular_acceleration")?]),
            _ => return Err(argument_error(py, "give both angular_velocity and angular_acceleration".to_owned())),
        };
        Ok(Self { source, is_force, turning })
    }

    /// The base's motion of now, and whether the arm may be armed on it.
    #[inline(always)]
    fn now(&self, py: Python<'_>) -> (BaseMotion, bool) {
        let array = match &self.source {
            Source::Array(array) => vector(array),
            Source::Sensor(sensor) => {
                let (reading, armable) = sensor.get().advance(py, None);
                return (reading.base, armable);
            }
        };
        let specific_force = if self.is_force { SpecificForce(array) } else { Gravity(array).into() };
        let [angular_velocity, angular_acceleration] = match &self.turning {
            Some(rates) => [vector(&rates[0]), vector(&rates[1])],
            None => [Vector3::zeros(); 2],
        };
        (BaseMotion { specific_force, angular_velocity, angular_acceleration }, true)
    }

    fn inputs(&self) -> impl Iterator<Item = &Pinned> {
        self.source.array().into_iter().chain(self.turning.iter().flatten())
    }
}

/// A control law bound to its arrays: `step()` reads the inputs, computes, and writes the outputs.
///
/// Nothing is parsed or allocated. It raises only if an array was resized, reshaped, retyped or made read-only after it
/// was bound.
#[pyclass(frozen, module = "ravengc._core")]
pub struct ControlCycle {
    controller: Py<Controller>,
    base: Base,
    q: Pinned,
    qd: Option<Pinned>,
    q_desired: Option<Pinned>,
    qd_desired: Option<Pinned>,
    out: Pinned,
    tau_pd: Option<Pinned>,
    tau_gravity: Option<Pinned>,
}

impl std::fmt::Debug for ControlCycle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("ControlCycle")
    }
}

impl ControlCycle {
    fn inputs(&self) -> impl Iterator<Item = &Pinned> {
        let given = [&self.qd, &self.q_desired, &self.qd_desired];
        [&self.q].into_iter().chain(given.into_iter().flatten()).chain(self.base.inputs())
    }

    fn outputs(&self) -> impl Iterator<Item = &Pinned> {
        [&self.out].into_iter().chain([&self.tau_pd, &self.tau_gravity].into_iter().flatten())
    }
}

#[pymethods]
impl ControlCycle {
    /// Read the inputs, compute, write the outputs.
    #[inline(always)]
    fn step(&self, py: Python<'_>) -> PyResult<()> {
        if !self.inputs().chain(self.outputs()).all(|array| array.unchanged(py)) {
            return Err(changed(py));
        }
        let controller = self.controller.get();
        let n = controller.n;
        let (base, armable) = self.base.now(py);
        let [mut q, mut qd, mut q_desired, mut qd_desired] = [const { Joints([0.0; MAX_JOINTS]) }; 4];
        self.q.elements().read(&mut q[..n]);
        for (array, into) in
            [(&self.qd, &mut qd), (&self.q_desired, &mut q_desired), (&self.qd_desired, &mut qd_desired)]
        {
            if let Some(array) = array {
                array.elements().read(&mut into[..n]);
            }
        }
        let qd = self.qd.is_some().then_some(&qd);
        let inputs = Inputs { q: &q, qd, q_desired: &q_desired, qd_desired: &qd_desired, base: &base, armable };
        controller.shared.change(py, |law| {
            controller.robot.get().with(py, |robot| law.step(robot, &inputs));
            let output = law.output();
            self.out.elements().write(&output.tau[..n]);
            for (array, term) in [(&self.tau_pd, &output.tau_pd), (&self.tau_gravity, &output.tau_gravity)] {
                if let Some(array) = array {
                    array.elements().write(&term[..n]);
                }
            }
        });
        Ok(())
    }

    /// What the cycle holds, for the garbage collector.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.controller)?;
        visit.call(self.base.source.sensor())?;
        self.inputs().chain(self.outputs()).try_for_each(|pinned| visit.call(pinned.array()))
    }
}

/// What each event says, by name, in the order of the bits of a status word.
pub fn event_meanings(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    meanings(py, Event::ALL.map(|event| (event.name(), event.meaning())))
}
