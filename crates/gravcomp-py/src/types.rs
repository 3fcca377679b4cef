//! `Gravity`, `SpecificForce`, `BaseMotion`, `Mounting`: the sign and frame of what a base sensor says, as types.

use crate::arrays::read;
use crate::errors::{argument_error, configuration_error, cut, did_you_mean, model_error, outsized};
use nalgebra::{Matrix3, Unit, Vector3};
use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict, PyString, PyTuple};
use std::f64::consts::TAU;

/// No length, mass or inertia of an arm is larger (SI); the limit of `ravengc.config.physical`.
const LARGEST: f64 = 1e9;

/// A plain number.
pub fn real(x: &Bound<'_, PyAny>) -> PyResult<f64> {
    x.extract().map_err(|error| unless_too_large(x.py(), error, "a number is too large for a float64"))
}

/// A whole number.
pub fn whole(x: &Bound<'_, PyAny>) -> PyResult<isize> {
    x.extract().map_err(|error| unless_too_large(x.py(), error, "a whole number is beyond 64 bits"))
}

fn unless_too_large(py: Python<'_>, error: PyErr, message: &str) -> PyErr {
    let is_overflow = error.is_instance_of::<PyOverflowError>(py);
    if is_overflow { argument_error(py, message.into()) } else { error }
}

/// A name as Rust holds it.
#[inline(always)]
pub fn text<'a>(x: &'a Bound<'_, PyString>) -> PyResult<&'a str> {
    x.to_str().map_err(|_| argument_error(x.py(), "a name is not valid Unicode: it holds a lone surrogate".into()))
}

/// The value that `name` names, or a ConfigError with the known names and the near one.
pub fn choice<T: Copy>(py: Python<'_>, what: &str, name: &str, options: &[(&str, T)]) -> PyResult<T> {
    options.iter().find(|(option, _)| *option == name).map(|(_, value)| *value).ok_or_else(|| {
        let known: Vec<String> = options.iter().map(|(option, _)| (*option).to_owned()).collect();
        let near = did_you_mean(py, name, &known);
        let listed = known.join("', '");
        let listed = listed.rsplit_once(", ").map_or(listed.clone(), |(first, last)| format!("{first} or {last}"));
        configuration_error(py, format!("{what} is '{}'; choose '{listed}'{near}", cut(name)))
    })
}

/// ModelError for numbers that no arm has and that could overflow in a cycle; NaN passes, to be named by later checks.
pub fn check_size(py: Python<'_>, place: &str, field: &str, values: &[f64]) -> PyResult<()> {
    let large = values.iter().find(|x| x.abs() > LARGEST);
    large.map_or(Ok(()), |x| {
        Err(outsized(py, &format!("{place}: {field}: got {x:e}, expected at most {LARGEST:e} (SI)")))
    })
}

/// A vector argument: three numbers in any form.
pub fn vector(x: &Bound<'_, PyAny>, name: &'static str) -> PyResult<Vector3<f64>> {
    Ok(Vector3::from(read::<3>(x, 3, name)?.0))
}

/// A rotation or any 3 × 3 argument, row by row.
pub fn matrix(x: &Bound<'_, PyAny>, name: &'static str) -> PyResult<Matrix3<f64>> {
    let array = crate::arrays::as_double(x, name)?;
    let mut rows = [0.0; 9];
    crate::arrays::required(&array, [3, 3], crate::arrays::Use::Input(name))?.read(&mut rows);
    Ok(Matrix3::from_row_slice(&rows))
}

/// A dict of what belongs to each name.
pub fn by_name<'py, T: IntoPyObject<'py>>(
    py: Python<'py>,
    named: impl IntoIterator<Item = (&'static str, T)>,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    named.into_iter().try_for_each(|(name, value)| dict.set_item(name, value))?;
    Ok(dict)
}

/// A tuple of names.
pub fn names(py: Python<'_>, names: impl Iterator<Item = &'static str>) -> PyResult<Bound<'_, PyTuple>> {
    PyTuple::new(py, names.collect::<Vec<_>>())
}

fn tuple(v: Vector3<f64>) -> (f64, f64, f64) {
    (v.x, v.y, v.z)
}

/// The numbers x, y, z, or the three of one argument.
fn three_numbers(
    x: &Bound<'_, PyAny>,
    y: Option<&Bound<'_, PyAny>>,
    z: Option<&Bound<'_, PyAny>>,
    name: &'static str,
) -> PyResult<Vector3<f64>> {
    match (y, z) {
        (Some(y), Some(z)) => Ok(Vector3::new(real(x)?, real(y)?, real(z)?)),
        (None, None) => vector(x, name),
        _ => Err(argument_error(x.py(), format!("{name} takes x, y and z (m/s²), or one vector of the three"))),
    }
}

/// An axis by its name or as a vector of any length.
fn axis_of(axis: &Bound<'_, PyAny>) -> PyResult<Unit<Vector3<f64>>> {
    if let Ok(name) = axis.cast::<PyString>() {
        let known = [("x", Vector3::x_axis()), ("y", Vector3::y_axis()), ("z", Vector3::z_axis())];
        return choice(axis.py(), "axis", text(name)?, &known);
    }
    let v = vector(axis, "axis")?;
    let unit = Unit::try_new(v, f64::MIN_POSITIVE).filter(|unit| unit.iter().all(|x| x.is_finite()));
    unit.ok_or_else(|| argument_error(axis.py(), format!("axis is ({}, {}, {}); expected a direction", v.x, v.y, v.z)))
}

/// An angle that is no degrees taken for rad.
fn within_a_turn(py: Python<'_>, angle: f64) -> PyResult<f64> {
    if angle.abs() <= TAU {
        return Ok(angle);
    }
    Err(argument_error(
        py,
        format!("angle is {angle} rad; expected at most a turn (math.radians makes rad of degrees)"),
    ))
}

/// Refuses a constant where an array is wanted that is read again in every step.
pub fn refuse_constant(x: &Bound<'_, PyAny>, name: &str) -> PyResult<()> {
    let (kind, remedy) = match (x.cast::<Gravity>(), x.cast::<SpecificForce>()) {
        (Ok(_), _) => ("Gravity", "np.array([*gravity])"),
        (_, Ok(_)) => ("SpecificForce", "np.array([*specific_force.as_gravity()])"),
        _ => return Ok(()),
    };
    let wanted = "expected a float64 array of shape (3,) that every step reads anew";
    Err(argument_error(x.py(), format!("{name} is a {kind}, which never changes; {wanted}, such as {remedy}")))
}

macro_rules! vector_type {
    ($(#[$doc:meta])* $name:ident, $other:ident, $as_other:ident) => {
        $(#[$doc])*
        #[pyclass(frozen, eq, module = "ravengc")]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name(pub gravcomp::$name);

        #[pymethods]
        impl $name {
            #[new]
            #[pyo3(signature = (x, y=None, z=None))]
            fn new(x: &Bound<'_, PyAny>, y: Option<&Bound<'_, PyAny>>, z: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
                three_numbers(x, y, z, stringify!($name)).map(|v| Self(gravcomp::$name(v)))
            }

            #[staticmethod]
            fn level() -> Self {
                Self(gravcomp::$name::from(gravcomp::Gravity::LEVEL))
            }

            /// At rest on a base that is turned from level by `angle` (rad) about an axis of its own, "x", "y", "z" or (3,).
            #[staticmethod]
            fn tilted(#[pyo3(from_py_with = real)] angle: f64, axis: &Bound<'_, PyAny>) -> PyResult<Self> {
                let angle = within_a_turn(axis.py(), angle)?;
                Ok(Self(gravcomp::$name::from(gravcomp::Gravity::tilted(angle, axis_of(axis)?))))
            }

            /// The other view of a base at rest: f = -g.
            fn $as_other(&self) -> $other {
                $other(self.0.into())
            }

            #[getter]
            fn x(&self) -> f64 {
                self.0.0.x
            }

            #[getter]
            fn y(&self) -> f64 {
                self.0.0.y
            }

            #[getter]
            fn z(&self) -> f64 {
                self.0.0.z
            }

            fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                tuple(self.0.0).into_pyobject(py)?.into_any().call_method0("__iter__")
            }

            fn __repr__(&self) -> String {
                let v = self.0.0;
                format!(concat!(stringify!($name), "({:?}, {:?}, {:?})"), v.x, v.y, v.z)
            }

            fn __hash__(&self) -> u64 {
                self.0.0.iter().fold(17, |hash: u64, x| hash.wrapping_mul(31) ^ (x + 0.0).to_bits())
            }

            fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
                Ok((slf.get_type().into_any(), tuple(slf.get().0.0).into_pyobject(slf.py())?))
            }
        }
    };
}

vector_type! {
    /// Gravity(x, y, z)
    /// --
    ///
    /// The gravity field g in base axes, m/s²: level it is (0, 0, -9.80665). The paper's s_g.
    Gravity, SpecificForce, as_specific_force
}
vector_type! {
    /// SpecificForce(x, y, z)
    /// --
    ///
    /// What an ideal accelerometer at the base origin reads, f = a - g, in base axes, m/s²: level and at rest (0, 0, +9.80665).
    SpecificForce, Gravity, as_gravity
}

/// How the base moves: specific force (m/s²), angular velocity (rad/s) and angular acceleration (rad/s²) at the base origin,
/// in base axes.
#[pyclass(frozen, eq, module = "ravengc")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseMotion(pub gravcomp::BaseMotion);

fn optional(x: Option<&Bound<'_, PyAny>>, name: &'static str) -> PyResult<Vector3<f64>> {
    x.map_or(Ok(Vector3::zeros()), |x| vector(x, name))
}

#[pymethods]
impl BaseMotion {
    #[new]
    #[pyo3(signature = (*, specific_force, angular_velocity=None, angular_acceleration=None))]
    fn new(
        specific_force: &Bound<'_, PyAny>,
        angular_velocity: Option<&Bound<'_, PyAny>>,
        angular_acceleration: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        Ok(Self(gravcomp::BaseMotion {
            specific_force: force(specific_force, "specific_force")?,
            angular_velocity: optional(angular_velocity, "angular_velocity")?,
            angular_acceleration: optional(angular_acceleration, "angular_acceleration")?,
        }))
    }

    #[staticmethod]
    fn at_rest(gravity: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self(gravcomp::BaseMotion::at_rest(self::gravity(gravity)?.0)))
    }

    #[staticmethod]
    #[pyo3(signature = (*, specific_force, angular_velocity=None, angular_acceleration=None, mounting=None))]
    fn from_imu(
        specific_force: &Bound<'_, PyAny>,
        angular_velocity: Option<&Bound<'_, PyAny>>,
        angular_acceleration: Option<&Bound<'_, PyAny>>,
        mounting: Option<&Bound<'_, Mounting>>,
    ) -> PyResult<Self> {
        let sample = gravcomp::ImuSample {
            specific_force: vector(specific_force, "specific_force")?,
            angular_velocity: optional(angular_velocity, "angular_velocity")?,
            angular_acceleration: optional(angular_acceleration, "angular_acceleration")?,
        };
        let mounting = mounting.map_or_else(Default::default, |m| m.get().checked);
        Ok(Self(gravcomp::BaseMotion::from_imu(&sample, &mounting)))
    }

    #[getter]
    fn specific_force(&self) -> SpecificForce {
        SpecificForce(self.0.specific_force)
    }

    #[getter]
    fn angular_velocity(&self) -> (f64, f64, f64) {
        tuple(self.0.angular_velocity)
    }

    #[getter]
    fn angular_acceleration(&self) -> (f64, f64, f64) {
        tuple(self.0.angular_acceleration)
    }

    /// For copies and pickles.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        let force = self.specific_force().into_pyobject(py)?.into_any();
        let rates = [self.angular_velocity(), self.angular_acceleration()];
        let [w, dw] = rates.map(|rate| rate.into_pyobject(py));
        let named =
            [("specific_force", force), ("angular_velocity", w?.into_any()), ("angular_acceleration", dw?.into_any())];
        Ok((PyTuple::empty(py), named.into_py_dict(py)?))
    }

    fn __repr__(&self) -> String {
        format!(
            "BaseMotion(specific_force={:?}, angular_velocity={:?}, angular_acceleration={:?})",
            tuple(self.0.specific_force.0),
            self.angular_velocity(),
            self.angular_acceleration()
        )
    }
}

/// Where an inertial sensor sits on the base: rotation R_BS maps sensor axes to base axes, position is in base axes, m.
/// A mirror (determinant -1) is refused.
#[pyclass(frozen, eq, module = "ravengc")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    checked: gravcomp::Mounting,
    rotation: Matrix3<f64>,
    position: Vector3<f64>,
}

#[pymethods]
impl Mounting {
    #[new]
    #[pyo3(signature = (rotation, position=None))]
    fn new(rotation: &Bound<'_, PyAny>, position: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let py = rotation.py();
        let (rotation, position) = (matrix(rotation, "rotation")?, optional(position, "position")?);
        let checked = gravcomp::Mounting::new(rotation, position).map_err(|e| model_error(py, "Mounting", &e))?;
        Ok(Self { checked, rotation, position })
    }

    /// R_BS, row by row.
    #[getter]
    fn rotation(&self) -> [(f64, f64, f64); 3] {
        [0, 1, 2].map(|row| tuple(self.rotation.row(row).transpose()))
    }

    /// m, base axes.
    #[getter]
    fn position(&self) -> (f64, f64, f64) {
        tuple(self.position)
    }

    /// For copies and pickles.
    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        (self.rotation(), self.position()).into_pyobject(py)
    }

    fn __repr__(&self) -> String {
        format!("Mounting({:?}, {:?})", self.rotation(), self.position())
    }
}

/// A gravity argument: three numbers, `Gravity`, or `SpecificForce` (turned round); and the array it was read from.
#[inline(always)]
pub fn gravity(x: &Bound<'_, PyAny>) -> PyResult<(gravcomp::Gravity, Option<crate::arrays::Elements>)> {
    if let Some(found) = crate::arrays::elements(x, [3], crate::arrays::Use::Input("gravity")) {
        let mut g = [0.0; 3];
        found.read(&mut g);
        return Ok((gravcomp::Gravity(g.into()), Some(found)));
    }
    if let Ok(g) = x.cast::<Gravity>() {
        return Ok((g.get().0, None));
    }
    if let Ok(f) = x.cast::<SpecificForce>() {
        return Ok((f.get().0.into(), None));
    }
    Ok((gravcomp::Gravity(vector(x, "gravity")?), None))
}

/// A specific force argument: three numbers, `SpecificForce`, or `Gravity` (turned round).
fn force(x: &Bound<'_, PyAny>, name: &'static str) -> PyResult<gravcomp::SpecificForce> {
    if let Ok(f) = x.cast::<SpecificForce>() {
        return Ok(f.get().0);
    }
    if let Ok(g) = x.cast::<Gravity>() {
        return Ok(g.get().0.into());
    }
    Ok(gravcomp::SpecificForce(vector(x, name)?))
}

/// A base argument: `BaseMotion`, or `Gravity` or `SpecificForce` for a base at rest. A bare vector could mean either.
#[inline(always)]
pub fn base_motion(x: &Bound<'_, PyAny>) -> PyResult<gravcomp::BaseMotion> {
    if let Ok(base) = x.cast::<BaseMotion>() {
        return Ok(base.get().0);
    }
    if let Ok(g) = x.cast::<Gravity>() {
        return Ok(gravcomp::BaseMotion::at_rest(g.get().0));
    }
    if let Ok(f) = x.cast::<SpecificForce>() {
        return Ok(gravcomp::BaseMotion::at_rest(f.get().0.into()));
    }
    let kind = x.get_type().name()?;
    let message = format!(
        "base is a {kind}; expected a BaseMotion, a Gravity or a SpecificForce (a bare vector could mean either)"
    );
    Err(argument_error(x.py(), message))
}
