"""The page's special terms for the MTM: its formulas, its jumps, the coil of the wrist, the mirrored masses."""

from __future__ import annotations

import json
from math import cos, pi, radians, sin, sqrt
from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc
from ravengc.cli import main
from ravengc.dvrk import mtm_with_special_terms, special_terms
from ravengc.errors import ConfigError

if TYPE_CHECKING:
    from pathlib import Path

GRAVITY = np.array((0.0, 0.0, -9.81))


def page(q: np.ndarray, qd: np.ndarray, *, right: bool) -> np.ndarray:
    """What the page adds to the torques of the masses, and the coil of the dynamic model, as they are written."""
    tau = np.zeros(7)
    tau[0] = -0.1 * qd[0]
    if right and q[0] > -0.15:
        tau[0] += (q[0] - (-0.15)) * 0.1 + 0.04
    tau[1] = -0.30
    if q[1] < 0.05:
        tau[1] += (q[1] - 0.05) * 1.0 + 0.05
    tau[2] = -0.051 * 9.81 * cos(q[1] + q[2])
    if q[2] < 0.05:
        tau[2] += (q[2] - 0.05) * 0.1 - 0.07
    r, h, rest, stiffness, angle = 0.0075, 0.1035, 0.0613, 270.94, pi + radians(23.0) - q[4]
    length = sqrt(r * r + h * h - 2.0 * r * h * cos(angle))
    tau[4] = -stiffness * r * h * sin(angle) / length * (length - rest)
    return tau


@pytest.mark.parametrize("name", ["dvrk_mtml", "dvrk_mtmr"])
def test_elements_are_the_pages_formulas(name: str) -> None:
    robot, rng = ravengc.Robot(mtm_with_special_terms(name)), np.random.default_rng(0)
    for q, qd in zip(rng.uniform(-0.6, 0.6, (50, 7)), rng.normal(size=(50, 7)), strict=True):
        np.testing.assert_allclose(
            robot.disturbance_torque(q, qd), page(q, qd, right=name.endswith("r")), rtol=0.0, atol=1e-13
        )


def test_jumps_are_pointed_out() -> None:
    jumps = {term.element.name: [(jump.at, round(jump.size, 12)) for jump in term.jumps] for term in special_terms()}
    assert {name: places for name, places in jumps.items() if places} == {
        "yaw cable": [(-0.15, 0.04)],
        "shoulder cable": [(0.05, -0.05)],
        "elbow cable": [(0.05, 0.07)],
    }
    robot = ravengc.Robot(mtm_with_special_terms())
    for place, (at, size) in enumerate(((-0.15, 0.04), (0.05, -0.05), (0.05, 0.07))):
        q, step = np.zeros(7), 1e-9 * np.eye(7)[place]
        q[place] = at
        kick = robot.disturbance_torque(q + step) - robot.disturbance_torque(q - step)
        assert kick[place] == pytest.approx(size, abs=1e-7)


def test_together_they_come_near_the_published_files() -> None:
    """At (0, 0, 0, 0, 90 deg, 0, 0) the masses ask joints 2 and 3 for 0.905 N m; the five files for 0.61 to 0.68, 0.4.

    Joint 2: less 0.30, and the cable's 0.05 - 0.05. Joint 3: less 0.051 kg m of gravity and the cable's 0.07 + 0.005.
    """
    robot, q = ravengc.Robot(mtm_with_special_terms()), np.array((0.0, 0.0, 0.0, 0.0, pi / 2.0, 0.0, 0.0))
    tau = robot.gravity_torque(q, GRAVITY) + robot.disturbance_torque(q)
    np.testing.assert_allclose(tau[1:3], (0.90512 - 0.30, 0.90512 - 0.051 * 9.81 - 0.075), atol=5e-6)


def test_left_and_right_are_mirrored() -> None:
    """z of link 4's centre of mass and y of link 5's change sign, and no other number of the masses does."""
    left, right = (mtm_with_special_terms(f"dvrk_mtm{side}") for side in "lr")
    for place, (mine, other) in enumerate(zip(left.links, right.links, strict=True), 1):
        assert mine.mass == other.mass
        signs = {4: (1.0, 1.0, -1.0), 5: (1.0, -1.0, 1.0)}.get(place, (1.0, 1.0, 1.0))
        np.testing.assert_allclose(mine.com, np.array(signs) * other.com)
    assert "yaw cable" not in [element.name for element in left.disturbances]


def test_only_an_mtm_has_such_terms() -> None:
    with pytest.raises(ConfigError, match="dvrk_mtml"):
        special_terms("panda")


@pytest.fixture(autouse=True)
def a_wide_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tables on lines as long as they like."""
    monkeypatch.setenv("COLUMNS", "200")


def test_command(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "page.toml"
    assert main(["dvrk", "terms", "-o", str(out)]) == 0
    said = capsys.readouterr().out
    for expected in ("parallel mechanism", "wrist spring", "3 of 7 jump", "-0.05", "+0.07"):
        assert expected in said
    assert ravengc.load(out).spec.disturbances == mtm_with_special_terms().disturbances
    assert "not in here" not in ravengc.load(out).spec.description
    assert "point masses" in ravengc.load(out).spec.description
    assert main(["dvrk", "terms", "dvrk_mtml", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["terms"]) == 6
    assert main(["dvrk", "terms", "panda"]) == 2
    assert main(["dvrk", "terms", "-o", "a.json"]) == 2
