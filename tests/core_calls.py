"""The functions of the compiled core as a table, and arrays that they must refuse."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

import ravengc as rg

if TYPE_CHECKING:
    from collections.abc import Callable

N, BODIES = 7, 7
"""Coordinates and bodies of the Panda, on which the calls are tried."""

LEVEL = (0.0, 0.0, -9.75)
"""A gravity vector that every floating-point type holds exactly."""

VALUES = {
    "q": np.array([0.5, -1.25, 2.0, -2.0, 0.25, 1.5, -0.75]),
    "qd": np.array([0.5, -0.25, 1.0, 2.0, -1.5, 0.75, 1.25]),
    "qdd": np.array([3.0, -2.0, 1.5, 0.5, -4.0, 2.5, 1.0]),
    "tau": np.array([1.0, -30.0, 4.0, 12.0, 0.5, -1.5, 0.25]),
    "gravity": np.array(LEVEL),
}
"""Arguments whose numbers float32 holds exactly."""

ROCKING = rg.BaseMotion(
    specific_force=(0.5, -1.0, 9.5), angular_velocity=(0.1, -0.2, 0.3), angular_acceleration=(1.0, 0.5, -0.25)
)
ROCKING_ROW = np.array([0.5, -1.0, 9.5, 0.1, -0.2, 0.3, 1.0, 0.5, -0.25])


@dataclass(frozen=True)
class Call:
    """A function: its name, the names of its arguments in order, the shape of its result."""

    name: str
    inputs: tuple[str, ...]
    shape: tuple[int, ...]

    def __str__(self) -> str:
        return self.name

    @property
    def arrays(self) -> tuple[str, ...]:
        """The arguments that are arrays."""
        return tuple(name for name in self.inputs if name != "base")

    def arguments(self, **replaced: Any) -> dict[str, Any]:
        """Fresh arguments by name, some of them replaced."""
        own = {name: ROCKING if name == "base" else VALUES[name].copy() for name in self.inputs}
        return own | replaced

    def __call__(self, robot: rg.Robot, **replaced: Any) -> Any:
        return getattr(robot, self.name)(**self.arguments(**replaced))


ON_BASE = ("q", "qd", "qdd", "base")
CALLS = (
    Call("gravity_torque", ("q", "gravity"), (N,)),
    Call("forward_kinematics", ("q",), (4, 4)),
    Call("jacobian", ("q",), (6, N)),
    Call("inverse_dynamics", ON_BASE, (N,)),
    Call("base_wrench", ON_BASE, (6,)),
    Call("mass_matrix", ("q",), (N, N)),
    Call("forward_dynamics", ("q", "qd", "tau", "base"), (N,)),
    Call("gravity_regressor", ("q", "gravity"), (N, 4 * BODIES)),
    Call("inverse_dynamics_regressor", ON_BASE, (N, 10 * BODIES)),
    Call("gravity_stiffness", ("q", "gravity"), (N, N)),
    Call("center_of_mass", ("q",), (3,)),
)
POTENTIAL_ENERGY = Call("potential_energy", ("q", "gravity"), ())


BASE_PARTS = ("specific_force", "angular_velocity", "angular_acceleration")
ARGUMENTS = VALUES | dict(zip(BASE_PARTS, np.split(ROCKING_ROW, 3), strict=True))


@dataclass(frozen=True)
class Binding:
    """A way to bind: the method, its inputs, the result's shape, and the call that computes the same."""

    name: str
    inputs: tuple[str, ...]
    shape: tuple[int, ...]
    direct: Callable[[rg.Robot, dict[str, np.ndarray]], np.ndarray]

    def __str__(self) -> str:
        return self.name

    def arrays(self) -> dict[str, np.ndarray]:
        """Fresh arrays by name, ``out`` full of NaN."""
        inputs = {name: ARGUMENTS[name].copy() for name in self.inputs}
        return {**inputs, "out": np.full(self.shape, np.nan)}

    def bind(self, robot: rg.Robot, arrays: dict[str, Any]) -> Callable[[], None]:
        """The cycle."""
        return getattr(robot, self.name)(**arrays)


BINDINGS = (
    Binding("bind", ("q", "gravity"), (N,), lambda robot, x: robot.gravity_torque(x["q"], x["gravity"])),
    Binding(
        "bind_inverse_dynamics",
        ("q", "qd", "qdd", *BASE_PARTS),
        (N,),
        lambda robot, x: robot.inverse_dynamics(
            x["q"], x["qd"], x["qdd"], rg.BaseMotion(**{part: x[part] for part in BASE_PARTS})
        ),
    ),
    Binding("bind_forward_kinematics", ("q",), (4, 4), lambda robot, x: robot.forward_kinematics(x["q"])),
    Binding("bind_jacobian", ("q",), (6, N), lambda robot, x: robot.jacobian(x["q"])),
)


def misaligned(values: np.ndarray) -> np.ndarray:
    """The same numbers one byte off their natural place."""
    copy = np.frombuffer(bytearray(values.nbytes + 1), dtype=np.float64, count=values.size, offset=1)
    copy = copy.reshape(values.shape)
    copy[...] = values
    return copy


def strided(values: np.ndarray) -> np.ndarray:
    """The same numbers with gaps between them."""
    copy = np.zeros((*values.shape[:-1], 2 * values.shape[-1]))[..., ::2]
    copy[...] = values
    return copy


def read_only(values: np.ndarray) -> np.ndarray:
    """The same numbers, not to be written."""
    copy = values.copy()
    copy.flags.writeable = False
    return copy


def big_endian(values: np.ndarray) -> np.ndarray:
    """The same numbers in the byte order that this machine does not have, or only names differently."""
    return values.astype(values.dtype.newbyteorder("S"))


def longer(values: np.ndarray) -> np.ndarray:
    """One number too many."""
    return np.zeros((*values.shape[:-1], values.shape[-1] + 1))


def deeper(values: np.ndarray) -> np.ndarray:
    """One dimension too many."""
    return values[np.newaxis].copy()


def overlapping(size: int, other: int) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """Pairs of contiguous arrays with ``size`` and ``other`` numbers that share memory: all of it, or one number."""
    buffer = np.zeros(size + other)
    raw = bytearray(8 * (size + other))
    return (
        (buffer[:size], buffer[:other]),
        (buffer[:size], buffer[size - 1 : size - 1 + other]),
        (buffer[other - 1 : other - 1 + size], buffer[:other]),
        (buffer.view(np.uint8).view(np.float64)[:size], buffer.reshape(1, -1)[0][:other]),
        (np.frombuffer(raw, count=size), np.frombuffer(raw, count=other, offset=8 * (size - 1))),
    )


WRONG_SHAPES: tuple[tuple[Callable[[np.ndarray], Any], str], ...] = (
    (longer, "has shape"),
    (deeper, "has shape"),
    (lambda values: values.ravel()[:0], "has shape"),
)
WRONG_LAYOUTS: tuple[tuple[Callable[[np.ndarray], Any], str], ...] = (
    (lambda values: values.astype(np.float32), "has dtype float32"),
    (lambda values: values.astype(np.int64), "has dtype int64"),
    (lambda values: values.astype(np.complex128), "has dtype complex128"),
    (lambda values: values.astype(object), "has dtype object"),
    (big_endian, "has dtype"),
    (strided, "is not C-contiguous"),
    (misaligned, "is not aligned"),
    (np.ndarray.tolist, "is a list"),
    (lambda _: 3.0, "is a float"),
    (lambda _: "out", "is a str"),
)
NOT_NUMBERS: tuple[tuple[Callable[[np.ndarray], Any], str], ...] = (
    (lambda values: values.astype(str), "real numbers"),
    (lambda values: values.astype(object), "real numbers"),
    (lambda values: values.astype(np.complex128), "real numbers"),
    (lambda values: values > 0, "real numbers"),
    (lambda values: [*values.tolist()[:-1], [1.0, 2.0]], "array of numbers"),
    (lambda _: "0 0 0", "real numbers"),
    (lambda _: None, "real numbers"),
    (lambda _: {}, "real numbers"),
    (lambda _: [2**70] * N, "real numbers"),
)


class Tagged(np.ndarray):
    """An array with a name."""

    name = "tagged"
