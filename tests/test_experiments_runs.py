"""The experiments with a simulated plant at small settings, and how they are shared out among processes."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco")

from ravengc.experiments import EXPERIMENTS, Outcome, base_feedback, run_experiment, settings_from
from ravengc.experiments.pool import Job, run_all
from ravengc.experiments.static_poses import StaticPoses, predicted_share

SMALL: dict[str, dict[str, Any]] = {
    "static-poses": {"tilts_deg": [0.0, 20.0], "j1_deg": [0.0, 60.0], "hold_s": 0.6, "count_s": 0.1},
    "cartesian-sinusoids": {"tilts_deg": [0.0, 20.0], "levels": [0.0], "level": 3.5, "period_s": 0.6, "cycles": 1},
    "rocking": {"levels": [0.0], "level": 0.0, "amplitude": 0.005, "period_s": 0.7, "cycles": 1},
    "acceleration-step": {"start_s": 0.1, "lasts_s": 0.4, "after_s": 0.1},
    "base-feedback": {"duration_s": 4.0},
    "moving-base-terms": {"samples": 32, "j1_deg": 45.0, "j2_deg": 90.0},
    "ship": {"duration_s": 5.0},
    "base-wrench": {"states": 3, "samples": 16},
    "newton-euler": {"states": 2, "repeats": 1},
}


def job(name: str) -> Job:
    experiment = EXPERIMENTS[name]
    return experiment, settings_from(experiment.settings, SMALL[name])


@pytest.fixture(scope="module")
def alone() -> dict[str, Outcome]:
    """Every experiment, one task after the other in this process."""
    return {name: run_experiment(*job(name)) for name in EXPERIMENTS}


def test_processes_change_nothing(alone: dict[str, Outcome]) -> None:
    heard = []
    names = ["newton-euler", "acceleration-step", "static-poses", "ship"]
    pooled = run_all([job(name) for name in names], processes=2, on_done=lambda *counts: heard.append(counts))
    assert list(pooled) == names
    assert heard[-1][0] == heard[-1][1] == len(heard)
    for name, outcome in pooled.items():
        assert outcome.numbers == alone[name].numbers
        timed = {key for key in outcome.series if key.startswith("seconds_")}
        for key in set(outcome.series) - timed:
            np.testing.assert_array_equal(outcome.series[key], alone[name].series[key])


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_outcomes_are_finite_and_complete(alone: dict[str, Outcome], name: str) -> None:
    outcome = alone[name]
    assert outcome.numbers
    assert all(isinstance(value, float) for value in outcome.numbers.values())
    assert all(np.isfinite(value) for key, value in outcome.numbers.items() if key != "critical_delay_s")
    assert outcome.findings
    assert all(finding.why for finding in outcome.findings if finding.stated)
    assert all(np.isfinite(finding.value) for finding in outcome.findings)
    assert not any(re.search(r"\dNm", finding.quantity + finding.why) for finding in outcome.findings)
    for table in outcome.tables:
        assert table.rows
        assert {len(row) for row in table.rows} == {len(table.columns)}


def test_a_base_too_heavy_for_a_critical_delay_is_said_to_have_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(base_feedback, "LONGEST_DELAY_S", 0.004)
    experiment = EXPERIMENTS["base-feedback"]
    outcome = run_experiment(experiment, settings_from(experiment.settings, {"base_mass": 50.0, "duration_s": 2.0}))
    assert np.isinf(outcome.numbers["critical_delay_s"])
    delay = next(finding for finding in outcome.findings if finding.unit == "ms")
    assert (delay.quantity, delay.value) == ("without low-pass: no critical delay up to", 4.0)


def test_static_shares_are_those_of_statics(alone: dict[str, Outcome]) -> None:
    numbers = alone["static-poses"].numbers
    settings = StaticPoses(**SMALL["static-poses"])
    assert numbers["share_pd+sg_20deg"] == pytest.approx(predicted_share(settings, 20.0), abs=0.2)
    assert numbers["share_pd+sg_0deg"] < 0.01
    assert numbers["share_pd+dg_20deg"] < 0.01


def test_friction_that_sticks_is_the_limit_of_friction_that_creeps(alone: dict[str, Outcome]) -> None:
    numbers = alone["static-poses"].numbers
    stuck, rigid, soft = (numbers[f"share_pd+sg_{way}_20deg"] for way in ("start", "rigid", "soft"))
    assert rigid == pytest.approx(stuck, abs=0.3)
    assert soft > stuck + 5.0
    found = alone["cartesian-sinusoids"].numbers
    exact, *softened = (found[f"error_j1_pd_20deg_3.5Nm{suffix}"] for suffix in ("", "_soft1", "_soft2", "_soft3"))
    gaps = [abs(value - exact) for value in softened]
    assert gaps == sorted(gaps, reverse=True)
    assert gaps[-1] < 0.01 * exact


def test_dynamic_gravity_helps_most_where_nothing_rubs(alone: dict[str, Outcome]) -> None:
    numbers = alone["cartesian-sinusoids"].numbers
    assert numbers["change_j1_pd+dg_20deg_0Nm"] < numbers["change_j1_pd+sg_20deg_0Nm"] < 0.0
    rocked = alone["rocking"].numbers
    assert rocked["change_j1_bm_0Nm"] < rocked["change_j1_dg_0Nm"] < rocked["change_j1_dg_pivot_0Nm"] < 0.0


def test_the_step_response_is_as_late_as_the_sensor(alone: dict[str, Outcome]) -> None:
    numbers = alone["acceleration-step"].numbers
    assert numbers["ideal_y0_peak"] < 1e-9
    assert numbers["typical_y0_peak"] < numbers["slow_y0_peak"] < numbers["sg_y0_peak"]
    assert numbers["typical_y0_steady"] < 0.05 * numbers["sg_y0_steady"]
    lag = 1e3 * numbers["typical_y0_integral"] / numbers["sg_y0_steady"]
    assert lag == pytest.approx(15.0, abs=1.0)


def test_noise_is_seeded() -> None:
    few = {**SMALL["rocking"], "period_s": 0.5, "noise": 0.05}
    rocking = EXPERIMENTS["rocking"]

    def found(seed: int) -> float:
        settings = settings_from(rocking.settings, {**few, "seed": seed})
        task = next(task for task in rocking.tasks(settings) if task[1].way == "dg")
        return float(rocking.run(task)["error"][0])

    assert found(1) == found(1) != found(2)


def test_an_error_in_a_task_is_raised_here() -> None:
    with pytest.raises(ZeroDivisionError):
        run_all([_failing(), job("ship")], processes=2)


def _failing() -> Job:
    from dataclasses import replace

    return replace(EXPERIMENTS["base-wrench"], name="failing", run=_divide), EXPERIMENTS["base-wrench"].settings()


def _divide(task: object) -> object:
    return 1 // (task is None)
