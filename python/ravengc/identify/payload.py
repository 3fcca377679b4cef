"""What a load weighs and where it sits, from the torques of one motion with it and without.

The difference of the torques is that of the load alone: friction, springs and the arm's own errors cancel. A load on a
link is Y (m, h, I) of that link's columns; a point mass at c has h = m c and I = m (c² 1 - c cᵀ).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ravengc._convert import as_number, as_texts, as_vector, check_type
from ravengc.errors import ArgumentError, CalibrationError, ConfigError
from ravengc.identify.recording import FloatArray, Recording, as_recordings
from ravengc.messages import did_you_mean, listed, shown
from ravengc.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["Payload", "payload"]

SAME_MOTION = 0.05
"""RMS difference of the two motions, as a share of the motion, up to which they count as the same."""
LARGEST_CONDITION = 200.0
ROUNDS = 40
REMEDY = "move the link that carries it through at least two directions against gravity, or say where it sits (com)"


@dataclass(frozen=True, slots=True, eq=False)
class Payload:
    """A load on a link: ``mass`` (kg) at ``com`` (m, link frame), with standard errors from the residuals.

    ``rms`` (n,) is what is left of the torque difference and ``difference`` (n,) its own RMS; ``condition`` is that of
    the columns that were fitted. Errors of the drives' gains are in none of these: they scale the mass.
    """

    link: str
    mass: float
    com: FloatArray
    mass_sd: float
    com_sd: FloatArray
    rms: FloatArray
    difference: FloatArray
    condition: float


def payload(
    robot: Robot,
    unloaded: Recording,
    loaded: Recording,
    *,
    link: str | None = None,
    com: npt.ArrayLike | None = None,
    lever: float | None = None,
    joints: Sequence[str] | None = None,
) -> Payload:
    """Find the load on ``link`` (the one that carries the tool unless given) from the same motion with it and without.

    With ``com`` (3,) m in the link frame known, only the mass is sought; with ``lever`` known, the distance (m) of the
    load from the frame's origin, its mass and direction; otherwise mass and first moment, the load being a point. Every
    joint may have an offset between the runs; ``joints`` names those that count, all unless given. Raises
    CalibrationError for two motions that differ and for motions that do not tell the unknowns apart.
    """
    check_type(robot, Robot, "robot")
    as_recordings((unloaded, loaded), "unloaded and loaded", robot.n)
    body = _body(robot, link)
    rows = _joints(robot, joints)
    first, second = _aligned(unloaded, loaded)
    if not (first.counts & second.counts)[:, rows].all():
        raise ArgumentError("not every torque of the joints counts; name those that were measured with joints=")
    Y = _columns(robot, second, body)[:, rows]
    difference = (second.tau - first.tau)[:, rows]
    Y, difference = Y - Y.mean(axis=0), difference - difference.mean(axis=0)
    problem = _Problem(Y.reshape(-1, 10), difference.ravel())
    if com is not None:
        mass, place = _mass_at(problem, as_vector(com, "com", 3))
        free = 1
    elif lever is not None:
        mass, place = _at_lever(problem, _distance(lever))
        free = 3
    else:
        mass, place = _anywhere(problem)
        free = 4
    return _result(robot.spec.moving_links[body].name, problem, mass, place, free, difference.shape)


def _distance(lever: float) -> float:
    distance = as_number(lever, "lever")
    if not 0.0 < distance < np.inf:
        raise ArgumentError(f"lever is {shown(lever)}; expected more than 0 m")
    return distance


def _body(robot: Robot, link: str | None) -> int:
    names = [part.name for part in robot.spec.moving_links]
    wanted = link if link is not None else robot.tip
    if not isinstance(wanted, str) or wanted not in names:
        near = did_you_mean(wanted, names)
        raise ConfigError(f"{robot.name} has no moving link {shown(wanted)}{near}; it has {listed(names)}")
    return names.index(wanted)


def _joints(robot: Robot, joints: Sequence[str] | None) -> list[int]:
    names = list(robot.spec.coordinate_names)
    if joints is None:
        return list(range(robot.n))
    chosen = as_texts(joints, "joints")
    if not chosen:
        raise ArgumentError(f"joints is empty; choose of {listed(names)}, or leave it out for all")
    for name in chosen:
        if name not in names:
            raise ConfigError(
                f"{robot.name} has no joint {shown(name)}{did_you_mean(name, names)}; it has {listed(names)}"
            )
    return [names.index(name) for name in chosen]


def _aligned(unloaded: Recording, loaded: Recording) -> tuple[Recording, Recording]:
    """The samples of both in which the arm does the same, at the lag at which it does so best."""
    samples = min(unloaded.samples, loaded.samples)
    length = 1 << (2 * samples).bit_length()
    a, b = (one.q[:samples] - unloaded.q.mean(axis=0) for one in (unloaded, loaded))
    product = np.conj(np.fft.rfft(a, length, axis=0)) * np.fft.rfft(b, length, axis=0)
    correlation = np.fft.irfft(product.sum(axis=1), length)
    most = samples // 2
    lags = np.arange(-most, most + 1)
    lag = int(lags[np.argmax(correlation[lags])])
    count = samples - abs(lag)
    first, second = (
        unloaded.take(slice(max(-lag, 0), max(-lag, 0) + count)),
        loaded.take(slice(max(lag, 0), max(lag, 0) + count)),
    )
    off = float(np.linalg.norm(second.q - first.q) / max(float(np.linalg.norm(first.q - first.q.mean(axis=0))), 1e-300))
    if off > SAME_MOTION:
        said = (
            f"the two motions differ by {100.0 * off:.1f} % of their size; expected at most {100.0 * SAME_MOTION:g} %"
        )
        raise CalibrationError(f"{said}: record the same motion, at the same speed, with the load and without")
    return first, second


def _columns(robot: Robot, recording: Recording, body: int) -> FloatArray:
    """Columns m, h, I of one link, (N, n, 10)."""
    whole = robot.inverse_dynamics_regressor_batch(
        recording.q, recording.velocity, recording.acceleration, recording.base
    )
    return whole[:, :, 10 * body : 10 * body + 10]


@dataclass(frozen=True, slots=True, eq=False)
class _Problem:
    """Rows of a link's ten columns, and the torque differences that they are to explain."""

    Y: FloatArray
    aims: FloatArray

    def errors(self, mass: float, com: FloatArray) -> FloatArray:
        return self.aims - self.Y @ (mass * _point(com))

    def slopes(self, mass: float, com: FloatArray) -> FloatArray:
        """Derivatives of the torque by mass and com, (rows, 4)."""
        by_com = [mass * (_point(com + step) - _point(com - step)) / 2.0 for step in np.eye(3)]  # exact: quadratic
        return np.asarray(self.Y @ np.column_stack([_point(com), *by_com]))


def _point(com: FloatArray) -> FloatArray:
    """The ten parameters of a unit mass at a place."""
    inertia = com @ com * np.eye(3) - np.outer(com, com)
    return np.concatenate([[1.0], com, inertia[np.triu_indices(3)]])


def _mass_at(problem: _Problem, com: FloatArray) -> tuple[float, FloatArray]:
    column = problem.Y @ _point(com)
    square = float(column @ column)
    return (float(column @ problem.aims) / square if square > 0.0 else 0.0), com


def _at_lever(problem: _Problem, lever: float) -> tuple[float, FloatArray]:
    """Mass and direction at a known distance: from the best of many directions, by Gauss-Newton on the sphere."""
    starts = [_mass_at(problem, lever * one) for one in _directions()]
    mass, com = min((one for one in starts if one[0] > 0.0), key=lambda one: _size(problem, one), default=starts[0])
    for _ in range(ROUNDS):
        across = np.linalg.svd(com[np.newaxis])[2][1:]
        slopes = problem.slopes(mass, com)
        step = np.linalg.lstsq(np.column_stack([slopes[:, 0], slopes[:, 1:] @ across.T]), problem.errors(mass, com))[0]
        turned = com + step[1:] @ across
        mass, com = _mass_at(problem, lever * turned / np.linalg.norm(turned))
        if np.abs(step).max() < 1e-12:
            break
    return mass, com


def _anywhere(problem: _Problem) -> tuple[float, FloatArray]:
    """Mass and first moment, then the place with the inertia of a point, by Gauss and Newton."""
    first = np.linalg.lstsq(problem.Y[:, :4], problem.aims)[0]
    if not first[0] > 0.0:
        raise _refusal(f"the load's mass comes out as {first[0]:.4g} kg", float(first[0]))
    mass, com = float(first[0]), first[1:] / first[0]
    for _ in range(ROUNDS):
        step = np.linalg.lstsq(problem.slopes(mass, com), problem.errors(mass, com))[0]
        mass, com = mass + float(step[0]), com + step[1:]
        if np.abs(step).max() < 1e-12:
            break
    return mass, com


def _refusal(what: str, mass: float) -> CalibrationError:
    exchanged = "are the logs with the load and without it exchanged? If not, " if mass < 0.0 else ""
    return CalibrationError(f"{what}; {exchanged}{REMEDY}")


def _size(problem: _Problem, load: tuple[float, FloatArray]) -> float:
    return float(np.linalg.norm(problem.errors(*load)))


def _directions() -> FloatArray:
    """Directions to start from: to the faces, edges and corners of a cube, (26, 3)."""
    grid = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if x or y or z], dtype=float)
    return np.asarray(grid / np.linalg.norm(grid, axis=1, keepdims=True))


def _result(link: str, problem: _Problem, mass: float, com: FloatArray, free: int, shape: tuple[int, ...]) -> Payload:
    slopes = problem.slopes(mass, com)[:, : 1 if free == 1 else 4]
    if free == 3:  # the distance is known: no slope along it
        along = com / np.linalg.norm(com)
        slopes[:, 1:] -= np.outer(slopes[:, 1:] @ along, along)
    lengths = np.linalg.norm(slopes, axis=0)
    sizes = np.linalg.svd(slopes / np.where(lengths > 0.0, lengths, 1.0), compute_uv=False)[:free]
    condition = float(sizes[0] / sizes[-1]) if sizes[-1] > 0.0 else np.inf
    if not mass > 0.0 or condition > LARGEST_CONDITION:
        what = f"the load comes out as {mass:.4g} kg, with a condition of {condition:.3g}"
        raise _refusal(what, mass)
    errors = problem.errors(mass, com)
    variance = float(errors @ errors) / max(errors.size - free, 1)
    sd = np.sqrt(np.clip(np.diag(variance * np.linalg.pinv(slopes.T @ slopes)), 0.0, None))
    com_sd = np.zeros(3) if free == 1 else sd[1:]
    rms, size = (np.sqrt((part.reshape(shape) ** 2).mean(axis=0)) for part in (errors, problem.aims))
    return Payload(link, mass, com, float(sd[0]), com_sd, rms, size, condition)
