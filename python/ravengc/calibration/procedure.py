"""From a recording to a calibration: find the positions, choose the method that they allow, fit, and say what came out.

Without known tilts it is six positions, if every axis stands up and down, or twelve free ones from all around. Known
tilts give the mounting rotation as well, and bias alone where the base cannot be turned over.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import check_choice, check_type
from ravengc.calibration.ellipsoid import FEWEST_POSITIONS, LEAST_COVERAGE_DEG, fit_ellipsoid
from ravengc.calibration.imu import STANDARD_GRAVITY, FloatArray, ImuRecording, as_rows, check_unit
from ravengc.calibration.mounted import mounted
from ravengc.calibration.positions import (
    FACES,
    SAME_DEG,
    Position,
    angle_between,
    coverage_deg,
    different,
    rest_rate,
    spread_deg,
    still_positions,
)
from ravengc.calibration.six import LARGEST_LEAN_DEG, fit_six_positions, nearest_face
from ravengc.calibration.tilts import fit_tilts
from ravengc.errors import CalibrationError

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt

    from ravengc.calibration.result import Calibration
    from ravengc.calibration.still import StillLimits, StillSegment

__all__ = ["METHODS", "Outcome", "calibrate_accelerometer"]

METHODS = ("auto", "six", "ellipsoid", "tilts")
LEAST_ERROR = 1e-4
"""m/s², 0.01 milli-g; readings that repeat exactly are rounded, not that good."""
SAME_TILT_DEG = 0.5
"""Rests that follow each other and are closer than this are one of the known tilts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """A calibration and where it comes from; ``gyro_bias`` (3,), rad/s, is the mean at rest, None without gyroscope."""

    calibration: Calibration
    positions: tuple[Position, ...]
    segments: tuple[StillSegment, ...]
    recording: ImuRecording
    gyro_bias: FloatArray | None

    def block(self) -> dict[str, Any]:
        """Return the keys of the table ``[accelerometer]`` that it determines, with their values."""
        found = self.calibration
        values = {"bias": found.bias, "correction": found.correction, "rotation": found.rotation}
        if found.method == "known tilts":
            del values["correction"]
        values["gyro_bias"] = self.gyro_bias
        return {key: value.tolist() for key, value in values.items() if value is not None}


def calibrate_accelerometer(
    recording: ImuRecording,
    method: str = "auto",
    *,
    tilts: npt.ArrayLike | None = None,
    correction: npt.ArrayLike | None = None,
    declared: npt.ArrayLike | None = None,
    limits: StillLimits | None = None,
    gravity: float = STANDARD_GRAVITY,
) -> Outcome:
    """Return the calibration that the still parts of a recording allow.

    ``tilts`` (n, 3), m/s², are the specific forces in base axes of the n positions in their order
    (:func:`ravengc.calibration.tilted_force`). ``correction`` and ``declared`` (3, 3) are the scale matrix and mounting
    known before; method ``tilts`` keeps the former. Raises CalibrationError, with what was found and what is missing,
    where the positions do not allow the method, or any; UnitsError where the readings are not of length g.
    """
    check_type(recording, ImuRecording, "recording")
    check_choice(method, METHODS, "method")
    check_unit(recording, gravity)
    expected = None if tilts is None else as_rows(tilts, "tilts")
    same_deg = SAME_DEG if expected is None else SAME_TILT_DEG
    positions, segments = still_positions(recording, limits, same_deg=same_deg, in_order=expected is not None)
    try:
        chosen = _allowed(positions, expected) if method == "auto" else method
        _check_tilts(chosen, positions, expected)
        calibration = _fit(chosen, positions, expected, correction, declared, gravity)
    except CalibrationError as error:
        raise CalibrationError(f"{recording.source}: {_found(recording, segments)}: {error}") from error
    return Outcome(
        calibration=calibration,
        positions=positions,
        segments=segments,
        recording=recording,
        gyro_bias=rest_rate(segments),
    )


def _forces(positions: Sequence[Position]) -> FloatArray:
    return np.array([position.force for position in positions])


def _errors(positions: Sequence[Position]) -> FloatArray:
    return np.array([max(position.error, LEAST_ERROR) for position in positions])


def _fit(
    method: str,
    positions: Sequence[Position],
    expected: FloatArray | None,
    correction: npt.ArrayLike | None,
    declared: npt.ArrayLike | None,
    gravity: float,
) -> Calibration:
    forces, errors = _forces(positions), _errors(positions)
    if method == "tilts" and expected is not None:
        return fit_tilts(forces, expected, errors, correction=correction, declared=declared)
    if method == "six":
        return fit_six_positions(forces, errors, gravity)
    found = fit_ellipsoid(forces, errors, gravity)
    if expected is None:
        return found
    return mounted(found, forces, expected, errors, declared)


def _allowed(positions: Sequence[Position], expected: FloatArray | None) -> str:
    forces = _forces(positions)
    is_ellipsoid = different(forces) >= FEWEST_POSITIONS and coverage_deg(forces) >= LEAST_COVERAGE_DEG
    if expected is not None:
        return "ellipsoid" if is_ellipsoid else "tilts"
    if _shows_faces(forces):
        return "six"
    if is_ellipsoid:
        return "ellipsoid"
    raise CalibrationError(_too_little(forces))


def _shows_faces(forces: FloatArray) -> bool:
    """Whether all six faces are there and nothing else; the bias, which adds to the lean, is taken off first."""
    centred = forces - (forces.max(axis=0) + forces.min(axis=0)) / 2.0
    faces = [nearest_face(force) for force in centred]
    leans = [angle_between(force, FACES[face]) for force, face in zip(centred, faces, strict=True)]
    return set(faces) == set(FACES) and max(leans) <= LARGEST_LEAN_DEG


def _found(recording: ImuRecording, segments: Sequence[StillSegment]) -> str:
    """The still segments in a few words."""
    rests = [segment.force for segment in segments]
    still = sum(segment.end - segment.begin for segment in segments)
    within = f" within {spread_deg(rests):.1f} degrees of each other" if len(rests) > 1 else ""
    return f"{len(rests)} still segments ({still:.1f} s of {recording.duration:.1f} s){within}"


def _too_little(forces: FloatArray) -> str:
    count, faces = different(forces), {nearest_face(force) for force in forces}
    missing = ", ".join(face for face in FACES if face not in faces) or "none, but they lean"
    return (
        f"{count} position{'s' * (count != 1)}, coverage {coverage_deg(forces):.1f} degrees. Bias and scale take six "
        f"positions, each axis up once and down once (missing: {missing}), or at least {FEWEST_POSITIONS} free ones "
        f"that cover {LEAST_COVERAGE_DEG:g} degrees. Where the base cannot be turned over: known tilts"
    )


def _check_tilts(method: str, positions: Sequence[Position], expected: FloatArray | None) -> None:
    if expected is None:
        if method == "tilts":
            raise CalibrationError("the method tilts needs the tilt of every position (--tilts)")
        return
    if method == "six":
        raise CalibrationError("six positions need no tilts: leave them out, or take the method tilts or ellipsoid")
    if len(expected) != len(positions):
        rests = ", ".join(f"{position.begin:.1f} to {position.end:.1f} s" for position in positions[:20])
        raise CalibrationError(
            f"{len(expected)} tilts for {len(positions)} positions; expected one each, in order. Still, at least "
            f"{SAME_TILT_DEG:g} degrees from the one before: {rests}{', ...' if len(positions) > 20 else ''}"
        )
