"""Formulas against the compiled core, in random states."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import as_count, check_type
from ravengc._core import BaseMotion
from ravengc.coordinates import sliding
from ravengc.robot import Robot
from ravengc.symbolic.code import function_name, to_python
from ravengc.symbolic.formulas import Formulas

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

__all__ = ["Check", "check", "function"]

TOLERANCE, LEAST = 1e-10, 1e-3
"""Largest difference that rounding explains, as a share of the result's largest entry, or of LEAST if all are less."""

MOST_STATES = 1_000_000

SPREAD = {"q": np.pi, "qd": 3.0, "qdd": 10.0, "g": 15.0, "f": 15.0, "w": 3.0, "dw": 10.0}
"""Largest random entry of every input (rad, m/s², ...)."""


@dataclass(frozen=True, slots=True)
class Check:
    """How far formulas are from the core: ``difference`` in the worst of ``states``, and the ``largest`` entry seen."""

    states: int
    difference: float
    largest: float

    @property
    def holds(self) -> bool:
        """The difference is rounding."""
        return self.difference <= TOLERANCE * max(self.largest, LEAST)

    def __str__(self) -> str:
        states = f"{self.states} random state{'s' if self.states > 1 else ''}"
        return f"against the core in {states}: largest difference {self.difference:.2g}, of {self.largest:.4g}"


def function(formulas: Formulas) -> Callable[..., Array]:
    """The formulas as a function of their inputs, and of the parameters (default: the robot's), to an array."""
    check_type(formulas, Formulas, "formulas")
    names: dict[str, Any] = {}
    exec(compile(to_python(formulas, []), "<formulas>", "exec"), names)  # noqa: S102 -- text that to_python wrote
    compute = names[function_name(formulas)]
    return lambda *inputs: np.array(compute(*inputs), np.float64)


def check(formulas: Formulas, states: int = 5, seed: int = 0) -> Check:
    """Compare formulas with the core in random states of the robot and, if it matters, of its base."""
    check_type(formulas, Formulas, "formulas")
    count, rng = as_count(states, "states", 1, MOST_STATES), np.random.default_rng(as_count(seed, "seed", 0))
    compute, robot = function(formulas), Robot(formulas.spec)
    difference = largest = 0.0
    for _ in range(count):
        state = _state(formulas, rng)
        expected = _core(formulas, robot, state)
        difference = max(difference, float(np.max(np.abs(compute(*state.values()) - expected), initial=0.0)))
        largest = max(largest, float(np.max(np.abs(expected), initial=0.0)))
    return Check(count, difference, largest)


def _state(formulas: Formulas, rng: np.random.Generator) -> dict[str, Any]:
    state: dict[str, Any] = {}
    for one in formulas.inputs:
        values = rng.uniform(-SPREAD[one.name], SPREAD[one.name], len(one.symbols))
        if one.name == "q":
            values[np.array(sliding(formulas.spec))] /= 2.0 * np.pi
        is_magnitude = [symbol.name for symbol in one.symbols] == [one.name]
        state[one.name] = float(values[0]) if is_magnitude else values.tolist()
    return state


def _core(formulas: Formulas, robot: Robot, state: dict[str, Any]) -> Array:
    q = np.array(state["q"])
    match formulas.what:
        case "kinematics":
            return robot.forward_kinematics(q, formulas.frame)
        case "jacobian":
            return robot.jacobian(q, formulas.frame)
        case "gravity":
            return robot.gravity_torque(q, _field(formulas, state))
        case "regressor":
            return robot.gravity_regressor(q, _field(formulas, state))
    motion = q, np.array(state["qd"]), np.array(state["qdd"]), _base(formulas, state)
    if formulas.what == "inverse-dynamics":
        return robot.inverse_dynamics(*motion)
    return robot.inverse_dynamics_regressor(*motion)


def _field(formulas: Formulas, state: dict[str, Any]) -> Array:
    """The gravity field of a state: three numbers drawn, those of a level base, or the fixed ones."""
    if "g" not in state:
        return np.array(formulas.gravity)
    g = state["g"]
    return np.array(g if isinstance(g, list) else [0.0, 0.0, -g])


def _base(formulas: Formulas, state: dict[str, Any]) -> BaseMotion:
    if "f" not in state:
        return BaseMotion(specific_force=-_field(formulas, state))
    return BaseMotion(specific_force=state["f"], angular_velocity=state["w"], angular_acceleration=state["dw"])
