"""The paper's experiments, its open questions and the moving-base literature, each named, seeded and documented.

``EXPERIMENTS`` has them by name, in the order of the report; :func:`run_experiment` runs one, :func:`run_all` several
on a pool of processes. ``ravengc reproduce`` runs them all and writes the report.

>>> from ravengc.experiments import EXPERIMENTS, run_experiment, settings_from
>>> ship = EXPERIMENTS["ship"]
>>> settings = settings_from(ship.settings, {"roll_deg": 5.0})
>>> outcome = run_experiment(ship, settings)
>>> outcome.numbers["accelerometer_j1"] < outcome.numbers["tilt_j1"] < outcome.numbers["sg_j1"]
True
"""

from __future__ import annotations

from ravengc.experiments.acceleration_step import ACCELERATION_STEP
from ravengc.experiments.base_feedback import BASE_FEEDBACK
from ravengc.experiments.base_wrench import BASE_WRENCH
from ravengc.experiments.cartesian_sinusoids import CARTESIAN_SINUSOIDS
from ravengc.experiments.experiment import (
    Experiment,
    Finding,
    Outcome,
    Settings,
    Table,
    run_experiment,
    setting,
    settings_from,
    settings_table,
)
from ravengc.experiments.moving_base_terms import MOVING_BASE_TERMS
from ravengc.experiments.newton_euler import NEWTON_EULER
from ravengc.experiments.rocking import ROCKING
from ravengc.experiments.ship import SHIP
from ravengc.experiments.static_poses import STATIC_POSES

__all__ = [
    "EXPERIMENTS",
    "Experiment",
    "Finding",
    "Outcome",
    "Settings",
    "Table",
    "run_experiment",
    "setting",
    "settings_from",
    "settings_table",
]

EXPERIMENTS: dict[str, Experiment] = {
    experiment.name: experiment
    for experiment in (
        STATIC_POSES,
        CARTESIAN_SINUSOIDS,
        ROCKING,
        ACCELERATION_STEP,
        BASE_FEEDBACK,
        MOVING_BASE_TERMS,
        SHIP,
        BASE_WRENCH,
        NEWTON_EULER,
    )
}
"""By name, in the order of the report."""
