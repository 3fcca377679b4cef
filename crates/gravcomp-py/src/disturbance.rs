//! Disturbance elements read attribute by attribute from a `RobotSpec` and built, and their batches.

use crate::batch::Batch;
use crate::dispatch::kernel;
use crate::errors::{argument_error, outsized};
use crate::robot::{DISTURBANCE_REGRESSOR, Robot};
use crate::rows::Array;
use crate::spec::Names;
use crate::types::whole;
use gravcomp::disturbance::{Along, Blend, Direction, Disturbances, Pieces, Range, Shape};
use gravcomp::error::SettingsError;
use gravcomp::{Frame, Pose};
use nalgebra::{Matrix3, Vector3};
use pyo3::prelude::*;

/// A coordinate by name, or a share of each.
#[derive(FromPyObject)]
enum AlongSpec {
    #[pyo3(transparent)]
    Name(String),
    #[pyo3(transparent)]
    Shares(Vec<f64>),
}

/// What all elements have.
#[derive(FromPyObject)]
struct Element {
    name: String,
    parameters: Vec<f64>,
}

/// What elements along joints have.
#[derive(FromPyObject)]
struct Reads {
    joint: AlongSpec,
    of: Option<AlongSpec>,
}

/// What a constant has.
#[derive(FromPyObject)]
struct Acts {
    joint: AlongSpec,
}

#[derive(FromPyObject)]
struct BlendSpec {
    dead_band: f64,
    saturation: f64,
    ratio: f64,
    blend: String,
}

/// What each kind has that no other has.
#[derive(FromPyObject)]
enum KindSpec {
    Polynomial {
        #[pyo3(attribute("coefficients"))]
        _coefficients: Vec<f64>,
        direction: String,
        range: Option<(f64, f64)>,
    },
    Cable {
        knots: Vec<f64>,
        pieces: Vec<Vec<f64>>,
        range: Option<(f64, f64)>,
    },
    Spring {
        body_a: String,
        point_a: [f64; 3],
        body_b: String,
        point_b: [f64; 3],
        rest_length: f64,
    },
    Friction {
        #[pyo3(attribute("coulomb"))]
        _coulomb: f64,
        stribeck_velocity: Option<f64>,
    },
    Harmonic {
        order: f64,
    },
    LinearSpring {
        rest: f64,
    },
    Constant {
        #[pyo3(attribute("torque"))]
        _torque: f64,
    },
}

/// The elements of a description, where it has any. Raises ModelError, which names the element.
pub fn read(spec: &Bound<'_, PyAny>, names: &Names) -> PyResult<Option<Box<Disturbances>>> {
    let (py, given) = (spec.py(), spec.getattr("disturbances")?);
    let mut all = Box::new(Disturbances::new());
    for element in given.try_iter()? {
        let element = element?;
        let about: Element = element.extract()?;
        let refused =
            |error: SettingsError| outsized(py, &format!("{}: disturbance '{}': {error}", names.robot, about.name));
        match element.extract()? {
            KindSpec::Spring { body_a, point_a, body_b, point_b, rest_length } => {
                let (a, b) = (end(py, names, &body_a, point_a)?, end(py, names, &body_b, point_b)?);
                let stiffness = about.parameters.first().copied().unwrap_or(f64::NAN);
                all.between(&a, &b, rest_length, stiffness).map_err(refused)?;
            }
            kind => {
                let (acts, reads) = directions(&element, &kind)?;
                let acts = acts.checked(py, names)?.map_err(refused)?;
                let reads = reads.map_or(Ok(Ok(acts)), |reads| reads.checked(py, names))?.map_err(refused)?;
                let shape = kind.shape(&element)?.map_err(refused)?;
                all.along(acts, reads, shape, &about.parameters).map_err(refused)?;
            }
        }
    }
    Ok((!all.parameters().is_empty()).then_some(all))
}

/// What an element acts along and, where that is something else, what it reads.
fn directions(element: &Bound<'_, PyAny>, kind: &KindSpec) -> PyResult<(AlongSpec, Option<AlongSpec>)> {
    if matches!(kind, KindSpec::Constant { .. }) {
        return Ok((element.extract::<Acts>()?.joint, None));
    }
    let Reads { joint, of } = element.extract()?;
    Ok((joint, of))
}

/// A point of a link, or of frame 0 for "base", as a frame.
fn end(py: Python<'_>, names: &Names, body: &str, point: [f64; 3]) -> PyResult<Frame> {
    let frame = if body == "base" { Frame::ROOT } else { names.frame(py, body)? };
    let pose = Pose::new(Matrix3::identity(), Vector3::from(point), "point");
    Ok(frame.then(pose.map_err(|error| outsized(py, &format!("{}: {body}: {error}", names.robot)))?))
}

impl AlongSpec {
    fn checked(&self, py: Python<'_>, names: &Names) -> PyResult<Result<Along, SettingsError>> {
        let n = names.joints.len();
        match self {
            Self::Shares(shares) if shares.len() == n => Ok(Along::new(shares)),
            Self::Shares(shares) => {
                let message = format!("{}: {} shares; expected {n}, one per coordinate", names.robot, shares.len());
                Err(argument_error(py, message))
            }
            Self::Name(name) => match names.joints.iter().position(|joint| joint == name) {
                Some(at) => {
                    let mut shares = vec![0.0; n];
                    shares[at] = 1.0;
                    Ok(Along::new(&shares))
                }
                None => Err(argument_error(py, format!("{}: there is no joint '{name}'", names.robot))),
            },
        }
    }
}

impl KindSpec {
    fn shape(&self, element: &Bound<'_, PyAny>) -> PyResult<Result<Shape, SettingsError>> {
        Ok(Ok(match self {
            Self::Polynomial { direction, range, .. } => Shape::Polynomial {
                direction: match direction.as_str() {
                    "positive" => Direction::Positive,
                    "negative" => Direction::Negative,
                    _ => Direction::Both,
                },
                blend: blend(element)?,
                range: ends(*range),
            },
            Self::Cable { knots, pieces, range } => {
                let lengths: Vec<_> = pieces.iter().map(Vec::len).collect();
                return Ok(Pieces::new(knots, &lengths).map(|pieces| Shape::Cable { pieces, range: ends(*range) }));
            }
            Self::Friction { stribeck_velocity, .. } => {
                Shape::Friction { blend: blend(element)?, stribeck: *stribeck_velocity }
            }
            Self::Harmonic { order } => Shape::Harmonic { order: *order },
            Self::LinearSpring { rest } => Shape::LinearSpring { rest: *rest },
            Self::Constant { .. } | Self::Spring { .. } => Shape::Constant,
        }))
    }
}

fn blend(element: &Bound<'_, PyAny>) -> PyResult<Blend> {
    let BlendSpec { dead_band, saturation, ratio, blend } = element.extract()?;
    Ok(Blend { dead_band, saturation, ratio, smooth: blend == "tanh" })
}

fn ends(range: Option<(f64, f64)>) -> Range {
    range.map_or(Range::ALL, |(low, high)| Range { low, high })
}

/// Efforts against the disturbance elements, (samples, n).
#[pyfunction]
#[pyo3(signature = (robot, q, qd=None, out=None, threads=1))]
pub fn disturbance_torque_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    qd: Option<&Array<'py>>,
    out: Option<&Array<'py>>,
    #[pyo3(from_py_with = whole)] threads: isize,
) -> PyResult<Array<'py>> {
    let (n, elements) = (robot.get().n(), robot.get().disturbances());
    Batch::new(robot, q, threads)?.moving(qd, out, &[n], &|robot, [q, qd], to| {
        let tau = elements.map_or_else(Default::default, |all| kernel!(disturbance_torque(robot, all, q, qd)));
        to.write(&tau[..n]);
    })
}

/// Their regressors, (samples, n, columns).
#[pyfunction]
#[pyo3(signature = (robot, q, qd=None, out=None, threads=1))]
pub fn disturbance_regressor_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    qd: Option<&Array<'py>>,
    out: Option<&Array<'py>>,
    #[pyo3(from_py_with = whole)] threads: isize,
) -> PyResult<Array<'py>> {
    let (n, elements) = (robot.get().n(), robot.get().disturbances());
    let width = elements.map_or(0, |all| all.parameters().len());
    Batch::new(robot, q, threads)?.moving(qd, out, &[n, width], &|robot, [q, qd], to| {
        if let Some(all) = elements {
            to.compute::<DISTURBANCE_REGRESSOR>(|entries| {
                kernel!(disturbance_regressor(robot, all, q, qd, entries));
            });
        }
    })
}
