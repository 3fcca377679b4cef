"""Every public function of the dVRK's part with every argument of the wrong kind: a result, or an error of ours."""

from __future__ import annotations

import atexit
import json
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import ravengc as rg
from dvrk_files import gc_file, kinematic_psm_si
from misuse import functions_of, try_everything
from ravengc import dvrk
from ravengc.dvrk.peers import Peer
from ravengc.errors import RavenGCError

if TYPE_CHECKING:
    from collections.abc import Callable

MTM = rg.load("dvrk_mtmr")
RRBOT = rg.load("rrbot")
TRUTH = dvrk.simulated_mtm()
FOLDER = tempfile.TemporaryDirectory()
atexit.register(FOLDER.cleanup)
GC, KINEMATIC = Path(FOLDER.name, "gc.json"), Path(FOLDER.name, "k.json")
GC.write_text(json.dumps(gc_file()))
KINEMATIC.write_text(json.dumps(kinematic_psm_si()))
PUBLISHED = dvrk.read_published(GC)
ARRAYS = ("positive", "negative", "lower", "upper", "dead_band", "saturation", "ratio")
CALIBRATED = dvrk.Calibrated(rg.Robot(TRUTH), np.zeros(24 + 27), 1, 10, 3, 1.0)
ONE_TILT = ((0.0, (1.0, 0.0)),)

CALLS: list[tuple[Callable[..., object], dict[str, Any]]] = [
    (dvrk.Published, {name: getattr(PUBLISHED, name) for name in (*ARRAYS, "arm", "serial", "source")}),
    (PUBLISHED.torque, {"q": np.zeros(7), "qd": np.zeros(7), "gravity": (0.0, 0.0, -9.8)}),
    (PUBLISHED.blend, {"qd": np.zeros(7)}),
    (PUBLISHED.on_tilt, {"degrees": 10.0}),
    (CALIBRATED.torque, {"q": np.zeros(7), "gravity": (0.0, 0.0, -9.8)}),
    (CALIBRATED.error, {"q": np.zeros(7), "gravity": (0.0, 0.0, -9.8)}),
    (CALIBRATED.error_at_any_tilt, {"q": np.zeros(7)}),
    (dvrk.friction_shares, {"calibration": CALIBRATED, "count": 2, "seed": 0}),
    (dvrk.compare_tables, {"name": "dvrk_mtmr", "poses": 2, "seed": 0}),
    (dvrk.convert, {"paths": [KINEMATIC], "name": "arm", "mounting_pitch": 0.1}),
    (dvrk.mistakes, {}),
    (dvrk.modified_mtm, {"robot": MTM}),
    (
        dvrk.mounted,
        {"spec": RRBOT.spec.__class__(name="a", convention="standard", links=RRBOT.spec.links), "pitch": 0.1},
    ),
    (dvrk.mtm_with_special_terms, {"name": "dvrk_mtmr"}),
    (dvrk.published_from_robot, {"spec": MTM.spec}),
    (dvrk.published_regressor, {"q": np.zeros(7)}),
    (dvrk.read_kinematic, {"path": KINEMATIC}),
    (dvrk.read_published, {"path": GC}),
    (dvrk.robot_spec_from_published, {"published": PUBLISHED, "mtm": MTM.spec}),
    (dvrk.simulated_mtm, {"name": "dvrk_mtmr"}),
    (dvrk.special_terms, {"name": "dvrk_mtmr"}),
]
IN_SIMULATION: list[tuple[Callable[..., object], dict[str, Any]]] = [
    (dvrk.hold, {"robot": RRBOT, "poses": None, "count": 1, "seconds": 0.001, "tilt_deg": 0.0, "axis": "x", "seed": 0}),
    (dvrk.let_go, {"calibration": CALIBRATED, "q": np.zeros(7), "tilt_deg": 0.0, "axis": (1.0, 0.0), "seconds": 0.004}),
]
SLOW = {dvrk.agreement_table, dvrk.calibrate, dvrk.passive}
"""Their arguments are tried in tests of their own, with the slow part left out."""
WRITERS = {dvrk.write_kinematic, dvrk.write_published}
DATA = {
    dvrk.Calibrated, dvrk.Cell, dvrk.Column, dvrk.Conversion, dvrk.Drift, dvrk.Hold, dvrk.Holding, dvrk.Mistake,
    dvrk.PassiveRuns, dvrk.SameArm, dvrk.SpecialTerm, dvrk.Table, dvrk.TiltReport,
}  # fmt: skip
"""Data that the package makes itself."""


def named(part: object) -> str:
    return getattr(part, "__qualname__", "")


@pytest.mark.parametrize(("function", "good"), CALLS, ids=named)
def test_a_wrong_argument_is_an_error_of_ours(function: Callable[..., object], good: dict[str, Any]) -> None:
    try_everything(function, good)


@pytest.mark.parametrize(("function", "good"), [*CALLS, *IN_SIMULATION], ids=named)
def test_no_argument_is_left_unread(function: Callable[..., object], good: dict[str, Any]) -> None:
    """What nothing can mean is refused in the place of every argument."""
    for name in good:
        with pytest.raises(RavenGCError):
            function(**(good | {name: object()}))


@pytest.mark.parametrize(("function", "good"), IN_SIMULATION, ids=named)
def test_so_it_is_in_simulation(function: Callable[..., object], good: dict[str, Any]) -> None:
    pytest.importorskip("mujoco")
    try_everything(function, good)


def test_so_it_is_where_it_takes_long(monkeypatch: pytest.MonkeyPatch) -> None:
    """With what takes long left out: libraries that are asked, fits, and runs."""
    pytest.importorskip("mujoco")
    monkeypatch.setattr("ravengc.dvrk.table.ask_toolbox", lambda *_: Peer("toolbox", why_not="not asked"))
    monkeypatch.setattr("ravengc.dvrk.table.ask_kdl", lambda *_, **__: Peer("kdl", why_not="not asked"))
    try_everything(dvrk.agreement_table, {"poses": 2, "pykdl": None, "seed": 0})
    monkeypatch.setattr("ravengc.dvrk.calibration.identify", lambda *_, **__: CALIBRATED)
    try_everything(dvrk.calibrate, {"truth": TRUTH, "tilted": True, "seed": 0, "degrees": 10.0})
    monkeypatch.setattr("ravengc.dvrk.letting_go.calibrate", lambda *_, **__: CALIBRATED)
    good = {"name": "dvrk_mtmr", "seconds": 0.004, "tilts": ONE_TILT, "seed": 0, "on_progress": None}
    try_everything(dvrk.passive, good)


@pytest.mark.parametrize("function", sorted(WRITERS, key=named), ids=named)
def test_so_it_is_when_writing(
    function: Callable[..., object], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    thing = {"spec": MTM.spec} if function is dvrk.write_kinematic else {"published": PUBLISHED}
    try_everything(function, thing | {"path": tmp_path / "out.json"})


def test_no_function_was_forgotten() -> None:
    called = {function for function, _ in (*CALLS, *IN_SIMULATION)}
    assert functions_of(dvrk) == {one for one in called if not hasattr(one, "__self__")} | SLOW | WRITERS | DATA
