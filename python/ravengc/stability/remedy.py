"""What to change so that the certificate is given, each with the number at which it is: searched, not estimated.

Every remedy changes one thing. Its ``value`` is the least change after which the count of unstable poles is proven to
be zero; None says that this alone does not do it within its range.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import check_type
from ravengc.stability.counting import poles_right_of
from ravengc.stability.loop_margins import margins
from ravengc.stability.state_space import pade_poles
from ravengc.stability.system import System

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

__all__ = ["Remedy", "remedies", "with_own_reaction_removed", "with_stiffer_joints"]

STIFFEST = 10.0
"""Largest factor on the natural frequency of the joints that is proposed."""
MOST_DAMPING = 100.0
QUICKEST = 30.0
FASTEST_HZ = 10_000.0
PRECISION = 1e-5
NUDGE = 1e-5
"""How much further, relative, a value is taken than where the approximation has the limit."""
LARGEST_ERROR = 0.5
"""Errors of the base's model up to this share are tried."""


@dataclass(frozen=True, slots=True)
class Remedy:
    """One change: its ``name``, the ``value`` (None: does not help alone) in ``unit``, and what it means in words."""

    name: str
    value: float | None
    unit: str
    text: str


def remedies(system: System) -> tuple[Remedy, ...]:
    """Search every remedy for a system without a certificate; () for one that has it."""
    check_type(system, System, "system")
    if poles_right_of(system).none:
        return ()
    return tuple(_all(system))


def with_stiffer_joints(system: System, factor: float) -> System:
    """The same with the joints' natural frequencies times ``factor``: K_P times its square, K_D times it."""
    joints = slice(system.base, None)
    damping, stiffness = system.damping.copy(), system.stiffness.copy()
    damping[joints, joints] *= factor
    stiffness[joints, joints] *= factor**2
    return replace(system, damping=damping, stiffness=stiffness)


def with_own_reaction_removed(system: System, error: float = 0.0) -> System:
    """The same, fed with what the sensor reads minus what the arm's own reaction moves by a model of the base.

    The model, driven by the joints' motion, has the base's mass and damping, and its stiffness times 1 + ``error``.
    """
    m, n = system.base, system.size
    model = {"mass": 1.0, "damping": 1.0, "stiffness": 1.0 + error}
    changed: dict[str, Any] = {}
    for name, factor in model.items():
        own = getattr(system, name)
        grown = np.zeros((n + m, n + m))
        grown[:n, :n] = own
        grown[n:, m:n] = own[:m, m:]
        grown[n:, n:] = factor * own[:m, :m]
        changed[name] = grown
    return replace(
        system,
        **changed,
        inputs=np.vstack([system.inputs, np.zeros((m, system.inputs.shape[1]))]),
        turns=system.turns + system.turns[:m],
        reads_acceleration=_minus_model(system.reads_acceleration, m),
        reads_position=_minus_model(system.reads_position, m),
    )


def _minus_model(reads: NDArray[np.float64], m: int) -> NDArray[np.float64]:
    return np.hstack([reads, -reads[:, :m]])


def _all(system: System) -> Iterator[Remedy]:
    yield _stiffer(system)
    sensing = system.sensing
    parts = ((_sooner, sensing.latency_s), (_faster, sensing.rate_hz), (_wider, sensing.cutoff_hz))
    chain = [search(system) for search, there in parts if there]
    yield from chain
    if len(chain) > 1 and all(remedy.value is None for remedy in chain):
        yield _all_of_the_chain(system)
    yield _less(system)
    yield _damped(system)
    yield _own_reaction(system)


def _stiffer(system: System) -> Remedy:
    factor = _least(lambda x: with_stiffer_joints(system, x), np.geomspace(1.0, STIFFEST, 25))
    if factor is None:
        return Remedy("joint stiffness", None, "", f"stiffer joints do not help up to {STIFFEST:g} times the frequency")
    gains = np.diag(system.stiffness)[system.base :] * factor**2
    shown = _with_units(gains, system.turns[system.base :], turning="N m/rad", sliding="N/m")
    text = f"raise the joints' natural frequency {factor:.3g} times: K_P at least {shown} (K_D {factor:.3g} times)"
    return Remedy("joint stiffness", factor, "times the frequency", text)


def _sooner(system: System) -> Remedy:
    latency = system.sensing.latency_s
    value = _least(lambda x: system.sensed(latency_s=x), latency * np.linspace(1.0, 0.0, 25))
    if value is None:
        return Remedy("latency", None, "s", "no latency would still be too late")
    return Remedy("latency", value, "s", f"bring the latency below {1e3 * value:.4g} ms (now {1e3 * latency:.4g})")


def _faster(system: System) -> Remedy:
    rate = system.sensing.rate_hz or math.nan
    value = _least(lambda x: system.sensed(rate_hz=x), np.geomspace(rate, max(FASTEST_HZ, rate), 20))
    if value is None:
        return Remedy("sample rate", None, "Hz", "a faster sensor alone does not help")
    return Remedy("sample rate", value, "Hz", f"sample faster than {value:.4g} Hz (now {rate:.4g})")


def _wider(system: System) -> Remedy:
    now = system.sensing.cutoff_hz or math.nan
    rate = system.sensing.rate_hz
    top = FASTEST_HZ if rate is None else max(rate / 2.0, now)
    value = _least(lambda x: system.sensed(cutoff_hz=x), np.geomspace(now, top, 40))
    if value is None:
        text = f"a higher cut-off alone does not help (now {now:.4g} Hz, at most {top:.4g})"
        return Remedy("cut-off", None, "Hz", text)
    return Remedy("cut-off", value, "Hz", f"raise the low-pass's cut-off above {value:.4g} Hz (now {now:.4g})")


def _all_of_the_chain(system: System) -> Remedy:
    """Latency down, sample rate and cut-off up by one factor."""
    now = system.sensing

    def quicker(factor: float) -> System:
        faster = {"rate_hz": now.rate_hz, "cutoff_hz": now.cutoff_hz}
        raised = {name: factor * value for name, value in faster.items() if value is not None}
        return system.sensed(latency_s=now.latency_s / factor, **raised)

    value = _least(quicker, np.geomspace(1.0, QUICKEST, 20))
    if value is None:
        return Remedy("whole chain", None, "times", f"even a chain {QUICKEST:g} times quicker in all is too slow")
    best = quicker(value).sensing
    parts = [f"latency {1e3 * best.latency_s:.4g} ms"]
    parts += [] if best.rate_hz is None else [f"{best.rate_hz:.4g} samples/s"]
    parts += [] if best.cutoff_hz is None else [f"cut-off {best.cutoff_hz:.4g} Hz"]
    return Remedy("whole chain", value, "times", f"make the whole chain {value:.3g} times quicker: {', '.join(parts)}")


def _less(system: System) -> Remedy:
    critical = margins(system).critical_gains
    gain = system.sensing.gain * (1.0 - 1e-4) * critical[0] if critical else math.nan
    if not critical or not poles_right_of(system.sensed(gain=gain)).none:
        return Remedy("share fed", None, "", "no share of the dynamic gravity can be fed: take static gravity (pd+sg)")
    text = f"feed at most {gain:.3g} of the deviation from rest at this frequency (rho; static gravity is 0)"
    return Remedy("share fed", gain, "", text)


def _damped(system: System) -> Remedy:
    def damped(factor: float) -> System:
        damping = system.damping.copy()
        damping[: system.base, : system.base] *= factor
        return replace(system, damping=damping)

    value = _least(damped, np.geomspace(1.0, MOST_DAMPING, 30))
    if value is None:
        return Remedy("base damping", None, "times", "more damping of the base alone does not help")
    needed = np.diag(system.damping)[: system.base] * value
    shown = _with_units(needed, system.turns[: system.base], turning="N m s/rad", sliding="N s/m")
    return Remedy("base damping", value, "times", f"damp the base {value:.3g} times as much: c at least {shown}")


def _with_units(values: NDArray[np.float64], turns: tuple[bool, ...], *, turning: str, sliding: str) -> str:
    """The numbers, each with its unit, or one unit behind the last if it is that of all."""
    units = [turning if turn else sliding for turn in turns]
    told = units if len(set(units)) > 1 else [""] * (len(units) - 1) + units[-1:]
    return ", ".join(f"{value:.4g} {unit}".rstrip() for value, unit in zip(values, told, strict=True))


def _own_reaction(system: System) -> Remedy:
    """Largest error of the base's stiffness, either way, that the model may have."""

    def systems(error: float) -> list[System]:
        return [with_own_reaction_removed(system, side * error) for side in (1.0, -1.0)]

    def likely(error: float) -> bool:
        return all(pade_poles(one).real.max() < 0.0 for one in systems(error))

    name, unit = "own reaction removed", "share"
    errors = np.geomspace(1e-3, LARGEST_ERROR, 12)
    good = next((i for i, error in enumerate(errors) if not likely(float(error))), len(errors))
    value = float(errors[-1])
    if 0 < good < len(errors):
        value = (1.0 - 1e-3) * _bisect(likely, float(errors[good - 1]), float(errors[good]))
    if good == 0 or not all(poles_right_of(one).none for one in systems(value)):
        return Remedy(name, None, unit, "feeding the reading minus the arm's own reaction does not help")
    text = "feed the reading minus what a model of the base says the arm's own reaction does"
    return Remedy(name, value, unit, f"{text}: its stiffness may be off by {100.0 * value:.2g} %")


def _least(change: Callable[[float], System], path: NDArray[np.float64]) -> float | None:
    """The first value on the path, from what is to what could be, with a certificate; bisected; None if there is none.

    Searched with the delay approximated, which is quick; what is found is proven, or else searched with proofs.
    """

    def proven(value: float) -> bool:
        return poles_right_of(change(value)).none

    def likely(value: float) -> bool:
        return bool(pade_poles(change(value)).real.max() < 0.0)

    quick = _first(likely, path)
    if quick is not None:
        value = quick * (1.0 + math.copysign(NUDGE, path[-1] - path[0]))
        if proven(value):
            return value
    return _first(proven, path)


def _first(holds: Callable[[float], bool], path: NDArray[np.float64]) -> float | None:
    first = next((i for i, value in enumerate(path) if holds(float(value))), None)
    if not first:  # 0: cannot be, the path starts where there is no certificate
        return None
    return _bisect(holds, float(path[first]), float(path[first - 1]))


def _bisect(holds: Callable[[float], bool], good: float, bad: float) -> float:
    """The last value from ``good`` towards ``bad`` that holds."""
    while abs(bad - good) > PRECISION * max(abs(good), abs(bad)):
        middle = (good + bad) / 2.0
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good
