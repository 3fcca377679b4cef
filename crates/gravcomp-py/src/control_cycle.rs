//! The cycle that steps a control law: its arrays, and where the base's motion comes from.

use crate::accelerometer::Accelerometer;
use crate::arrays::{Elements, Pins, Use};
use crate::controller::Controller;
use crate::cycle::{changed, check_apart};
use crate::errors::argument_error;
use crate::types::refuse_constant;
use gravcomp::control::Inputs;
use gravcomp::{BaseMotion, Gravity, Joints, MAX_JOINTS, SpecificForce};
use nalgebra::Vector3;
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;

type Array<'py> = Bound<'py, PyAny>;

/// An array that was given, by its name.
type Named<'a, 'py> = (&'static str, Option<&'a Array<'py>>);

/// Where the base's motion comes from.
pub(crate) struct Base {
    source: Source,
    /// ω and dω, where arrays hold them.
    turning: Option<[Elements; 2]>,
}

/// Where gravity comes from.
enum Source {
    Gravity(Elements),
    /// f = −g.
    SpecificForce(Elements),
    /// Each cycle steps it too.
    Sensor(Py<Accelerometer>),
}

impl Base {
    pub fn new(
        py: Python<'_>,
        pins: &mut Pins,
        gravity: Option<&Array<'_>>,
        force: Option<&Array<'_>>,
        w: Option<&Array<'_>>,
        dw: Option<&Array<'_>>,
    ) -> PyResult<Self> {
        let mut vector = |x, name| pins.hold(x, [3], Use::Held(name));
        let source = match (gravity, force) {
            (Some(gravity), None) => {
                if let Ok(sensor) = gravity.cast::<Accelerometer>() {
                    Source::Sensor(sensor.clone().unbind())
                } else {
                    refuse_constant(gravity, "gravity")?;
                    Source::Gravity(vector(gravity, "gravity")?)
                }
            }
            (None, Some(force)) => Source::SpecificForce(vector(force, "specific_force")?),
            _ => return Err(argument_error(py, "give either gravity or specific_force".to_owned())),
        };
        let turning = match (w, dw, &source) {
            (None, None, _) => None,
            (_, _, Source::Sensor(_)) => {
                let message = "the Accelerometer says how the base turns; leave out angular_velocity and \
                               angular_acceleration";
                return Err(argument_error(py, message.to_owned()));
            }
            (Some(w), Some(dw), _) => Some([vector(w, "angular_velocity")?, vector(dw, "angular_acceleration")?]),
            _ => return Err(argument_error(py, "give both angular_velocity and angular_acceleration".to_owned())),
        };
        Ok(Self { source, turning })
    }

    /// The base's motion of now, and whether the arm may be armed on it.
    #[inline(always)]
    fn now(&self, py: Python<'_>) -> (BaseMotion, bool) {
        let specific_force = match &self.source {
            Source::Gravity(g) => Gravity(vector(*g)).into(),
            Source::SpecificForce(f) => SpecificForce(vector(*f)),
            Source::Sensor(sensor) => {
                let (reading, armable) = sensor.get().advance(py, None);
                return (reading.base, armable);
            }
        };
        let [angular_velocity, angular_acceleration] = match self.turning {
            Some(rates) => rates.map(vector),
            None => [Vector3::zeros(); 2],
        };
        (BaseMotion { specific_force, angular_velocity, angular_acceleration }, true)
    }

    fn arrays(&self) -> impl Iterator<Item = Elements> {
        let own = match self.source {
            Source::Gravity(x) | Source::SpecificForce(x) => Some(x),
            Source::Sensor(_) => None,
        };
        own.into_iter().chain(self.turning.into_iter().flatten())
    }
}

/// Three numbers.
#[inline(always)]
fn vector(x: Elements) -> Vector3<f64> {
    let mut v = [0.0; 3];
    x.read(&mut v);
    v.into()
}

/// A control law bound to its arrays: `step()` reads the inputs, computes, and writes the outputs.
///
/// Nothing is parsed or allocated. It raises only if an array was resized, reshaped, retyped or made read-only after it
/// was bound.
#[pyclass(frozen, module = "ravengc._core")]
pub struct ControlCycle {
    controller: Py<Controller>,
    pins: Pins,
    base: Base,
    inputs: [Option<Elements>; 5],
    outputs: [Option<Elements>; 5],
    disturbs: bool,
}

impl std::fmt::Debug for ControlCycle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("ControlCycle")
    }
}

impl ControlCycle {
    /// `inputs` are q, q̇, the links, q_d and q̇_d; `outputs` τ, its three terms and θ_d.
    pub(crate) fn new(
        controller: &Bound<'_, Controller>,
        mut pins: Pins,
        base: Base,
        inputs: [Named<'_, '_>; 5],
        outputs: [Named<'_, '_>; 5],
    ) -> PyResult<Self> {
        let (py, n) = (controller.py(), controller.get().n);
        let (mut read, mut written) = ([None; 5], [None; 5]);
        for (place, (name, array)) in read.iter_mut().zip(inputs) {
            *place = array.map(|array| pins.hold(array, [n], Use::Held(name))).transpose()?;
        }
        for (place, (name, array)) in written.iter_mut().zip(outputs) {
            *place = array.map(|array| pins.hold(array, [n], Use::Output(name))).transpose()?;
        }
        let named = written.into_iter().zip(outputs).filter_map(|(place, (name, _))| Some((name, place?)));
        check_apart(py, read.into_iter().flatten().chain(base.arrays()), named)?;
        let disturbs = controller.get().disturbs;
        Ok(Self { controller: controller.clone().unbind(), pins, base, inputs: read, outputs: written, disturbs })
    }
}

#[pymethods]
impl ControlCycle {
    /// Read the inputs, compute, write the outputs.
    #[inline(always)]
    fn step(&self, py: Python<'_>) -> PyResult<()> {
        if !self.pins.unchanged(py) {
            return Err(changed(py));
        }
        let controller = self.controller.get();
        let n = controller.n;
        // Read before the sensor is stepped: by the time the law wants them whole, they have come to rest.
        let mut given = [const { Joints([0.0; MAX_JOINTS]) }; 5];
        for (array, into) in self.inputs.iter().zip(&mut given) {
            if let Some(array) = array {
                array.read(&mut into[..n]);
            }
        }
        let (base, armable) = self.base.now(py);
        let [q, qd, q_link, q_desired, qd_desired] = &given;
        let qd = self.inputs[1].is_some().then_some(qd);
        let q_link = self.inputs[2].is_some().then_some(q_link);
        let disturbances = if self.disturbs { controller.robot.get().disturbances() } else { None };
        let inputs = Inputs { q, qd, q_link, q_desired, qd_desired, base: &base, disturbances, armable };
        controller.shared.change(py, |law| {
            controller.robot.get().with(py, |robot| law.step(robot, &inputs));
            let output = law.output();
            let terms = [
                Some(&output.tau),
                Some(&output.tau_pd),
                Some(&output.tau_gravity),
                Some(&output.tau_disturbance),
                law.theta_desired(),
            ];
            for (array, term) in self.outputs.iter().zip(terms) {
                if let (Some(array), Some(term)) = (array, term) {
                    array.write(&term[..n]);
                }
            }
        });
        Ok(())
    }

    /// What the cycle holds, for the garbage collector.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.controller)?;
        if let Source::Sensor(sensor) = &self.base.source {
            visit.call(sensor)?;
        }
        self.pins.arrays().try_for_each(|array| visit.call(array))
    }
}
