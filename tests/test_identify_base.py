"""What torques do not show, and that what is said to show it does."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import ravengc as rg
from ravengc.identify import Model, Recording, base_parameters
from ravengc.identify.base_parameters import random_states

LEVEL = 9.80665
TEN = np.radians(10.0)
ARMS = {
    "ur10": (10, 12), "pa10": (10, 12), "panda": (12, 14), "dvrk_mtml": (12, 14), "dvrk_mtmr": (12, 14),
    "raven2_gold": (5, 5), "dvrk_psm_si": (5, 5), "dvrk_ecm_si": (5, 5), "rrbot": (4, 4), "rrbot_modified": (4, 4),
}  # fmt: skip


def turned(force: np.ndarray, axis: str, angle: float = TEN) -> np.ndarray:
    """A specific force as a base sees it that was turned about one of its axes: Rᵀ f."""
    c, s = np.cos(angle), np.sin(angle)
    R = {
        "x": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "y": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
    }[axis]
    return R.T @ force


def axes_of(sentence: str) -> list[str]:
    """The axes in ``about its x or y axis``."""
    return re.search(r"about its (.*) axis", sentence)[1].split(" or ")


@pytest.mark.parametrize(("name", "ranks"), ARMS.items())
def test_the_tilt_that_is_named_shows_what_is_named(name: str, ranks: tuple[int, int]) -> None:
    robot, up = rg.load(name), np.array([[0.0, 0.0, LEVEL]])
    found = base_parameters(robot, Model(), up)
    tilts = [sentence for sentence in found.unidentifiable if "tilt the base" in sentence]
    assert found.rank == ranks[0]
    assert len(tilts) == (ranks[1] > ranks[0])
    for sentence in tilts:
        assert len(sentence.split(": ")[0].split("; ")) == ranks[1] - ranks[0]
        assert axes_of(sentence) == ["x", "y"]  # joint 1 of all of these is vertical
        for axis in axes_of(sentence):
            visited = np.vstack([up, turned(up[0], axis)])
            after = base_parameters(robot, Model(), visited)
            assert after.rank == ranks[1]
            assert not any("tilt the base" in sentence for sentence in after.unidentifiable)
            for word in sentence.split(": ")[0].split("; "):
                assert word in after.names


def test_a_turn_about_ravens_first_axis_shows_nothing_new() -> None:
    """Joint 1 vertical: 3 of 5. Tilts about it are turns of joint 1; the two others show the rest."""
    robot = rg.load("raven2_gold")
    along = LEVEL * np.array(robot.base.rotation)[:, 2]
    found = base_parameters(robot, Model(), along[np.newaxis])
    assert found.rank == 3
    (sentence,) = (sentence for sentence in found.unidentifiable if "tilt the base" in sentence)
    axes = axes_of(sentence)
    assert len(axes) == 2
    for axis in "xyz":
        rank = base_parameters(robot, Model(), np.vstack([along, turned(along, axis)])).rank
        assert rank == (5 if axis in axes else 3)


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("kind", ["gravity", "dynamics"])
def test_what_no_torque_depends_on_moves_none_however_the_base_moves(name: str, kind: str) -> None:
    robot, model = rg.load(name), Model(kind=kind, friction=())
    for at in ("level", "rocking"):
        found = base_parameters(robot, model, at)
        never = [sentence for sentence in found.unidentifiable if "no joint torque" in sentence]
        hidden = never[0].split(": ")[0].split(", ") if never else []
        random = np.random.default_rng(1)
        motions = np.hstack([random.normal(size=(20, 3)) * LEVEL, random.normal(size=(20, 6))])
        columns = model.regressor(robot, random_states(robot, motions, 30))
        sizes = dict(zip(found.columns, np.abs(columns).max(axis=0), strict=True))
        assert {column for column, size in sizes.items() if size < 1e-9} == set(hidden)


@pytest.mark.parametrize(("name", "ranks"), [("panda", (43, 45, 49)), ("ur10", (36, 38, 42))])
def test_every_stage_of_the_dynamics_gains_what_its_sentence_names(name: str, ranks: tuple[int, ...]) -> None:
    robot, model = rg.load(name), Model(kind="dynamics", friction=())
    found = base_parameters(robot, model, "level")
    tilt, rock, _ = found.unidentifiable
    assert "tilt the base" in tilt
    assert "rock the base" in rock
    gains = [len(sentence.split(": ")[0].split("; ")) for sentence in (tilt, rock)]
    assert [found.rank, *(found.rank + np.cumsum(gains))] == list(ranks)
    still = base_parameters(robot, model, "level", at_rest=True)
    assert still.rank == ARMS[name][0]
    move = still.unidentifiable[0]
    assert move.endswith("record a motion in which every joint moves and speeds up")
    assert still.rank + len(move.split(": ")[0].split("; ")) == ranks[0]


def test_a_slide_that_is_level_needs_a_tilt_about_the_axis_across_it() -> None:
    """A carriage along x carries nothing level, and nothing on a base that is rolled about x."""
    placement = rg.spec.JointOrigin(axis=(1.0, 0.0, 0.0))
    carriage = rg.spec.LinkSpec(name="carriage", placement=placement, joint="prismatic", mass=2.0, inertia=(0.1,) * 6)
    carriage = replace(carriage, inertia=(0.1, 0.0, 0.0, 0.1, 0.0, 0.1))
    robot = rg.Robot(rg.spec.RobotSpec(name="slide", convention="frames", links=(carriage,)))
    found = base_parameters(robot, Model(), "level")
    assert found.rank == 0
    assert found.unidentifiable[0] == "carriage.m: tilt the base, once by 10 degrees or more about its y axis"


def test_a_level_recording_says_so() -> None:
    robot = rg.load("panda")
    q = np.random.default_rng(0).uniform(-1.0, 1.0, (20, 7))
    recording = Recording(stamps=np.arange(20.0), q=q, tau=q)
    assert "about its x or y axis" in base_parameters(robot, Model(), recording).unidentifiable[0]
