"""The table of conventions: every cell, the page's mistakes, the MTM's two tables."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc
from ravengc.dvrk import agreement_table, compare_tables, mistakes, modified_mtm
from ravengc.dvrk.peers import Peer, ask_kdl, ask_toolbox
from ravengc.dvrk.table import PAGE, ROWS
from ravengc.errors import ArgumentError, ConfigError
from ravengc.spec import JointOrigin

if TYPE_CHECKING:
    from pathlib import Path

FAKE_KDL = """
import json, sys
asked = json.load(sys.stdin)
n = len(asked["q"])
json.dump({{"version": "0", "poses": [[{value}] * 12] * n, "torques": [[0.0] * 2] * n}}, sys.stdout)
"""


def test_every_cell_is_yes() -> None:
    table = agreement_table(20)
    assert table.complete
    assert table.conventions.agrees
    reference = table.columns[0]
    assert len(reference.cells) == len(ROWS) == len(PAGE) == 4
    for column in table.columns:
        assert column.cells or "not installed" in column.why_not
        assert all(cell.agrees for cell in column.cells)


def test_the_page_is_explained_by_two_mistakes() -> None:
    """The three rows at (0.3, 0.5); reference values of independent routes."""
    right, behind, mirrored = (one.torque for one in mistakes())
    np.testing.assert_allclose(right, (-7.080490, -3.166768), atol=5e-7)
    np.testing.assert_allclose(behind, (-10.805, -9.500), atol=5e-4)
    np.testing.assert_allclose(mirrored, (1.862, 3.167), atol=5e-4)


@pytest.mark.parametrize("name", ["dvrk_mtml", "dvrk_mtmr"])
def test_the_two_tables_of_the_mtm_are_one_arm(name: str) -> None:
    found = compare_tables(name, 20, seed=4)
    assert found.agrees
    assert found.torque < 1e-14


def test_the_modified_mtm_moves_its_tool_alike() -> None:
    standard = ravengc.load("dvrk_mtmr")
    modified = modified_mtm(standard)
    assert modified.spec.convention == "modified"
    assert modified.spec.transmission == standard.spec.transmission
    q, qd, qdd = np.random.default_rng(1).normal(0.0, 1.0, (3, 7))
    np.testing.assert_allclose(modified.forward_kinematics(q), standard.forward_kinematics(q), atol=1e-14)
    base = ravengc.BaseMotion(specific_force=(1.0, 2.0, 9.0), angular_velocity=(0.3, 0.2, 0.1))
    one, other = (robot.inverse_dynamics(q, qd, qdd, base) for robot in (standard, modified))
    np.testing.assert_allclose(one, other, atol=1e-12)


def test_inertias_move_with_their_frames() -> None:
    spec = ravengc.load("dvrk_mtmr").spec
    links = tuple(replace(link, mass=1.0, massless=False, inertia=(0.02, 0.001, 0.0, 0.03, 0.002, 0.025))
                  for link in spec.links)  # fmt: skip
    standard = ravengc.Robot(replace(spec, links=links))
    q = np.linspace(-0.5, 0.6, 7)
    np.testing.assert_allclose(modified_mtm(standard).mass_matrix(q), standard.mass_matrix(q), atol=1e-13)


def test_other_arms_are_refused() -> None:
    with pytest.raises(ConfigError, match="no MTM in standard DH"):
        modified_mtm(ravengc.load("panda"))
    spec = ravengc.load("dvrk_mtmr").spec
    other = replace(spec, links=(*spec.links[:1], replace(spec.links[1], placement=spec.links[0].placement),
                                 *spec.links[2:]))  # fmt: skip
    with pytest.raises(ConfigError, match="other axes"):
        modified_mtm(ravengc.Robot(other))


@pytest.mark.parametrize("poses", [0, -1, True, 2.5, "3"])
def test_impossible_numbers_of_poses(poses: object) -> None:
    with pytest.raises(ArgumentError, match="poses"):
        agreement_table(poses)  # type: ignore[arg-type]


def kdl_that(tmp_path: Path, program: str) -> str:
    """An interpreter that runs this program instead of the script it is given."""
    script, interpreter = tmp_path / "answers.py", tmp_path / "python"
    script.write_text(program)
    interpreter.write_text(f"#!/bin/sh\nexec {sys.executable} {script}\n")
    interpreter.chmod(0o755)
    return str(interpreter)


def test_a_wrong_answer_is_a_no(tmp_path: Path) -> None:
    table = agreement_table(5, pykdl=kdl_that(tmp_path, FAKE_KDL.format(value="1.0")))
    assert not table.complete
    assert not any(cell.agrees for cell in table.columns[1].cells)


def test_answers_that_are_not_numbers_are_a_no(tmp_path: Path) -> None:
    assert not agreement_table(5, pykdl=kdl_that(tmp_path, FAKE_KDL.format(value="float('nan')"))).complete


@pytest.mark.parametrize(
    ("program", "said"),
    [
        ("import sys; sys.exit(3)", "has no PyKDL"),
        ("print('hello')", "did not answer"),
        ("import sys; sys.exit('segment')", "segment"),
        ("print('{}')", "did not answer"),
        ('print(\'{"version": "", "poses": [[1]], "torques": []}\')', "did not answer"),
        ('print(\'{"version": "", "poses": [], "torques": []}\')', "did not answer"),
    ],
)
def test_interpreters_that_cannot_answer(tmp_path: Path, program: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        agreement_table(5, pykdl=kdl_that(tmp_path, program))


@pytest.mark.parametrize("python", ["/nonexistent/python", "/", "a\0b"])
def test_interpreters_that_cannot_be_started(python: str) -> None:
    with pytest.raises(ConfigError, match="cannot be asked"):
        agreement_table(5, pykdl=python)


def test_without_the_libraries_the_columns_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = ravengc.load("rrbot").spec
    monkeypatch.setitem(sys.modules, "roboticstoolbox", None)
    assert "not installed" in ask_toolbox(spec, np.zeros((1, 2)), np.zeros((1, 3))).why_not
    monkeypatch.setattr("ravengc.dvrk.peers._asked", lambda *_: None)
    assert "python3-pykdl" in ask_kdl(spec, np.zeros((1, 2)), np.zeros((1, 3))).why_not
    monkeypatch.setattr("ravengc.dvrk.table.ask_toolbox", lambda *_: Peer("Robotics Toolbox", why_not="not installed"))
    assert agreement_table(5).complete


def test_an_old_toolbox_is_not_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    toolbox = type(sys)("roboticstoolbox")
    toolbox.__version__ = "1.0.3"
    monkeypatch.setitem(sys.modules, "roboticstoolbox", toolbox)
    spec = ravengc.load("rrbot").spec
    assert "from 1.4.4 on" in ask_toolbox(spec, np.zeros((1, 2)), np.zeros((1, 3))).why_not


def test_only_dh_rows_can_be_asked() -> None:
    spec = ravengc.load("rrbot").spec
    bent = replace(spec, links=(replace(spec.links[0], placement=JointOrigin()), *spec.links[1:]))
    with pytest.raises(ConfigError, match="no DH row"):
        ask_kdl(bent, np.zeros((1, 2)), np.zeros((1, 3)))
