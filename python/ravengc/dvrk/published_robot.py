"""From a published gravity compensation file to a robot, and back.

Gravity's ten columns are those of an MTM whose first axis is vertical. The robot keeps its masses m and gets the first
moments h = m com that give the same torques there and differ least from its own,

    Y(q) [m; h] = R(q) p        for all q, on a level base, g = 9.81 m/s²

and the polynomials become elements, a pair per joint, blended as the controller does. Base-fixed elements do not turn
with gravity and the masses do: on a tilted base the robot shows what such a file is worth there.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ravengc._convert import check_type
from ravengc.disturbances import Constant, LinearSpring, Polynomial
from ravengc.dvrk.published import GRAVITY, JOINTS, Published, published_regressor
from ravengc.errors import ConfigError
from ravengc.robot import Robot
from ravengc.spec import Pose, RobotSpec

if TYPE_CHECKING:
    from ravengc.disturbances import Disturbance
    from ravengc.spec import LinkSpec

__all__ = ["published_from_robot", "robot_spec_from_published"]

Array = npt.NDArray[np.float64]
POSES = 60
SAME = 1e-9
"""N·m: torques are the same."""
DISTAL = range(1, 6)
"""Places of the links whose first moments the ten columns know: joints 2 to 6."""
ORDER = 4
"""Of the polynomials."""
PLAIN_BLEND = (0.0, 0.2, 1.0, "linear")
"""Of a joint whose directions are alike."""


def robot_spec_from_published(published: Published, mtm: RobotSpec) -> RobotSpec:
    """The MTM ``mtm`` with the file's gravity and elements; its torques are the controller's before they are clipped.

    Raises ConfigError for a file whose directions differ in gravity, which no masses do, and for another arm.
    """
    check_type(published, Published, "published")
    check_type(mtm, RobotSpec, "mtm")
    _require_mtm(mtm)
    apart = np.flatnonzero(published.positive[:10] != published.negative[:10])
    if apart.size:
        place = int(apart[0])
        values = f"{published.positive[place]:g} and {published.negative[place]:g}"
        raise ConfigError(
            f"{published.source}: gravity parameter {place + 1} is {values} in the two directions; masses have no "
            "direction: expected the first 10 of gc_dynamic_params_pos and _neg to be the same"
        )
    links = _with_moments(mtm, published.positive[:10])
    said = f"dvrk-gravity-compensation, {published.arm} {published.serial}".rstrip()
    return replace(
        mtm,
        name=f"{mtm.name}_{published.serial}" if published.serial else f"{mtm.name}_published",
        links=links,
        disturbances=_polynomials(published, mtm, said),
        description=f"{mtm.name} with the gravity and cables of a published file. LEVEL BASE ONLY: "
        f"{published.on_tilt().sentence}. First moments are exact at g = {GRAVITY} m/s^2, masses "
        f"those of {mtm.name}.",
        source=f"{said}; arm: {mtm.source}",
        mass_set="default",
        mass_sets=("default",),
        level_only=True,
    )


def _require_mtm(spec: RobotSpec) -> None:
    if len(spec.links) != JOINTS or any(link.joint != "revolute" for link in spec.links) or spec.base != Pose():
        raise ConfigError(f"{spec.name} is no level MTM of seven joints; expected dvrk_mtml or dvrk_mtmr")


def _poses() -> Array:
    return np.random.default_rng(0).uniform(-1.5, 1.5, (POSES, JOINTS))


def _columns(spec: RobotSpec) -> tuple[Array, Array]:
    """Of joints 2 to 7 in many poses: the robot's columns (rows, 4 bodies) and the file's (rows, 10)."""
    robot, level = Robot(replace(spec, disturbances=())), np.array((0.0, 0.0, -GRAVITY))
    ours = [robot.gravity_regressor(q, level)[1:] for q in _poses()]
    theirs = [published_regressor(q)[1:, :10] for q in _poses()]
    return np.concatenate(ours), np.concatenate(theirs)


def _with_moments(mtm: RobotSpec, p: Array) -> tuple[LinkSpec, ...]:
    ours, theirs = _columns(mtm)
    masses = np.array([link.mass for link in mtm.links])
    before = np.array([[link.mass * x for x in link.com] for link in mtm.links])
    given = np.hstack([masses[:, None], before]).ravel()
    sought = [4 * place + axis for place in DISTAL for axis in (1, 2, 3)]
    error = theirs @ p - ours @ given
    step, *_ = np.linalg.lstsq(ours[:, sought], error, rcond=1e-10)
    if np.abs(ours[:, sought] @ step - error).max() > SAME * max(1.0, float(np.abs(error).max())):
        raise ConfigError(f"{mtm.name} has other axes than the MTM of the file; expected dvrk_mtml or dvrk_mtmr")
    moments = before.copy()
    moments[DISTAL] += step.reshape(-1, 3)
    return tuple(_heavy(link, h) for link, h in zip(mtm.links, moments, strict=True))


def _heavy(link: LinkSpec, moment: Array) -> LinkSpec:
    if not link.mass:
        return link
    x, y, z = (moment / link.mass).tolist()
    return replace(link, com=(x, y, z), source="first moment of the published file, mass as before")


def _polynomials(published: Published, mtm: RobotSpec, source: str) -> tuple[Disturbance, ...]:
    found = []
    for joint, name in enumerate(mtm.coordinate_names[:6]):
        for direction, parameters in (("positive", published.positive), ("negative", published.negative)):
            coefficients = parameters[10 + 5 * joint : 15 + 5 * joint].tolist()
            found.append(
                Polynomial(
                    name=f"cable of {name}, {direction}",
                    joint=name,
                    coefficients=tuple(coefficients),
                    direction="positive" if direction == "positive" else "negative",
                    dead_band=float(published.dead_band[joint]),
                    saturation=float(published.saturation[joint]),
                    ratio=float(published.ratio[joint]),
                    source=source,
                )
            )
    return tuple(found)


def published_from_robot(spec: RobotSpec) -> Published:
    """A file for the published controller from an MTM's masses and elements; clipped at the joints' largest efforts.

    Raises ConfigError for gravity that the ten columns do not have and for elements other than polynomials of a joint's
    own position up to the fourth power, springs along it and constants, for directions that are blended in two ways
    at one joint, and for a joint without a largest effort.
    """
    check_type(spec, RobotSpec, "spec")
    _require_mtm(spec)
    ours, theirs = _columns(spec)
    given = np.array([[link.mass, *(link.mass * x for x in link.com)] for link in spec.links]).ravel()
    p, *_ = np.linalg.lstsq(theirs, ours @ given, rcond=None)
    left = float(np.abs(theirs @ p - ours @ given).max())
    if left > SAME:
        raise ConfigError(
            f"{spec.name}: {left:.2g} N m of its gravity is in none of the file's ten columns; expected an MTM "
            "with the axes of dvrk_mtml and dvrk_mtmr, and no mass beside the axis of joint 7"
        )
    sides = [np.concatenate([p, np.zeros(30)]) for _ in range(2)]
    for element in spec.disturbances:
        joint, coefficients, directions = _as_polynomial(element, spec)
        for side in directions:
            start = 10 + 5 * joint
            sides[side][start : start + len(coefficients)] += coefficients
    dead_band, saturation, ratio = np.array([_blend(spec, name) for name in spec.coordinate_names]).T
    effort = np.array([_largest_effort(link) for link in spec.links])
    positive, negative = sides
    return Published(
        positive=positive, negative=negative, lower=-effort, upper=effort, dead_band=dead_band,
        saturation=saturation, ratio=ratio, arm="MTML" if "mtml" in spec.name.lower() else "MTMR", source=spec.name,
    )  # fmt: skip


def _largest_effort(link: LinkSpec) -> float:
    """What a file's clip is made of: without one the controller would command nothing."""
    if link.limits.effort is None:
        raise ConfigError(f"link '{link.name}' has no limit of its effort; the file's controller clips there")
    return link.limits.effort


def _blend(spec: RobotSpec, joint: str) -> tuple[float, float, float]:
    """Dead band, saturation and ratio of a joint, of which a file has one each: that of its directed polynomials."""
    directed = [one for one in spec.disturbances if isinstance(one, Polynomial) and one.direction != "both"]
    found = {(one.dead_band, one.saturation, one.ratio, one.blend) for one in directed if one.joint == joint}
    if len(found) > 1 or any(blend != "linear" for *_, blend in found):
        raise ConfigError(f"{spec.name}: polynomials of {joint} blend otherwise than a file can say; expected one "
                          "dead_band, saturation and ratio for both directions, and blend = 'linear'")  # fmt: skip
    dead_band, saturation, ratio, _ = found.pop() if found else PLAIN_BLEND
    return dead_band, saturation, ratio


def _as_polynomial(element: Disturbance, spec: RobotSpec) -> tuple[int, tuple[float, ...], tuple[int, ...]]:
    """Joint, coefficients and directions (0: positive, 1: negative) of an element that the file can say."""
    names, both = spec.coordinate_names[:6], (0, 1)
    own = getattr(element, "of", None) in {None, getattr(element, "joint", None)}
    where = getattr(element, "joint", None)
    if own and isinstance(where, str) and where in names:
        joint = names.index(where)
        match element:
            case Constant():
                return joint, (element.torque,), both
            case LinearSpring():
                return joint, (-element.stiffness * element.rest, element.stiffness), both
            case Polynomial() if len(element.coefficients) <= ORDER + 1 and element.range is None:
                side = {"positive": (0,), "negative": (1,), "both": both}[element.direction]
                return joint, element.coefficients, side
            case _:
                pass
    raise ConfigError(
        f"{spec.name}: element '{element.name}' has no place in such a file; expected polynomials of a joint's own "
        f"position up to the power {ORDER}, without a range, on joints 1 to 6"
    )
