//! The solvers behind limited rates, each by itself: what the tests and benches hold to account.

use crate::arrays::{Elements, Use, as_double, output, read_joints, required};
use crate::dispatch::kernel;
use crate::robot::Robot;
use gravcomp::box_qp::{Active, Problem, ROWS, Solution};
use gravcomp::manipulability::{Ascent, Projection};
use gravcomp::{Joints, MAX_JOINTS};
use pyo3::prelude::*;

type Array<'py> = Bound<'py, PyAny>;

/// What the rows of J hold.
const MATRIX: usize = ROWS * MAX_JOINTS;

/// Places in a problem of seven joints and fewer.
const FEW: usize = 8;

/// Rows (6, n) of an array, by place.
fn rows<const N: usize>(found: Elements, n: usize) -> [[f64; N]; ROWS] {
    let (mut flat, mut rows) = ([0.0; MATRIX], [[0.0; N]; ROWS]);
    found.read(&mut flat[..ROWS * n]);
    for (row, values) in rows.iter_mut().zip(flat.chunks_exact(n)) {
        row[..n].copy_from_slice(values);
    }
    rows
}

/// The first places of `x`, then `rest`.
fn places<const N: usize>(x: &Joints, n: usize, rest: f64) -> [f64; N] {
    let mut places = [rest; N];
    places[..n].copy_from_slice(&x[..n]);
    places
}

fn six(x: &Array<'_>, name: &'static str) -> PyResult<[f64; ROWS]> {
    let array = as_double(x, name)?;
    let mut six = [0.0; ROWS];
    required(&array, [ROWS], Use::Input(name))?.read(&mut six);
    Ok(six)
}

/// One programme: `_box_minimum(rows (6, n), target (6,), row_weight (6,), wish, weight, lower, upper (n,), warm)`.
///
/// Returns x, the bounds that hold it (two words), the residual, the rounds taken, and how it ended (0 solved, 1 capped, 2 refused).
#[pyfunction]
#[pyo3(name = "_box_minimum")]
#[allow(clippy::too_many_arguments, clippy::type_complexity)] // the programme's own numbers
pub fn box_minimum<'py>(
    rows: &Array<'py>,
    target: &Array<'py>,
    row_weight: &Array<'py>,
    wish: &Array<'py>,
    weight: &Array<'py>,
    lower: &Array<'py>,
    upper: &Array<'py>,
    warm: (u16, u16),
) -> PyResult<(Array<'py>, (u16, u16), f64, u32, u8)> {
    let py = rows.py();
    let n = weight.len()?.clamp(1, MAX_JOINTS);
    let matrix = as_double(rows, "rows")?;
    let elements = required(&matrix, [ROWS, n], Use::Input("rows"))?;
    let (target, row_weight) = (six(target, "target")?, six(row_weight, "row_weight")?);
    let of = |x: &Array<'py>, name| read_joints(x, n, name).map(|(joints, _)| joints);
    let (wish, weight) = (of(wish, "wish")?, of(weight, "weight")?);
    let (lower, upper) = (of(lower, "lower")?, of(upper, "upper")?);
    let warm = Active { lower: warm.0, upper: warm.1 };
    macro_rules! solved {
        ($N:expr) => {{
            let problem = Problem::<$N> {
                rows: self::rows(elements, n),
                target,
                row_weight,
                wish: places(&wish, n, 0.0),
                weight: places(&weight, n, 1.0),
                lower: places(&lower, n, 0.0),
                upper: places(&upper, n, 0.0),
            };
            let found = kernel!(minimum_in_box(&problem, warm));
            (Joints::from_slice(&found.x), told(&found))
        }};
    }
    let (x, (active, residual, taken, outcome)) = if n <= FEW { solved!(FEW) } else { solved!(MAX_JOINTS) };
    let (out, place) = output(py, None, [n], &[])?;
    place.write(&x[..n]);
    Ok((out, active, residual, taken, outcome))
}

fn told<const N: usize>(found: &Solution<N>) -> ((u16, u16), f64, u32, u8) {
    ((found.active.lower, found.active.upper), found.residual, found.rounds, found.outcome as u8)
}

/// Manipulability of the tool for its whole twist, and its gradient (n,).
#[pyfunction]
#[pyo3(name = "_manipulability")]
pub fn manipulability<'py>(robot: &Bound<'py, Robot>, q: &Array<'py>) -> PyResult<(f64, Array<'py>)> {
    let py = robot.py();
    let n = robot.get().with(py, gravcomp::Robot::coordinates);
    let (q, _) = read_joints(q, n, "q")?;
    let found = robot.get().with(py, |robot| kernel!(manipulability(robot, &q, robot.tool(), &Projection::TWIST)));
    let (out, place) = output(py, None, [n], &[])?;
    place.write(&found.gradient[..n]);
    Ok((found.value, out))
}

/// One step of at most eight joints: `_ascend(rows (6, n), v (6,), gradient (n,), (effort, slack, progress), lower, upper (n,))`.
///
/// Returns x, how much of the ascent was given up, and how it ended (0 solved, 1 capped, 2 refused).
#[pyfunction]
#[pyo3(name = "_ascend")]
pub fn ascend<'py>(
    rows: &Array<'py>,
    v: &Array<'py>,
    gradient: &Array<'py>,
    settings: (f64, f64, f64),
    lower: &Array<'py>,
    upper: &Array<'py>,
) -> PyResult<(Array<'py>, f64, u8)> {
    let n = gradient.len()?.clamp(1, FEW);
    let (effort, slack, progress) = settings;
    let matrix = as_double(rows, "rows")?;
    let T = self::rows::<FEW>(required(&matrix, [ROWS, n], Use::Input("rows"))?, n);
    let of = |x: &Array<'py>, name, rest| read_joints(x, n, name).map(|(joints, _)| places::<FEW>(&joints, n, rest));
    let limits = (of(lower, "lower", 0.0)?, of(upper, "upper", 0.0)?);
    let (v, gradient) = (six(v, "v")?, of(gradient, "gradient", 0.0)?);
    let found = kernel!(ascend(&T, &v, &gradient, Ascent { effort, slack, progress }, limits, [Active::default(); 2]));
    let (out, place) = output(rows.py(), None, [n], &[])?;
    place.write(&found.x[..n]);
    Ok((out, found.restrained, found.outcome as u8))
}
