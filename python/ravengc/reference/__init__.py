"""The yardstick: robot kinematics, gravity and dynamics in plain NumPy, as a reader of the paper would write them.

Nothing here is fast, and nothing is shared with the compiled core: it reads a :class:`~ravengc.spec.RobotSpec`
itself, row by row, with 4x4 matrices. Every function takes the spec first and works in ``float64``, ``longdouble`` (a
more precise yardstick) or complex numbers (derivatives by complex step).

Notation: ``q`` are the user's coordinates (rad, m), ``g`` the gravity field and ``f`` = a - g the specific force of the
base's origin in base axes B (m/s²); torques are those that hold or move the arm. ``payload`` is (mass, com, inertia) in
the tool frame. All raise ArgumentError for arguments of the wrong kind, shape or name.
"""

from ravengc.reference.disturbances import (
    disturbance_parameters,
    disturbance_regressor,
    disturbance_torque,
    spring_energy,
)
from ravengc.reference.dynamics import (
    base_wrench,
    forward_dynamics,
    inverse_dynamics,
    inverse_dynamics_regressor,
    kinetic_energy,
    lagrangian_torque,
    mass_matrix,
)
from ravengc.reference.gravity import (
    center_of_mass,
    gravity_regressor,
    gravity_stiffness,
    gravity_torque,
    gravity_torque_from_energy,
    inertial_parameters,
    potential_energy,
)
from ravengc.reference.kinematics import Payload, forward_kinematics, jacobian, joint_axes, link_frames

__all__ = [
    "Payload",
    "base_wrench",
    "center_of_mass",
    "disturbance_parameters",
    "disturbance_regressor",
    "disturbance_torque",
    "forward_dynamics",
    "forward_kinematics",
    "gravity_regressor",
    "gravity_stiffness",
    "gravity_torque",
    "gravity_torque_from_energy",
    "inertial_parameters",
    "inverse_dynamics",
    "inverse_dynamics_regressor",
    "jacobian",
    "joint_axes",
    "kinetic_energy",
    "lagrangian_torque",
    "link_frames",
    "mass_matrix",
    "potential_energy",
    "spring_energy",
]
