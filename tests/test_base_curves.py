"""What the picture of a run shows of its base: everything that moves, and nothing that does not."""

from __future__ import annotations

import numpy as np
import pytest

from ravengc import sim
from ravengc.reports.base_curves import base_curves

TIMES = np.linspace(0.0, 6.0, 121)


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("level", ["about x"]),
        ("tilt:20", ["about x"]),
        ("rocking:10:20:1", ["about x"]),
        ("rocking:-5:5:0.5", ["about x"]),
        ("ship", ["about x", "about y", "z"]),
        ("ship:0:0.1:4:0.13:0:0.1", ["about y"]),
        ("elevator:20", ["z"]),
        ("step:1.96:1:3", ["x"]),
    ],
)
def test_what_moves_is_shown(text: str, names: list[str]) -> None:
    base = sim.parse_base(text, axis="x", pivot=(0.0, 0.0, -0.3))
    curves = base_curves(base, TIMES)
    assert [curve.name for curve in curves] == names
    assert all(np.ptp(curve.values) > 0.0 for curve in curves) or text in {"level", "tilt:20"}


def test_curves_are_angles_in_degrees_and_accelerations() -> None:
    base = sim.parse_base("ship", axis="x", pivot=(0.0, 0.0, 0.0))
    roll, pitch, heave = base_curves(base, TIMES)
    states = [base.state(t) for t in TIMES]
    assert roll.turns
    assert pitch.turns
    assert not heave.turns
    assert np.abs(roll.values).max() == pytest.approx(10.0, rel=0.01)
    assert np.array_equal(pitch.values, np.rad2deg([state.position[4] for state in states]))
    assert np.array_equal(heave.values, [state.acceleration[2] for state in states])


def test_a_base_that_coasts_stands_still_for_the_arm() -> None:
    """A step of acceleration leaves a speed; what is shown goes back to zero."""
    (along,) = base_curves(sim.acceleration_step(2.0, start_s=1.0, end_s=2.0), TIMES)
    assert along.values.max() == 2.0
    assert along.values[-1] == 0.0


def test_axes_are_named_as_they_lie() -> None:
    (turning,) = base_curves(sim.rocking(10.0, 20.0, hz=1.0, axis=(0.0, -1.0, 0.0)), TIMES)
    assert turning.name == "about -y"
    (turning,) = base_curves(sim.rocking(10.0, 20.0, hz=1.0, axis=(1.0, 1.0, 0.0)), TIMES)
    assert turning.name == "about axis 1"


def test_no_moments_no_values() -> None:
    (none,) = base_curves(sim.ship(), np.zeros(0))
    assert none.values.shape == (0,)
