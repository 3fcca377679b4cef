//! The same functions over many configurations, without the GIL and on as many threads as asked for.

use crate::arrays::{Elements, output};
use crate::dispatch::{Level, kernel};
use crate::robot::{GRAVITY_REGRESSOR, JACOBIAN, REGRESSOR, Robot, SQUARE, jacobian_axes};
use crate::rows::{Array, GravityOf, Lane, Rows, WIDTH, base_of, gravity_of, run};
use crate::types::whole;
use gravcomp::{BaseMotion, GRAVITY_PARAMETERS, Gravity, Joints, MAX_JOINTS, PARAMETERS};
use pyo3::prelude::*;
use pyo3::types::PyString;
use std::ops::Range;

/// Up to [`WIDTH`] samples side by side, as the gravity kernel takes them; reused from block to block.
struct Block {
    q: [[f64; WIDTH]; MAX_JOINTS],
    g: [[f64; WIDTH]; 3],
    tau: [[f64; WIDTH]; MAX_JOINTS],
}

impl Block {
    /// Nothing but the gravity vector that all samples share, if they do.
    fn new(g: GravityOf) -> Self {
        let shared = g.shared().map_or([0.0; 3], |g| g.0.into());
        let zero = [[0.0; WIDTH]; MAX_JOINTS];
        Self { q: zero, g: shared.map(|x| [x; WIDTH]), tau: zero }
    }

    /// The samples of `range`; lanes beyond its end repeat the last one.
    fn gather(&mut self, q: Lane, g: GravityOf, range: &Range<usize>) {
        for l in 0..WIDTH {
            let k = (range.start + l).min(range.end - 1);
            for (lanes, x) in self.q.iter_mut().zip(q.sample(k).iter()) {
                lanes[l] = x;
            }
            if g.shared().is_none() {
                let g = g.at(k).0;
                for (axis, lanes) in self.g.iter_mut().enumerate() {
                    lanes[l] = g[axis];
                }
            }
        }
    }

    /// Their gravity torques, in the best build.
    fn compute(&mut self, robot: &gravcomp::Robot, level: Level) {
        let Self { q, g, tau } = self;
        #[cfg(target_arch = "x86_64")]
        if level == Level::Avx512 {
            // SAFETY: AVX-512 F, VL and DQ were detected on this processor.
            return unsafe { gravcomp::avx512::gravity_torques(robot, q, g, tau) };
        }
        let _ = level;
        kernel!(gravity_torques(robot, q, g, tau));
    }
}

/// What every batch function needs: a copy of the robot, its positions, and where the results go.
pub(crate) struct Batch<'py> {
    robot: gravcomp::Robot,
    q: Rows<'py>,
    samples: usize,
    threads: isize,
}

/// Writes the result of sample `k` for positions q.
type Positions<'a> = &'a (dyn Fn(&gravcomp::Robot, &Joints, Elements) + Sync);
/// The same for positions and a gravity vector.
type InGravity<'a> = &'a (dyn Fn(&gravcomp::Robot, &Joints, &Gravity, Elements) + Sync);
/// The same for positions and rates, both of them zero where none were given.
type Moving<'a> = &'a (dyn Fn(&gravcomp::Robot, [&Joints; 2], Elements) + Sync);
/// The same for positions, two more rows (rates and accelerations, or rates and efforts) and a base motion.
type OnBase<'a> = &'a (dyn Fn(&gravcomp::Robot, [&Joints; 3], &BaseMotion, Elements) + Sync);

impl<'py> Batch<'py> {
    pub(crate) fn new(robot: &Bound<'py, Robot>, q: &Array<'py>, threads: isize) -> PyResult<Self> {
        let robot = robot.get().with(robot.py(), Clone::clone);
        let (q, samples) = Rows::new(q, None, robot.coordinates(), "q")?;
        Ok(Self { robot, q, samples, threads })
    }

    /// `out`, or a fresh array, of shape (samples, shape...), as rows of one sample each.
    fn output(
        &self,
        out: Option<&Array<'py>>,
        shape: &[usize],
        inputs: &[Option<&Rows<'py>>],
    ) -> PyResult<(Array<'py>, Lane)> {
        let py = self.q.py();
        let mut at: Vec<_> = inputs.iter().map(|rows| rows.map(|rows| rows.at)).collect();
        at.push(Some(self.q.at));
        let (out, to) = match *shape {
            [] => output(py, out, [self.samples], &at)?,
            [a] => output(py, out, [self.samples, a], &at)?,
            [a, b, ..] => output(py, out, [self.samples, a, b], &at)?,
        };
        Ok((out, Lane { at: to, width: shape.iter().product() }))
    }

    fn positions(&self, out: Option<&Array<'py>>, shape: &[usize], compute: Positions<'_>) -> PyResult<Array<'py>> {
        let (out, to) = self.output(out, shape, &[])?;
        let (robot, q) = (&self.robot, self.q.lane());
        run(out.py(), self.samples, self.threads, |range| {
            for k in range {
                compute(robot, &q.joints(k), to.sample(k));
            }
        })?;
        Ok(out)
    }

    fn in_gravity(
        &self,
        gravity: &Array<'py>,
        out: Option<&Array<'py>>,
        shape: &[usize],
        compute: InGravity<'_>,
    ) -> PyResult<Array<'py>> {
        let (g, g_rows) = gravity_of(gravity, self.samples)?;
        let (out, to) = self.output(out, shape, &[g_rows.as_ref()])?;
        let (robot, q) = (&self.robot, self.q.lane());
        run(out.py(), self.samples, self.threads, |range| {
            for k in range {
                compute(robot, &q.joints(k), &g.at(k), to.sample(k));
            }
        })?;
        Ok(out)
    }

    /// Rates are zero where none are given.
    pub(crate) fn moving(
        &self,
        qd: Option<&Array<'py>>,
        out: Option<&Array<'py>>,
        shape: &[usize],
        compute: Moving<'_>,
    ) -> PyResult<Array<'py>> {
        let qd = qd.map(|qd| Rows::new(qd, Some(self.samples), self.q.width, "qd")).transpose()?;
        let qd = qd.as_ref().map(|(rows, _)| rows);
        let (out, to) = self.output(out, shape, &[qd])?;
        let (robot, q, qd) = (&self.robot, self.q.lane(), qd.map(Rows::lane));
        run(out.py(), self.samples, self.threads, |range| {
            for k in range {
                let rates = qd.map_or_else(Joints::default, |qd| qd.joints(k));
                compute(robot, [&q.joints(k), &rates], to.sample(k));
            }
        })?;
        Ok(out)
    }

    fn on_base(
        &self,
        [(qd, qd_name), (x, x_name)]: [(&Array<'py>, &'static str); 2],
        base: &Array<'py>,
        out: Option<&Array<'py>>,
        shape: &[usize],
        compute: OnBase<'_>,
    ) -> PyResult<Array<'py>> {
        let n = self.q.width;
        let (qd, _) = Rows::new(qd, Some(self.samples), n, qd_name)?;
        let (x, _) = Rows::new(x, Some(self.samples), n, x_name)?;
        let (base, base_rows) = base_of(base, self.samples)?;
        let (out, to) = self.output(out, shape, &[Some(&qd), Some(&x), base_rows.as_ref()])?;
        let (robot, q, qd, x) = (&self.robot, self.q.lane(), qd.lane(), x.lane());
        run(out.py(), self.samples, self.threads, |range| {
            for k in range {
                compute(robot, [&q.joints(k), &qd.joints(k), &x.joints(k)], &base.at(k), to.sample(k));
            }
        })?;
        Ok(out)
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
    #[pyo3(from_py_with = whole)] threads: isize,
) -> PyResult<Array<'py>> {
    let batch = Batch::new(robot, q, threads)?;
    let (g, g_rows) = gravity_of(gravity, batch.samples)?;
    let (out, to) = batch.output(out, &[batch.q.width], &[g_rows.as_ref()])?;
    let (robot, q, level) = (&batch.robot, batch.q.lane(), Level::get());
    run(out.py(), batch.samples, threads, |range| {
        let mut block = Block::new(g);
        for first in range.clone().step_by(WIDTH) {
            block.gather(q, g, &(first..range.end));
            block.compute(robot, level);
            for (l, k) in (first..range.end).take(WIDTH).enumerate() {
                to.sample(k).write_all(block.tau.iter().map(|lanes| lanes[l]));
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
    #[pyo3(from_py_with = whole)] threads: isize,
) -> PyResult<Array<'py>> {
    let frame = robot.get().frame(robot.py(), frame)?;
    Batch::new(robot, q, threads)?.positions(out, &[4, 4], &|robot, q, to| {
        to.write(kernel!(forward_kinematics(robot, q, &frame)).transpose().as_slice());
    })
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
    #[pyo3(from_py_with = whole)] threads: isize,
) -> PyResult<Array<'py>> {
    let (frame, axes, n) = (robot.get().frame(robot.py(), frame)?, jacobian_axes(axes)?, robot.get().n());
    Batch::new(robot, q, threads)?.positions(out, &[6, n], &|robot, q, to| {
        to.compute::<JACOBIAN>(|entries| kernel!(jacobian(robot, q, &frame, axes, entries)));
    })
}

/// Mass matrices, (samples, n, n).
#[pyfunction]
#[pyo3(signature = (robot, q, out=None, threads=1))]
pub fn mass_matrix_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    out: Option<&Array<'py>>,
    #[pyo3(from_py_with = whole)] threads: isize,
) -> PyResult<Array<'py>> {
    let n = robot.get().n();
    Batch::new(robot, q, threads)?.positions(out, &[n, n], &|robot, q, to| {
        to.compute::<SQUARE>(|entries| kernel!(mass_matrix(robot, q, entries)));
    })
}

/// Centres of mass, (samples, 3).
#[pyfunction]
#[pyo3(signature = (robot, q, out=None, threads=1))]
pub fn center_of_mass_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    out: Option<&Array<'py>>,
    #[pyo3(from_py_with = whole)] threads: isize,
) -> PyResult<Array<'py>> {
    Batch::new(robot, q, threads)?.positions(out, &[3], &|robot, q, to| {
        to.write(kernel!(center_of_mass(robot, q)).as_slice());
    })
}

/// Potential energies, (samples,).
#[pyfunction]
#[pyo3(signature = (robot, q, gravity, out=None, threads=1))]
pub fn potential_energy_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    gravity: &Array<'py>,
    out: Option<&Array<'py>>,
    #[pyo3(from_py_with = whole)] threads: isize,
) -> PyResult<Array<'py>> {
    Batch::new(robot, q, threads)?.in_gravity(gravity, out, &[], &|robot, q, g, to| {
        to.write(&[kernel!(potential_energy(robot, q, g))]);
    })
}

/// Stiffnesses of the gravity torque, (samples, n, n).
#[pyfunction]
#[pyo3(signature = (robot, q, gravity, out=None, threads=1))]
pub fn gravity_stiffness_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    gravity: &Array<'py>,
    out: Option<&Array<'py>>,
    #[pyo3(from_py_with = whole)] threads: isize,
) -> PyResult<Array<'py>> {
    let n = robot.get().n();
    Batch::new(robot, q, threads)?.in_gravity(gravity, out, &[n, n], &|robot, q, g, to| {
        to.compute::<SQUARE>(|entries| kernel!(gravity_stiffness(robot, q, g, entries)));
    })
}

/// Gravity regressors, (samples, n, 4 bodies).
#[pyfunction]
#[pyo3(signature = (robot, q, gravity, out=None, threads=1))]
pub fn gravity_regressor_batch<'py>(
    robot: &Bound<'py, Robot>,
    q: &Array<'py>,
    gravity: &Array<'py>,
    out: Option<&Array<'py>>,
    #[pyo3(from_py_with = whole)] threads: isize,
) -> PyResult<Array<'py>> {
    let batch = Batch::new(robot, q, threads)?;
    let (n, width) = (batch.q.width, GRAVITY_PARAMETERS * batch.robot.bodies());
    batch.in_gravity(gravity, out, &[n, width], &|robot, q, g, to| {
        to.compute::<GRAVITY_REGRESSOR>(|entries| kernel!(gravity_regressor(robot, q, g, entries)));
    })
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
    #[pyo3(from_py_with = whole)] threads: isize,
) -> PyResult<Array<'py>> {
    let n = robot.get().n();
    let rates = [(qd, "qd"), (qdd, "qdd")];
    Batch::new(robot, q, threads)?.on_base(rates, base, out, &[n], &|robot, [q, qd, qdd], base, to| {
        to.write(&kernel!(inverse_dynamics(robot, q, qd, qdd, base))[..n]);
    })
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
    #[pyo3(from_py_with = whole)] threads: isize,
) -> PyResult<Array<'py>> {
    let rates = [(qd, "qd"), (qdd, "qdd")];
    Batch::new(robot, q, threads)?.on_base(rates, base, out, &[6], &|robot, [q, qd, qdd], base, to| {
        to.write(kernel!(base_wrench(robot, q, qd, qdd, base)).as_slice());
    })
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
    #[pyo3(from_py_with = whole)] threads: isize,
) -> PyResult<Array<'py>> {
    let n = robot.get().n();
    let rows = [(qd, "qd"), (tau, "tau")];
    Batch::new(robot, q, threads)?.on_base(rows, base, out, &[n], &|robot, [q, qd, tau], base, to| {
        to.write(&kernel!(forward_dynamics(robot, q, qd, tau, base))[..n]);
    })
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
    #[pyo3(from_py_with = whole)] threads: isize,
) -> PyResult<Array<'py>> {
    let batch = Batch::new(robot, q, threads)?;
    let (n, width) = (batch.q.width, PARAMETERS * batch.robot.bodies());
    batch.on_base([(qd, "qd"), (qdd, "qdd")], base, out, &[n, width], &|robot, [q, qd, qdd], base, to| {
        to.compute::<REGRESSOR>(|entries| kernel!(inverse_dynamics_regressor(robot, q, qd, qdd, base, entries)));
    })
}
