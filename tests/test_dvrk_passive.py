"""An MTM calibrated in simulation and let go on tilted bases: better than its friction, it stays."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc
from ravengc.dvrk import Calibrated, calibrate, friction_shares, let_go, passive, simulated_mtm
from ravengc.dvrk.calibration import COULOMB, calibration_grid, tilt_fields
from ravengc.dvrk.letting_go import PassiveRuns
from ravengc.errors import ArgumentError, ConfigError

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("mujoco")


@pytest.fixture(scope="module")
def identified() -> Calibrated:
    return calibrate(simulated_mtm(), tilted=True)


@pytest.fixture(scope="module")
def level_only() -> Calibrated:
    return calibrate(simulated_mtm(), tilted=False)


def errors(calibration: Calibrated, g: np.ndarray) -> np.ndarray:
    rng = np.random.default_rng(3)
    low, high = np.radians(((-40, -11, -11, -80, -85, -40, -180), (7, 16, 11, 190, 175, 40, 180)))
    return np.max([np.abs(calibration.error(q, g)) for q in rng.uniform(low, high, (50, 7))], axis=0)


def test_the_grid_is_the_published_one() -> None:
    assert calibration_grid().shape == (2181, 7)


def test_tilts_are_level_and_four_more() -> None:
    fields = tilt_fields(10.0)
    np.testing.assert_allclose(np.linalg.norm(fields, axis=1), ravengc.STANDARD_GRAVITY)
    np.testing.assert_allclose(fields.sum(axis=0)[:2], 0.0, atol=1e-12)


def test_both_are_right_on_a_level_base(identified: Calibrated, level_only: Calibrated) -> None:
    level = np.array((0.0, 0.0, -ravengc.STANDARD_GRAVITY))
    for calibration in (identified, level_only):
        assert (errors(calibration, level) < COULOMB).all()


def test_tilts_in_the_calibration_are_needed_on_tilted_bases(identified: Calibrated, level_only: Calibrated) -> None:
    """Two more base parameters, both about joint 1; joint 2 is better by an order of magnitude and more."""
    assert identified.rank == level_only.rank + 2
    assert identified.readings == level_only.readings
    for g in np.array(((0.0, -9.8, 0.0), (9.8, 0.0, 0.0), (0.0, 0.0, 9.8), (5.0, 5.0, -7.0))):
        good, bad = errors(identified, g), errors(level_only, g)
        assert (good < COULOMB).all()
        assert bad[1] > 10.0 * good[1]


def test_the_largest_error_is_that_of_the_worst_tilt(level_only: Calibrated) -> None:
    """No attitude has a larger one, and of many one comes near."""
    q, rng = np.radians((-10.0, 10.0, 5.0, 30.0, 90.0, 10.0, 0.0)), np.random.default_rng(4)
    fields = rng.normal(size=(3000, 3))
    fields *= ravengc.STANDARD_GRAVITY / np.linalg.norm(fields, axis=1, keepdims=True)
    found, bound = np.max([np.abs(level_only.error(q, g)) for g in fields], axis=0), level_only.error_at_any_tilt(q)
    assert (found <= bound + 1e-12).all()
    assert (found >= 0.97 * bound).all()


def test_friction_holds_at_any_tilt_what_is_calibrated_on_tilted_bases(
    identified: Calibrated, level_only: Calibrated
) -> None:
    assert friction_shares(identified, count=300, seed=1).max() < 1.0
    shares = friction_shares(level_only, count=300, seed=1)
    assert (shares[:2] > 1.0).all()


def test_better_than_friction_it_stays(identified: Calibrated, level_only: Calibrated) -> None:
    q = np.radians((-10.0, 10.0, 5.0, 30.0, 90.0, 10.0, 0.0))
    for tilt in (0.0, 45.0, 180.0):
        assert let_go(identified, q, tilt_deg=tilt, seconds=0.5).drift < 1e-6
    falling = let_go(level_only, q, tilt_deg=90.0, seconds=10.0)
    assert not falling.stays
    assert falling.time[-1] < 10.0


def test_runs_side_by_side(identified: Calibrated, level_only: Calibrated, monkeypatch: pytest.MonkeyPatch) -> None:
    made = {True: identified, False: level_only}
    monkeypatch.setattr("ravengc.dvrk.letting_go.calibrate", lambda *_, tilted, **__: made[tilted])
    told: list[tuple[int, int]] = []
    tilts = ((0.0, (1.0, 0.0)), (90.0, (1.0, 0.0)))
    found = passive(seconds=0.2, tilts=tilts, on_progress=lambda *progress: told.append(progress))
    assert isinstance(found, PassiveRuns)
    assert found.stays
    assert told == [(1, 2), (2, 2)]
    assert len(found.with_identified) == len(found.with_level_only) == 2
    assert found.identified_shares.max() < 1.0 < found.level_only_shares.max()


def test_a_picture(identified: Calibrated, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    from ravengc.reports.dvrk_passive_plot import plot_passive

    run = let_go(identified, np.zeros(7), seconds=0.05)
    path = tmp_path / "passive.svg"
    plot_passive(path, PassiveRuns("dvrk_mtmr", 0.05, identified, identified, (run,), (run,), run.q, run.q))
    assert path.stat().st_size > 1000


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"seconds": 0.0}, "seconds"),
        ({"seconds": 1e9}, "seconds"),
        ({"tilts": ()}, "at least one"),
        ({"tilts": (3.0,)}, "the angle and a horizontal axis"),
        ({"tilts": ((3.0, (0.0, 0.0)),)}, "not both zero"),
        ({"tilts": ((1e9, (1.0, 0.0)),)}, "-360 to 360"),
        ({"seed": -1}, "seed"),
        ({"calibration_tilt_deg": 0.0}, "0.1 to 90"),
    ],
)
def test_impossible_arguments(wrong: dict[str, object], said: str) -> None:
    with pytest.raises(ArgumentError, match=said):
        passive(**wrong)  # type: ignore[arg-type]


def test_only_an_mtm_is_calibrated_so() -> None:
    with pytest.raises(ConfigError, match="dvrk_mtml"):
        passive("panda")
