"""The count of unstable poles, and the poles, against polynomials, closed forms and numbers computed elsewhere."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from ravengc.stability import OneLink, Sensing, margins, poles, poles_right_of, rightmost_pole
from ravengc.stability.state_space import state_space
from stability_cases import EX1, links, random_system

theorem = settings(max_examples=40, deadline=None)


def closed_polynomial(link: OneLink) -> np.ndarray:
    """The numerator of D(s) without a delay, lowest power first, by multiplying polynomials out."""
    times = np.polynomial.polynomial.polymul
    p = link.sensing.polynomial
    joint = (link.kp, link.kd, link.inertia)
    base = times((link.stiffness, link.damping, link.total), times(joint, p))
    fed = np.polynomial.polynomial.polysub((link.sensing.gain,), p)
    return np.polynomial.polynomial.polyadd(base, link.coupling**2 * times((0.0, 0.0, 0.0, 0.0, 1.0), fed))


@given(links(delay=False))
@theorem
def test_without_a_delay_the_count_is_that_of_the_polynomials_roots(link: OneLink) -> None:
    roots = np.polynomial.polynomial.polyroots(closed_polynomial(link))
    if np.abs(roots.real).min() < 1e-6 * np.abs(roots).max():
        return  # on the axis as far as rounding can tell
    count = poles_right_of(link.system())
    assert count.proven
    assert count.number == (roots.real > 0.0).sum()
    assert rightmost_pole(link.system()).s.real == pytest.approx(roots.real.max(), rel=1e-6, abs=1e-8)


@given(st.integers(0, 10_000))
@theorem
def test_random_systems_without_a_delay_count_like_their_state_matrix(seed: int) -> None:
    """Any stiffness, damping and feedback, several signals: u = rho p closes the loop at once."""
    system = random_system(seed, delay=False)
    space = state_space(system)
    through = np.eye(len(space.d)) - system.sensing.gain * space.d
    closed = space.a + system.sensing.gain * space.b @ np.linalg.solve(through, space.c)
    values = np.linalg.eigvals(closed)
    if np.abs(values.real).min() < 1e-6 * np.abs(values).max() or np.linalg.cond(through) > 1e6:
        return
    count = poles_right_of(system)
    assert not count.proven or count.number == (values.real > 0.0).sum()
    assert count.proven or system.sensing.cutoff_hz is None  # a gain above 1 at all frequencies has no far end


@given(links(), st.floats(-0.5, 0.5))
@settings(max_examples=30, deadline=None)
def test_every_pole_that_is_found_is_counted(link: OneLink, shift: float) -> None:
    system = link.system()
    sigma = shift * link.w_base
    count = poles_right_of(system, sigma)
    if not math.isfinite(count.radius):
        return
    reach = np.append(0.0, np.geomspace(1e-2, count.radius, 30))
    found = poles(system, (sigma + reach[:8:2, None] + 1j * reach).ravel())
    if not count.proven or not len(found) or np.abs(found.real - sigma).min() < 1e-6 * link.w_base:
        return
    right = found[found.real > sigma]
    seen = (1 + (right.imag > 1e-9 * np.abs(right))).sum()  # a pair counts twice
    assert count.number >= seen


FAR_LEFT = OneLink(
    base_mass=0.25,
    base_frequency_hz=1.0,
    base_damping_ratio=0.25,
    mass=1.0,
    length=1.5,
    inertia=2.3203125,
    kp=91.60226584761061,
    kd=29.157906816130268,
    sensing=Sensing(rate_hz=None, latency_s=0.0625, cutoff_hz=16.0, order=1),
)
"""Where its response is 1e32, Newton's steps vanish in rounding."""


@given(links())
@example(FAR_LEFT)
@theorem
def test_poles_are_zeros_of_the_characteristic(link: OneLink) -> None:
    for s in poles(link.system()):
        scale = (
            abs(link.total * s * s)
            + abs(link.damping * s)
            + link.stiffness
            + abs(link.coupling**2 * s**4 * link.joint(s))
        )
        fed = abs(link.sensing.response(s))
        assert abs(link.characteristic(s)) < 1e-6 * scale * (1.0 + fed)


@given(links())
@theorem
def test_static_gravity_is_always_stable(link: OneLink) -> None:
    """With rho = 0 energy is only lost: a count of none, whatever the delay."""
    assert poles_right_of(link.with_(gain=0.0).system()).none


@given(links(), st.floats(0.1, 10.0), st.floats(0.1, 10.0), st.floats(0.2, 5.0))
@theorem
def test_scaling_masses_lengths_and_times_scales_the_poles(
    link: OneLink, heavier: float, longer: float, slower: float
) -> None:
    """Masses times a, the link's length times b, all times times c: the poles are those divided by c."""
    sensing = link.sensing
    cutoff = None if sensing.cutoff_hz is None else sensing.cutoff_hz / slower
    moment = heavier * longer**2
    other = link.with_(
        base_mass=link.base_mass * heavier,
        mass=link.mass * heavier,
        length=link.length * longer,
        inertia=link.inertia * moment,
        kp=link.kp * moment / slower**2,
        kd=link.kd * moment / slower,
        base_frequency_hz=link.base_frequency_hz / slower,
        latency_s=sensing.delay_s * slower,
        rate_hz=None,
        cutoff_hz=cutoff,
    )
    one, two = rightmost_pole(link.system()), rightmost_pole(other.system())
    if one.proven and two.proven:
        assert two.s * slower == pytest.approx(one.s, rel=1e-5, abs=1e-7 * link.w_base)
    assert poles_right_of(link.system()).number == pytest.approx(poles_right_of(other.system()).number, nan_ok=True)


@given(links())
@settings(max_examples=15, deadline=None)
def test_the_count_changes_at_every_critical_gain_and_nowhere_else(link: OneLink) -> None:
    system = link.system()
    critical = [gain for gain in margins(system).critical_gains if gain * link.sensing.gain < 50.0]
    for gain in critical[:3]:
        below, above = (
            poles_right_of(system.sensed(gain=link.sensing.gain * gain * side)).number for side in (0.998, 1.002)
        )
        assert above != below
    first = critical[0] * link.sensing.gain if critical else 50.0
    for share in (0.1, 0.5, 0.99):
        assert poles_right_of(system.sensed(gain=first * share)).none


@pytest.mark.parametrize("delay", [1e-4, 1e-3, 0.05])
def test_a_high_frequency_gain_above_one_is_unstable_for_any_delay(delay: float) -> None:
    """m / M_b = 1.33 for a point mass, no low-pass: a chain of unstable poles; behind a low-pass, finitely many."""
    link = EX1.with_(mass=13.3, inertia=13.3 * 0.4**2, latency_s=delay, cutoff_hz=None)
    assert link.high_frequency_gain == pytest.approx(1.33)
    count = poles_right_of(link.system())
    assert (count.number, count.proven) == (math.inf, True)
    assert math.isfinite(poles_right_of(link.with_(cutoff_hz=50.0).system()).number)
    assert poles_right_of(link.with_(gain=0.7).system()).number < math.inf  # rho mu / (1 - mu) = 0.93


def test_a_pole_on_the_axis_is_not_certified() -> None:
    system = replace(EX1.system(), damping=np.diag((0.0, 3.0)), inputs=np.zeros((2, 1)), mass=np.diag((12.0, 0.37)))
    count = poles_right_of(system)
    assert not count.proven
    assert not count.none


def test_right_of_the_filters_pole_only() -> None:
    system = EX1.system()
    assert math.isnan(poles_right_of(system, EX1.sensing.rightmost_filter_pole - 1.0).number)
    assert poles_right_of(system, EX1.sensing.rightmost_filter_pole + 1.0).proven


def test_a_double_pole_counts_twice() -> None:
    """Two equal bases side by side, each with its own arm."""
    one = EX1.system()
    twice = replace(
        one,
        **{name: np.kron(np.eye(2), getattr(one, name)) for name in (
            "mass", "damping", "stiffness", "inputs", "reads_acceleration", "reads_position")},
    )  # fmt: skip
    assert poles_right_of(one).number == 2
    assert poles_right_of(twice).number == 4


@pytest.mark.parametrize("hz", [5.0, 20.0, 80.0])
def test_the_low_pass_is_the_chains_own(hz: float) -> None:
    """|H| of the core's Butterworth, 1 / sqrt(1 + (f / f_c)^4), and half its power at f_c."""
    sensing = Sensing(rate_hz=None, cutoff_hz=hz)
    for f in (0.3 * hz, hz, 4.0 * hz):
        assert abs(sensing.response(2j * math.pi * f)) == pytest.approx(1.0 / math.sqrt(1.0 + (f / hz) ** 4))
