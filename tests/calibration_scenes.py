"""Sensors with known faults in known positions: what the tests of the calibration measure with."""

from __future__ import annotations

from typing import Any

import numpy as np

from ravengc.calibration import ImuRecording
from ravengc.sensors.sample import Sample

G = 9.80665
UPPER = np.triu_indices(3)
NOISE = 0.0028
"""m/s²: 0.02 m/s² averaged over half a second at 100 Hz."""
FACES = np.vstack([np.eye(3), -np.eye(3)])
SIGMAS = 6.0


def within(found: Any, truth: Any, error: Any, slack: float = 1e-9) -> bool:
    """Whether what was found is the truth to six standard errors."""
    return bool((np.abs(np.asarray(found) - truth) <= SIGMAS * np.asarray(error) + slack).all())


def spread_of(trial: Any, count: int) -> np.ndarray:
    """Standard deviation, over random noise, of errors in units of their standard errors: 1 if these are right."""
    return np.std([trial(np.random.default_rng(seed)) for seed in range(count)], axis=0)


def a_bias(rng: np.random.Generator) -> np.ndarray:
    """Up to 0.5 m/s² along each axis."""
    return rng.uniform(-0.5, 0.5, 3)


def turn_between(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    """The small turn about base axes, rad, that leads from the true rotation to the one found."""
    turn = found @ true.T
    return np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2.0


def rotation(seed: int) -> np.ndarray:
    """A rotation, evenly from all."""
    q, r = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.linalg.det(q)


def evenly(count: int) -> np.ndarray:
    """Unit vectors all around, evenly, by the golden angle."""
    k = np.arange(count) + 0.5
    z, azimuth = 1.0 - 2.0 * k / count, np.pi * (1.0 + 5.0**0.5) * k
    return np.column_stack([np.sqrt(1 - z**2) * np.cos(azimuth), np.sqrt(1 - z**2) * np.sin(azimuth), z])


def cone(rng: np.random.Generator, count: int, degrees: float) -> np.ndarray:
    """Unit vectors up to this far from z, evenly at random."""
    z, azimuth = rng.uniform(np.cos(np.radians(degrees)), 1.0, count), rng.uniform(0.0, 2.0 * np.pi, count)
    return np.column_stack([np.sqrt(1 - z**2) * np.cos(azimuth), np.sqrt(1 - z**2) * np.sin(azimuth), z])


def correction(rng: np.random.Generator) -> np.ndarray:
    """An upper triangular S, up to 3 % from 1."""
    s = np.eye(3)
    s[UPPER] += rng.uniform(-0.03, 0.03, 6)
    return s


def readings(forces: np.ndarray, s: np.ndarray, bias: np.ndarray, rng: Any = None, noise: float = NOISE) -> np.ndarray:
    """What a sensor with f = S (s - b) says to these forces."""
    clean = forces @ np.linalg.inv(s).T + bias
    return clean if rng is None else clean + noise * rng.standard_normal(forces.shape)


def held(
    forces: np.ndarray,
    *,
    hold_s: float = 3.0,
    rate: float = 100.0,
    noise: float = 0.02,
    gyro: bool = True,
    seed: int = 0,
) -> ImuRecording:
    """A recording that holds every reading in turn, with a restless second between two of them."""
    rng = np.random.default_rng(seed)
    still, moving = round(hold_s * rate), round(rate)
    force, turning = [], []
    for number, reading in enumerate(forces):
        if number:
            force.append(np.linspace(forces[number - 1], reading, moving) + rng.standard_normal((moving, 3)))
            turning.append(rng.standard_normal((moving, 3)))
        force.append(np.tile(reading, (still, 1)))
        turning.append(np.zeros((still, 3)))
    f, w = np.vstack(force), np.vstack(turning)
    return ImuRecording(
        t=np.arange(len(f)) / rate,
        specific_force=f + noise * rng.standard_normal(f.shape),
        angular_velocity=w + [0.01, -0.02, 0.005] + 0.002 * rng.standard_normal(w.shape) if gyro else None,
    )


def rocked(
    place: tuple[float, float, float] = (0.1, -0.2, 0.3),
    *,
    axes: int = 2,
    seconds: float = 20.0,
    hz: float = 1.0,
    degrees: float = 10.0,
    noise: float = 0.03,
    gyro_noise: float = 0.002,
    gyro_bias: tuple[float, ...] = (0.01, -0.02, 0.015),
    seed: int = 1,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stamps, specific force and angular velocity of a sensor whose base rocks about x, or x and y, at its origin."""
    rng, t = np.random.default_rng(seed), np.arange(round(100 * seconds)) / 100.0

    def attitude(t: np.ndarray) -> np.ndarray:
        a = np.radians(degrees) * np.sin(2 * np.pi * hz * t)
        b = np.radians(degrees) * np.sin(2.6 * np.pi * hz * t + 1.0) * (axes > 1)
        zero, one = 0.0 * t, 1.0 + 0.0 * t
        about_x = [[one, zero, zero], [zero, np.cos(a), -np.sin(a)], [zero, np.sin(a), np.cos(a)]]
        about_y = [[np.cos(b), zero, np.sin(b)], [zero, one, zero], [-np.sin(b), zero, np.cos(b)]]
        return np.moveaxis(np.array(about_x), 2, 0) @ np.moveaxis(np.array(about_y), 2, 0)

    h, now = 1e-4, attitude(t)
    spin = np.swapaxes(now, 1, 2) @ (attitude(t + h) - attitude(t - h)) / (2 * h)
    w = np.column_stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]])
    acceleration = (attitude(t + h) - 2 * now + attitude(t - h)) @ np.array(place) / h**2
    f = np.einsum("nji,nj->ni", now, acceleration + np.array([0.0, 0.0, G]))
    return t, f + noise * rng.standard_normal(f.shape), w + gyro_bias + gyro_noise * rng.standard_normal(w.shape)


class Turned:
    """A live sensor in a hand: it shows what the question asks for, or the next of the given forces."""

    name = "sim: in a hand"

    def __init__(self, forces: Any = None, *, noise: float = 0.02, gyro: bool = True) -> None:
        self._given = None if forces is None else iter(np.asarray(forces, dtype=float))
        self._force, self._noise, self._gyro = np.array([0.0, 0.0, G]), noise, gyro
        self._rng, self._count = np.random.default_rng(7), 0
        self.asked: list[str] = []
        self.closed = False

    def ask(self, question: str) -> str:
        """Turn the sensor as it is told; "q" when there is nothing more to show."""
        self.asked.append(question)
        try:
            self._force = next(self._given) if self._given is not None else self._face(question)
        except StopIteration:
            return "q"
        return ""

    @staticmethod
    def _face(question: str) -> np.ndarray:
        if " up: " not in question:
            return np.array([0.0, 0.0, G])
        sign, axis = question.split(" up: ", maxsplit=1)[0][-2:]
        return G * np.eye(3)["xyz".index(axis)] * (1.0 if sign == "+" else -1.0)

    def read(self, timeout_s: float) -> Sample | None:
        """The next sample of 100 a second; nothing waits in a buffer."""
        if timeout_s == 0.0:
            return None
        self._count += 1
        force = self._force + self._noise * self._rng.standard_normal(3)
        rate = (0.01, -0.02, 0.005) if self._gyro else None
        return Sample(self._count, self._count * 10_000_000, tuple(force.tolist()), rate)

    def close(self) -> None:
        """Nothing to let go of, but remembered."""
        self.closed = True
