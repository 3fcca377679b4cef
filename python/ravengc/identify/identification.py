"""What an identification found, with everything that says how far to believe it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from ravengc._convert import as_number, check_type
from ravengc.config import write_toml
from ravengc.errors import ArgumentError, CalibrationError
from ravengc.identify.base_parameters import BaseParameters, base_parameters
from ravengc.identify.recording import FloatArray, Recording
from ravengc.identify.robot_file import identified_spec, nearest
from ravengc.messages import shown

if TYPE_CHECKING:
    from collections.abc import Iterator
    from os import PathLike

    from ravengc.disturbances import Disturbance
    from ravengc.identify.held_out import JointErrors
    from ravengc.identify.model import Model
    from ravengc.robot import Robot
    from ravengc.spec import RobotSpec

__all__ = ["ESTIMATORS", "Estimator", "Identification"]

Estimator = Literal["ols", "wls", "huber", "consistent"]
ESTIMATORS = ("ols", "wls", "huber", "consistent")
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
    ``refused`` says why the result must not be used, ``None`` if it may be; ``warnings`` say what the recordings hardly
    tell apart, and what to record instead. ``spans`` are the least and the most that the coordinate of every element of
    the model was.
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
    warnings: tuple[str, ...]
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
        said = "".join(f"; {text}" for text in self.warnings)
        return f"{self._origin} ({how}); held-out error {held} % of the joints' RMS torque{said}"

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
        tilted = self.tilt > LEVEL
        spec = identified_spec(self.given, self.model, parameters, self.provenance, tilted=tilted)
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
