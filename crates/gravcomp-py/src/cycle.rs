//! Bound cycles: arrays checked and held once, then one call without arguments computes and writes.

use crate::accelerometer::Accelerometer;
use crate::arrays::{Elements, Pinned, Use};
use crate::dispatch::kernel;
use crate::errors::argument_error;
use crate::robot::{JACOBIAN, Robot, jacobian_axes};
use crate::types::{refuse_constant, text};
use gravcomp::{Frame, Gravity, JacobianAxes, Joints, SpecificForce};
use nalgebra::Vector3;
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::PyString;

/// What a cycle computes, and where its inputs lie.
enum Work {
    GravityTorque { q: Pinned, gravity: Source },
    InverseDynamics { q: Pinned, qd: Pinned, qdd: Pinned, base: Box<[Pinned; 3]> },
    ForwardKinematics { q: Pinned, frame: Option<Frame> },
    Jacobian { q: Pinned, frame: Option<Frame>, axes: JacobianAxes },
}

impl Work {
    fn inputs(&self) -> impl Iterator<Item = &Pinned> {
        let (first, rest): ([Option<&Pinned>; 3], &[Pinned]) = match self {
            Self::GravityTorque { q, gravity } => ([Some(q), gravity.array(), None], &[]),
            Self::InverseDynamics { q, qd, qdd, base } => ([Some(q), Some(qd), Some(qdd)], &base[..]),
            Self::ForwardKinematics { q, .. } | Self::Jacobian { q, .. } => ([Some(q), None, None], &[]),
        };
        first.into_iter().flatten().chain(rest)
    }
}

/// Where gravity comes from: an array that somebody fills, or a sensor that each step steps too.
pub enum Source {
    Array(Pinned),
    Sensor(Py<Accelerometer>),
}

impl Source {
    /// `gravity` is an Accelerometer, or an array of three numbers.
    pub fn new(gravity: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(sensor) = gravity.cast::<Accelerometer>() {
            return Ok(Self::Sensor(sensor.clone().unbind()));
        }
        refuse_constant(gravity, "gravity")?;
        Ok(Self::Array(Pinned::new(gravity, [3], Use::Held("gravity"))?))
    }

    /// The array, for those who check or traverse it.
    pub fn array(&self) -> Option<&Pinned> {
        match self {
            Self::Array(array) => Some(array),
            Self::Sensor(_) => None,
        }
    }

    /// The sensor, for those who traverse it.
    pub fn sensor(&self) -> Option<&Py<Accelerometer>> {
        match self {
            Self::Array(_) => None,
            Self::Sensor(sensor) => Some(sensor),
        }
    }

    /// Gravity of now.
    #[inline(always)]
    pub fn now(&self, py: Python<'_>) -> Gravity {
        match self {
            Self::Array(array) => Gravity(vector(array)),
            Self::Sensor(sensor) => sensor.get().advance(py, None).0.gravity,
        }
    }
}

/// A computation bound to its arrays: `step()` reads the inputs, computes, and writes `out`.
///
/// Nothing is parsed or allocated. It raises only if an array was resized, reshaped, retyped or made read-only after it
/// was bound.
#[pyclass(frozen, module = "ravengc._core")]
pub struct Cycle {
    robot: Py<Robot>,
    work: Work,
    out: Pinned,
}

impl std::fmt::Debug for Cycle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Cycle")
    }
}

impl Cycle {
    fn new(robot: &Bound<'_, Robot>, work: Work, out: Pinned) -> PyResult<Self> {
        check_apart(robot.py(), work.inputs().map(Pinned::elements), std::iter::once(out.named()))?;
        Ok(Self { robot: robot.clone().unbind(), work, out })
    }
}

/// ArgumentError where an output lies in the memory of an input or of another output.
pub fn check_apart(
    py: Python<'_>,
    inputs: impl Iterator<Item = Elements>,
    outputs: impl Iterator<Item = (&'static str, Elements)>,
) -> PyResult<()> {
    let mut taken: Vec<Elements> = inputs.collect();
    for (name, output) in outputs {
        if taken.iter().any(|place| place.overlaps(output)) {
            let message = format!("{name} shares memory with an input or another output; give it an array of its own");
            return Err(argument_error(py, message));
        }
        taken.push(output);
    }
    Ok(())
}

/// ArgumentError: an array is no longer what was bound.
#[cold]
pub fn changed(py: Python<'_>) -> PyErr {
    let what = "an array was resized, reshaped, retyped or made read-only after it was bound; bind again";
    argument_error(py, what.to_owned())
}

/// One number per coordinate.
#[inline(always)]
pub fn joints(q: &Pinned, n: usize) -> Joints {
    let mut joints = Joints::default();
    q.elements().read(&mut joints[..n]);
    joints
}

/// Three numbers.
#[inline(always)]
pub fn vector(x: &Pinned) -> Vector3<f64> {
    let mut v = [0.0; 3];
    x.elements().read(&mut v);
    v.into()
}

#[pymethods]
impl Cycle {
    /// Read the inputs, compute, write `out`.
    #[inline(always)]
    fn step(&self, py: Python<'_>) -> PyResult<()> {
        if !(self.out.unchanged(py) && self.work.inputs().all(|input| input.unchanged(py))) {
            return Err(changed(py));
        }
        self.robot.get().with(py, |robot| self.compute(py, robot));
        Ok(())
    }

    /// What the cycle holds, for the garbage collector: a robot may hold the cycle that holds it.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.robot)?;
        if let Work::GravityTorque { gravity, .. } = &self.work {
            visit.call(gravity.sensor())?;
        }
        self.work.inputs().chain([&self.out]).try_for_each(|pinned| visit.call(pinned.array()))
    }
}

impl Cycle {
    #[inline(always)]
    fn compute(&self, py: Python<'_>, robot: &gravcomp::Robot) {
        let (n, out) = (robot.coordinates(), self.out.elements());
        match &self.work {
            Work::GravityTorque { q, gravity } => {
                let (q, g) = (joints(q, n), gravity.now(py));
                out.write(&kernel!(gravity_torque(robot, &q, &g))[..n]);
            }
            Work::InverseDynamics { q, qd, qdd, base } => {
                let [f, w, dw] = &**base;
                let (q, qd, qdd) = (joints(q, n), joints(qd, n), joints(qdd, n));
                let base = gravcomp::BaseMotion {
                    specific_force: SpecificForce(vector(f)),
                    angular_velocity: vector(w),
                    angular_acceleration: vector(dw),
                };
                out.write(&kernel!(inverse_dynamics(robot, &q, &qd, &qdd, &base))[..n]);
            }
            Work::ForwardKinematics { q, frame } => {
                let (q, frame) = (joints(q, n), frame.as_ref().unwrap_or(robot.tool()));
                out.write(kernel!(forward_kinematics(robot, &q, frame)).transpose().as_slice());
            }
            Work::Jacobian { q, frame, axes } => {
                let (q, frame) = (joints(q, n), frame.as_ref().unwrap_or(robot.tool()));
                out.compute::<JACOBIAN>(|entries| kernel!(jacobian(robot, &q, frame, *axes, entries)));
            }
        }
    }
}

/// A frame by name; `None` where the cycle follows the tool.
fn named_frame(robot: &Bound<'_, Robot>, name: Option<&Bound<'_, PyString>>) -> PyResult<Option<Frame>> {
    match name {
        Some(name) if text(name)? != "tool" => Ok(Some(robot.get().frame(robot.py(), Some(name))?)),
        _ => Ok(None),
    }
}

/// A cycle that writes the gravity torque; `gravity` is an array, or an Accelerometer that each step steps too.
#[pyfunction]
pub fn bind_gravity_torque(
    robot: &Bound<'_, Robot>,
    q: &Bound<'_, PyAny>,
    gravity: &Bound<'_, PyAny>,
    out: &Bound<'_, PyAny>,
) -> PyResult<Cycle> {
    let n = robot.get().n();
    let work = Work::GravityTorque { q: Pinned::new(q, [n], Use::Held("q"))?, gravity: Source::new(gravity)? };
    Cycle::new(robot, work, Pinned::new(out, [n], Use::Output("out"))?)
}

/// A cycle that writes the inverse dynamics on a moving base.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn bind_inverse_dynamics(
    robot: &Bound<'_, Robot>,
    q: &Bound<'_, PyAny>,
    qd: &Bound<'_, PyAny>,
    qdd: &Bound<'_, PyAny>,
    specific_force: &Bound<'_, PyAny>,
    angular_velocity: &Bound<'_, PyAny>,
    angular_acceleration: &Bound<'_, PyAny>,
    out: &Bound<'_, PyAny>,
) -> PyResult<Cycle> {
    let n = robot.get().n();
    let work = Work::InverseDynamics {
        q: Pinned::new(q, [n], Use::Held("q"))?,
        qd: Pinned::new(qd, [n], Use::Held("qd"))?,
        qdd: Pinned::new(qdd, [n], Use::Held("qdd"))?,
        base: Box::new([
            Pinned::new(specific_force, [3], Use::Held("specific_force"))?,
            Pinned::new(angular_velocity, [3], Use::Held("angular_velocity"))?,
            Pinned::new(angular_acceleration, [3], Use::Held("angular_acceleration"))?,
        ]),
    };
    Cycle::new(robot, work, Pinned::new(out, [n], Use::Output("out"))?)
}

/// A cycle that writes a frame's pose.
#[pyfunction]
#[pyo3(signature = (robot, q, out, frame=None))]
pub fn bind_forward_kinematics(
    robot: &Bound<'_, Robot>,
    q: &Bound<'_, PyAny>,
    out: &Bound<'_, PyAny>,
    frame: Option<&Bound<'_, PyString>>,
) -> PyResult<Cycle> {
    let (n, frame) = (robot.get().n(), named_frame(robot, frame)?);
    let work = Work::ForwardKinematics { q: Pinned::new(q, [n], Use::Held("q"))?, frame };
    Cycle::new(robot, work, Pinned::new(out, [4, 4], Use::Output("out"))?)
}

/// A cycle that writes a frame's Jacobian.
#[pyfunction]
#[pyo3(signature = (robot, q, out, frame=None, axes=None))]
pub fn bind_jacobian(
    robot: &Bound<'_, Robot>,
    q: &Bound<'_, PyAny>,
    out: &Bound<'_, PyAny>,
    frame: Option<&Bound<'_, PyString>>,
    axes: Option<&Bound<'_, PyString>>,
) -> PyResult<Cycle> {
    let (n, frame) = (robot.get().n(), named_frame(robot, frame)?);
    let work = Work::Jacobian { q: Pinned::new(q, [n], Use::Held("q"))?, frame, axes: jacobian_axes(axes)? };
    Cycle::new(robot, work, Pinned::new(out, [6, n], Use::Output("out"))?)
}
