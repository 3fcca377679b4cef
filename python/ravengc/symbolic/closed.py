"""Formulas written out: one line per torque, in the form of a textbook.

Everything is multiplied out into terms of parameters times sines and cosines, equal terms meet, and what multiplies the
same parameters is drawn together. Joints with parallel axes turn in one plane: products of their sines and cosines
become those of sums of angles, cos(q1) cos(q2) - sin(q1) sin(q2) = cos(q1 + q2), which is unique, so everything that
can cancel does. Elsewhere sin² becomes 1 - cos², which is unique too.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from functools import reduce
from math import prod
from operator import add, mul
from typing import TYPE_CHECKING

from ravengc.symbolic.algebra import Expr, cosine, engine, exact, product
from ravengc.symbolic.mechanism import coordinates

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping, Sequence

    from ravengc.spec import RobotSpec
    from ravengc.symbolic.mechanism import Mechanism

__all__ = ["Planes", "planes", "term_count", "written_out"]

NOISE = 1e-13
"""Coefficients below this share of the largest are what rounding left of zero."""

Terms = dict[Expr, Expr]
"""A sum: products without a number, and the number that multiplies each."""

Sum = list[tuple[Expr, Expr]]
"""A sum as numbers and what they multiply."""

_Powers = tuple[tuple[int, int], ...]
"""A product: which variable, to which power."""

_Key = frozenset[tuple[Expr, Expr]]
"""A combination of parameters up to a factor."""


@dataclass(frozen=True, slots=True)
class Planes:
    """Which coordinates turn links in one plane: ``of`` gives their number, ``shared`` those of several joints."""

    of: Mapping[Expr, int]
    shared: Collection[int]


def planes(spec: RobotSpec, mechanism: Mechanism) -> Planes:
    """Coordinates whose joints have parallel axes on the way out, or that one joint adds up."""
    plane = {q: number for number, q in enumerate(coordinates(spec))}
    motions: dict[int, set[Expr]] = defaultdict(set)

    def unite(symbols: Iterable[Expr]) -> None:
        numbers = {plane[symbol] for symbol in symbols if symbol in plane}
        for symbol, number in plane.items():
            plane[symbol] = min(numbers) if number in numbers else number

    for index, body in enumerate(mechanism.bodies):
        if body.turns:
            unite(body.motion.free_symbols)
            unite(_parallel(mechanism, index))
    for body in mechanism.bodies:
        for symbol in body.motion.free_symbols & plane.keys() if body.turns else ():
            motions[plane[symbol]].add(body.motion)
    return Planes(plane, {number for number, angles in motions.items() if len(angles) > 1})


def _parallel(mechanism: Mechanism, index: int) -> set[Expr]:
    """Coordinates of a turning joint, and of the next turning joint inward if its axis is parallel."""
    body = mechanism.bodies[index]
    turn, parent = body.joint.rotation, body.parent
    while parent is not None and not mechanism.bodies[parent].turns:
        turn = product(mechanism.bodies[parent].joint.rotation, turn)
        parent = mechanism.bodies[parent].parent
    own: set[Expr] = set(body.motion.free_symbols)
    parallel = parent is not None and abs(turn[2][2]) == 1
    return own | mechanism.bodies[parent].motion.free_symbols if parallel and parent is not None else own


def term_count(defined: Mapping[Expr, Expr], outputs: Iterable[Expr]) -> int:
    """How many terms the outputs would have if they were multiplied out; an upper bound, without doing it."""
    counts: dict[Expr, int] = {}

    def count(expression: Expr) -> int:
        if expression.is_Add:
            return sum(map(count, expression.args))
        if expression.is_Mul:
            return prod(map(count, expression.args))
        if expression.is_Pow:
            return int(count(expression.args[0]) ** int(expression.args[1]))
        return counts.get(expression, 1)

    for symbol, expression in defined.items():
        counts[symbol] = count(expression)
    return sum(map(count, outputs))


def written_out(
    outputs: Sequence[Expr],
    defined: Mapping[Expr, Expr],
    atoms: Collection[Expr],
    known: Collection[Expr],
    plane: Planes,
) -> list[Expr]:
    """The outputs without steps. ``known`` are the parameters; ``atoms`` stay as they are until the last line."""
    polynomials = _Polynomials([*defined.values(), *outputs], {symbol for symbol in defined if symbol not in atoms})
    for symbol, expression in defined.items():
        if symbol not in atoms:
            polynomials.define(symbol, expression)
    kept = {symbol: defined[symbol] for symbol in atoms}
    sorting = _Sorting(polynomials.variables, {*known, *kept}, plane)
    return [_tidy(sorting.by_state(polynomials.of(output))).xreplace(kept) for output in outputs]


class _Polynomials:
    """Expressions as polynomials in symbols, sines and cosines, which multiply out faster than expressions do."""

    def __init__(self, expressions: Iterable[Expr], defined: Collection[Expr]) -> None:
        sp = engine()
        found: dict[Expr, None] = {}
        for expression in expressions:
            _find(expression, found)
        self.variables = [one for one in found if one not in defined]
        names = [f"v{k}" for k in range(len(self.variables))] or ["v0"]
        ring, *generators = sp.ring(names, sp.QQ)
        self._known = dict(zip(self.variables, generators, strict=False))
        self._ring = ring

    def define(self, symbol: Expr, expression: Expr) -> None:
        """Let a symbol stand for an expression from now on."""
        self._known[symbol] = self.of(expression)

    def of(self, expression: Expr) -> Expr:
        """An expression, multiplied out."""
        if (known := self._known.get(expression)) is not None:
            return known
        if expression.is_Rational:
            return self._ring(engine().QQ(int(expression.p), int(expression.q)))
        if expression.is_Pow:
            return self.of(expression.args[0]) ** int(expression.args[1])
        parts = map(self.of, expression.args)
        return reduce(add if expression.is_Add else mul, parts)


def _find(expression: Expr, found: dict[Expr, None]) -> None:
    """Symbols, sines and cosines in the order in which they are met; the angles of waves do not count."""
    if expression.is_Symbol or expression.is_Function:
        found[expression] = None
        return
    for part in expression.args:
        _find(part, found)


class _Sorting:
    """The terms of polynomials, sorted by what they say of the robot's state."""

    def __init__(self, variables: Sequence[Expr], known: Collection[Expr], plane: Planes) -> None:
        self._variables, self._plane = variables, plane
        self._kinds = [0 if one in known else 2 if one.is_Function else 1 for one in variables]
        self._unique: dict[_Powers, Sum] = {}

    def by_state(self, polynomial: Expr) -> dict[Expr, Terms]:
        """Numbers by state and parameters, waves in their unique form, without what rounding left of zero."""
        sp = engine()
        total: dict[tuple[_Powers, Expr, _Powers], Expr] = defaultdict(lambda: sp.QQ(0))
        for powers, number in polynomial.items():
            parts: list[_Powers] = [(), (), ()]
            for k, power in enumerate(powers):
                if power:
                    parts[self._kinds[k]] += ((k, power),)
            for share, wave in self._waves(parts[2]):
                total[parts[1], wave, parts[0]] += number * sp.QQ(int(share.p), int(share.q))
        largest = max(map(abs, total.values()), default=0)
        found: dict[Expr, Terms] = defaultdict(dict)
        for (state, wave, parameters), number in total.items():
            if abs(float(number)) > NOISE * float(largest):
                exact_number = sp.Rational(int(number.numerator), int(number.denominator))
                found[self._product(state) * wave][self._product(parameters)] = _short(exact_number)
        return found

    def _product(self, powers: _Powers) -> Expr:
        return engine().Mul(*(self._variables[k] ** power for k, power in powers))

    def _waves(self, powers: _Powers) -> Sum:
        """A product of sines and cosines as a sum of those that are unique."""
        if powers in self._unique:
            return self._unique[powers]
        factors: dict[int, list[Expr]] = defaultdict(list)
        for k, power in powers:
            wave = self._variables[k]
            factors[self._plane.of[next(iter(wave.free_symbols))]] += [wave] * power
        sums: Sum = [(engine().Integer(1), engine().Integer(1))]
        for where, waves in factors.items():
            unique = _summed(waves) if where in self._plane.shared else _without_squares(waves)
            sums = [(a * b, first * second) for a, first in sums for b, second in unique]
        self._unique[powers] = sums
        return sums


def _short(number: Expr) -> Expr:
    """A number without the rounding of the directions that it is made of."""
    if number.is_Integer or number.q < 10**12:
        return number
    value = float(number)
    short = float(f"{value:.12g}")
    return engine().Rational(repr(short if abs(short - value) <= 4e-15 * abs(value) else value))


def _summed(factors: list[Expr]) -> Sum:
    """A product of sines and cosines as a sum of them: 2 cos a cos b = cos(a - b) + cos(a + b), and so on."""
    sp = engine()
    waves = [(sp.Integer(1), sp.cos, sp.Integer(0))]
    for factor in factors:
        waves = [wave for number, kind, a in waves for wave in _product(number / 2, kind, a, factor)]
    return [(number * share, wave) for number, kind, a in waves for share, wave in [_wave(kind, a)]]


def _wave(kind: Expr, a: Expr) -> tuple[Expr, Expr]:
    """A sine or cosine as a number times a wave: sin(-a) is -sin(a), and without a coordinate it is a number."""
    if not a.free_symbols:
        return exact(cosine(float(kind(a)))), engine().Integer(1)
    number, wave = kind(a).as_coeff_Mul()
    return number, wave


def _product(half: Expr, kind: Expr, a: Expr, factor: Expr) -> list[tuple[Expr, Expr, Expr]]:
    """Half a number times twice a wave of a times another, as two waves."""
    sp, b = engine(), factor.args[0]
    match kind is sp.sin, factor.func is sp.sin:
        case True, True:
            return [(half, sp.cos, a - b), (-half, sp.cos, a + b)]
        case True, False:
            return [(half, sp.sin, a + b), (half, sp.sin, a - b)]
        case False, True:
            return [(half, sp.sin, a + b), (-half, sp.sin, a - b)]
        case _:
            return [(half, sp.cos, a - b), (half, sp.cos, a + b)]


def _without_squares(factors: list[Expr]) -> Sum:
    """sin² = 1 - cos² in a product of sines and cosines of one angle."""
    sp = engine()
    product_of_all = sp.Mul(*factors)
    powers = {base: int(power) for base, power in product_of_all.as_powers_dict().items()}
    base = next((base for base in powers if base.func is sp.sin and powers[base] > 1), None)
    if base is None:
        return [(sp.Integer(1), product_of_all)]
    power = powers[base]
    rest = product_of_all / base ** (2 * (power // 2))
    expanded = sp.expand(rest * (1 - sp.cos(base.args[0]) ** 2) ** (power // 2))
    return [term.as_coeff_Mul() for term in sp.Add.make_args(expanded)]


def _tidy(by_state: dict[Expr, Terms]) -> Expr:
    """The sum with what multiplies the same combination of parameters drawn together."""
    sp = engine()
    drawn: dict[_Key, tuple[Expr, Terms]] = {}
    for state, combination in by_state.items():
        lead = combination[min(combination, key=sp.default_sort_key)]
        key = frozenset((one, number / lead) for one, number in combination.items())
        drawn.setdefault(key, (abs(lead), {}))[1][state] = lead
    return sp.Add(*(_bracketed(key, scale, states) for key, (scale, states) in drawn.items()))


def _bracketed(key: _Key, scale: Expr, states: Terms) -> Expr:
    """Parameters times states; what all states share stands with the parameters, or before the bracket."""
    sp = engine()
    if len(key) == 1 and any(abs(number) != scale for number in states.values()):
        scale = sp.Integer(1)
    shared = set.intersection(*(set(sp.Mul.make_args(state)) for state in states)) - {sp.Integer(1)}
    common = sp.Mul(*shared)
    inside = sp.Add(*(_short(number / scale) * (state / common) for state, number in states.items()))
    return _combined(key, scale) * common * inside


def _combined(key: _Key, scale: Expr) -> Expr:
    """A combination of parameters, masses before brackets."""
    sp = engine()
    total = sp.Add(*(_short(number * scale) * parameters for parameters, number in key))
    masses = [symbol for symbol in total.free_symbols if symbol.name.startswith("m")]
    return sp.collect(total, sorted(masses, key=sp.default_sort_key))
