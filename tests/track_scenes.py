"""A run over a small moving surface without a control loop: every number of it is known beforehand."""

from __future__ import annotations

import numpy as np

import ravengc as rg
from ravengc.track import Hold, Surface, Trace, TrackResult, TrackSettings, Visits, liver_surface, lujan

ROBOT = rg.load("panda")
START = np.array((0.0, 0.2, 0.0, -2.1, 0.0, 2.3, 0.785))
STEP_S = 0.01
VISIT_S = 0.2
OUTCOMES = ("covered",) * 7 + ("missed", "timeout", "unreachable")


def small_run(points: int = 20, *, method: str = "resolved", holds: int = 2, error_m: float = 3e-4) -> TrackResult:
    """Every tenth visit fails in each of three ways; the error is ``error_m`` while the tool dwells or holds."""
    whole = liver_surface()
    surface = Surface(whole.points[:points], whole.normals[:points], "patch")
    settings = TrackSettings(method=method, hold_points=holds, hold_s=1.5, hold_after_s=0.5, trace_hz=1.0 / STEP_S)
    trace = _trace(surface, points, holds, error_m)
    visits = _visits(points, error_m)
    nan = float("nan")
    return TrackResult(
        surface=surface,
        settings=settings,
        motion="respiration 15 mm, 4 s, 10 % variation",
        robot="panda",
        visits=visits,
        holds=tuple(_hold(i, points * VISIT_S + 1.5 * i, error_m) for i in range(holds)),
        trace=trace,
        camera=np.column_stack((trace.stamps[::3], trace.displacement[::3] + 3e-4)),
        coverage=visits.count("covered") / points,
        confirmed=visits.count("covered") / points,
        revisits=1,
        time_per_point_s=VISIT_S,
        dwell_rms_m=error_m,
        dwell_p95_m=error_m,
        dwell_max_m=2.0 * error_m,
        hold_rms_m=error_m if holds else nan,
        hold_p95_m=error_m if holds else nan,
        hold_max_m=error_m if holds else nan,
        prediction_rms_m=error_m,
        acceleration_rms=9.0,
        acceleration_max=30.0,
        limit_violations={"position": 0, "velocity": 0},
        cycle_us={"median": 4.0, "p99": 9.0},
        duration_s=float(trace.stamps[-1]),
    )


def _trace(surface: Surface, points: int, holds: int, error_m: float) -> Trace:
    rows = round((points * VISIT_S + 1.5 * holds) / STEP_S)
    stamps = STEP_S * np.arange(rows)
    tour = stamps < points * VISIT_S
    visit = np.where(tour, stamps // VISIT_S, -1 - (stamps - points * VISIT_S) // 1.5).astype(np.intp)
    phase = np.where(tour, np.where(stamps % VISIT_S < 0.6 * VISIT_S, "approach", "dwell"), "hold")
    displacement = lujan(seed=1).positions(stamps)
    target = surface.points[np.where(tour, visit, -1 - visit).clip(0, points - 1)] + displacement
    error = np.where(phase == "approach", 5e-3 * (1.0 - stamps % VISIT_S / VISIT_S), error_m)
    q = START + 0.05 * np.sin(stamps)[:, None]
    return Trace(
        stamps=stamps,
        phase=phase,
        visit=visit,
        q=q,
        tool=target + error[:, None] * (1.0, 0.0, 0.0),
        axis=np.tile((0.0, 0.0, -1.0), (rows, 1)),
        target=target,
        displacement=displacement,
        predicted=displacement + error_m,
        error_m=error,
        scale=np.ones(rows),
        sigma_min=np.full(rows, 0.1),
    )


def _hold(point: int, start_s: float, error_m: float) -> Hold:
    return Hold(point, start_s, start_s + 0.5, error_m, error_m, error_m)


def _visits(points: int, error_m: float) -> Visits:
    outcome = np.array([OUTCOMES[i % len(OUTCOMES)] for i in range(points)])
    begun = outcome != "unreachable"
    reached = begun & (outcome != "timeout")
    start = np.where(begun, VISIT_S * np.arange(points), np.nan)
    error = np.where(reached, error_m, np.nan)
    return Visits(
        point=np.arange(points)[::-1].copy(),
        outcome=outcome,
        start_s=start,
        reached_s=np.where(reached, start + 0.6 * VISIT_S, np.nan),
        dwell_s=np.where(reached, 0.4 * VISIT_S, np.nan),
        time_s=np.where(begun, VISIT_S, np.nan),
        error_rms_m=error,
        error_p95_m=error,
        error_max_m=np.where(outcome == "missed", 2e-3, 1.3 * error),
        direction_max_rad=np.where(reached, 0.01, np.nan),
        tries=np.where(np.arange(points) == 1, 2, 1),
        verdict=np.select([outcome == "covered", reached], ["shown", "contradicted"], ""),
    )
