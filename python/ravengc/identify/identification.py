"""Identify a robot's parameters from recordings, and say how well the result predicts what it has not seen."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from ravengc._convert import as_number, check_choice, check_type
from ravengc.config import write_toml
from ravengc.errors import ArgumentError, CalibrationError
from ravengc.identify import estimators
from ravengc.identify.base_parameters import BaseParameters, base_parameters
from ravengc.identify.bounds import Bounds
from ravengc.identify.consistent import consistent
from ravengc.identify.held_out import JointErrors, excitation, joint_errors, refusal, split
from ravengc.identify.model import Model
from ravengc.identify.recording import FloatArray, Recording, as_recordings
from ravengc.identify.reduction import Reduction, joined, reduce_rows, rows_of
from ravengc.identify.repeatability import repeatability
from ravengc.identify.robot_file import identified_spec, nearest
from ravengc.messages import shown
from ravengc.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from os import PathLike

    import numpy.typing as npt

    from ravengc.disturbances import Disturbance
    from ravengc.identify.estimators import Estimate
    from ravengc.spec import RobotSpec

__all__ = ["Estimator", "Identification", "identify"]

Estimator = Literal["ols", "wls", "huber", "consistent"]
ESTIMATORS = ("ols", "wls", "huber", "consistent")
FOLDS = 5
LEVEL = np.radians(0.5)
"""A base that is tilted by less counts as level."""


@dataclass(frozen=True, slots=True, eq=False)
class Identification:
    """Identified parameters with everything that says how far to believe them.

    ``base`` are the base parameters, ``values`` (b,) their values, ``formal_covariance`` (b, b) what noise of
    independent samples would leave, ``cross_covariance`` what leaving out fifths of the recording does;
    ``formal_sd`` and ``cross_sd`` are the roots of their diagonals. ``parameters`` (p,) are all parameters of
    ``model``. ``train`` and ``held_out`` are the errors of every joint; ``floor`` (n,) is the RMS with which the
    motion repeats itself, where it does; ``tilt`` (rad) is how far the base's specific force turned from its z axis.
    ``refused`` says why the result must not be used, ``None`` if it may be; ``spans`` are the least and the most that
    the coordinate of every element of the model was.
    """

    given: Robot
    model: Model
    estimator: Estimator
    base: BaseParameters
    values: FloatArray
    parameters: FloatArray
    formal_covariance: FloatArray
    cross_covariance: FloatArray
    train: JointErrors
    held_out: JointErrors
    floor: FloatArray | None
    condition: float
    tilt: float
    refused: str | None
    sources: tuple[str, ...]
    spans: tuple[tuple[float, float], ...] = ()

    @property
    def rank(self) -> int:
        """Number of base parameters."""
        return self.base.rank

    @property
    def formal_sd(self) -> FloatArray:
        """Standard deviations (b,) that noise of independent samples would leave."""
        return np.asarray(np.sqrt(np.diag(self.formal_covariance)))

    @property
    def cross_sd(self) -> FloatArray:
        """Standard deviations (b,) by leaving out fifths of the recording."""
        return np.asarray(np.sqrt(np.diag(self.cross_covariance)))

    @property
    def coefficients(self) -> dict[str, float]:
        """The coefficients of the elements: friction, rotors, springs, cables, by column name."""
        names = self.model.columns(self.given.spec)
        first = len(self.model.link_columns(self.given.spec))
        return dict(zip(names[first:], self.parameters[first:].tolist(), strict=True))

    @property
    def provenance(self) -> str:
        """Where the numbers come from, in a sentence for a robot file."""
        held = ", ".join("-" if np.isnan(part) else f"{100.0 * part:.1f}" for part in self.held_out.relative)
        how = f"{self.model.kind}, estimator {self.estimator}, {self.rank} base parameters, {self._stood}"
        return f"{self._origin} ({how}); held-out error {held} % of the joints' RMS torque"

    @property
    def _origin(self) -> str:
        return f"identified from {', '.join(dict.fromkeys(self.sources))}"

    @property
    def _stood(self) -> str:
        """How the base stood, and what that leaves open."""
        counted = self.train.samples > 0
        hidden = base_parameters(self.given, self.model, "tilted", counted=counted).rank - self.rank
        left = f", {hidden} sums of parameters not shown that tilts show" if hidden > 0 else ""
        stood = "base level" if self.tilt < LEVEL else f"base tilted by up to {np.degrees(self.tilt):.1f} degrees"
        return stood + left

    @property
    def not_filed(self) -> tuple[str, ...]:
        """Names of the elements that a robot file has no form for."""
        return tuple(part.name for part in self.model.extras(self.given.spec) if part.filed is None)

    def disturbances(self, friction_share: float = 0.0) -> tuple[Disturbance, ...]:
        """What acts beside the masses, as a robot file has it: cables and offsets, and friction if it has a share.

        Control laws add it. ``friction_share`` is how much of the friction: all of it may be too much where the true
        one is less than was found.
        """
        share = as_number(friction_share, "friction_share")
        if not 0.0 <= share <= 1.0:
            raise ArgumentError(f"friction_share is {shown(friction_share)}; expected one from 0 to 1")
        first, parts = len(self.model.link_columns(self.given.spec)), []
        for element, span in zip(self.model.extras(self.given.spec), self.spans, strict=True):
            values = self.parameters[first : first + len(element.labels)]
            first += len(element.labels)
            if element.filed is not None:
                parts += [replace(one, source=self._origin) for one in element.filed(tuple(values), span, share)]
        return tuple(parts)

    def robot(self, friction_share: float = 0.0) -> RobotSpec:
        """The robot as identified; CalibrationError if the result is refused, or no body has the masses.

        What torques leave open stays as near to the robot as given as it can. To the disturbances that it had, with
        new coefficients if the model sought them, come those of :meth:`disturbances`.
        """
        if self.refused is not None:
            raise CalibrationError(f"the identification of {self.given.name} is refused: {self.refused}")
        parameters = self.parameters
        if self.estimator != "consistent":
            parameters = nearest(self.given, self.model, self.base, self.parameters)
        spec = identified_spec(self.given, self.model, parameters, self.provenance)
        return replace(spec, disturbances=(*spec.disturbances, *self._renamed(self.disturbances(friction_share))))

    def _renamed(self, elements: tuple[Disturbance, ...]) -> Iterator[Disturbance]:
        """The elements, their names other than those that the robot has already."""
        taken = {one.name for one in self.given.spec.disturbances}
        for element in elements:
            name = element.name
            while name in taken:
                name += ", more"
            taken.add(name)
            yield replace(element, name=name)

    def write(self, path: str | PathLike[str], friction_share: float = 0.0) -> None:
        """Write :meth:`robot` to a TOML file, whole or not at all."""
        write_toml(self.robot(friction_share), path)

    def predict(self, recording: Recording) -> FloatArray:
        """Joint torques of the identified model along a recording, (N, n)."""
        check_type(recording, Recording, "recording")
        torques = self.model.regressor(self.given, recording) @ self.parameters
        return np.asarray(torques.reshape(recording.q.shape) + self.model.known(self.given, recording))


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
    columns is returned, but ``refused``.
    """
    check_type(robot, Robot, "robot")
    check_type(model, Model, "model")
    if bounds is not None:
        check_type(bounds, Bounds, "bounds")
    check_choice(estimator, ESTIMATORS, "estimator", ArgumentError)
    given = as_recordings(recordings, "recordings", robot.n)
    train, test = split(given, held_out, robot.n)
    visited = np.unique(np.concatenate([one.base for one in train]), axis=0)
    measured = np.concatenate([one.counts for one in train]).any(axis=0)
    base = base_parameters(robot, model, visited, counted=measured)
    folds = [part for one in train for part in reduce_rows(robot, model, one, FOLDS)]
    whole, unseen = joined(folds), joined([part for one in test for part in reduce_rows(robot, model, one)])
    for what, reduction in (("recordings", whole), ("held_out", unseen)):
        if not reduction.samples.any():
            raise ArgumentError(f"{what}: no torque counts; give some whose torques do")
    excitation(base, whole)
    estimate = _estimate(robot, model, estimator, train, whole, base, bounds or Bounds())
    judged: Callable[[FloatArray], Reduction] = lambda _: unseen  # noqa: E731
    counted = whole
    if estimator == "huber":
        folds = [part for one in train for part in reduce_rows(robot, model, one, FOLDS, estimate.parameters)]
        counted, judged = joined(folds), _robustly(robot, model, test)

    def fit(rows: Reduction, without: npt.NDArray[np.bool_] | None = None) -> FloatArray:
        if estimator == "consistent":
            return consistent(robot, model, rows, estimate.weights, bounds or Bounds(), without)
        kept = base.chosen if without is None else base.chosen[~without[base.chosen]]
        return estimators.least_squares(rows, kept, estimate.weights).parameters

    return Identification(
        given=robot,
        model=model,
        estimator=estimator,
        base=base,
        values=base.K @ estimate.parameters,
        parameters=estimate.parameters,
        formal_covariance=estimate.covariance,
        cross_covariance=_cross_covariance(folds, base, fit),
        train=joint_errors(whole, estimate.parameters),
        held_out=joint_errors(unseen, estimate.parameters),
        floor=_floor((*test, *given)),
        condition=estimate.condition,
        tilt=max(_tilt(one) for one in train),
        refused=refusal(model.groups(robot.spec), judged, estimate, lambda without: fit(counted, without)),
        sources=tuple(one.source for one in given),
        spans=tuple(_span(element.direction(robot.spec), train) for element in model.extras(robot.spec)),
    )


def _span(direction: FloatArray, recordings: Sequence[Recording]) -> tuple[float, float]:
    """Least and most of a coordinate along a direction."""
    along = [one.q @ direction for one in recordings]
    return float(min(part.min() for part in along)), float(max(part.max() for part in along))


def _estimate(
    robot: Robot,
    model: Model,
    estimator: Estimator,
    train: tuple[Recording, ...],
    whole: Reduction,
    base: BaseParameters,
    bounds: Bounds,
) -> Estimate:
    match estimator:
        case "ols":
            return estimators.ordinary(whole, base.chosen)
        case "wls":
            return estimators.weighted(whole, base.chosen)
        case "huber":
            rows = zip(*(rows_of(robot, model, one) for one in train), strict=True)
            return estimators.huber([np.concatenate(parts) for parts in rows], base.chosen)
        case _:
            free = estimators.weighted(whole, base.chosen)
            return replace(free, parameters=consistent(robot, model, whole, free.weights, bounds))


def _tilt(recording: Recording) -> float:
    """The largest angle between the specific force and the base's z axis, rad."""
    x, y, z = recording.base[:, :3].T
    return float(np.arctan2(np.hypot(x, y), z).max())


def _floor(recordings: Sequence[Recording]) -> FloatArray | None:
    """The repeatability of the first recording that repeats itself."""
    floors = (repeatability(one) for one in recordings)
    return next((floor for floor in floors if floor is not None), None)


def _robustly(robot: Robot, model: Model, test: Sequence[Recording]) -> Callable[[FloatArray], Reduction]:
    """What is held out, with rows that are far from a fit counting less: by their size, not its square."""
    return lambda parameters: joined([part for one in test for part in reduce_rows(robot, model, one, 1, parameters)])


def _cross_covariance(
    folds: Sequence[Reduction], base: BaseParameters, fit: Callable[[Reduction], FloatArray]
) -> FloatArray:
    """Jackknife over the folds: (k - 1)/k Σ (b_i - mean)(b_i - mean)ᵀ, b_i fitted alike without fold i."""
    fits = []
    for place in range(len(folds)):
        others = joined([fold for number, fold in enumerate(folds) if number != place])
        fits.append(base.K @ fit(others))
    values = np.array(fits)
    deviations = values - values.mean(axis=0)
    return np.asarray((len(folds) - 1) / len(folds) * (deviations.T @ deviations))
