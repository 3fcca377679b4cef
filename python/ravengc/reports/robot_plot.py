"""A robot's frames in space: links as lines, joint axes, centres of mass, the tool, and which way gravity points."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ravengc.reports.figures import AXIS_COLOURS, FAINT, INK, STYLE, require_matplotlib, save_figure

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import ravengc

__all__ = ["plot_robot"]

FloatArray = npt.NDArray[np.float64]
MASS_COLOUR, GRAVITY_COLOUR = "#d1963d", "#7a4fa3"
JOINT_COLOUR = AXIS_COLOURS[2]


def plot_robot(path: Path, robot: ravengc.Robot, q: Sequence[float]) -> None:
    """Draw the robot at coordinates ``q`` (rad, m) into the file ``path`` (png, svg, pdf), in base axes."""
    matplotlib = require_matplotlib("a picture of the frames")
    frames = {name: robot.forward_kinematics(q, frame=name) for name in robot.frame_names}
    points = np.vstack([[pose[:3, 3] for pose in frames.values()], _centres(robot, frames)])
    size = max(float(np.ptp(points, axis=0).max()), 0.05)
    with matplotlib.rc_context(STYLE):
        figure = matplotlib.figure.Figure(figsize=(8.0, 8.0))
        axes = figure.add_axes((0.02, 0.02, 0.96, 0.9), projection="3d")
        figure.suptitle(
            f"{robot.name}: frames at {_pose_text(robot, q)}", x=0.02, ha="left", fontweight="bold", color=INK
        )
        _draw_links(axes, robot, frames)
        _draw_frames(axes, robot, frames, 0.09 * size)
        _draw_masses(axes, robot, frames)
        corner = _set_view(axes, points, size)
        _draw_gravity(axes, corner, 0.25 * size)
        axes.legend(loc="upper right")
        save_figure(figure, path)


def _pose_text(robot: ravengc.Robot, q: Sequence[float]) -> str:
    from ravengc.coordinates import sliding

    values = zip(q, sliding(robot.spec), strict=True)
    return ", ".join(f"{value:.3g} m" if slides else f"{np.rad2deg(value):.4g}°" for value, slides in values)


def _draw_links(axes: Any, robot: ravengc.Robot, frames: dict[str, FloatArray]) -> None:
    """A line from every link's parent frame to its own, and on to the tool."""
    spec = robot.spec
    pairs = [(link.parent or "base", link.name) for link in spec.links]
    pairs.append((spec.tip or spec.links[-1].name, "tool"))
    for start, end in pairs:
        points = np.array([frames[start][:3, 3], frames[end][:3, 3]])
        axes.plot(*points.T, color=FAINT, linewidth=5.0, solid_capstyle="round", zorder=1)


def _draw_frames(axes: Any, robot: ravengc.Robot, frames: dict[str, FloatArray], length: float) -> None:
    """Axes x, y, z of every frame; a long line along the axis about or along which a joint moves."""
    for pose in frames.values():
        origin = pose[:3, 3]
        for direction, colour in zip(pose[:3, :3].T, AXIS_COLOURS, strict=True):
            axes.plot(*np.array([origin, origin + length * direction]).T, color=colour, linewidth=1.4)
    for place, names in _names_by_place(frames, 0.02 * length).items():
        axes.text(*(np.array(place) + 0.35 * length), ", ".join(names), fontsize=7.5, color=INK)
    for link in robot.spec.moving_links:
        axis = _joint_axis(robot, link.name, frames)
        axes.plot(
            *(axis[0] + np.outer((-1.6, 1.6), length * axis[1])).T, color=JOINT_COLOUR, linewidth=0.9, linestyle=":"
        )


def _names_by_place(frames: dict[str, FloatArray], near: float) -> dict[tuple[float, ...], list[str]]:
    """Frame names by origin: frames closer than ``near`` (m) share one label."""
    places: dict[tuple[float, ...], list[str]] = {}
    for name, pose in frames.items():
        origin = pose[:3, 3]
        known = next((place for place in places if np.linalg.norm(origin - place) < near), tuple(map(float, origin)))
        places.setdefault(known, []).append(name)
    return places


def _joint_axis(robot: ravengc.Robot, name: str, frames: dict[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """A point on the axis of the joint that carries a link, and its direction, in base axes."""
    from ravengc.spec import JointOrigin

    link = next(link for link in robot.spec.links if link.name == name)
    if robot.spec.convention == "standard":
        parent = frames[link.parent] if link.parent else _frame_zero(robot)
        return parent[:3, 3], parent[:3, 2]
    direction = np.array(link.placement.axis if isinstance(link.placement, JointOrigin) else (0.0, 0.0, 1.0))
    return frames[name][:3, 3], frames[name][:3, :3] @ direction


def _frame_zero(robot: ravengc.Robot) -> FloatArray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = robot.spec.base.rotation, robot.spec.base.translation
    return pose


def _draw_masses(axes: Any, robot: ravengc.Robot, frames: dict[str, FloatArray]) -> None:
    """A dot at every link's centre of mass, its area in proportion to the mass."""
    heavy = [link for link in robot.spec.links if link.mass > 0.0]
    if not heavy:
        return
    points = _centres(robot, frames)
    masses = np.array([link.mass for link in heavy])
    for link, point in zip(heavy, points, strict=True):
        line = np.array([frames[link.name][:3, 3], point])
        axes.plot(*line.T, color=MASS_COLOUR, linewidth=0.7, linestyle="--")
    area = 20.0 + 130.0 * masses / masses.max()
    axes.scatter(
        *points.T,
        s=area,
        color=MASS_COLOUR,
        edgecolor=INK,
        linewidth=0.6,
        depthshade=False,
        zorder=5,
        label="centres of mass",
    )


def _centres(robot: ravengc.Robot, frames: dict[str, FloatArray]) -> FloatArray:
    """Centres of mass of the links that have one (m, base axes), (links, 3)."""
    heavy = [link for link in robot.spec.links if link.mass > 0.0]
    return np.array([frames[link.name][:3] @ (*link.com, 1.0) for link in heavy]).reshape(-1, 3)


def _draw_gravity(axes: Any, corner: FloatArray, length: float) -> None:
    field = {"color": GRAVITY_COLOUR, "linewidth": 2.0, "label": "gravity, level"}
    axes.quiver(*corner, 0.0, 0.0, -length, arrow_length_ratio=0.25, **field)
    axes.plot([], [], color=JOINT_COLOUR, linestyle=":", label="joint axes")
    for name, colour in zip("xyz", AXIS_COLOURS, strict=True):
        axes.plot([], [], color=colour, label=f"{name} of a frame")


def _set_view(axes: Any, points: FloatArray, size: float) -> FloatArray:
    """A cube around the frames, equal scales; returns the place for the gravity arrow, at an upper edge."""
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    reach = 0.62 * size
    for name, centre in zip("xyz", middle, strict=True):
        getattr(axes, f"set_{name}lim")(centre - reach, centre + reach)
        getattr(axes, f"set_{name}label")(f"{name}, m")
    axes.set_box_aspect((1.0, 1.0, 1.0))
    axes.view_init(elev=22.0, azim=-55.0)
    corner: FloatArray = middle + reach * np.array((-0.8, 0.8, 0.9))
    return corner
