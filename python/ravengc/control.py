"""Control laws for the loop: PD with no, static or dynamic gravity, and gravity alone.

    tau = Kp (q_d - q) + Kd (q_d' - q') + tau_g(q, g)          limited to +-tau_max

Static gravity takes the g of a level base, dynamic gravity the g that the base's accelerometer gives (paper, Fig. 6). A
controller owns its arrays and computes into them; its gravity term is a bound cycle of the robot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

import ravengc
from ravengc._convert import as_double, as_number, as_vector, check_choice, check_type
from ravengc.coordinates import sliding
from ravengc.errors import ArgumentError, ConfigError
from ravengc.messages import shown

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

__all__ = ["LAWS", "Controller", "Drive", "Law", "derived_drive", "drive_for", "raven2_drive"]

Array = NDArray[np.float64]

# RAVEN II, shoulder, elbow, insertion. Gains: N m (s) at the capstan per rad of the motor, uw-biorobotics/raven2
# params/r2params.yaml. Ratio: rad of the motor per rad or m of the joint, include/raven/defines.h. Rotor: RE40, kg m^2.
RAVEN2_KP = np.array((0.3, 0.3, 0.15))
RAVEN2_KD = np.array((0.008, 0.008, 0.012))
RAVEN2_RATIO = np.array((136.1963, 121.5221, 2158.590))
RAVEN2_GEARBOX = 12.25
RAVEN2_ROTOR = 1.42e-5

LARGEST_GAIN = 1e30
"""No gain is larger (SI); what is, could overflow."""
STIFFEST = 1e6
"""No natural frequency (Hz) or damping ratio of a drive is larger; what is, is a slip, and could overflow."""


@dataclass(frozen=True, slots=True)
class Law:
    """Which terms a control law has."""

    pd: bool
    gravity: Literal["none", "static", "dynamic"]
    title: str


LAWS = {
    "pd": Law(True, "none", "PD"),
    "pd+sg": Law(True, "static", "PD + static gravity"),
    "pd+dg": Law(True, "dynamic", "PD + dynamic gravity"),
    "passive": Law(False, "dynamic", "gravity alone"),
}


@dataclass(frozen=True, slots=True)
class Drive:
    """PD gains and the inertia of the motors' rotors, all at the joints: (n,) each, and where the numbers come from.

    ``kp`` N m/rad (N/m), ``kd`` N m s/rad (N s/m), ``rotor_inertia`` kg m^2 (kg).
    """

    kp: Array
    kd: Array
    rotor_inertia: Array
    source: str


class Controller:
    """One of :data:`LAWS` for one robot, with its inputs and outputs as arrays that stay where they are.

    Set ``q``, ``qd``, ``q_desired``, ``qd_desired`` (n,) and ``gravity`` (3,) in place, call :meth:`update`, and read
    ``tau_pd``, ``tau_gravity`` and ``tau`` (n,). ``gravity`` is that of a level base until it is set; a loop sets it
    for laws with dynamic gravity only.
    """

    def __init__(
        self, robot: ravengc.Robot, law: str, drive: Drive, *, tau_max: Sequence[float] | Array | float = math.inf
    ) -> None:
        check_type(robot, ravengc.Robot, "robot")
        check_type(drive, Drive, "drive")
        check_choice(law, LAWS, "controller")
        self.law = LAWS[law]
        self.q, self.qd, self.q_desired, self.qd_desired = np.zeros((4, robot.n))
        self.tau_pd, self.tau_gravity, self.tau = np.zeros((3, robot.n))
        self.gravity = np.array((0.0, 0.0, -ravengc.STANDARD_GRAVITY))
        self._kp = _gains("kp", drive.kp, robot.n, most=LARGEST_GAIN)
        self._kd = _gains("kd", drive.kd, robot.n, most=LARGEST_GAIN)
        self._upper = _gains("tau_max", tau_max, robot.n, most=math.inf)
        self._lower = -self._upper
        self._damping = np.zeros(robot.n)
        self._gravity_cycle: Callable[[], object] = robot.bind(q=self.q, gravity=self.gravity, out=self.tau_gravity)

    def update(self) -> None:
        """Compute the torques from the inputs; nothing is allocated."""
        if self.law.pd:
            np.subtract(self.q_desired, self.q, out=self.tau_pd)
            np.multiply(self.tau_pd, self._kp, out=self.tau_pd)
            np.subtract(self.qd_desired, self.qd, out=self._damping)
            np.multiply(self._damping, self._kd, out=self._damping)
            np.add(self.tau_pd, self._damping, out=self.tau_pd)
        if self.law.gravity != "none":
            self._gravity_cycle()
        np.add(self.tau_pd, self.tau_gravity, out=self.tau)
        np.minimum(self.tau, self._upper, out=self.tau)
        np.maximum(self.tau, self._lower, out=self.tau)


def drive_for(
    robot: ravengc.Robot, q: Array, *, natural_frequency_hz: float | None = None, damping_ratio: float | None = None
) -> Drive:
    """Give the robot's published gains, or :func:`derived_drive` at ``q`` if there are none or a number is given."""
    check_type(robot, ravengc.Robot, "robot")
    if natural_frequency_hz is None and damping_ratio is None and robot.name.startswith("raven2") and robot.n == 3:
        return raven2_drive()
    return derived_drive(
        robot,
        q,
        natural_frequency_hz=5.0 if natural_frequency_hz is None else natural_frequency_hz,
        damping_ratio=0.7 if damping_ratio is None else damping_ratio,
    )


def derived_drive(
    robot: ravengc.Robot, q: Array, *, natural_frequency_hz: float = 5.0, damping_ratio: float = 0.7
) -> Drive:
    """Derive gains from the mass matrix at ``q``: a joint alone swings at this frequency with this damping ratio.

    With m_i = M_ii + J_i, Kp = w^2 m_i and Kd = 2 zeta w m_i. The rotors are ASSUMED: J_i is a tenth of M_ii, and at
    least 1e-3 kg m^2 (0.1 kg on sliding joints), which also carries joints whose links are massless. As M is positive,
    no eigenvalue of (M + J)^-1 diag(m) exceeds 11, which keeps a loop with period dt far from its limit of
    stability, 11 * 2 zeta w dt < 2, whatever the arm.
    """
    check_type(robot, ravengc.Robot, "robot")
    frequency = as_number(natural_frequency_hz, "natural_frequency_hz")
    ratio = as_number(damping_ratio, "damping_ratio")
    if not (0.0 < frequency <= STIFFEST and 0.0 <= ratio <= STIFFEST):
        raise ConfigError(
            f"natural frequency {natural_frequency_hz} Hz, damping ratio {damping_ratio}: "
            f"the frequency must be positive and the ratio not negative, both at most {STIFFEST:g}"
        )
    links = np.diag(robot.mass_matrix(as_vector(q, "q", robot.n)))
    rotor = np.maximum(0.1 * links, np.where(sliding(robot.spec), 0.1, 1e-3))
    inertia = links + rotor
    rate = 2.0 * math.pi * natural_frequency_hz
    source = f"derived from the mass matrix: {natural_frequency_hz:g} Hz, damping ratio {damping_ratio:g}"
    return Drive(rate * rate * inertia, 2.0 * damping_ratio * rate * inertia, rotor, source)


def raven2_drive() -> Drive:
    """The gains of the RAVEN II software, carried from the motors to the joints: K = k ratio^2 / gearbox."""
    at_joint = RAVEN2_RATIO**2 / RAVEN2_GEARBOX
    return Drive(
        RAVEN2_KP * at_joint, RAVEN2_KD * at_joint, RAVEN2_ROTOR * RAVEN2_RATIO**2, "RAVEN II software (r2params.yaml)"
    )


def _gains(name: str, value: Sequence[float] | Array | float, n: int, *, most: float) -> Array:
    numbers = as_double(value, name)
    if numbers.shape not in {(), (n,)} or not ((numbers >= 0.0) & (numbers <= most)).all():
        raise ArgumentError(f"{name} must be one number or {n}, none negative or above {most:g}, not {shown(value)}")
    return np.array(np.broadcast_to(numbers, (n,)))
