"""Mounting, bias and link parameters found together, on a base that tilts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import ravengc as rg
from ravengc import disturbances as parts
from ravengc import identify
from ravengc.errors import ArgumentError
from ravengc.identify import Model
from test_identify import mounted

ROBOT = rg.load("raven2_gold")
TILT = np.radians(20.0)


def angle(found: identify.MountingFit, R: np.ndarray) -> float:
    return float(np.degrees(np.arccos(np.clip((np.trace(found.rotation @ R.T) - 1.0) / 2.0, -1.0, 1.0))))


def test_masses_come_out_with_the_mounting_and_are_those_of_an_identification() -> None:
    R, bias, recording = mounted(TILT, 2, 1)
    cad = rg.load("raven2_gold", mass_set="cad")  # the search starts from other masses
    found = identify.mounting(cad, recording, noise=0.003)
    assert angle(found, R) < 0.5
    assert np.abs(found.bias - bias).max() < 0.02
    again = identify.identify(cad, found.corrected(recording), Model(), "wls")
    np.testing.assert_allclose(again.values, found.values, atol=0.005)
    np.testing.assert_allclose(again.values, again.base.K @ Model().prior(ROBOT), atol=0.02)
    assert again.held_out.rms.max() < 0.02
    assert again.robot().moving_links[0].source.startswith("identified from")


def test_a_cable_is_told_from_the_mounting() -> None:
    R, bias, recording = mounted(TILT, 2, 4)
    pull = 1.5 * recording.q[:, 1] - 1.0
    pulled = replace(recording, tau=recording.tau + pull[:, np.newaxis] * [0.0, 1.0, 0.0])
    model = Model(elements=(identify.polynomial("elbow", (0, 1)),))
    found = identify.mounting(ROBOT, pulled, model=model, noise=0.003)
    assert angle(found, R) < 0.6
    assert np.abs(found.bias - bias).max() < 0.02
    assert found.rms.max() < 0.02
    without = identify.mounting(ROBOT, pulled, noise=0.003)
    assert without.rms[1] > 5.0 * found.rms[1]


def test_the_robots_own_cable_is_known() -> None:
    _, _, recording = mounted(TILT, 2, 4)
    cable = parts.Polynomial(name="cable", joint="elbow", coefficients=(-1.0, 1.5))
    robot = rg.Robot(replace(ROBOT.spec, disturbances=(cable,)))
    pull = 1.5 * recording.q[:, 1] - 1.0
    pulled = replace(recording, tau=recording.tau + pull[:, np.newaxis] * [0.0, 1.0, 0.0])
    plain, own = identify.mounting(ROBOT, recording), identify.mounting(robot, pulled)
    np.testing.assert_allclose(own.rotation, plain.rotation, atol=1e-9)


def test_the_scale_is_refused_with_the_reason() -> None:
    recording = mounted(TILT, 2, 1)[2]
    with pytest.raises(ArgumentError, match="twice the force and half of all masses"):
        identify.mounting(ROBOT, recording, find=("rotation", "bias", "scale"))
    with pytest.raises(ArgumentError, match="expected 'rotation', 'bias'"):
        identify.mounting(ROBOT, recording, find=("tilt",))
    with pytest.raises(ArgumentError, match="poses at rest show gravity"):
        identify.mounting(ROBOT, recording, model=Model(kind="dynamics"))


def test_twice_the_force_and_half_of_all_masses_are_the_same_torques() -> None:
    """The reason: no torque changes, so no torque can tell."""
    R, bias, recording = mounted(TILT, 2, 1)
    force = (recording.specific_force - bias) @ R.T
    Y = [Model().regressor(ROBOT, replace(recording, specific_force=size * force)) for size in (1.0, 2.0)]
    np.testing.assert_allclose(Y[1] @ (0.5 * Model().prior(ROBOT)), Y[0] @ Model().prior(ROBOT), atol=1e-12)
