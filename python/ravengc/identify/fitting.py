"""Identify a robot's parameters from recordings, and say how well the result predicts what it has not seen."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ravengc._convert import check_choice, check_type
from ravengc.errors import ArgumentError
from ravengc.identify import estimators
from ravengc.identify.base_parameters import base_parameters
from ravengc.identify.bounds import Bounds
from ravengc.identify.consistent import consistent
from ravengc.identify.held_out import excitation, joint_errors, misfit, refusal, split
from ravengc.identify.identification import ESTIMATORS, Estimator, Identification
from ravengc.identify.model import Model
from ravengc.identify.recording import FloatArray, Recording, as_recordings
from ravengc.identify.reduction import Reduction, joined, reduce_rows, rows_of
from ravengc.identify.repeatability import repeatability
from ravengc.identify.weakness import weakness
from ravengc.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.identify.base_parameters import BaseParameters
    from ravengc.identify.estimators import Estimate
    from ravengc.identify.recording import BoolArray

__all__ = ["identify"]

FOLDS = 5


def identify(
    robot: Robot,
    recordings: Recording | Sequence[Recording],
    model: Model,
    estimator: Estimator = "ols",
    *,
    held_out: float | Recording | Sequence[Recording] = 0.3,
    bounds: Bounds | None = None,
) -> Identification:
    """Identify the parameters of ``model`` from one recording or several.

    ``held_out`` is the share at the end of every recording that is kept from the fit, or a recording of its own.
    ``bounds`` are what ``"consistent"`` keeps to beside the laws of bodies; it needs the extra ``identify``. Raises
    CalibrationError for recordings that do not excite the model; a fit that predicts worse than one without its extra
    columns is returned, but ``refused``, and one whose parameters are hardly told apart has ``warnings``.
    """
    check_type(robot, Robot, "robot")
    check_type(model, Model, "model")
    if bounds is not None:
        check_type(bounds, Bounds, "bounds")
    check_choice(estimator, ESTIMATORS, "estimator", ArgumentError)
    given = as_recordings(recordings, "recordings", robot.n)
    train, test = split(given, held_out, robot.n)
    fit = _Fit(robot, model, estimator, bounds or Bounds(), train, test)
    found = fit.estimate
    return Identification(
        given=robot,
        model=model,
        estimator=estimator,
        base=fit.base,
        values=fit.base.K @ found.parameters,
        parameters=found.parameters,
        formal_covariance=found.covariance,
        cross_covariance=fit.cross_covariance(),
        train=joint_errors(fit.whole, found.parameters),
        held_out=joint_errors(fit.unseen, found.parameters),
        floor=_floor((*test, *given)),
        condition=found.condition,
        tilt=max(_tilt(one) for one in train),
        refused=fit.refused(),
        warnings=weakness(robot, model, fit.base, train, fit.whole, found),
        sources=tuple(one.source for one in given),
        spans=tuple(_span(element.direction(robot.spec), train) for element in model.extras(robot.spec)),
    )


class _Fit:
    """A fit with what judges it: the same fit without a fifth of the rows, and without columns."""

    def __init__(
        self,
        robot: Robot,
        model: Model,
        estimator: Estimator,
        bounds: Bounds,
        train: tuple[Recording, ...],
        test: tuple[Recording, ...],
    ) -> None:
        self.robot, self.model, self.estimator, self.bounds, self.test = robot, model, estimator, bounds, test
        self.base = _shown(robot, model, train)
        self.folds = self._reduced(train, FOLDS)
        self.whole, self.unseen = joined(self.folds), joined(self._reduced(test))
        _check_rows(self.base, self.whole, self.unseen)
        self.estimate = self._estimate(train)
        if estimator == "huber":  # in refits, rows that are far from the fit count less as they do in it
            self.folds = self._reduced(train, FOLDS, self.estimate.parameters)

    def _reduced(
        self, recordings: Sequence[Recording], parts: int = 1, robust: FloatArray | None = None
    ) -> list[Reduction]:
        return [part for one in recordings for part in reduce_rows(self.robot, self.model, one, parts, robust)]

    def _estimate(self, train: Sequence[Recording]) -> Estimate:
        chosen = self.base.chosen
        match self.estimator:
            case "ols":
                return estimators.ordinary(self.whole, chosen)
            case "wls":
                return estimators.weighted(self.whole, chosen)
            case "huber":
                of_joints = zip(*(rows_of(self.robot, self.model, one) for one in train), strict=True)
                return estimators.huber([np.concatenate(parts) for parts in of_joints], chosen)
            case _:
                free = estimators.weighted(self.whole, chosen)
                bodies = consistent(self.robot, self.model, self.whole, free.weights, self.bounds)
                return replace(free, parameters=bodies)

    def _again(self, rows: Reduction, without: BoolArray | None = None) -> FloatArray:
        """The parameters of these rows, estimated alike in the same weights, without the marked columns."""
        weights, chosen = self.estimate.weights, self.base.chosen
        if self.estimator == "consistent":
            return consistent(self.robot, self.model, rows, weights, self.bounds, without)
        kept = chosen if without is None else chosen[~without[chosen]]
        return estimators.least_squares(rows, kept, weights).parameters

    def cross_covariance(self) -> FloatArray:
        """Jackknife over the folds: (k - 1)/k Σ (b_i - mean)(b_i - mean)ᵀ, b_i fitted alike without fold i."""
        count = len(self.folds)
        others = [joined([*self.folds[:place], *self.folds[place + 1 :]]) for place in range(count)]
        values = np.array([self.base.K @ self._again(rows) for rows in others])
        deviations = values - values.mean(axis=0)
        return np.asarray((count - 1) / count * (deviations.T @ deviations))

    def refused(self) -> str | None:
        """Why the fit must not be used, if so."""
        return refusal(self.model.groups(self.robot.spec), self.estimate.parameters, self._held_out_errors)

    def _held_out_errors(self, without: BoolArray) -> tuple[float, float]:
        """Errors of what is held out, in sigma of the fit: of the fit, and of one without the marked columns.

        Huber's counts rows by their size, not its square, that are far from the simpler fit: wild ones hide nothing.
        """
        simpler = self._again(joined(self.folds), without)
        unseen = joined(self._reduced(self.test, 1, simpler)) if self.estimator == "huber" else self.unseen
        weights = self.estimate.weights
        return misfit(unseen, self.estimate.parameters, weights), misfit(unseen, simpler, weights)


def _shown(robot: Robot, model: Model, train: Sequence[Recording]) -> BaseParameters:
    """The sums of parameters that show at the attitudes that were visited, in the torques that count."""
    visited = np.unique(np.concatenate([one.base for one in train]), axis=0)
    counted = np.concatenate([one.counts for one in train]).any(axis=0)
    return base_parameters(robot, model, visited, counted=counted)


def _check_rows(base: BaseParameters, whole: Reduction, unseen: Reduction) -> None:
    for what, reduction in (("recordings", whole), ("held_out", unseen)):
        if not reduction.samples.any():
            raise ArgumentError(f"{what}: no torque counts; give some whose torques do")
    excitation(base, whole)


def _span(direction: FloatArray, recordings: Sequence[Recording]) -> tuple[float, float]:
    """Least and most of a coordinate along a direction."""
    along = [one.q @ direction for one in recordings]
    return float(min(part.min() for part in along)), float(max(part.max() for part in along))


def _tilt(recording: Recording) -> float:
    """The largest angle between the specific force and the base's z axis, rad."""
    x, y, z = recording.base[:, :3].T
    return float(np.arctan2(np.hypot(x, y), z).max())


def _floor(recordings: Sequence[Recording]) -> FloatArray | None:
    """The repeatability of the first recording that repeats itself."""
    floors = (repeatability(one) for one in recordings)
    return next((floor for floor in floors if floor is not None), None)
