"""From a robot to its formulas."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from ravengc._convert import as_number, as_vector, check_choice, check_type
from ravengc.config import validate
from ravengc.coordinates import sliding
from ravengc.errors import ArgumentError, ConfigError
from ravengc.messages import kind_of
from ravengc.spec import RobotSpec
from ravengc.symbolic.algebra import Expr, Triple, engine, scaled
from ravengc.symbolic.closed import planes, term_count, written_out
from ravengc.symbolic.formulas import FORMS, QUANTITIES, Form, Formulas, Input, Quantity
from ravengc.symbolic.kinematics import jacobian, pose
from ravengc.symbolic.mechanism import Mechanism, coordinates, place, vector, with_right_angles
from ravengc.symbolic.parameters import Inertial, inertials, regressor_columns
from ravengc.symbolic.recursions import BaseMotion, gravity_torques, inverse_dynamics
from ravengc.symbolic.regressors import dynamics_regressor, gravity_regressor
from ravengc.symbolic.steps import Steps, needed, pruned

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

__all__ = ["formulas"]

MOST_TERMS, MOST_OPERATIONS = 8_000, 1_000
"""Where nobody reads a formula that is written out: its terms before equal ones meet, its operations afterwards."""

LIMIT_OF_TERMS = 300_000
"""Terms that take minutes to multiply out."""

MOST_ROUNDING = 0.1
"""Farther from a right angle (rad), an angle was meant."""

RESULTS: dict[Quantity, str] = {
    "gravity": "tau",
    "kinematics": "T",
    "jacobian": "J",
    "regressor": "Y",
    "inverse-dynamics": "tau",
    "inverse-dynamics-regressor": "Y",
}
FIELD = ("gravity field in base axes, m/s^2",)
REST = ("specific force f = a - g of the base's origin, base axes, m/s^2",)
SPIN = ("angular velocity of the base, base axes, rad/s",)
SPIN_UP = ("angular acceleration of the base, base axes, rad/s^2",)


@dataclass(frozen=True, slots=True)
class _Around:
    """What surrounds the arm: the gravity field, the base's motion, and the arguments that they are made of."""

    gravity: Triple
    base: BaseMotion
    inputs: tuple[Input, ...]


@dataclass(frozen=True, slots=True)
class _Arm:
    """The arm in symbols, and the steps in which everything is computed."""

    mechanism: Mechanism
    bodies: list[Inertial]
    rates: list[Expr]
    accelerations: list[Expr]
    steps: Steps


def formulas(
    spec: RobotSpec,
    what: Quantity = "gravity",
    *,
    numbers: bool = False,
    lengths: bool = False,
    right_angles: float = 0.0,
    gravity: Literal["vector", "level"] | Sequence[float] = "vector",
    moving_base: bool = False,
    frame: str = "tool",
    form: Form = "auto",
    on_progress: Callable[[str], None] | None = None,
) -> Formulas:
    """Derive the formulas of a robot: ``what`` is one of :data:`QUANTITIES`.

    Masses, centres of mass and inertias that are not zero are symbols, or with ``numbers`` the numbers of the robot;
    ``lengths`` keeps a and d of Denavit-Hartenberg rows as symbols. Angles of rows that are within ``right_angles``
    (rad, at most 0.1) of a multiple of a right angle become that, as files round them. ``gravity`` is the field in base
    axes B: three symbols, (0, 0, -g) for a level base, or three numbers (m/s²). ``moving_base`` takes the specific
    force, angular velocity and acceleration of the base instead (inverse dynamics). ``frame`` is that of kinematics and
    Jacobian.

    ``form`` "closed" writes everything out in one line each, "steps" names what is used more than once, "auto" is
    closed where that is short. ``on_progress`` hears what is being done. Raises ArgumentError for a wrong argument,
    ConfigError for a closed form of more than 300,000 terms, MissingExtraError without SymPy.
    """
    _check(spec, what, frame, form)
    for name, flag in (("numbers", numbers), ("lengths", lengths), ("moving_base", moving_base)):
        check_type(flag, bool, name)
    if on_progress is not None and not callable(on_progress):
        raise ArgumentError(f"on_progress is {kind_of(on_progress)}; expected a function of a text, or None")
    spec = with_right_angles(spec, _tolerance(right_angles))
    around, say = _around(gravity, what, moving_base=moving_base), on_progress or _silent
    say("following the links")
    steps = Steps()
    mechanism = place(spec, symbolic_lengths=lengths)
    bodies, values = inertials(spec, mechanism, steps, numbers=numbers)
    arm = _Arm(mechanism, bodies, _of_joints(spec, mechanism, "qd"), _of_joints(spec, mechanism, "qdd"), steps)
    rows = _rows(arm, what, frame, around)
    entries = [entry for row in rows for entry in row]
    known = values | mechanism.lengths
    steps_left, entries = _formed(spec, arm, entries, known, form, say)
    columns = regressor_columns(mechanism, inertia=what.startswith("inverse")) if RESULTS[what] == "Y" else ()
    used = set().union(*(expression.free_symbols for expression in (*steps_left.values(), *entries)))
    return Formulas(
        spec=spec,
        what=what,
        frame=frame,
        inputs=_inputs(spec, what, around),
        parameters={symbol: value for symbol, value in known.items() if symbol in used},
        steps=steps_left,
        name=RESULTS[what],
        shape=(len(rows),) if RESULTS[what] == "tau" else (len(rows), len(rows[0])),
        entries=tuple(entries),
        columns=columns,
        right_angles=float(right_angles),
        gravity=None if around.inputs else tuple(map(float, around.gravity)),
    )


def _check(spec: RobotSpec, what: str, frame: str, form: str) -> None:
    check_type(spec, RobotSpec, "spec")
    validate(spec)
    check_choice(what, QUANTITIES, "what", ArgumentError)
    check_choice(form, FORMS, "form", ArgumentError)
    check_choice(frame, ("base", *(link.name for link in spec.links), "tool"), "frame", ArgumentError)


def _tolerance(right_angles: object) -> float:
    tolerance = as_number(right_angles, "right_angles")
    if not 0.0 <= tolerance <= MOST_ROUNDING:
        raise ArgumentError(f"right_angles is {tolerance:g}; expected an angle from 0 to {MOST_ROUNDING:g} rad")
    return tolerance


def _silent(_: str) -> None:
    """Nobody listens."""


def _around(gravity: object, what: str, *, moving_base: bool) -> _Around:
    symbols = engine().symbols
    still = vector((0.0, 0.0, 0.0))
    if moving_base:
        if not what.startswith("inverse") or not (isinstance(gravity, str) and gravity == "vector"):
            raise ArgumentError("moving_base is for inverse dynamics, and f = a - g then has gravity in it")
        f, w, dw = (symbols(f"{letter}x {letter}y {letter}z") for letter in ("f", "w", "dw"))
        moves = Input("f", f, REST), Input("w", w, SPIN), Input("dw", dw, SPIN_UP)
        return _Around(scaled(f, -1), BaseMotion(f, w, dw), moves)
    field, inputs = _field(gravity)
    return _Around(field, BaseMotion(scaled(field, -1), still, still), inputs)


def _field(gravity: object) -> tuple[Triple, tuple[Input, ...]]:
    symbols, zero = engine().symbols, engine().Integer(0)
    if not isinstance(gravity, str):
        return vector(as_vector(gravity, "gravity", 3, 1e4)), ()
    check_choice(gravity, ("vector", "level"), "gravity", ArgumentError)
    if gravity == "level":
        g = engine().Symbol("g")
        return (zero, zero, -g), (Input("g", (g,), ("gravity on a level base, along -z of base axes, m/s^2",)),)
    field = symbols("gx gy gz")
    return field, (Input("g", field, FIELD),)


def _of_joints(spec: RobotSpec, mechanism: Mechanism, letter: str) -> list[Expr]:
    """Rates of the mechanism's joints from those of the coordinates."""
    rates, zero = coordinates(spec, letter), engine().Integer(0)
    return [sum((c * rate for c, rate in zip(row, rates, strict=True)), zero) for row in mechanism.coupling]


def _rows(arm: _Arm, what: Quantity, frame: str, around: _Around) -> list[list[Expr]]:
    mechanism, steps = arm.mechanism, arm.steps
    moves = around.base, arm.rates, arm.accelerations, steps
    match what:
        case "gravity":
            return [[tau] for tau in gravity_torques(mechanism, arm.bodies, around.gravity, steps)]
        case "inverse-dynamics":
            return [[tau] for tau in inverse_dynamics(mechanism, arm.bodies, *moves)]
        case "regressor":
            return gravity_regressor(mechanism, around.gravity, steps)
        case "inverse-dynamics-regressor":
            return dynamics_regressor(mechanism, *moves)
        case "kinematics":
            return pose(mechanism, frame, steps)
        case "jacobian":
            return jacobian(mechanism, frame, steps)


def _inputs(spec: RobotSpec, what: Quantity, around: _Around) -> tuple[Input, ...]:
    slides = sliding(spec)

    def moving(letter: str, per: str) -> Input:
        units = ("m" if slide else "rad" for slide in slides)
        meaning = tuple(f"{name}, {unit}{per}" for name, unit in zip(spec.coordinate_names, units, strict=True))
        return Input(letter, coordinates(spec, letter), meaning)

    if what in {"kinematics", "jacobian"}:
        return (moving("q", ""),)
    if what.startswith("inverse"):
        return moving("q", ""), moving("qd", "/s"), moving("qdd", "/s^2"), *around.inputs
    return moving("q", ""), *around.inputs


def _formed(
    spec: RobotSpec, arm: _Arm, entries: list[Expr], known: dict[Expr, float], form: Form, say: Callable[[str], None]
) -> tuple[dict[Expr, Expr], list[Expr]]:
    """Steps and entries, or entries alone where they are wanted or short enough written out."""
    defined = needed(arm.steps.defined, entries)
    terms = term_count(defined, entries) if form != "steps" else 0
    if form == "closed" and terms > LIMIT_OF_TERMS:
        raise ConfigError(f"form='closed' would have up to {float(terms):.2g} terms; choose 'steps' or 'auto'")
    if form == "closed" or (form == "auto" and terms <= MOST_TERMS):
        say(f"multiplying out up to {terms} terms")
        closed = written_out(entries, defined, arm.steps.atoms & defined.keys(), known, planes(spec, arm.mechanism))
        if form == "closed" or sum(entry.count_ops() for entry in closed) <= MOST_OPERATIONS:
            return {}, closed
    say("naming what is used more than once")
    return pruned(defined, entries)
