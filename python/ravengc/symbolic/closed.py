"""Formulas written out: one line per torque, in the form of a textbook.

Everything is multiplied out into terms of parameters times sines and cosines, equal terms meet, and what multiplies the
same parameters is drawn together. Joints with parallel axes turn in one plane: products of their sines and cosines
become those of sums of angles, cos(q1) cos(q2) - sin(q1) sin(q2) = cos(q1 + q2), which is unique, so everything that
can cancel does. Elsewhere sin² becomes 1 - cos², which is unique too.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from math import prod
from typing import TYPE_CHECKING

from ravengc.symbolic.algebra import Expr, engine, product
from ravengc.symbolic.mechanism import coordinates

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping

    from ravengc.spec import RobotSpec
    from ravengc.symbolic.mechanism import Mechanism

__all__ = ["Planes", "planes", "term_count", "written_out"]

NOISE = 1e-13
"""Coefficients below this share of the largest are what rounding left of zero."""

Terms = dict[Expr, Expr]
"""A sum: products without a number, and the number that multiplies each."""

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
    outputs: list[Expr], defined: Mapping[Expr, Expr], atoms: Collection[Expr], known: Collection[Expr], plane: Planes
) -> list[Expr]:
    """The outputs without steps. ``known`` are the parameters; ``atoms`` stay as they are until the last line."""
    sp, whole = engine(), dict[Expr, Expr]()
    for symbol, expression in defined.items():
        whole[symbol] = symbol if symbol in atoms else sp.expand(expression.xreplace(whole))
    kept = {symbol: defined[symbol] for symbol in atoms}
    fixed = {*known, *kept}
    return [_tidy(_terms(sp.expand(output.xreplace(whole)), plane), fixed).xreplace(kept) for output in outputs]


def _terms(expression: Expr, plane: Planes) -> Terms:
    """A sum as products and numbers, sines and cosines in their unique form, without what rounding left."""
    sp, total = engine(), defaultdict[Expr, Expr](lambda: engine().Integer(0))
    for term in sp.Add.make_args(expression):
        for number, rest in _unique(term, plane):
            total[rest] += number
    largest = max((abs(number) for number in total.values()), default=0)
    return {rest: _short(number) for rest, number in total.items() if abs(number) > NOISE * largest}


def _short(number: Expr) -> Expr:
    """A number without the rounding of the directions that it is made of."""
    if number.is_Integer or number.q < 10**12:
        return number
    value = float(number)
    short = float(f"{value:.12g}")
    return engine().Rational(repr(short if abs(short - value) <= 4e-15 * abs(value) else value))


def _unique(term: Expr, plane: Planes) -> list[tuple[Expr, Expr]]:
    """A product as numbers and products in which sines and cosines of each plane stand in their unique form."""
    sp = engine()
    number, rest = term.as_coeff_Mul()
    waves: dict[int | None, list[Expr]] = defaultdict(list)
    for factor in sp.Mul.make_args(rest):
        base, power = factor.as_base_exp()
        if base.func not in {sp.sin, sp.cos}:
            waves[None].append(factor)
        else:
            symbol = next(iter(base.free_symbols))
            waves[plane.of[symbol]].extend([base] * int(power))
    sums = [(number, sp.Mul(*waves.pop(None, [])))]
    for where, factors in waves.items():
        unique = _summed(factors) if where in plane.shared else _without_squares(factors)
        sums = [(a * b, first * second) for a, first in sums for b, second in unique]
    return sums


def _summed(factors: list[Expr]) -> list[tuple[Expr, Expr]]:
    """A product of sines and cosines as a sum of them: 2 cos a cos b = cos(a - b) + cos(a + b), and so on."""
    sp = engine()
    sums = [(sp.Integer(1), sp.cos, sp.Integer(0))]
    for factor in factors:
        sums = [wave for number, kind, a in sums for wave in _product(number / 2, kind, a, factor)]
    return [kind(a).as_coeff_Mul() if n == 1 else _scaled(n, kind(a)) for n, kind, a in sums]


def _product(half: Expr, kind: Expr, a: Expr, factor: Expr) -> list[tuple[Expr, Expr, Expr]]:
    sp, b = engine(), factor.args[0]
    even = kind is factor.func
    sign = -1 if factor.func is sp.sin else 1
    wave = sp.cos if even else sp.sin
    if kind is sp.sin and factor.func is sp.cos:
        return [(half, wave, a + b), (half, wave, a - b)]
    if kind is sp.cos and factor.func is sp.sin:
        return [(half, wave, a + b), (-half, wave, a - b)]
    return [(half, wave, a - b), (sign * half, wave, a + b)]


def _scaled(number: Expr, wave: Expr) -> tuple[Expr, Expr]:
    """sin(-a) is -sin(a), and cos(0) is 1: the number takes what is no wave."""
    factor, rest = wave.as_coeff_Mul()
    return number * factor, rest


def _without_squares(factors: list[Expr]) -> list[tuple[Expr, Expr]]:
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


def _tidy(terms: Terms, known: Collection[Expr]) -> Expr:
    """The sum with what multiplies the same combination of parameters drawn together."""
    sp = engine()
    by_state: dict[Expr, Terms] = defaultdict(dict)
    for rest, number in terms.items():
        parameters, state = _split(rest, known)
        by_state[state][parameters] = number
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


def _split(rest: Expr, known: Collection[Expr]) -> tuple[Expr, Expr]:
    """Parameters and the others of a product."""
    sp = engine()
    parameters: list[Expr] = []
    others: list[Expr] = []
    for factor in sp.Mul.make_args(rest):
        (parameters if factor.free_symbols and factor.free_symbols <= known else others).append(factor)
    return sp.Mul(*parameters), sp.Mul(*others)


def _combined(key: _Key, scale: Expr) -> Expr:
    """A combination of parameters, masses before brackets."""
    sp = engine()
    total = sp.Add(*(_short(number * scale) * parameters for parameters, number in key))
    masses = [symbol for symbol in total.free_symbols if symbol.name.startswith("m")]
    return sp.collect(total, sorted(masses, key=sp.default_sort_key))
