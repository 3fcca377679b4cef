//! `Robot`: a robot as the methods of Python and the other classes use it.

mod methods;

use crate::arrays::{output, read_joints};
use crate::disturbance;
use crate::errors::{argument_error, cut};
use crate::present::Present;
use crate::shared::Shared;
use crate::spec::{Names, RobotSpec};
use crate::types::text;
use gravcomp::disturbance::{Disturbances, MAX_PARAMETERS};
use gravcomp::{Frame, GRAVITY_PARAMETERS, JacobianAxes, Joints, MAX_JOINTS, PARAMETERS, Transmission};
use pyo3::prelude::*;
use pyo3::types::PyString;

/// A robot, lowered once from its description. Python's `ravengc.Robot` adds names, limits and files.
#[pyclass(frozen, subclass, module = "ravengc._core")]
pub struct Robot {
    shared: Shared<Present>,
    transmission: Option<Box<Transmission>>,
    disturbances: Option<Box<Disturbances>>,
    names: Names,
    n: usize,
    bodies: usize,
}

impl std::fmt::Debug for Robot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Robot({})", self.names.robot)
    }
}

type Array<'py> = Bound<'py, PyAny>;

/// Most entries of a Jacobian.
pub const JACOBIAN: usize = 6 * MAX_JOINTS;

/// Most entries of a matrix with a row and a column per coordinate.
pub const SQUARE: usize = MAX_JOINTS * MAX_JOINTS;

/// Most entries of the regressor of the gravity torque.
pub const GRAVITY_REGRESSOR: usize = GRAVITY_PARAMETERS * SQUARE;

/// Most entries of the regressor of the disturbance elements.
pub const DISTURBANCE_REGRESSOR: usize = MAX_JOINTS * MAX_PARAMETERS;

/// Most entries of the regressor of the inverse dynamics: 20 KB on the stack, as a cycle takes nothing from the heap.
pub const REGRESSOR: usize = PARAMETERS * SQUARE;

impl Robot {
    /// From its description.
    fn lowered(py: Python<'_>, spec: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (present, transmission, names) = spec.extract::<RobotSpec>()?.build(py)?;
        let (n, bodies) = (present.robot.coordinates(), present.robot.bodies());
        let disturbances = disturbance::read(spec, &names)?;
        Ok(Self {
            n,
            bodies,
            shared: Shared::new(present),
            transmission: transmission.map(Box::new),
            disturbances,
            names,
        })
    }

    /// Coordinates.
    #[inline(always)]
    pub fn n(&self) -> usize {
        self.n
    }

    /// From motors to coordinates, where the robot's file says how.
    pub fn transmission(&self) -> Option<&Transmission> {
        self.transmission.as_deref()
    }

    /// What acts beside the masses, where anything does.
    #[inline(always)]
    pub fn disturbances(&self) -> Option<&Disturbances> {
        self.disturbances.as_deref()
    }

    /// Names of its parts.
    pub(crate) fn names(&self) -> &Names {
        &self.names
    }

    /// Computes with the robot as it is now; `compute` is plain Rust.
    #[inline(always)]
    pub fn with<R>(&self, py: Python<'_>, compute: impl FnOnce(&gravcomp::Robot) -> R) -> R {
        self.shared.with(py, |present| compute(&present.robot))
    }

    /// Maps one number per motor or coordinate through the transmission.
    fn transmit<'py>(
        &self,
        x: &Array<'py>,
        name: &'static str,
        out: Option<&Array<'py>>,
        map: impl Fn(&Transmission, &Joints) -> Joints,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (x.py(), self.n);
        let Some(transmission) = &self.transmission else {
            let message = format!("{} has no transmission; give its file a [transmission] table", self.names.robot);
            return Err(crate::errors::configuration_error(py, message));
        };
        let (x, x_at) = read_joints(x, n, name)?;
        let (out, target) = output(py, out, [n], &[x_at])?;
        target.write(&map(transmission, &x)[..n]);
        Ok(out)
    }

    /// A frame by name; `None` is the tool.
    #[inline(always)]
    pub fn frame(&self, py: Python<'_>, name: Option<&Bound<'_, PyString>>) -> PyResult<Frame> {
        match name.map(text).transpose()? {
            None | Some("tool") => Ok(self.with(py, |robot| *robot.tool())),
            Some(name) => self.names.frame(py, name),
        }
    }
}

/// `axes="base"` or `axes="frame"`.
#[inline(always)]
pub fn jacobian_axes(axes: Option<&Bound<'_, PyString>>) -> PyResult<JacobianAxes> {
    let Some(axes) = axes else { return Ok(JacobianAxes::Base) };
    match text(axes)? {
        "base" => Ok(JacobianAxes::Base),
        "frame" => Ok(JacobianAxes::Frame),
        other => Err(argument_error(axes.py(), format!("axes is '{}'; expected 'base' or 'frame'", cut(other)))),
    }
}
