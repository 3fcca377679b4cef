//! `Robot` as Python sees it: the functions of a cycle, one call each.

use super::{Array, DISTURBANCE_REGRESSOR, GRAVITY_REGRESSOR, JACOBIAN, REGRESSOR, Robot, SQUARE, jacobian_axes};
use crate::arrays::{Elements, output, read, read_joints};
use crate::dispatch::kernel;
use crate::present::{Payload, Present, State, Tool, given};
use crate::types::{base_motion, gravity, real, text, vector};
use gravcomp::disturbance::Disturbances;
use gravcomp::{GRAVITY_PARAMETERS, Joints, PARAMETERS, Transmission};
use pyo3::prelude::*;
use pyo3::types::{PyString, PyTuple};

#[pymethods]
impl Robot {
    #[new]
    fn new(py: Python<'_>, spec: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::lowered(py, spec)
    }

    /// The robot's name.
    #[getter]
    fn name(&self) -> &str {
        &self.names.robot
    }

    /// Number of coordinates: the length of q.
    #[getter(n)]
    fn coordinate_count(&self) -> usize {
        self.n
    }

    /// Number of moving bodies.
    #[getter]
    fn body_count(&self) -> usize {
        self.bodies
    }

    /// Names of the coordinates.
    #[getter]
    fn joint_names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, &self.names.joints)
    }

    /// Names that `frame=` knows: "base", the links, "tool".
    #[getter]
    fn frame_names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, &self.names.frame_order)
    }

    /// Efforts that hold the arm still, eqs (1)-(3) of Lewis & Hannaford.
    ///
    /// `q` (n,) rad or m; `gravity` (3,) m/s² in base axes, a Gravity or a SpecificForce; returns (n,) N·m or N.
    /// `out` is a C-contiguous float64 array that shares no memory with the inputs. Raises ArgumentError.
    #[pyo3(signature = (q, gravity, out=None))]
    fn gravity_torque<'py>(
        &self,
        q: &Array<'py>,
        gravity: &Array<'py>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (q.py(), self.n);
        let (q, q_at) = read_joints(q, n, "q")?;
        let (g, g_at) = self::gravity(gravity)?;
        let (out, target) = output(py, out, [n], &[q_at, g_at])?;
        let tau = self.with(py, |robot| kernel!(gravity_torque(robot, &q, &g)));
        target.write(&tau[..n]);
        Ok(out)
    }

    /// Pose of a frame in the base frame B, (4, 4) homogeneous.
    ///
    /// `frame` is "tool" (default), "base" or a link's name. Raises ArgumentError.
    #[pyo3(signature = (q, frame=None, out=None))]
    fn forward_kinematics<'py>(
        &self,
        q: &Array<'py>,
        frame: Option<&Bound<'py, PyString>>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let py = q.py();
        let frame = self.frame(py, frame)?;
        let (q, q_at) = read_joints(q, self.n, "q")?;
        let (out, target) = output(py, out, [4, 4], &[q_at])?;
        let pose = self.with(py, |robot| kernel!(forward_kinematics(robot, &q, &frame))).transpose();
        target.write(pose.as_slice());
        Ok(out)
    }

    /// Geometric Jacobian of a frame, (6, n): linear rows (m/s) first, then angular (rad/s).
    ///
    /// `axes` is "base" (default) or "frame": the axes in which the rows are written. Raises ArgumentError.
    #[pyo3(signature = (q, frame=None, axes=None, out=None))]
    fn jacobian<'py>(
        &self,
        q: &Array<'py>,
        frame: Option<&Bound<'py, PyString>>,
        axes: Option<&Bound<'py, PyString>>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (q.py(), self.n);
        let (frame, axes) = (self.frame(py, frame)?, jacobian_axes(axes)?);
        let (q, q_at) = read_joints(q, n, "q")?;
        let (out, target) = output(py, out, [6, n], &[q_at])?;
        target
            .compute::<JACOBIAN>(|entries| self.with(py, |robot| kernel!(jacobian(robot, &q, &frame, axes, entries))));
        Ok(out)
    }

    /// Efforts (n,) for the motion q, qd, qdd on a base that moves.
    ///
    /// `base` is a BaseMotion, or a Gravity or SpecificForce for a base at rest. Raises ArgumentError.
    #[pyo3(signature = (q, qd, qdd, base, out=None))]
    fn inverse_dynamics<'py>(
        &self,
        q: &Array<'py>,
        qd: &Array<'py>,
        qdd: &Array<'py>,
        base: &Array<'py>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (q.py(), self.n);
        let (q, q_at) = read_joints(q, n, "q")?;
        let (qd, qd_at) = read_joints(qd, n, "qd")?;
        let (qdd, qdd_at) = read_joints(qdd, n, "qdd")?;
        let base = base_motion(base)?;
        let (out, target) = output(py, out, [n], &[q_at, qd_at, qdd_at])?;
        target.write(&self.with(py, |robot| kernel!(inverse_dynamics(robot, &q, &qd, &qdd, &base)))[..n]);
        Ok(out)
    }

    /// What the mount exerts on the arm and all that is fixed to the base, (6,): force (N), moment about the base origin (N·m).
    #[pyo3(signature = (q, qd, qdd, base, out=None))]
    fn base_wrench<'py>(
        &self,
        q: &Array<'py>,
        qd: &Array<'py>,
        qdd: &Array<'py>,
        base: &Array<'py>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (q.py(), self.n);
        let (q, q_at) = read_joints(q, n, "q")?;
        let (qd, qd_at) = read_joints(qd, n, "qd")?;
        let (qdd, qdd_at) = read_joints(qdd, n, "qdd")?;
        let base = base_motion(base)?;
        let (out, target) = output(py, out, [6], &[q_at, qd_at, qdd_at])?;
        target.write(self.with(py, |robot| kernel!(base_wrench(robot, &q, &qd, &qdd, &base))).as_slice());
        Ok(out)
    }

    /// Mass matrix (n, n), symmetric.
    #[pyo3(signature = (q, out=None))]
    fn mass_matrix<'py>(&self, q: &Array<'py>, out: Option<&Array<'py>>) -> PyResult<Array<'py>> {
        let (py, n) = (q.py(), self.n);
        let (q, q_at) = read_joints(q, n, "q")?;
        let (out, target) = output(py, out, [n, n], &[q_at])?;
        target.compute::<SQUARE>(|entries| self.with(py, |robot| kernel!(mass_matrix(robot, &q, entries))));
        Ok(out)
    }

    /// Accelerations (n,) under efforts `tau` on a base that moves; NaN where the mass matrix is not positive definite.
    #[pyo3(signature = (q, qd, tau, base, out=None))]
    fn forward_dynamics<'py>(
        &self,
        q: &Array<'py>,
        qd: &Array<'py>,
        tau: &Array<'py>,
        base: &Array<'py>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (q.py(), self.n);
        let (q, q_at) = read_joints(q, n, "q")?;
        let (qd, qd_at) = read_joints(qd, n, "qd")?;
        let (tau, tau_at) = read_joints(tau, n, "tau")?;
        let base = base_motion(base)?;
        let (out, target) = output(py, out, [n], &[q_at, qd_at, tau_at])?;
        target.write(&self.with(py, |robot| kernel!(forward_dynamics(robot, &q, &qd, &tau, &base)))[..n]);
        Ok(out)
    }

    /// Y with gravity_torque = Y @ p, (n, 4 body_count); p has (m, hx, hy, hz) per moving link, in its link frame.
    #[pyo3(signature = (q, gravity, out=None))]
    fn gravity_regressor<'py>(
        &self,
        q: &Array<'py>,
        gravity: &Array<'py>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (q.py(), self.n);
        let (q, q_at) = read_joints(q, n, "q")?;
        let (g, g_at) = self::gravity(gravity)?;
        let width = GRAVITY_PARAMETERS * self.bodies;
        let (out, target) = output(py, out, [n, width], &[q_at, g_at])?;
        target.compute::<GRAVITY_REGRESSOR>(|entries| {
            self.with(py, |robot| kernel!(gravity_regressor(robot, &q, &g, entries)));
        });
        Ok(out)
    }

    /// Y with inverse_dynamics = Y @ inertial_parameters(), (n, 10 body_count).
    #[pyo3(signature = (q, qd, qdd, base, out=None))]
    fn inverse_dynamics_regressor<'py>(
        &self,
        q: &Array<'py>,
        qd: &Array<'py>,
        qdd: &Array<'py>,
        base: &Array<'py>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (q.py(), self.n);
        let (q, q_at) = read_joints(q, n, "q")?;
        let (qd, qd_at) = read_joints(qd, n, "qd")?;
        let (qdd, qdd_at) = read_joints(qdd, n, "qdd")?;
        let base = base_motion(base)?;
        let width = PARAMETERS * self.bodies;
        let (out, target) = output(py, out, [n, width], &[q_at, qd_at, qdd_at])?;
        target.compute::<REGRESSOR>(|entries| {
            self.with(py, |robot| kernel!(inverse_dynamics_regressor(robot, &q, &qd, &qdd, &base, entries)));
        });
        Ok(out)
    }

    /// Efforts (n,) against the disturbance elements: cables, springs, friction, offsets. At rest without `qd`.
    ///
    /// They are added to those of gravity or motion; they are fixed to the base and do not turn with gravity.
    #[pyo3(signature = (q, qd=None, out=None))]
    fn disturbance_torque<'py>(
        &self,
        q: &Array<'py>,
        qd: Option<&Array<'py>>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (q.py(), self.n);
        let (q, q_at) = read_joints(q, n, "q")?;
        let (qd, qd_at) = rates(qd, n)?;
        let (out, target) = output(py, out, [n], &[q_at, qd_at])?;
        let tau = match self.disturbances() {
            Some(elements) => self.with(py, |robot| kernel!(disturbance_torque(robot, elements, &q, &qd))),
            None => Joints::default(),
        };
        target.write(&tau[..n]);
        Ok(out)
    }

    /// Y with disturbance_torque = Y @ disturbance_parameters(), (n, columns): a column for each of `disturbance_columns`.
    #[pyo3(signature = (q, qd=None, out=None))]
    fn disturbance_regressor<'py>(
        &self,
        q: &Array<'py>,
        qd: Option<&Array<'py>>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (q.py(), self.n);
        let (q, q_at) = read_joints(q, n, "q")?;
        let (qd, qd_at) = rates(qd, n)?;
        let width = self.names.columns.len();
        let (out, target) = output(py, out, [n, width], &[q_at, qd_at])?;
        if let Some(elements) = self.disturbances() {
            target.compute::<DISTURBANCE_REGRESSOR>(|entries| {
                self.with(py, |robot| kernel!(disturbance_regressor(robot, elements, &q, &qd, entries)));
            });
        }
        Ok(out)
    }

    /// Parameters (columns,) of the disturbance elements, in the order of `disturbance_columns`.
    fn disturbance_parameters<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let (out, target) = output(py, None, [self.names.columns.len()], &[])?;
        target.write(self.disturbances().map_or(&[], Disturbances::parameters));
        Ok(out)
    }

    /// Names of the disturbance elements' parameters: the element's, a dot, and which of its parameters.
    #[getter]
    fn disturbance_columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, &self.names.columns)
    }

    /// Derivative of the gravity torque by q, (n, n), symmetric: the Hessian of the potential energy.
    #[pyo3(signature = (q, gravity, out=None))]
    fn gravity_stiffness<'py>(
        &self,
        q: &Array<'py>,
        gravity: &Array<'py>,
        out: Option<&Array<'py>>,
    ) -> PyResult<Array<'py>> {
        let (py, n) = (q.py(), self.n);
        let (q, q_at) = read_joints(q, n, "q")?;
        let (g, g_at) = self::gravity(gravity)?;
        let (out, target) = output(py, out, [n, n], &[q_at, g_at])?;
        target.compute::<SQUARE>(|entries| self.with(py, |robot| kernel!(gravity_stiffness(robot, &q, &g, entries))));
        Ok(out)
    }

    /// U = -sum m g.p, J: zero for a mass at the base origin.
    fn potential_energy(&self, q: &Array<'_>, gravity: &Array<'_>) -> PyResult<f64> {
        let py = q.py();
        let (q, _) = read_joints(q, self.n, "q")?;
        let (g, _) = self::gravity(gravity)?;
        Ok(self.with(py, |robot| kernel!(potential_energy(robot, &q, &g))))
    }

    /// Centre of mass of all that moves, (3,), m, in the base frame B.
    #[pyo3(signature = (q, out=None))]
    fn center_of_mass<'py>(&self, q: &Array<'py>, out: Option<&Array<'py>>) -> PyResult<Array<'py>> {
        let py = q.py();
        let (q, q_at) = read_joints(q, self.n, "q")?;
        let (out, target) = output(py, out, [3], &[q_at])?;
        target.write(self.with(py, |robot| kernel!(center_of_mass(robot, &q))).as_slice());
        Ok(out)
    }

    /// (10 body_count,): m, hx, hy, hz, Ixx, Ixy, Ixz, Iyy, Iyz, Izz per moving link about its link frame's origin.
    ///
    /// What is rigidly attached to the link is included, the payload too.
    fn inertial_parameters<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let (out, target) = output(py, None, [PARAMETERS * self.bodies], &[])?;
        for body in 0..self.bodies {
            let parameters = self.with(py, |robot| robot.inertia(body).parameters());
            target.part(PARAMETERS * body, PARAMETERS).write(&parameters);
        }
        Ok(out)
    }

    /// Motor efforts (n,) for efforts `tau` at the coordinates: tau_motor = C^T tau with q = C m + c0.
    #[pyo3(signature = (tau, out=None))]
    fn actuator_torque<'py>(&self, tau: &Array<'py>, out: Option<&Array<'py>>) -> PyResult<Array<'py>> {
        self.transmit(tau, "tau", out, Transmission::motor_efforts)
    }

    /// Efforts at the coordinates (n,) for motor efforts: the inverse of `actuator_torque`.
    #[pyo3(signature = (tau_motor, out=None))]
    fn joint_torque<'py>(&self, tau_motor: &Array<'py>, out: Option<&Array<'py>>) -> PyResult<Array<'py>> {
        self.transmit(tau_motor, "tau_motor", out, Transmission::joint_efforts)
    }

    /// Coordinates (n,) for motor positions: q = C m + c0.
    #[pyo3(signature = (motors, out=None))]
    fn joint_positions<'py>(&self, motors: &Array<'py>, out: Option<&Array<'py>>) -> PyResult<Array<'py>> {
        self.transmit(motors, "motors", out, Transmission::joint_positions)
    }

    /// Motor positions (n,) for coordinates: the inverse of `joint_positions`.
    #[pyo3(signature = (q, out=None))]
    fn motor_positions<'py>(&self, q: &Array<'py>, out: Option<&Array<'py>>) -> PyResult<Array<'py>> {
        self.transmit(q, "q", out, Transmission::motor_positions)
    }

    /// Attach a payload in place of the one before: mass (kg), com (3,) m and inertia about it (6,) kg·m², in the tool frame.
    #[pyo3(signature = (mass, com, inertia=None))]
    fn set_payload(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = real)] mass: f64,
        com: &Array<'_>,
        inertia: Option<&Array<'_>>,
    ) -> PyResult<()> {
        let com = vector(com, "com")?.into();
        let about_com = inertia.map_or(Ok([0.0; 6]), |i| Ok::<_, PyErr>(read::<6>(i, 6, "inertia")?.0))?;
        let payload = Payload::new(py, mass, com, about_com)?;
        self.shared.change(py, |present| present.set_payload(Some(payload)));
        Ok(())
    }

    /// Take the payload off.
    fn clear_payload(&self, py: Python<'_>) {
        self.shared.change(py, |present| present.set_payload(None));
    }

    /// Replace the pose of frame 0 in the base frame B: p_B = rotation @ p_0 + translation. Raises ModelError.
    #[pyo3(signature = (rotation, translation=None))]
    fn set_base(&self, rotation: &Array<'_>, translation: Option<&Array<'_>>) -> PyResult<()> {
        let base = given(rotation, translation, "base")?;
        self.shared.change(rotation.py(), |present| present.robot.set_base(base));
        Ok(())
    }

    /// Replace the tool frame: its pose in the frame of `link`, the robot's tip by default. A payload stays where it is.
    ///
    /// "tool" moves the tool as it is now, on its link. Raises ArgumentError or ModelError.
    #[pyo3(signature = (rotation, translation=None, link=None))]
    fn set_tool(
        &self,
        rotation: &Array<'_>,
        translation: Option<&Array<'_>>,
        link: Option<&Bound<'_, PyString>>,
    ) -> PyResult<()> {
        let (py, names) = (rotation.py(), &self.names);
        let pose = given(rotation, translation, "tool")?;
        let tool = match link.map(text).transpose()?.unwrap_or(&names.tip) {
            "tool" => self.shared.with(py, |present| present.tool().clone()).then(py, names, pose)?,
            link => Tool::new(py, names, link, pose)?,
        };
        self.shared.change(py, |present| present.set_tool(tool));
        Ok(())
    }

    /// Base, tool and payload as they were given last: what copies and pickles carry beside the description.
    ///
    /// `base` and `tool` have a rotation and a translation (m): frame 0 in the base frame B, the tool in the frame of link
    /// `tip`. `payload` is None or has mass (kg), com (m), inertia about it (kg·m²), and the tool and tip of its time.
    fn __getstate__(&self, py: Python<'_>) -> State {
        State::of(&self.shared.with(py, Present::setting))
    }

    /// Set base, tool and payload to a state from `__getstate__`. Raises ArgumentError or ModelError and changes nothing then.
    fn __setstate__(&self, state: &Array<'_>) -> PyResult<()> {
        let py = state.py();
        let setting = State::read(state, &self.names)?.checked(py, &self.names)?;
        self.shared.change(py, |present| present.set(setting));
        Ok(())
    }
}

/// Rates of the coordinates; at rest where none are given.
fn rates(qd: Option<&Array<'_>>, n: usize) -> PyResult<(Joints, Option<Elements>)> {
    qd.map_or(Ok((Joints::default(), None)), |qd| read_joints(qd, n, "qd"))
}
