"""The published gravity compensation of an MTM: files of dvrk-gravity-compensation, version 2, and their controller.

A file has two sets of 40 parameters, for motion in the positive and in the negative direction of each joint. The
first 10 multiply gravity's columns, the others are polynomials 1, q, ... q^4 of the joints 1 to 6:

    tau = alpha R(q) p+  +  (1 - alpha) R(q) p-,        clipped to the torques seen in training
    alpha = 0.5 up to the dead band, then linear to 0.5 + 0.5 ratio sign(v) at the saturation

Joint 1 is taken as vertical, so no column turns with the base: the file belongs to a level base.

Source: H. Lin, C. W. V. Hui, Y. Wang, A. Deguet, P. Kazanzides, K. W. S. Au, "A Reliable Gravity Compensation Control
Strategy for dVRK Robotic Arms With Nonlinear Disturbance Forces", RA-L 2019; jhu-dvrk/dvrk-gravity-compensation
@18787b3c analytical_regressor_mat.m; jhu-dvrk/sawIntuitiveResearchKit@9e535e68 robGravityCompensationMTM.cpp.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ravengc._convert import as_number, as_path, as_vector, check_type
from ravengc.config.files import write_atomically
from ravengc.config.physical import LARGEST
from ravengc.dvrk.json_file import numbers, read_json, table_of
from ravengc.errors import ArgumentError, ConfigError

if TYPE_CHECKING:
    import os

__all__ = ["Published", "TiltReport", "published_from", "published_regressor", "read_published", "write_published"]

Array = npt.NDArray[np.float64]
JOINTS, PARAMETERS = 7, 40
GRAVITY = 9.81
"""What the controller takes for g, m/s²."""
VERSION = "2.0"
LEVEL_WITHIN_DEG = 0.1
"""Tilt up to which a base counts as level: 2 thousandths of the torque."""
WEIGHT_WITHIN = 0.05
"""Share of gravity up to which a field is that of a base at rest."""
SHOWN_POSE = (0.0, 0.0, 0.0, 0.0, np.pi / 2.0, 0.0, 0.0)
"""Where the files' own test begins, in which they are compared."""
KNOWN_CHANGES = (-4.1, 4.0)
"""Changes of joint 2's torque (N·m) at a tilt of 10 deg by the five files of jhu-dvrk/dvrk_config_jhu@033a1946."""
VECTORS = {
    "gc_dynamic_params_pos": ("positive", PARAMETERS),
    "gc_dynamic_params_neg": ("negative", PARAMETERS),
    "safe_upper_torque_limit": ("upper", JOINTS),
    "safe_lower_torque_limit": ("lower", JOINTS),
    "db_vel_vec": ("dead_band", JOINTS),
    "sat_vec_vec": ("saturation", JOINTS),
    "fric_comp_ratio_vec": ("ratio", JOINTS),
}
"""Keys of a file that the controller reads, the names here, and how many numbers."""


def published_regressor(q: npt.ArrayLike) -> Array:
    """R(q), (7, 40), of q (7,) rad: columns 1 to 10 gravity, then five of each joint's polynomial, joints 1 to 6.

    With a = q2 + q3, s and c for sine and cosine; gravity's columns of joint 2 and 3 are derivatives by q2 and q3 of a
    potential that is linear in the parameters, joint 4 to 6 by q4 to q6.
    """
    _, q2, q3, q4, q5, q6, _ = angles = as_vector(q, "q", JOINTS, LARGEST)
    sa, ca = np.sin(q2 + q3), np.cos(q2 + q3)
    s4, c4, s5, c5, s6, c6 = np.sin(q4), np.cos(q4), np.sin(q5), np.cos(q5), np.sin(q6), np.cos(q6)
    rows = np.zeros((JOINTS, PARAMETERS))
    beyond = (
        ca,
        -sa,
        ca * c4,
        -ca * s4,
        -sa * c5 - ca * c4 * s5,
        ca * c4 * c5 - sa * s5,
        ca * s4 * s6 + sa * s5 * c6 - ca * c4 * c5 * c6,
        ca * s4 * c6 - sa * s5 * s6 + ca * c4 * c5 * s6,
    )
    rows[1, :2] = np.sin(q2), np.cos(q2)
    rows[1, 2:10] = rows[2, 2:10] = beyond
    rows[3, 4:10] = -s4, -c4, s4 * s5, -s4 * c5, c4 * s6 + s4 * c5 * c6, c4 * c6 - s4 * c5 * s6
    rows[3, 4:10] *= sa
    rows[4, 6:8] = -ca * s5 - sa * c4 * c5, ca * c5 - sa * c4 * s5
    rows[4, 8:10] = sa * c4 * s5 * c6 - ca * c5 * c6, ca * c5 * s6 - sa * c4 * s5 * s6
    rows[5, 8] = sa * s4 * c6 + ca * s5 * s6 + sa * c4 * c5 * s6
    rows[5, 9] = ca * s5 * c6 - sa * s4 * s6 + sa * c4 * c5 * c6
    rows *= GRAVITY
    for joint, angle in enumerate(angles[:6].tolist()):
        rows[joint, 10 + 5 * joint : 15 + 5 * joint] = angle ** np.arange(5)
    return rows


@dataclass(frozen=True, slots=True)
class TiltReport:
    """What a published file would do on a base tilted about the shoulder's axis (deg, N·m, kg·m).

    ``change`` is that of joint 2's torque, ``limit`` the clip in that direction, ``first_moment`` the file's parameter
    1 and ``spring`` its linear cable term (N·m/rad), which cancel on a level base and nowhere else.
    """

    tilt_deg: float
    level: float
    change: float
    limit: float
    first_moment: float
    spring: float

    @property
    def sentence(self) -> str:
        """The report in words."""
        low, high = KNOWN_CHANGES
        return (
            f"identified on a level base, where its first moment of {self.first_moment:+.2f} kg m and its cable of "
            f"{self.spring:+.1f} N m/rad cancel: tilted {self.tilt_deg:g} deg about the shoulder axis it asks joint 2 "
            f"for {self.change:+.2f} N m more (level {self.level:.2f}, limit {self.limit:.2f}); the five files that "
            f"dvrk_config_jhu publishes disagree by {low:+.1f} ... {high:+.1f} N m at 10 deg"
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Published:
    """One file's parameters: joint side, N·m, rad, rad/s; arrays are read-only.

    ``positive`` and ``negative`` (40,) are those of the two directions, ``lower`` and ``upper`` (7,) the clip,
    ``dead_band``, ``saturation`` (rad/s) and ``ratio`` (7,) how the directions are blended. ``arm`` is MTML or MTMR.
    Raises ArgumentError for arrays of another size, ConfigError for numbers that the controller cannot use.
    """

    positive: Array
    negative: Array
    lower: Array
    upper: Array
    dead_band: Array
    saturation: Array
    ratio: Array
    arm: str = "MTMR"
    serial: str = ""
    source: str = ""

    def __post_init__(self) -> None:
        """Freeze the arrays and check them."""
        for name, count in VECTORS.values():
            values = np.array(as_vector(getattr(self, name), name, count, LARGEST))
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        for part in ("arm", "serial", "source"):
            check_type(getattr(self, part), str, part)
        _check(self)

    def torque(self, q: npt.ArrayLike, qd: npt.ArrayLike | None = None, gravity: npt.ArrayLike | None = None) -> Array:
        """What the published controller commands, (7,) N·m, at q (7,) rad and qd (7,) rad/s; at rest without qd.

        ``gravity`` (3,) m/s², in axes of frame 0, is asked for no other reason than to refuse: ConfigError, with
        numbers, where the base does not stand level and at rest.
        """
        if gravity is not None:
            self._require_level(as_vector(gravity, "gravity", 3, LARGEST))
        rates = np.zeros(JOINTS) if qd is None else as_vector(qd, "qd", JOINTS, LARGEST)
        rows, weight = published_regressor(q), self.blend(rates)
        return np.clip(
            weight * (rows @ self.positive) + (1.0 - weight) * (rows @ self.negative), self.lower, self.upper
        )

    def blend(self, qd: npt.ArrayLike) -> Array:
        """alpha, (7,): the share of the positive direction at these rates (7,) rad/s."""
        v = as_vector(qd, "qd", JOINTS)
        ramp = np.clip((np.abs(v) - self.dead_band) / (self.saturation - self.dead_band), 0.0, 1.0)
        return 0.5 + 0.5 * self.ratio * np.sign(v) * ramp

    def on_tilt(self, degrees: float = 10.0) -> TiltReport:
        """What the file would do on a base tilted by so much about the shoulder's axis, at the files' own test pose.

        The columns of gravity know q2 and q2 + q3 alone, so that tilt is a shift of q2. A base that is mounted at a
        pitch is tilted by its negative: the shoulder's axis is -x of frame 0.
        """
        angle = as_number(degrees, "degrees")
        if not abs(angle) <= 180.0:
            raise ArgumentError(f"degrees is {degrees!r}; expected -180 to 180")
        pose, turned = np.array(SHOWN_POSE), np.array(SHOWN_POSE)
        turned[1] += np.radians(angle)
        mean = 0.5 * (self.positive + self.negative)
        difference = (published_regressor(turned) - published_regressor(pose))[1, :10] @ mean[:10]
        change, level = float(difference), float(self.torque(pose)[1])
        limit = float(self.upper[1] if change > 0.0 else self.lower[1])
        return TiltReport(angle, level, change, limit, float(mean[0]), float(mean[16]))

    def _require_level(self, gravity: Array) -> None:
        name, size = self.source or self.arm, float(np.linalg.norm(gravity))
        if not abs(size - GRAVITY) <= WEIGHT_WITHIN * GRAVITY:
            raise ConfigError(f"{name} in a field of {size:.3g} m/s^2: its first moments are for {GRAVITY}, at rest")
        tilt = float(np.degrees(np.arctan2(np.hypot(*gravity[:2]), -gravity[2])))
        if tilt > LEVEL_WITHIN_DEG:
            said = self.on_tilt(min(tilt, 90.0)).sentence
            raise ConfigError(f"{name} on a base tilted by {tilt:.1f} deg: {said}")


def _check(published: Published) -> None:
    if published.arm not in {"MTML", "MTMR"}:
        raise ConfigError(f"arm is '{published.arm}'; expected MTML or MTMR")
    rules = (
        ("upper", published.upper >= published.lower, "no less than the lower limit"),
        ("dead_band", published.dead_band >= 0.0, "0 or more"),
        ("saturation", published.saturation > published.dead_band, "more than the dead band"),
        ("ratio", (published.ratio >= 0.0) & (published.ratio <= 1.0), "0 to 1"),
    )
    keys = {name: key for key, (name, _) in VECTORS.items()}
    for name, good, expected in rules:
        if not good.all():
            joint = int(np.argmin(good))
            value = float(getattr(published, name)[joint])
            where = f"{published.source}: " if published.source else ""
            raise ConfigError(f"{where}{keys[name]}[{joint}] is {value:g}, expected {expected} (joint {joint + 1})")


def read_published(path: str | os.PathLike[str]) -> Published:
    """Read a file of version 2; ParseError or ConfigError for anything else."""
    file = as_path(path, "path")
    return published_from(read_json(file), file.name)


def published_from(data: dict[str, Any], file: str) -> Published:
    """The parameters in what was read from a file; ``file`` says in errors which."""
    top = table_of(data, file, "the file")
    if "GC_controller" not in top:
        raise top.complaint("GC_controller", "the parameters of a gravity compensation file")
    version = data.get("version")
    if str(version) not in {VERSION, "2"}:
        expected = "version 2.0; files of version 1 blend the directions otherwise: calibrate anew"
        raise ConfigError(f"{file}: version is {version!r}, expected {expected}")
    table = table_of(data["GC_controller"], file, "GC_controller")
    vectors = {name: np.array(numbers(table, key, count)) for key, (name, count) in VECTORS.items()}
    serial = data.get("SN", "")
    if not isinstance(serial, (str, int)) or isinstance(serial, bool):
        raise top.complaint("SN", "a serial number: a text or a whole number")
    return Published(**vectors, arm=top.text("ARM_NAME", "MTMR"), serial=str(serial), source=file)


def write_published(published: Published, path: str | os.PathLike[str]) -> None:
    """Write the parameters as a file of version 2, atomically."""
    check_type(published, Published, "published")
    write_atomically(as_path(path, "path"), json.dumps(published_object(published), indent=1) + "\n")


def published_object(published: Published) -> dict[str, Any]:
    """The parameters as a file has them."""
    names = {part.name for part in fields(Published)}
    controller = {key: getattr(published, name).tolist() for key, (name, _) in VECTORS.items() if name in names}
    return {
        "ARM_NAME": published.arm,
        "SN": published.serial,
        "lse": {"g_constant": GRAVITY},
        "GC_controller": {**controller, "GC_init_pos": [0, 0, 0, 0, 90, 0, 0]},
        "version": VERSION,
    }
