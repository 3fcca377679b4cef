//! The cycle that steps resolved-rate motion: its arrays, and where the base's twist comes from.

use crate::accelerometer::Accelerometer;
use crate::arrays::{Pinned, Use};
use crate::cycle::{changed, check_apart, joints, vector};
use crate::errors::argument_error;
use crate::resolved_rate::{ResolvedRate, TWIST, target_shape};
use crate::shared::Shared;
use gravcomp::resolved_rate::{Goal, Inputs, STEPS, SensedBase, TARGET, turning_about};
use nalgebra::Vector3;
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;

type Array<'py> = Bound<'py, PyAny>;

/// The arrays that a cycle is bound to, as they are given.
#[derive(Debug)]
pub struct Given<'a, 'py> {
    pub q: &'a Array<'py>,
    pub out: &'a Array<'py>,
    pub twist: Option<&'a Array<'py>>,
    pub target: Option<&'a Array<'py>>,
    pub target_twist: Option<&'a Array<'py>>,
    pub base_twist: Option<&'a Array<'py>>,
    pub pivot: Option<&'a Array<'py>>,
    pub base_velocity: Option<&'a Array<'py>>,
}

/// Where the base's twist comes from.
enum Base {
    Still,
    Array(Pinned),
    Sensor(Box<Sensed>),
}

/// A base whose turning a sensor measures: about a pivot, which may move.
struct Sensed {
    sensor: Py<Accelerometer>,
    /// Base axes, m.
    pivot: Vector3<f64>,
    /// The pivot's own, m/s.
    velocity: Option<Pinned>,
    base: Shared<SensedBase>,
}

impl Sensed {
    fn new(sensor: Py<Accelerometer>, given: &Given<'_, '_>, py: Python<'_>) -> PyResult<Self> {
        if given.pivot.is_none() && given.base_velocity.is_none() {
            let message = "an Accelerometer says how the base turns, not how fast its origin moves: give pivot, the point \
                           (3,) that it turns about, or base_velocity (3,), or both";
            return Err(argument_error(py, message.to_owned()));
        }
        let pivot = given.pivot.map_or(Ok(Vector3::zeros()), |pivot| crate::types::vector(pivot, "pivot"))?;
        if !pivot.iter().all(|x| x.abs() <= 1e6) {
            let message = format!("pivot is {:?}; it should be a point, in m, base axes", pivot.as_slice());
            return Err(argument_error(py, message));
        }
        let velocity = given.base_velocity.map(|v| Pinned::new(v, [3], Use::Held("base_velocity"))).transpose()?;
        let base = Shared::new(SensedBase::new(sensor.get().steps()));
        Ok(Self { sensor, pivot, velocity, base })
    }

    /// The base's twist in the middle of the next `dt` seconds, and whether it is in doubt.
    #[inline(always)]
    fn now(&self, py: Python<'_>, dt: f64) -> ([f64; TWIST], bool) {
        let (sensor, v) = (self.sensor.get(), self.velocity.as_ref().map_or_else(Vector3::zeros, vector));
        self.base.change(py, |base| {
            let (said, is_trusted) = sensor.turning(py, base.ahead(sensor.steps(), dt));
            let (w, in_doubt) = base.follow(&said, is_trusted, dt);
            (turning_about(&self.pivot, &v, &w), in_doubt)
        })
    }
}

impl Base {
    fn new(given: &Given<'_, '_>, py: Python<'_>) -> PyResult<Self> {
        let sensor = given.base_twist.and_then(|base| base.cast::<Accelerometer>().ok());
        if let Some(sensor) = sensor {
            return Ok(Self::Sensor(Box::new(Sensed::new(sensor.clone().unbind(), given, py)?)));
        }
        if given.pivot.is_some() || given.base_velocity.is_some() {
            let message =
                "pivot and base_velocity belong to a base_twist that is an Accelerometer; an array (6,) says it all";
            return Err(argument_error(py, message.to_owned()));
        }
        given.base_twist.map_or(Ok(Self::Still), |x| Ok(Self::Array(Pinned::new(x, [TWIST], Use::Held("base_twist"))?)))
    }

    /// The base's twist, if it moves, and whether that is in doubt.
    #[inline(always)]
    fn now(&self, py: Python<'_>, dt: f64) -> (Option<[f64; TWIST]>, bool) {
        match self {
            Self::Still => (None, false),
            Self::Array(array) => {
                let mut twist = [0.0; TWIST];
                array.elements().read(&mut twist);
                (Some(twist), false)
            }
            Self::Sensor(sensed) => {
                let (twist, in_doubt) = sensed.now(py, dt);
                (Some(twist), in_doubt)
            }
        }
    }

    fn array(&self) -> Option<&Pinned> {
        match self {
            Self::Still => None,
            Self::Array(array) => Some(array),
            Self::Sensor(sensed) => sensed.velocity.as_ref(),
        }
    }
}

/// Resolved-rate motion bound to its arrays: `step()` reads the inputs, computes, and writes `out`.
///
/// Nothing is parsed or allocated. It raises only if an array was resized, reshaped, retyped or made read-only after it
/// was bound.
#[pyclass(frozen, module = "ravengc._core")]
pub struct RateCycle {
    rate: Py<ResolvedRate>,
    q: Pinned,
    goal: Pinned,
    reaches: bool,
    target_twist: Option<Pinned>,
    base: Base,
    out: Pinned,
    dt: f64,
}

impl std::fmt::Debug for RateCycle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("RateCycle")
    }
}

/// A time step that a cycle can be bound to.
fn time_step(py: Python<'_>, dt: f64) -> PyResult<f64> {
    if dt >= STEPS.0 && dt <= STEPS.1 {
        return Ok(dt);
    }
    Err(argument_error(py, format!("dt is {dt:?}; it should be a time step of {:?} to {:?} s", STEPS.0, STEPS.1)))
}

impl RateCycle {
    /// Checks the arrays and holds them.
    pub fn new(rate: &Bound<'_, ResolvedRate>, given: &Given<'_, '_>, dt: Option<f64>) -> PyResult<Self> {
        let (py, inner) = (rate.py(), rate.get());
        let dt = time_step(py, dt.unwrap_or(inner.period))?;
        let (n, len) = (inner.n, inner.task.twist_len());
        let goal = match (given.twist, given.target) {
            (Some(twist), None) if given.target_twist.is_none() => Pinned::new(twist, [len], Use::Held("twist"))?,
            (None, Some(target)) => match target_shape(inner.task) {
                [rows, columns] => Pinned::new(target, [*rows, *columns], Use::Held("target"))?,
                shape => Pinned::new(target, [shape[0]], Use::Held("target"))?,
            },
            _ => return Err(argument_error(py, "give either twist, or target and its target_twist".to_owned())),
        };
        let target_twist = given.target_twist.map(|x| Pinned::new(x, [len], Use::Held("target_twist"))).transpose()?;
        let cycle = Self {
            rate: rate.clone().unbind(),
            q: Pinned::new(given.q, [n], Use::Held("q"))?,
            goal,
            reaches: given.target.is_some(),
            target_twist,
            base: Base::new(given, py)?,
            out: Pinned::new(given.out, [n], Use::Output("out"))?,
            dt,
        };
        check_apart(py, cycle.inputs().map(Pinned::elements), std::iter::once(cycle.out.named()))?;
        Ok(cycle)
    }

    fn inputs(&self) -> impl Iterator<Item = &Pinned> {
        [&self.q, &self.goal].into_iter().chain(self.target_twist.as_ref()).chain(self.base.array())
    }
}

#[pymethods]
impl RateCycle {
    /// Read the inputs, compute, write the rates.
    #[inline(always)]
    fn step(&self, py: Python<'_>) -> PyResult<()> {
        if !self.inputs().chain([&self.out]).all(|array| array.unchanged(py)) {
            return Err(changed(py));
        }
        let rate = self.rate.get();
        let q = joints(&self.q, rate.n);
        let (mut goal, mut twist) = ([0.0; TARGET], [0.0; TWIST]);
        self.goal.elements().read(if self.reaches { &mut goal } else { &mut twist });
        if let Some(array) = &self.target_twist {
            array.elements().read(&mut twist);
        }
        let (base, base_in_doubt) = self.base.now(py, self.dt);
        let goal = if self.reaches { Goal::Reach(&goal, &twist) } else { Goal::Move(&twist) };
        let inputs = Inputs { q: &q, goal, base_twist: base.as_ref(), base_in_doubt, dt: self.dt };
        rate.run(py, &inputs, self.out.elements());
        Ok(())
    }

    /// What the cycle holds, for the garbage collector.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.rate)?;
        if let Base::Sensor(sensed) = &self.base {
            visit.call(&sensed.sensor)?;
        }
        self.inputs().chain([&self.out]).try_for_each(|pinned| visit.call(pinned.array()))
    }
}
