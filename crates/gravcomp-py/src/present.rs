//! The robot as it is now: base, tool and payload may change at run time.
//!
//! They are kept as they were given, beside what they are lowered to. A copy is given the same words and passes the same
//! checks, so it computes with the same bits.

use crate::errors::{argument_error, model_error};
use crate::spec::Names;
use crate::types::{check_size, matrix, vector};
use gravcomp::{Frame, Inertia, Pose};
use nalgebra::{Matrix3, Vector3};
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::borrow::Cow;
use std::iter::successors;

/// A pose that a robot may have; `field` names it in the error.
fn checked(py: Python<'_>, rotation: Matrix3<f64>, translation: Vector3<f64>, field: &'static str) -> PyResult<Pose> {
    check_size(py, field, "translation", translation.as_slice())?;
    Pose::new(rotation, translation, field).map_err(|e| model_error(py, field, &e))
}

/// A pose from the arguments of a setter, without a shift unless one is given.
pub fn given(
    rotation: &Bound<'_, PyAny>,
    translation: Option<&Bound<'_, PyAny>>,
    field: &'static str,
) -> PyResult<Pose> {
    let translation = translation.map_or(Ok(Vector3::zeros()), |t| vector(t, "translation"))?;
    checked(rotation.py(), matrix(rotation, "rotation")?, translation, field)
}

/// A tool frame: `pose` in the frame of the link `tip`.
#[derive(Clone)]
pub struct Tool {
    tip: String,
    pose: Pose,
    frame: Frame,
}

impl Tool {
    /// On a link, or on "base".
    pub fn new(py: Python<'_>, names: &Names, tip: &str, pose: Pose) -> PyResult<Self> {
        if tip == "tool" {
            return Err(argument_error(py, "tip is 'tool'; a tool frame stands on a link or on 'base'".into()));
        }
        Ok(Self { tip: tip.to_owned(), pose, frame: names.frame(py, tip)?.then(pose) })
    }

    /// The tool that `pose` places in this one, on the same link.
    pub fn then(&self, py: Python<'_>, names: &Names, pose: Pose) -> PyResult<Self> {
        let sum = self.pose * pose;
        Self::new(py, names, &self.tip, checked(py, *sum.rotation(), *sum.translation(), "tool")?)
    }

    /// As the kernels need it.
    pub const fn frame(&self) -> Frame {
        self.frame
    }
}

/// A payload in the tool frame: mass (kg), COM (m) and inertia about the COM (kg·m², xx xy xz yy yz zz).
#[derive(Clone)]
pub struct Payload {
    mass: f64,
    com: [f64; 3],
    about_com: [f64; 6],
    lowered: Inertia,
}

impl Payload {
    /// One that can exist. Raises ModelError.
    pub fn new(py: Python<'_>, mass: f64, com: [f64; 3], about_com: [f64; 6]) -> PyResult<Self> {
        for (field, values) in [("mass", &[mass][..]), ("com", &com), ("inertia", &about_com)] {
            check_size(py, "payload", field, values)?;
        }
        let lowered = Inertia::new(mass, com.into(), about_com).map_err(|e| model_error(py, "payload", &e))?;
        Ok(Self { mass, com, about_com, lowered })
    }
}

/// How a robot is set: what may change at run time. A payload comes with the tool that it was attached to.
pub struct Setting {
    base: Pose,
    tool: Tool,
    payload: Option<(Payload, Tool)>,
}

/// The robot that kernels compute with, and the tool and payload as they were given. Its base is kept as it was given anyway.
pub struct Present {
    /// For the kernels.
    pub robot: gravcomp::Robot,
    tool: Tool,
    payload: Option<(Payload, Tool)>,
}

impl Present {
    /// A robot as it was built, with the tool that it was built with.
    pub const fn new(robot: gravcomp::Robot, tool: Tool) -> Self {
        Self { robot, tool, payload: None }
    }

    /// Base, tool and payload as they are now.
    pub fn setting(&self) -> Setting {
        Setting { base: *self.robot.base(), tool: self.tool.clone(), payload: self.payload.clone() }
    }

    /// The tool as it is now.
    pub const fn tool(&self) -> &Tool {
        &self.tool
    }

    /// Replaces the tool. A payload stays where it is.
    pub fn set_tool(&mut self, tool: Tool) {
        self.robot.set_tool(tool.frame);
        self.tool = tool;
    }

    /// Attaches a payload to the tool in place of the one before, or takes it off.
    pub fn set_payload(&mut self, payload: Option<Payload>) {
        match &payload {
            Some(payload) => self.robot.set_payload(payload.lowered),
            None => self.robot.clear_payload(),
        }
        self.payload = payload.map(|payload| (payload, self.tool.clone()));
    }

    /// Sets everything: the payload on the tool of its time, then the tool of now.
    pub fn set(&mut self, Setting { base, tool, payload }: Setting) {
        let (payload, carrier) = payload.unzip();
        if let Some(carrier) = carrier {
            self.set_tool(carrier);
        }
        self.set_payload(payload);
        self.set_tool(tool);
        self.robot.set_base(base);
    }
}

/// Numbers as a tuple.
fn tuple<'py, const N: usize>(numbers: Cow<'_, [f64; N]>, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
    PyTuple::new(py, *numbers).map(Bound::into_any)
}

/// Rows as a tuple of tuples.
fn rows<'py>(matrix: Cow<'_, [[f64; 3]; 3]>, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
    let [x, y, z] = matrix.map(|row| tuple(Cow::Owned(row), py));
    PyTuple::new(py, [x?, y?, z?]).map(Bound::into_any)
}

/// A pose in Python's words: rotation row by row, translation in m.
#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
struct PoseState {
    #[pyo3(into_py_with = rows)]
    rotation: [[f64; 3]; 3],
    #[pyo3(into_py_with = tuple)]
    translation: [f64; 3],
}

impl PoseState {
    fn of(pose: &Pose) -> Self {
        // nalgebra keeps columns; those of the transpose are the rows.
        Self { rotation: pose.rotation().transpose().into(), translation: (*pose.translation()).into() }
    }

    fn checked(&self, py: Python<'_>, field: &'static str) -> PyResult<Pose> {
        checked(py, Matrix3::from_row_slice(self.rotation.as_flattened()), self.translation.into(), field)
    }
}

#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
struct PayloadState {
    mass: f64,
    #[pyo3(into_py_with = tuple)]
    com: [f64; 3],
    #[pyo3(into_py_with = tuple)]
    inertia: [f64; 6],
    tool: PoseState,
    tip: String,
}

/// A [`Setting`] in Python's words: what a pickle holds beside the description.
#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
pub struct State {
    base: PoseState,
    tool: PoseState,
    tip: String,
    payload: Option<PayloadState>,
}

impl State {
    /// In words.
    pub fn of(setting: &Setting) -> Self {
        let payload = setting.payload.as_ref().map(|(payload, tool)| PayloadState {
            mass: payload.mass,
            com: payload.com,
            inertia: payload.about_com,
            tool: PoseState::of(&tool.pose),
            tip: tool.tip.clone(),
        });
        let Setting { base, tool, .. } = setting;
        Self { base: PoseState::of(base), tool: PoseState::of(&tool.pose), tip: tool.tip.clone(), payload }
    }

    /// Reads the words. Raises ArgumentError for anything that is not built like a state.
    pub fn read(state: &Bound<'_, PyAny>, names: &Names) -> PyResult<Self> {
        let py = state.py();
        state.extract().map_err(|error: PyErr| {
            if !error.is_instance_of::<PyException>(py) {
                return error;
            }
            let causes = successors(Some(error.clone_ref(py)), |error| error.cause(py)).take(4);
            let problem = causes.map(|error| error.to_string()).collect::<Vec<_>>().join(": ");
            let expected = "base, tool, tip and payload as __getstate__ of the robot returns them";
            let refusal = argument_error(py, format!("state of {}: {problem}; expected {expected}", names.robot));
            refusal.set_cause(py, Some(error));
            refusal
        })
    }

    /// What the words mean for a robot with these names. Raises ModelError or ArgumentError for what no robot can be set to.
    pub fn checked(&self, py: Python<'_>, names: &Names) -> PyResult<Setting> {
        let payload = self.payload.as_ref().map(|payload| payload.checked(py, names)).transpose()?;
        let tool = Tool::new(py, names, &self.tip, self.tool.checked(py, "tool")?)?;
        Ok(Setting { base: self.base.checked(py, "base")?, tool, payload })
    }
}

impl PayloadState {
    fn checked(&self, py: Python<'_>, names: &Names) -> PyResult<(Payload, Tool)> {
        let tool = Tool::new(py, names, &self.tip, self.tool.checked(py, "payload's tool")?)?;
        Ok((Payload::new(py, self.mass, self.com, self.inertia)?, tool))
    }
}
