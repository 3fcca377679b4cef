//! The same functions over many configurations, without the GIL and on as many threads as asked for.

use crate::arrays::{Elements, Use, as_double, elements, output, required};
use crate::dispatch::{Level, kernel};
use crate::errors::argument_error;
use crate::robot::{Robot, jacobian_axes, write_jacobian, write_square};
use crate::types::{base_motion, gravity};
use gravcomp::{BaseMotion, GRAVITY_PARAMETERS, Gravity, Joints, MAX_JOINTS, PARAMETERS, SpecificForce};
use numpy::{PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyString;
use std::ops::Range;

/// Configurations that share the lanes of one kernel call.
const WIDTH: usize = 8;

type Array<'py> = Bound<'py, PyAny>;

/// An argument with one row per sample; the array that owns it is held.
struct Rows<'py> {
    _array: Array<'py>,
    at: Elements,
    width: usize,
}

impl<'py> Rows<'py> {
    /// A (samples, width) argument; `samples` is known from an earlier one, or read off this one.
    fn new(x: &Array<'py>, samples: Option<usize>, width: usize, name: &'static str) -> PyResult<(Self, usize)> {
        let rows =
            |x: &Array<'py>| x.cast::<PyUntypedArray>().ok().and_then(|x| x.shape().first().copied()).unwrap_or(0);
        let count = samples.unwrap_or_else(|| rows(x));
        if let Some(at) = elements(x, [count, width], Use::Input(name)) {
            return Ok((Self { _array: x.clone(), at, width }, count));
        }
        let array = as_double(x, name)?;
        let count = samples.unwrap_or_else(|| rows(&array));
        let at = required(&array, [count, width], Use::Input(name))?;
        Ok((Self { _array: array, at, width }, count))
    }

    fn lane(&self) -> Lane {
        Lane { at: self.at, width: self.width }
    }
}

/// Rows as the worker threads see them.
#[derive(Clone, Copy)]
struct Lane {
    at: Elements,
    width: usize,
}

impl Lane {
    #[inline(always)]
    fn row<const N: usize>(self, k: usize) -> [f64; N] {
        let mut row = [0.0; N];
        self.sample(k).read(&mut row[..self.width]);
        row
    }

    #[inline(always)]
    fn joints(self, k: usize) -> Joints {
        Joints(self.row(k))
    }

    /// Where sample `k` lies.
    fn sample(self, k: usize) -> Elements {
        self.at.part(k * self.width, self.width)
    }

    fn write(self, k: usize, values: &[f64]) {
        self.sample(k).write(values);
    }
}

/// One gravity vector for all samples, or one each.
#[derive(Clone, Copy)]
enum GravityOf {
    All(Gravity),
    Each(Lane),
}

impl GravityOf {
    #[inline(always)]
    fn at(self, k: usize) -> Gravity {
        match self {
            Self::All(g) => g,
            Self::Each(rows) => Gravity(rows.row::<3>(k).into()),
        }
    }
}

fn gravity_of<'py>(x: &Array<'py>, samples: usize) -> PyResult<(GravityOf, Option<Rows<'py>>)> {
    if x.getattr("ndim").and_then(|ndim| ndim.extract::<usize>()).is_ok_and(|ndim| ndim == 2) {
        let (rows, _) = Rows::new(x, Some(samples), 3, "gravity")?;
        return Ok((GravityOf::Each(rows.lane()), Some(rows)));
    }
    Ok((GravityOf::All(gravity(x)?.0), None))
}

/// One base motion for all samples, or one each: rows of specific force, angular velocity, angular acceleration.
#[derive(Clone, Copy)]
enum BaseOf {
    All(BaseMotion),
    Each(Lane),
}

impl BaseOf {
    #[inline(always)]
    fn at(self, k: usize) -> BaseMotion {
        match self {
            Self::All(base) => base,
            Self::Each(rows) => {
                let [fx, fy, fz, wx, wy, wz, ax, ay, az] = rows.row::<9>(k);
                BaseMotion {
                    specific_force: SpecificForce([fx, fy, fz].into()),
                    angular_velocity: [wx, wy, wz].into(),
                    angular_acceleration: [ax, ay, az].into(),
                }
            }
        }
    }
}

fn base_of<'py>(x: &Array<'py>, samples: usize) -> PyResult<(BaseOf, Option<Rows<'py>>)> {
    if x.cast::<PyUntypedArray>().is_ok() {
        let (rows, _) = Rows::new(x, Some(samples), 9, "base")?;
        return Ok((BaseOf::Each(rows.lane()), Some(rows)));
    }
    Ok((BaseOf::All(base_motion(x)?), None))
}

/// Threads for `samples`: 0 asks for one per core.
fn thread_count(py: Python<'_>, threads: isize, samples: usize) -> PyResult<usize> {
    let wanted = match threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        _ => usize::try_from(threads).map_err(|_| {
            argument_error(py, format!("threads is {threads}; expected 0 (all cores) or a positive number"))
        })?,
    };
    Ok(wanted.min(samples / 256 + 1))
}

/// Runs `work` over the samples without the GIL, split among the threads at multiples of [`WIDTH`].
fn run(py: Python<'_>, samples: usize, threads: isize, work: impl Fn(Range<usize>) + Sync) -> PyResult<()> {
    let threads = thread_count(py, threads, samples)?;
    let share = samples.div_ceil(threads).next_multiple_of(WIDTH).max(WIDTH);
    py.detach(|| {
        std::thread::scope(|scope| {
            for first in (share..samples).step_by(share) {
                let work = &work;
                scope.spawn(move || work(first..(first + share).min(samples)));
            }
            work(0..share.min(samples));
        });
    });
    Ok(())
}

/// The gravity torques of up to [`WIDTH`] samples from `first`; lanes beyond `last` repeat it.
#[inline(always)]
fn gravity_block(
    robot: &gravcomp::Robot,
    q: Lane,
    g: GravityOf,
    range: Range<usize>,
    level: Level,
) -> [[f64; WIDTH]; MAX_JOINTS] {
    let (mut positions, mut field) = ([[0.0; WIDTH]; MAX_JOINTS], [[0.0; WIDTH]; 3]);
    for l in 0..WIDTH {
        let k = (range.start + l).min(range.end - 1);
        let row = q.joints(k);
        for i in 0..q.width {
            positions[i][l] = row[i];
        }
        let g = g.at(k).0;
        for axis in 0..3 {
            field[axis][l] = g[axis];
        }
    }
    #[cfg(target_arch = "x86_64")]
    if level == Level::Avx512 {
        // SAFETY: AVX-512 F, VL and DQ were detected on this processor.
        return unsafe { gravcomp::avx512::gravity_torques(robot, &positions, &field) };
    }
    let _ = level;
    kernel!(gravity_torques(robot, &positions, &field))
}

/// What every batch function needs: a copy of the robot, its positions, and where the results go.
struct Batch<'py> {
    robot: gravcomp::Robot,
    q: Rows<'py>,
    samples: usize,
}

impl<'py> Batch<'py> {
    fn new(robot: &Bound<'py, Robot>, q: &Array<'py>) -> PyResult<Self> {
        let robot = robot.get().with(robot.py(), Clone::clone);
        let (q, samples) = Rows::new(q, None, robot.coordinates(), "q")?;
        Ok(Self { robot, q, samples })
    }

    /// One number per coordinate and sample.
    fn rows(&self, x: &Array<'py>, name: &'static str) -> PyResult<Rows<'py>> {
        Ok(Rows::new(x, Some(self.samples), self.robot.coordinates(), name)?.0)
    }

    /// `out`, or a fresh array, of shape (samples, shape...), as rows of one sample each.
    fn output<const D: usize>(
        &self,
        py: Python<'py>,
        out: Option<&Array<'py>>,
        shape: [usize; D],
        inputs: &[Option<&Rows<'py>>],
    ) -> PyResult<(Array<'py>, Lane)>
    where
        [usize; D]: numpy::ndarray::IntoDimension,
    {
        let mut at: Vec<_> = inputs.iter().map(|rows| rows.map(|rows| rows.at)).collect();
        at.push(Some(self.q.at));
        let (out, to) = output(py, out, shape, &at)?;
        Ok((out, Lane { at: to, width: shape[1..].iter().product() }))
    }
}

/// Gravity torques, (samples, n).
#[pyfunction]
#[pyo3(signature = (robot, q, gravity, out=None, threads=1))]
pub fn gravity_torque_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    gravity: &Array<'py>,
    out: Option<&Array<'py>>,
    threads: isize,
) -> PyResult<Array<'py>> {
    let py = robot.py();
    let batch = Batch::new(robot, q)?;
    let (g, g_rows) = gravity_of(gravity, batch.samples)?;
    let (out, to) = batch.output(py, out, [batch.samples, batch.q.width], &[g_rows.as_ref()])?;
    let (robot, q, level) = (&batch.robot, batch.q.lane(), Level::get());
    run(py, batch.samples, threads, |range| {
        for first in range.clone().step_by(WIDTH) {
            let tau = gravity_block(robot, q, g, first..range.end, level);
            for (l, k) in (first..range.end).take(WIDTH).enumerate() {
                to.write(k, &tau.map(|lanes| lanes[l])[..to.width]);
            }
        }
    })?;
    Ok(out)
}

/// Poses of a frame, (samples, 4, 4).
#[pyfunction]
#[pyo3(signature = (robot, q, frame=None, out=None, threads=1))]
pub fn forward_kinematics_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    frame: Option<&Bound<'py, PyString>>,
    out: Option<&Array<'py>>,
    threads: isize,
) -> PyResult<Array<'py>> {
    let (py, frame) = (robot.py(), robot.get().frame(robot.py(), frame)?);
    let batch = Batch::new(robot, q)?;
    let (out, to) = batch.output(py, out, [batch.samples, 4, 4], &[])?;
    let (robot, q) = (&batch.robot, batch.q.lane());
    run(py, batch.samples, threads, |range| {
        for k in range {
            to.write(k, kernel!(forward_kinematics(robot, &q.joints(k), &frame)).transpose().as_slice());
        }
    })?;
    Ok(out)
}

/// Jacobians of a frame, (samples, 6, n).
#[pyfunction]
#[pyo3(signature = (robot, q, frame=None, axes=None, out=None, threads=1))]
pub fn jacobian_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    frame: Option<&Bound<'py, PyString>>,
    axes: Option<&Bound<'py, PyString>>,
    out: Option<&Array<'py>>,
    threads: isize,
) -> PyResult<Array<'py>> {
    let (py, frame, axes) = (robot.py(), robot.get().frame(robot.py(), frame)?, jacobian_axes(axes)?);
    let batch = Batch::new(robot, q)?;
    let n = batch.q.width;
    let (out, to) = batch.output(py, out, [batch.samples, 6, n], &[])?;
    let (robot, q) = (&batch.robot, batch.q.lane());
    run(py, batch.samples, threads, |range| {
        for k in range {
            write_jacobian(to.sample(k), n, &kernel!(jacobian(robot, &q.joints(k), &frame, axes)));
        }
    })?;
    Ok(out)
}

/// Inverse dynamics on a moving base, (samples, n).
#[pyfunction]
#[pyo3(signature = (robot, q, qd, qdd, base, out=None, threads=1))]
pub fn inverse_dynamics_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    qd: &Array<'py>,
    qdd: &Array<'py>,
    base: &Array<'py>,
    out: Option<&Array<'py>>,
    threads: isize,
) -> PyResult<Array<'py>> {
    let py = robot.py();
    let batch = Batch::new(robot, q)?;
    let (qd, qdd) = (batch.rows(qd, "qd")?, batch.rows(qdd, "qdd")?);
    let (base, base_rows) = base_of(base, batch.samples)?;
    let inputs = [Some(&qd), Some(&qdd), base_rows.as_ref()];
    let (out, to) = batch.output(py, out, [batch.samples, batch.q.width], &inputs)?;
    let (robot, q, qd, qdd) = (&batch.robot, batch.q.lane(), qd.lane(), qdd.lane());
    run(py, batch.samples, threads, |range| {
        for k in range {
            let tau = kernel!(inverse_dynamics(robot, &q.joints(k), &qd.joints(k), &qdd.joints(k), &base.at(k)));
            to.write(k, &tau[..to.width]);
        }
    })?;
    Ok(out)
}

/// Base wrenches, (samples, 6).
#[pyfunction]
#[pyo3(signature = (robot, q, qd, qdd, base, out=None, threads=1))]
pub fn base_wrench_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    qd: &Array<'py>,
    qdd: &Array<'py>,
    base: &Array<'py>,
    out: Option<&Array<'py>>,
    threads: isize,
) -> PyResult<Array<'py>> {
    let py = robot.py();
    let batch = Batch::new(robot, q)?;
    let (qd, qdd) = (batch.rows(qd, "qd")?, batch.rows(qdd, "qdd")?);
    let (base, base_rows) = base_of(base, batch.samples)?;
    let (out, to) = batch.output(py, out, [batch.samples, 6], &[Some(&qd), Some(&qdd), base_rows.as_ref()])?;
    let (robot, q, qd, qdd) = (&batch.robot, batch.q.lane(), qd.lane(), qdd.lane());
    run(py, batch.samples, threads, |range| {
        for k in range {
            let wrench = kernel!(base_wrench(robot, &q.joints(k), &qd.joints(k), &qdd.joints(k), &base.at(k)));
            to.write(k, wrench.as_slice());
        }
    })?;
    Ok(out)
}

/// Mass matrices, (samples, n, n).
#[pyfunction]
#[pyo3(signature = (robot, q, out=None, threads=1))]
pub fn mass_matrix_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    out: Option<&Array<'py>>,
    threads: isize,
) -> PyResult<Array<'py>> {
    let py = robot.py();
    let batch = Batch::new(robot, q)?;
    let n = batch.q.width;
    let (out, to) = batch.output(py, out, [batch.samples, n, n], &[])?;
    let (robot, q) = (&batch.robot, batch.q.lane());
    run(py, batch.samples, threads, |range| {
        for k in range {
            write_square(to.sample(k), n, &kernel!(mass_matrix(robot, &q.joints(k))));
        }
    })?;
    Ok(out)
}

/// Forward dynamics on a moving base, (samples, n).
#[pyfunction]
#[pyo3(signature = (robot, q, qd, tau, base, out=None, threads=1))]
pub fn forward_dynamics_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    qd: &Array<'py>,
    tau: &Array<'py>,
    base: &Array<'py>,
    out: Option<&Array<'py>>,
    threads: isize,
) -> PyResult<Array<'py>> {
    let py = robot.py();
    let batch = Batch::new(robot, q)?;
    let (qd, tau) = (batch.rows(qd, "qd")?, batch.rows(tau, "tau")?);
    let (base, base_rows) = base_of(base, batch.samples)?;
    let inputs = [Some(&qd), Some(&tau), base_rows.as_ref()];
    let (out, to) = batch.output(py, out, [batch.samples, batch.q.width], &inputs)?;
    let (robot, q, qd, tau) = (&batch.robot, batch.q.lane(), qd.lane(), tau.lane());
    run(py, batch.samples, threads, |range| {
        for k in range {
            let qdd = kernel!(forward_dynamics(robot, &q.joints(k), &qd.joints(k), &tau.joints(k), &base.at(k)));
            to.write(k, &qdd[..to.width]);
        }
    })?;
    Ok(out)
}

/// Gravity regressors, (samples, n, 4 bodies).
#[pyfunction]
#[pyo3(signature = (robot, q, gravity, out=None, threads=1))]
pub fn gravity_regressor_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    gravity: &Array<'py>,
    out: Option<&Array<'py>>,
    threads: isize,
) -> PyResult<Array<'py>> {
    let py = robot.py();
    let batch = Batch::new(robot, q)?;
    let (g, g_rows) = gravity_of(gravity, batch.samples)?;
    let width = GRAVITY_PARAMETERS * batch.robot.bodies();
    let (out, to) = batch.output(py, out, [batch.samples, batch.q.width, width], &[g_rows.as_ref()])?;
    let (robot, q) = (&batch.robot, batch.q.lane());
    run(py, batch.samples, threads, |range| {
        let mut values = vec![0.0; to.width];
        for k in range {
            kernel!(gravity_regressor(robot, &q.joints(k), &g.at(k), &mut values));
            to.write(k, &values);
        }
    })?;
    Ok(out)
}

/// Regressors of the inverse dynamics, (samples, n, 10 bodies).
#[pyfunction]
#[pyo3(signature = (robot, q, qd, qdd, base, out=None, threads=1))]
pub fn inverse_dynamics_regressor_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    qd: &Array<'py>,
    qdd: &Array<'py>,
    base: &Array<'py>,
    out: Option<&Array<'py>>,
    threads: isize,
) -> PyResult<Array<'py>> {
    let py = robot.py();
    let batch = Batch::new(robot, q)?;
    let (qd, qdd) = (batch.rows(qd, "qd")?, batch.rows(qdd, "qdd")?);
    let (base, base_rows) = base_of(base, batch.samples)?;
    let width = PARAMETERS * batch.robot.bodies();
    let inputs = [Some(&qd), Some(&qdd), base_rows.as_ref()];
    let (out, to) = batch.output(py, out, [batch.samples, batch.q.width, width], &inputs)?;
    let (robot, q, qd, qdd) = (&batch.robot, batch.q.lane(), qd.lane(), qdd.lane());
    run(py, batch.samples, threads, |range| {
        let mut values = vec![0.0; to.width];
        for k in range {
            let (q, qd, qdd, base) = (q.joints(k), qd.joints(k), qdd.joints(k), base.at(k));
            kernel!(inverse_dynamics_regressor(robot, &q, &qd, &qdd, &base, &mut values));
            to.write(k, &values);
        }
    })?;
    Ok(out)
}

/// Stiffnesses of the gravity torque, (samples, n, n).
#[pyfunction]
#[pyo3(signature = (robot, q, gravity, out=None, threads=1))]
pub fn gravity_stiffness_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    gravity: &Array<'py>,
    out: Option<&Array<'py>>,
    threads: isize,
) -> PyResult<Array<'py>> {
    let py = robot.py();
    let batch = Batch::new(robot, q)?;
    let (g, g_rows) = gravity_of(gravity, batch.samples)?;
    let n = batch.q.width;
    let (out, to) = batch.output(py, out, [batch.samples, n, n], &[g_rows.as_ref()])?;
    let (robot, q) = (&batch.robot, batch.q.lane());
    run(py, batch.samples, threads, |range| {
        for k in range {
            write_square(to.sample(k), n, &kernel!(gravity_stiffness(robot, &q.joints(k), &g.at(k))));
        }
    })?;
    Ok(out)
}

/// Potential energies, (samples,).
#[pyfunction]
#[pyo3(signature = (robot, q, gravity, out=None, threads=1))]
pub fn potential_energy_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    gravity: &Array<'py>,
    out: Option<&Array<'py>>,
    threads: isize,
) -> PyResult<Array<'py>> {
    let py = robot.py();
    let batch = Batch::new(robot, q)?;
    let (g, g_rows) = gravity_of(gravity, batch.samples)?;
    let (out, to) = batch.output(py, out, [batch.samples], &[g_rows.as_ref()])?;
    let (robot, q) = (&batch.robot, batch.q.lane());
    run(py, batch.samples, threads, |range| {
        for k in range {
            to.write(k, &[kernel!(potential_energy(robot, &q.joints(k), &g.at(k)))]);
        }
    })?;
    Ok(out)
}

/// Centres of mass, (samples, 3).
#[pyfunction]
#[pyo3(signature = (robot, q, out=None, threads=1))]
pub fn center_of_mass_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    out: Option<&Array<'py>>,
    threads: isize,
) -> PyResult<Array<'py>> {
    let py = robot.py();
    let batch = Batch::new(robot, q)?;
    let (out, to) = batch.output(py, out, [batch.samples, 3], &[])?;
    let (robot, q) = (&batch.robot, batch.q.lane());
    run(py, batch.samples, threads, |range| {
        for k in range {
            to.write(k, kernel!(center_of_mass(robot, &q.joints(k))).as_slice());
        }
    })?;
    Ok(out)
}
