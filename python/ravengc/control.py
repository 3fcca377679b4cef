"""Control laws for the loop: PD with no, static or dynamic gravity or the base's full motion, and gravity alone.

    tau = Kp (q_d - q) + Kd (q_d' - q') + tau_g(q; base)       within limits of torque and rate

Static gravity takes the g of the moment of arming, dynamic gravity the g that the base's accelerometer gives (paper,
Fig. 6), the full motion also how the base turns: tau_g = inverse dynamics of the arm at rest for f, w, dw. The
arithmetic is the core's (``crates/gravcomp/src/control.rs`` says the law and its states): a controller owns its arrays,
and :attr:`Controller.update` is one bound call.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

import ravengc
from ravengc import _core
from ravengc._convert import as_count, as_double, as_number, as_vector, check_choice, check_type
from ravengc.coordinates import sliding
from ravengc.errors import ArgumentError, ConfigError
from ravengc.messages import shown

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

__all__ = [
    "CONTROLLER_STATES",
    "EVENTS",
    "LAWS",
    "Controller",
    "Drive",
    "Law",
    "derived_drive",
    "drive_for",
    "raven2_drive",
]

Array = NDArray[np.float64]
Numbers: TypeAlias = "Sequence[float] | Array | float"

# RAVEN II, shoulder, elbow, insertion. Gains: N m (s) at the capstan per rad of the motor, uw-biorobotics/raven2
# params/r2params.yaml. Ratio: rad of the motor per rad or m of the joint, include/raven/defines.h. Rotor: RE40, kg m^2.
RAVEN2_KP = np.array((0.3, 0.3, 0.15))
RAVEN2_KD = np.array((0.008, 0.008, 0.012))
RAVEN2_RATIO = np.array((136.1963, 121.5221, 2158.590))
RAVEN2_GEARBOX = 12.25
RAVEN2_ROTOR = 1.42e-5

STIFFEST = 1e6
"""No natural frequency (Hz) or damping ratio of a drive is larger; what is, is a slip, and could overflow."""
CONTROLLER_STATES = ("disarmed", "ramping", "armed", "fault")
"""States of a controller; a log holds their numbers."""
EVENTS: dict[str, str] = _core.EVENTS
"""What can happen in an update, by name, in the order of the bits of a status word, with what it says."""
SIDES = ("joint", "motor")
ON_FAULT = ("gravity", "decay")
WITHOUT_GOAL = ("quasi_static", "link")
"""Variants of elastic gravity that need no goal."""


@dataclass(frozen=True, slots=True)
class Law:
    """Which terms a control law has; ``turning``: it also takes how the base turns."""

    pd: bool
    gravity: Literal["none", "static", "dynamic"]
    title: str
    turning: bool = False


LAWS = {
    "pd": Law(True, "none", "PD"),
    "pd+sg": Law(True, "static", "PD + static gravity"),
    "pd+dg": Law(True, "dynamic", "PD + dynamic gravity"),
    "pd+bm": Law(True, "dynamic", "PD + full base motion", turning=True),
    "passive": Law(False, "dynamic", "gravity alone"),
}


@dataclass(frozen=True, slots=True)
class Drive:
    """PD gains and the inertia of the motors' rotors, all at the joints: (n,) each, and where the numbers come from.

    ``kp`` N m/rad (N/m), ``kd`` N m s/rad (N s/m), ``rotor_inertia`` kg m^2 (kg), zero if it is left out. For a
    controller with feedback from the motors ``kp`` and ``kd`` are those at the motors. Raises ArgumentError for gains
    that are no numbers.
    """

    kp: Array
    kd: Array
    rotor_inertia: Array = None  # type: ignore[assignment]  # one zero for each gain
    source: str = "given"

    def __post_init__(self) -> None:
        """Give rotors of which nothing is said no inertia."""
        if self.rotor_inertia is None:
            object.__setattr__(self, "rotor_inertia", np.zeros_like(as_double(self.kp, "kp")))


class Controller:
    """One of :data:`LAWS` for one robot, with its inputs and outputs as arrays that stay where they are.

    Set ``q``, ``qd``, ``q_desired``, ``qd_desired`` (n,), ``gravity`` (3,) and for "pd+bm" ``angular_velocity`` and
    ``angular_acceleration`` (3,) in place, call :attr:`update`, and read ``tau_pd``, ``tau_gravity``,
    ``tau_disturbance`` and ``tau`` (n,). ``gravity`` is that of a level base until it is set; static gravity takes it
    once, when the arm is armed. With an ``accelerometer`` each update steps its chain, on the clock of
    ``time.monotonic_ns()``, and uses that instead.

    Whatever the inputs are, ``tau`` is finite, within ``tau_max`` (N m, N) and ``tau_rate_max`` (per s, at ``rate_hz``
    updates per second). Arming, disarming and leaving a fault take ``ramp_s``, on which pose and torque start where
    they are; a controller that is not made ``armed`` exerts nothing until :meth:`arm`. A joint state with a NaN, beyond
    the modulus ``wrap`` of an encoder, or further than ``jump`` (rad, m per update) from the one before is not used:
    the last good pose stands in for at most ``hold_s``, then the fault is latched: gravity torque at that pose, or
    ``on_fault="decay"`` none, until :meth:`acknowledge`. Targets are kept within ``limits``: lower and upper ones, or
    "robot" for those of its file. Numbers are (n,) or one for all; infinite where there is no limit.

    ``feedback`` says where ``q`` is measured and the drive's gains act, ``output`` where ``tau`` goes and is limited
    (as feedback by default): "joint" or "motor" of the robot's transmission, q = C m + c0, tau_m = C^T tau. Targets are
    always those of the joints. ``differentiate``: velocities are first differences of ``q``, and ``qd`` is not read.

    ``elastic`` (made for the same robot) is for arms with cables, harmonic drives or long shafts between motors and
    links. ``q`` are then the motors' positions, in joint units with feedback "joint". PD aims at ``theta_desired``
    (n,), which each update writes, so that the links come to the goal, and gravity is taken where the variant says;
    "link" also reads ``q_link`` (n,): a link that is NaN is a missing joint state. The gains must keep the promise of
    its condition.

    ``disturbances``: laws with a gravity term add the torque of the robot's disturbance elements (cables, springs,
    friction), if it has any, at ``q`` and ``qd``; a fault holds them at rest.

    ``timed`` says whether any of this depends on ``rate_hz``. Raises ConfigError, LimitError or ArgumentError for what
    cannot be meant.
    """

    update: Callable[[], None]
    """Compute the torques from the inputs; nothing is allocated, and nothing that came in can make it fail."""

    def __init__(
        self,
        robot: ravengc.Robot,
        law: str,
        drive: Drive,
        *,
        tau_max: Numbers = math.inf,
        tau_rate_max: Numbers = math.inf,
        limits: tuple[Numbers, Numbers] | Literal["robot"] | None = None,
        jump: Numbers = math.inf,
        wrap: Numbers = math.inf,
        rate_hz: float = 1000.0,
        ramp_s: float = 0.0,
        hold_s: float = 0.05,
        feedback: Literal["joint", "motor"] = "joint",
        output: Literal["joint", "motor"] | None = None,
        on_fault: Literal["gravity", "decay"] = "gravity",
        differentiate: bool = False,
        accelerometer: ravengc.Accelerometer | None = None,
        elastic: ravengc.ElasticGravity | None = None,
        disturbances: bool = True,
        armed: bool = True,
    ) -> None:
        check_type(robot, ravengc.Robot, "robot")
        check_type(drive, Drive, "drive")
        check_choice(law, LAWS, "controller")
        for name, flag in (("differentiate", differentiate), ("disturbances", disturbances), ("armed", armed)):
            check_type(flag, bool, name)
        self.robot, self.law = robot, LAWS[law]
        self.feedback, self.output = feedback, feedback if output is None else output
        for name, value, options in (
            ("feedback", self.feedback, SIDES),
            ("output", self.output, SIDES),
            ("on_fault", on_fault, ON_FAULT),
        ):
            check_choice(value, options, name)
        terms = {"kp": drive.kp, "kd": drive.kd, "tau_max": tau_max, "tau_rate_max": tau_rate_max}
        terms |= {"jump": jump, "wrap": wrap, **_limits(limits, robot)}
        given = {name: _numbers(name, value, robot.n) for name, value in terms.items()}
        self.elastic = elastic
        if elastic is not None:
            _check_elastic(elastic, law, robot, given["kp"], feedback)
        self._core = _core.Controller(
            robot,
            law,
            **given,
            rate_hz=as_number(rate_hz, "rate_hz"),
            ramp_s=as_number(ramp_s, "ramp_s"),
            hold_s=as_number(hold_s, "hold_s"),
            feedback=feedback,
            output=self.output,
            on_fault=on_fault,
            elastic=elastic,
            disturbances=disturbances,
        )
        self.rate_hz = float(rate_hz)
        limited = np.isfinite(given["tau_rate_max"]).any() or np.isfinite(given["jump"]).any()
        self.timed = bool(differentiate or ramp_s > 0.0 or limited)
        self._make_arrays(robot.n)
        self.update = self._bound(differentiate=differentiate, accelerometer=accelerometer)
        if armed:
            self.arm()

    def _make_arrays(self, n: int) -> None:
        # One piece of memory: an update checks and fetches one array, not one for each.
        block = np.zeros(10 * n + 9)
        self.q, self.qd, self.q_desired, self.qd_desired, self.q_link = block[: 5 * n].reshape(5, n)
        self.gravity, self.angular_velocity, self.angular_acceleration = block[5 * n : 5 * n + 9].reshape(3, 3)
        outputs = block[5 * n + 9 :].reshape(5, n)
        self.tau, self.tau_pd, self.tau_gravity, self.tau_disturbance, self.theta_desired = outputs
        self.gravity[2] = -ravengc.STANDARD_GRAVITY

    def _bound(self, *, differentiate: bool, accelerometer: ravengc.Accelerometer | None) -> Callable[[], None]:
        base: dict[str, Any] = {"gravity": self.gravity if accelerometer is None else accelerometer}
        if accelerometer is not None:
            check_type(accelerometer, ravengc.Accelerometer, "accelerometer")
        elif self.law.turning:
            base["angular_velocity"] = self.angular_velocity
            base["angular_acceleration"] = self.angular_acceleration
        return self._core.bind(
            q=self.q,
            qd=None if differentiate else self.qd,
            q_desired=self.q_desired,
            qd_desired=self.qd_desired,
            **base,
            out=self.tau,
            tau_pd=self.tau_pd,
            tau_gravity=self.tau_gravity,
            tau_disturbance=self.tau_disturbance,
            **({} if self.elastic is None else {"q_link": self.q_link, "theta_desired": self.theta_desired}),
        )

    def arm(self) -> None:
        """Drive the arm, on a ramp, from the next update on that has a good joint state."""
        self._core.arm()

    def disarm(self) -> None:
        """Let the torque go to zero, on a ramp. A latched fault stays latched, without torque."""
        self._core.disarm()

    def acknowledge(self) -> None:
        """Somebody has looked at it: with a good joint state the next update leaves a latched fault, on a ramp."""
        self._core.acknowledge()

    def skip(self, updates: int) -> None:
        """So many updates were left out: the last good pose is that much older."""
        self._core.skip(as_count(updates, "updates", 0, 2**32 - 1))

    @property
    def state(self) -> str:
        """One of :data:`CONTROLLER_STATES`."""
        return self._core.state

    @property
    def status(self) -> int:
        """Events since the last acknowledgement in the low 32 bits, those of the last update in the high ones.

        The bits are in the order of :data:`EVENTS`.
        """
        return self._core.status

    @property
    def seen(self) -> tuple[str, ...]:
        """What happened in the last update: keys of :data:`EVENTS`."""
        return self._core.seen

    @property
    def since(self) -> tuple[str, ...]:
        """What happened since the last acknowledgement."""
        return self._core.since

    @property
    def counters(self) -> dict[str, int]:
        """How many updates there were ("cycles"), and in how many of them each event happened."""
        return self._core.counters


def _numbers(name: str, value: Numbers, n: int) -> Array:
    """One number for all, or one each."""
    numbers = as_double(value, name)
    if numbers.shape not in {(), (n,)}:
        raise ArgumentError(f"{name} must be one number or {n}, not {shown(value)}")
    return np.array(np.broadcast_to(numbers, (n,)))


def _check_elastic(elastic: ravengc.ElasticGravity, law: str, robot: ravengc.Robot, kp: Array, feedback: str) -> None:
    """Refuse elastic gravity in a law without gravity or goal, and gains that break the promise of its condition."""
    check_type(elastic, ravengc.ElasticGravity, "elastic")
    if LAWS[law].gravity == "none":
        raise ConfigError(
            f"elastic is given, but the law {law!r} has no gravity term; use 'pd+dg', or leave elastic out"
        )
    if not LAWS[law].pd and elastic.variant not in WITHOUT_GOAL:
        options = " or ".join(WITHOUT_GOAL)
        raise ConfigError(
            f"elastic has the variant {elastic.variant!r}, but the law {law!r} has no goal; use {options}"
        )
    if LAWS[law].pd:
        elastic.require(_joint_gains(robot, kp, feedback))


def _joint_gains(robot: ravengc.Robot, kp: Array, feedback: str) -> Array:
    """Gains in joint units, (n, n): those of motors stiffen the joints by A^T K_P A with A = C^-1."""
    if feedback == "joint" or robot.spec.transmission is None:
        return np.diag(kp)
    zero = robot.motor_positions(np.zeros(robot.n))
    columns = [robot.motor_positions(column) - zero for column in np.eye(robot.n)]
    per_joint = np.stack(columns, axis=1)
    stiffness: Array = per_joint.T @ np.diag(kp) @ per_joint
    return 0.5 * (stiffness + stiffness.T)


def _limits(limits: object, robot: ravengc.Robot) -> dict[str, Any]:
    """Lower and upper limits of the coordinates, infinite where there is none."""
    if limits is None:
        return {}
    if isinstance(limits, str):
        check_choice(limits, ("robot",), "limits")
        of_joints = robot.spec.coordinate_limits
        lower = [-math.inf if limit.lower is None else limit.lower for limit in of_joints]
        return {"lower": lower, "upper": [math.inf if limit.upper is None else limit.upper for limit in of_joints]}
    if not isinstance(limits, (tuple, list)) or len(limits) != 2:
        raise ArgumentError(f"limits is {shown(limits)}; expected lower and upper limits, 'robot' or None")
    return {"lower": limits[0], "upper": limits[1]}


def drive_for(
    robot: ravengc.Robot, q: Array, *, natural_frequency_hz: float | None = None, damping_ratio: float | None = None
) -> Drive:
    """Give the robot's published gains, or :func:`derived_drive` at ``q`` if there are none or a number is given."""
    check_type(robot, ravengc.Robot, "robot")
    as_vector(q, "q", robot.n)
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
