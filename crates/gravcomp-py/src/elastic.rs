//! `ElasticGravity`: gravity compensation for elastic joints, with its warm start; and how stiff gravity can be.

use crate::arrays::{Pinned, Use, as_double, elements, output, read_joints, required};
use crate::cycle::{Source, changed, check_apart, joints};
use crate::dispatch::kernel;
use crate::errors::{argument_error, configuration_error, cut};
use crate::robot::{Robot, SQUARE};
use crate::shared::Shared;
use crate::types::{choice, gravity, real, text, vector};
use gravcomp::elastic::{Compensation, Field, Settings, Stiffness, StiffnessError, Variant};
use gravcomp::{Gravity, Joints};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::PyString;

type Array<'py> = Bound<'py, PyAny>;

/// Variants by the names that Python gives them.
const VARIANTS: [(&str, Variant); 5] = [
    ("desired", Variant::Desired),
    ("motor", Variant::Motor),
    ("biased", Variant::Biased),
    ("quasi_static", Variant::QuasiStatic),
    ("link", Variant::Link),
];

/// The law, and what its last cycle said of the fixed point.
struct Running {
    law: gravcomp::ElasticGravity,
    iterations: u32,
    error: f64,
}

/// Gravity compensation for one robot with elastic joints. Python's `ravengc.ElasticGravity` adds the conditions of stability.
#[pyclass(frozen, subclass, module = "ravengc._core")]
pub struct ElasticGravity {
    robot: Py<Robot>,
    running: Shared<Running>,
    variant: &'static str,
    needs_links: bool,
}

impl std::fmt::Debug for ElasticGravity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ElasticGravity({})", self.variant)
    }
}

/// One spring per joint, or a matrix of them.
fn stiffness_of(x: &Array<'_>, n: usize) -> PyResult<Stiffness> {
    let array = as_double(x, "stiffness")?;
    let mut values = [0.0; SQUARE];
    let made = if let Some(found) = elements(&array, [n], Use::Held("stiffness")) {
        found.read(&mut values[..n]);
        Stiffness::each(&values[..n])
    } else {
        required(&array, [n, n], Use::Held("stiffness"))?.read(&mut values[..n * n]);
        Stiffness::coupled(&values[..n * n], n)
    };
    made.map_err(|error| unusable(x.py(), &error))
}

fn unusable(py: Python<'_>, error: &StiffnessError) -> PyErr {
    configuration_error(py, format!("stiffness: {error}"))
}

impl ElasticGravity {
    #[inline(always)]
    fn step(&self, py: Python<'_>, theta: &Joints, q_d: &Joints, q: &Joints, g: &Gravity) -> Compensation {
        self.robot.get().with(py, |robot| {
            self.running.change(py, |running| {
                let found = kernel!(elastic_gravity(robot, &mut running.law, theta, q_d, q, g));
                (running.iterations, running.error) = (found.iterations, found.error);
                found
            })
        })
    }

    /// The same law for a controller of `robot`, with nothing of this one's past.
    pub fn law_for(&self, robot: &Bound<'_, Robot>) -> PyResult<gravcomp::ElasticGravity> {
        let py = robot.py();
        if !self.robot.is(robot) {
            let (own, other) = (self.robot.get(), robot.get());
            let message = format!(
                "controller: elastic is made for another robot ('{}', n = {}) than the controller's ('{}', n = {}); make it \
                 for the same object, so that payload and base are the same",
                cut(&own.names().robot),
                own.n(),
                cut(&other.names().robot),
                other.n(),
            );
            return Err(configuration_error(py, message));
        }
        Ok(self.running.with(py, |running| running.law))
    }

    /// Its gravity is taken where the links are measured.
    pub fn needs_links(&self) -> bool {
        self.needs_links
    }

    /// The links' positions if they are needed; the motors' stand in where they are not.
    fn links<'a, 'py>(&self, py: Python<'py>, q: Option<&'a Array<'py>>) -> PyResult<Option<&'a Array<'py>>> {
        if self.needs_links && q.is_none() {
            let message = "variant 'link' takes gravity where the links are: give their positions q";
            return Err(argument_error(py, message.to_owned()));
        }
        Ok(q)
    }
}

#[pymethods]
impl ElasticGravity {
    #[new]
    #[pyo3(signature = (robot, stiffness, variant, contraction, iterations, tolerance))]
    fn new(
        robot: &Bound<'_, Robot>,
        stiffness: &Array<'_>,
        variant: &Bound<'_, PyString>,
        #[pyo3(from_py_with = real)] contraction: f64,
        iterations: u32,
        #[pyo3(from_py_with = real)] tolerance: f64,
    ) -> PyResult<Self> {
        let (name, variant) = choice(variant.py(), "variant", text(variant)?, &VARIANTS.map(|one| (one.0, one)))?;
        let settings = Settings { variant, contraction, iterations, tolerance };
        let law = gravcomp::ElasticGravity::new(stiffness_of(stiffness, robot.get().n())?, settings);
        let running = Shared::new(Running { law, iterations: 0, error: 0.0 });
        let needs_links = variant == Variant::Link;
        Ok(Self { robot: robot.clone().unbind(), running, variant: name, needs_links })
    }

    /// Where gravity is taken: "desired", "motor", "biased", "quasi_static" or "link".
    #[getter]
    fn variant(&self) -> &'static str {
        self.variant
    }

    /// Steps of the fixed point in the last cycle; 0 before it, and for the variants that have none.
    #[getter]
    fn iterations(&self, py: Python<'_>) -> u32 {
        self.running.with(py, |running| running.iterations)
    }

    /// How far, at most, the last cycle took gravity from the fixed point, rad (m); infinite where nothing is known.
    #[getter]
    fn error_bound(&self, py: Python<'_>) -> f64 {
        self.running.with(py, |running| running.error)
    }

    /// Forget the sag found last: after the arm was moved by hand, or exchanged.
    fn reset(&self, py: Python<'_>) {
        self.running.change(py, |running| {
            running.law.reset();
            (running.iterations, running.error) = (0, 0.0);
        });
    }

    /// Gravity torque (n,) to add to the motors' PD: one cycle.
    ///
    /// `theta` (n,) are the motors' positions in joint units, `q_desired` (n,) the goal of the links, `gravity` (3,) m/s² in
    /// base axes; `q` (n,), the links' own positions, is only read, and then required, by variant "link". NaN in, NaN out,
    /// for this cycle alone. Raises ArgumentError.
    #[pyo3(signature = (theta, q_desired, gravity, q=None, out=None))]
    fn torque<'py>(
        &self,
        theta: &Array<'py>,
        q_desired: &Array<'py>,
        gravity: &Array<'py>,
        q: Option<&Array<'py>>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (theta.py(), self.robot.get().n());
        let q = self.links(py, q)?.unwrap_or(theta);
        let (theta, theta_at) = read_joints(theta, n, "theta")?;
        let (q_d, q_d_at) = read_joints(q_desired, n, "q_desired")?;
        let (q, q_at) = read_joints(q, n, "q")?;
        let (g, g_at) = self::gravity(gravity)?;
        let (out, target) = output(py, out, [n], &[theta_at, q_d_at, q_at, g_at])?;
        target.write(&self.step(py, &theta, &q_d, &q, &g).torque[..n]);
        Ok(out)
    }

    /// Where the motors belong for the links to hang at `q_desired`, (n,): q_d + K^-1 g(q_d).
    #[pyo3(signature = (q_desired, gravity, out=None))]
    fn theta_desired<'py>(
        &self,
        q_desired: &Array<'py>,
        gravity: &Array<'py>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (q_desired.py(), self.robot.get().n());
        let (q_d, q_d_at) = read_joints(q_desired, n, "q_desired")?;
        let (g, g_at) = self::gravity(gravity)?;
        let (out, target) = output(py, out, [n], &[q_d_at, g_at])?;
        let theta_d = self.robot.get().with(py, |robot| {
            self.running.with(py, |run| run.law.theta_desired(|q| kernel!(gravity_torque(robot, q, &g)), &q_d))
        });
        target.write(&theta_d[..n]);
        Ok(out)
    }

    /// Where the links hang at rest with the motors at `theta`, (n,): q = theta - K^-1 g(q), whatever the variant.
    ///
    /// What encoders on the motors do not see is `theta - link_position(theta, gravity)`.
    #[pyo3(signature = (theta, gravity, out=None))]
    fn link_position<'py>(
        &self,
        theta: &Array<'py>,
        gravity: &Array<'py>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (theta.py(), self.robot.get().n());
        let (theta, theta_at) = read_joints(theta, n, "theta")?;
        let (g, g_at) = self::gravity(gravity)?;
        let (out, target) = output(py, out, [n], &[theta_at, g_at])?;
        let found = self.robot.get().with(py, |robot| {
            let hold = |q: &Joints| kernel!(gravity_torque(robot, q, &g));
            self.running.with(py, |running| running.law.hanging(hold, g.0.norm(), &theta))
        });
        target.write(&found.q[..n]);
        Ok(out)
    }

    /// What it holds, for the garbage collector: a robot may hold the law that holds it.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.robot)
    }
}

/// A law bound to its arrays: `step()` reads positions and gravity and writes the torque, and where the motors belong.
///
/// Nothing is parsed or allocated. It raises only if an array was resized, reshaped, retyped or made read-only after it
/// was bound.
#[pyclass(frozen, module = "ravengc._core")]
pub struct ElasticCycle {
    law: Py<ElasticGravity>,
    theta: Pinned,
    q_desired: Pinned,
    gravity: Source,
    q: Option<Pinned>,
    out: Pinned,
    theta_desired: Option<Pinned>,
}

impl std::fmt::Debug for ElasticCycle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("ElasticCycle")
    }
}

impl ElasticCycle {
    fn inputs(&self) -> impl Iterator<Item = &Pinned> {
        [&self.theta, &self.q_desired].into_iter().chain(self.gravity.array()).chain(&self.q)
    }

    fn outputs(&self) -> impl Iterator<Item = &Pinned> {
        std::iter::once(&self.out).chain(&self.theta_desired)
    }
}

#[pymethods]
impl ElasticCycle {
    /// Read the inputs, compute, write the outputs.
    #[inline(always)]
    fn step(&self, py: Python<'_>) -> PyResult<()> {
        if !self.inputs().chain(self.outputs()).all(|pinned| pinned.unchanged(py)) {
            return Err(changed(py));
        }
        let law = self.law.get();
        let n = law.robot.get().n();
        let (theta, q_d) = (joints(&self.theta, n), joints(&self.q_desired, n));
        let q = self.q.as_ref().map_or(theta, |q| joints(q, n));
        let found = law.step(py, &theta, &q_d, &q, &self.gravity.now(py));
        self.out.elements().write(&found.torque[..n]);
        if let Some(theta_desired) = &self.theta_desired {
            theta_desired.elements().write(&found.theta_d[..n]);
        }
        Ok(())
    }

    /// What the cycle holds, for the garbage collector.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.law)?;
        visit.call(self.gravity.sensor())?;
        self.inputs().chain(self.outputs()).try_for_each(|pinned| visit.call(pinned.array()))
    }
}

/// A cycle of gravity compensation for elastic joints; `theta_desired` (n,), if given, is written too. `gravity` is an array, or
/// an Accelerometer that each step steps too.
#[pyfunction]
#[pyo3(signature = (law, theta, q_desired, gravity, out, q=None, theta_desired=None))]
pub fn bind_elastic_gravity(
    law: &Bound<'_, ElasticGravity>,
    theta: &Array<'_>,
    q_desired: &Array<'_>,
    gravity: &Array<'_>,
    out: &Array<'_>,
    q: Option<&Array<'_>>,
    theta_desired: Option<&Array<'_>>,
) -> PyResult<ElasticCycle> {
    let (py, n) = (law.py(), law.get().robot.get().n());
    let q = law.get().links(py, q)?;
    let cycle = ElasticCycle {
        law: law.clone().unbind(),
        theta: Pinned::new(theta, [n], Use::Held("theta"))?,
        q_desired: Pinned::new(q_desired, [n], Use::Held("q_desired"))?,
        gravity: Source::new(gravity)?,
        q: q.map(|q| Pinned::new(q, [n], Use::Held("q"))).transpose()?,
        out: Pinned::new(out, [n], Use::Output("out"))?,
        theta_desired: theta_desired.map(|x| Pinned::new(x, [n], Use::Output("theta_desired"))).transpose()?,
    };
    check_apart(py, cycle.inputs().map(Pinned::elements), cycle.outputs().map(Pinned::named))?;
    Ok(cycle)
}

/// Bounds (n, n) on |d tau_g / dq|, entry by entry, in a gravity field of 1 m/s², whatever the angles.
///
/// `lower` and `upper` (n,) are the ranges of the coordinates, as far as shifts depend on them; they may be infinite. `along`
/// (3,) is the direction of gravity in base axes, of length 1; without it, all directions. Raises ArgumentError.
#[pyfunction]
#[pyo3(signature = (robot, lower, upper, along=None, out=None))]
pub fn gravity_stiffness_bound<'py>(
    robot: &Bound<'py, Robot>,
    lower: &Array<'py>,
    upper: &Array<'py>,
    along: Option<&Array<'py>>,
    out: Option<&Array<'py>>,
) -> PyResult<Array<'py>> {
    let (py, n) = (robot.py(), robot.get().n());
    let (lower, lower_at) = read_joints(lower, n, "lower")?;
    let (upper, upper_at) = read_joints(upper, n, "upper")?;
    let field = along.map_or(Ok(Field::Anyhow), |g| vector(g, "along").map(Field::Along))?;
    let (out, target) = output(py, out, [n, n], &[lower_at, upper_at])?;
    target.compute::<SQUARE>(|entries| {
        robot.get().with(py, |robot| gravcomp::elastic::stiffness_bound(robot, &lower, &upper, field, entries));
    });
    Ok(out)
}
