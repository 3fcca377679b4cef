//! `Controller`: a control law with all that it remembers.

use crate::arrays::{Pins, read_given};
use crate::control_cycle::{Base, ControlCycle};
use crate::dispatch::kernels;
use crate::elastic::ElasticGravity;
use crate::errors::{self, argument_error, of_joint};
use crate::robot::Robot;
use crate::shared::Shared;
use crate::types::{by_name, choice, names, real, text};
use gravcomp::control::{Event, Law, OnFault, Settings, SettingsError, Side};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};

type Array<'py> = Bound<'py, PyAny>;

/// A control law for one robot, with limits, ramps, checks and a latched fault; `ravengc.control.Controller` says it all.
///
/// Arrays (n,) stand at the side they belong to. Raises ConfigError, LimitError or ArgumentError for what cannot be meant.
#[pyclass(frozen, module = "ravengc._core")]
pub struct Controller {
    pub(crate) robot: Py<Robot>,
    pub(crate) n: usize,
    law: Law,
    has_springs: bool,
    needs_links: bool,
    pub(crate) disturbs: bool,
    pub(crate) shared: Shared<Box<gravcomp::Controller>>,
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
    let side = if error.field.starts_with("tau") { settings.output } else { settings.feedback };
    let at_motor = side == Side::Motor && !error.field.starts_with("limits");
    let whose = match error.joint {
        Some(motor) if at_motor => format!(" of motor {motor} (from 0)"),
        _ => of_joint(error, names),
    };
    let is_side = error.value.is_nan() && error.joint.is_none() && error.wanted.starts_with("at the joints");
    let value = if error.field == "elastic" { Some("given") } else { is_side.then_some("'motor'") };
    errors::refused(py, "controller", error, &whose, value)
}

impl Controller {
    /// ArgumentError for arrays that the law needs and were not given, or that were given and it has not.
    fn require(&self, py: Python<'_>, has_target: bool, has_links: bool, has_aim: bool) -> PyResult<()> {
        if self.law.has_pd() && !has_target {
            let message = format!("q_desired is missing: the law '{}' follows a target", self.law.name());
            return Err(argument_error(py, message));
        }
        if self.needs_links && !has_links {
            let message = "q_link is missing: the elastic variant 'link' takes gravity where the links are";
            return Err(argument_error(py, message.to_owned()));
        }
        if has_aim && !self.has_springs {
            let message =
                "theta_desired is where the motors of elastic joints belong; make the controller with elastic=";
            return Err(argument_error(py, message.to_owned()));
        }
        Ok(())
    }
}

#[pymethods]
impl Controller {
    #[new]
    #[pyo3(signature = (
        robot, law, *, kp, kd, rate_hz=1000.0, tau_max=None, tau_rate_max=None, lower=None, upper=None, jump=None, wrap=None,
        ramp_s=1.0, hold_s=0.05, feedback=None, output=None, on_fault=None, elastic=None,
        disturbances=true,
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
        elastic: Option<&Bound<'_, ElasticGravity>>,
        disturbances: bool,
    ) -> PyResult<Self> {
        let (py, inner) = (robot.py(), robot.get());
        let n = inner.n();
        let mut s = Settings {
            rate_hz,
            ramp_s,
            hold_s,
            ..Settings::of(named(law, "law", &Law::ALL.map(|law| (law.name(), law)))?, n)
        };
        read_given(Some(kp), n, "kp", &mut s.kp)?;
        read_given(Some(kd), n, "kd", &mut s.kd)?;
        read_given(tau_max, n, "tau_max", &mut s.tau_max)?;
        read_given(tau_rate_max, n, "tau_rate_max", &mut s.tau_rate_max)?;
        read_given(lower, n, "limits (lower)", &mut s.limits.0)?;
        read_given(upper, n, "limits (upper)", &mut s.limits.1)?;
        read_given(jump, n, "jump", &mut s.jump)?;
        read_given(wrap, n, "wrap", &mut s.modulus)?;
        s.feedback = feedback.map_or(Ok(Side::Joint), |side| side_of(side, "feedback"))?;
        s.output = output.map_or(Ok(s.feedback), |side| side_of(side, "output"))?;
        let fault = [("gravity", OnFault::Gravity), ("decay", OnFault::Decay)];
        s.on_fault = on_fault.map_or(Ok(OnFault::Gravity), |end| named(end, "on_fault", &fault))?;
        s.transmission = inner.transmission().copied();
        let refused = |error| refused(py, &error, &s, &inner.names().joints);
        let mut law = gravcomp::Controller::new(s, kernels()).map_err(refused)?;
        if let Some(elastic) = elastic {
            law = law.with_elastic(elastic.get().law_for(robot)?).map_err(refused)?;
        }
        let needs_links = elastic.is_some_and(|elastic| elastic.get().needs_links());
        let has_springs = elastic.is_some();
        let (robot, shared) = (robot.clone().unbind(), Shared::new(Box::new(law)));
        Ok(Self { robot, n, law: s.law, has_springs, needs_links, disturbs: disturbances, shared })
    }

    /// Bind the law to arrays: the result's call reads them, computes, and writes the outputs.
    ///
    /// `q` (n,) and, if given, `qd` (n,) at the side of the feedback; `q_desired` (n,) and, if given, `qd_desired` (n,), of the
    /// coordinates, which every law but "passive" needs. `gravity` is an array (3,) or an Accelerometer that each call
    /// steps too; or `specific_force` (3,) instead. "pd+bm" also takes `angular_velocity` and `angular_acceleration` (3,)
    /// where an array is given. `out`, `tau_pd`, `tau_gravity` and `tau_disturbance` (n,) are written. With elastic joints
    /// `q_link` (n,) is read, and then required, by variant "link" alone, and `theta_desired` (n,), where the motors belong, is
    /// written.
    ///
    /// Of arrays that are views of a common one, that one is checked in each call: it may not be resized, reshaped or
    /// retyped.
    #[pyo3(signature = (
        *, q, out, gravity=None, specific_force=None, angular_velocity=None, angular_acceleration=None, qd=None, q_link=None,
        q_desired=None, qd_desired=None, tau_pd=None, tau_gravity=None, tau_disturbance=None,
        theta_desired=None,
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
        q_link: Option<&Array<'py>>,
        q_desired: Option<&Array<'py>>,
        qd_desired: Option<&Array<'py>>,
        tau_pd: Option<&Array<'py>>,
        tau_gravity: Option<&Array<'py>>,
        tau_disturbance: Option<&Array<'py>>,
        theta_desired: Option<&Array<'py>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, controller) = (slf.py(), slf.get());
        controller.require(py, q_desired.is_some(), q_link.is_some(), theta_desired.is_some())?;
        let mut pins = Pins::default();
        let base = Base::new(py, &mut pins, gravity, specific_force, angular_velocity, angular_acceleration)?;
        let inputs =
            [("q", Some(q)), ("qd", qd), ("q_link", q_link), ("q_desired", q_desired), ("qd_desired", qd_desired)];
        let outputs = [
            ("out", Some(out)),
            ("tau_pd", tau_pd),
            ("tau_gravity", tau_gravity),
            ("tau_disturbance", tau_disturbance),
            ("theta_desired", theta_desired),
        ];
        let cycle = ControlCycle::new(slf, pins, base, inputs, outputs)?;
        Bound::new(py, cycle)?.into_any().getattr("step")
    }

    /// Ask for the arm to be driven: on a ramp, from the next cycle on that has a good joint state.
    fn arm(&self, py: Python<'_>) {
        self.shared.change(py, |law| law.arm());
    }

    /// Ask for no torque, on a ramp. A latched fault stays latched, without torque.
    fn disarm(&self, py: Python<'_>) {
        self.shared.change(py, |law| law.disarm());
    }

    /// Somebody has looked at it: the next cycle leaves a latched fault, on a ramp, if it has a good joint state.
    fn acknowledge(&self, py: Python<'_>) {
        self.shared.change(py, |law| law.acknowledge());
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

    /// Steps of the elastic joints' fixed point in the last cycle; 0 where there is none.
    #[getter]
    fn iterations(&self, py: Python<'_>) -> u32 {
        self.shared.with(py, |law| law.fixed_point().map_or(0, |found| found.0))
    }

    /// How far, at most, the last cycle took gravity from that fixed point, rad (m); infinite where nothing is known.
    #[getter]
    fn error_bound(&self, py: Python<'_>) -> f64 {
        self.shared.with(py, |law| law.fixed_point().map_or(0.0, |found| found.1))
    }

    /// Names of what happened in the last cycle, each a key of `EVENTS`.
    #[getter]
    fn seen<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let seen = self.shared.with(py, |law| law.status().seen);
        names(py, seen.iter().map(Event::name))
    }

    /// Names of what happened since the last acknowledgement.
    #[getter]
    fn since<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let since = self.shared.with(py, |law| law.status().since);
        names(py, since.iter().map(Event::name))
    }

    /// How often, since the start: "cycles", and in how many of them what happened, by name.
    #[getter]
    fn counters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let counters = self.shared.with(py, |law| *law.counters());
        let all = [("cycles", counters.cycles)];
        by_name(py, all.into_iter().chain(Event::ALL.map(|event| (event.name(), counters.of(event)))))
    }

    /// What the controller holds, for the garbage collector.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.robot)
    }
}

/// What each event says, by name, in the order of the bits of a status word.
pub fn event_meanings(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    by_name(py, Event::ALL.map(|event| (event.name(), event.meaning())))
}
