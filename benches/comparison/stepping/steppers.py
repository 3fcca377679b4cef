"""The libraries' steps. Each library is imported when its function is called, as not all are installed."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from comparison.arm import dh_row
from comparison.call import Call
from comparison.stepping.scene import DAMPING, DT, GAIN, ROUND, Scene, damped, pose_error

if TYPE_CHECKING:
    from collections.abc import Iterator

    from comparison.arm import Array

GAINS: Any = {"gain": GAIN, "turning_gain": GAIN, "qdd_max": np.inf, "qddd_max": np.inf}
"""Without ramps: each step begins from rates of another."""

PLACO_DT = 1.0 / GAIN
"""It goes the whole way in one step of this time."""


def ours(scene: Scene) -> Iterator[Call]:
    """The core, called with arrays and bound to them."""
    law, out = import_module("ravengc.resolved_rate").ResolvedRate, np.empty(len(scene.rate))
    for limits in ("scale", "qp", "manipulability"):
        rate = law(scene.robot, limits=limits, **GAINS)

        def track(k: int, rate: Any = rate) -> Any:
            return rate.track(scene.q[k], scene.goal[k], DT, out=out)

        yield Call("ravengc", scene.operation, f"{limits}, out=", track, 2)
        yield bound(scene, f"{limits}, bind", law(scene.robot, limits=limits, **GAINS), out)


def bound(scene: Scene, way: str, rate: Any, out: Array) -> Call:
    """Bound to the arrays of a round, in turn, as a step costs what its limits ask; for a loop, to its own."""
    made = [rate.bind(q=scene.q[k], target=scene.goal[k], out=out, dt=DT) for k in range(ROUND)]
    cycles = made * (len(scene.q) // ROUND)
    q, goal = np.empty(len(out)), np.empty((4, 4))

    def run(k: int) -> None:
        cycles[k]()

    def fill(k: int) -> None:
        q[:], goal[:] = scene.q[k], scene.goal[k]

    alone = rate.bind(q=q, target=goal, out=out, dt=DT)
    return Call("ravengc", scene.operation, way, run, 1, lambda _: out.copy(), fill=fill, alone=alone, varied=True)


def pinocchio(scene: Scene) -> Iterator[Call]:
    """Frame Jacobian and log6 in C++, damped least squares in NumPy."""
    pin = __import__("pinocchio")
    model = pin.buildModelFromXML(urdf(scene))
    data, tool = model.createData(), model.getFrameId("tool")

    def step(k: int) -> Any:
        pin.computeJointJacobians(model, data, scene.q[k])
        pin.updateFramePlacement(model, data, tool)
        rows = pin.getFrameJacobian(model, data, tool, pin.LOCAL)
        return damped(rows, GAIN * pin.log6(data.oMf[tool].actInv(pin.SE3(scene.goal[k]))).vector)

    yield Call("pinocchio", scene.operation, "log6, numpy", step, 2)


def placo(scene: Scene) -> Iterator[Call]:
    """The frame task of its QP solver, with and without velocity limits; joint positions and goal are set each time."""
    library = __import__("placo")
    for limited in (False, True):
        with TemporaryDirectory() as folder:
            Path(folder, "robot.urdf").write_text(urdf(scene), encoding="utf-8")
            robot = library.RobotWrapper(folder, library.Flags.ignore_collisions)
        solver = library.KinematicsSolver(robot)
        solver.dt = PLACO_DT
        solver.mask_fbase(True)
        solver.enable_velocity_limits(limited)
        task = solver.add_frame_task("tool", np.eye(4))
        task.configure("tool", "soft", 1.0, 1.0)
        solver.add_regularization_task(DAMPING**2)

        def step(k: int, robot: Any = robot, solver: Any = solver, task: Any = task) -> Any:
            robot.state.q[7:] = scene.q[k]
            robot.update_kinematics()
            task.T_world_frame = scene.goal[k]
            return solver.solve(False)

        way = "velocity limits" if limited else "no limits"
        yield Call("placo", scene.operation, way, step, 2, value=lambda moved: moved[6:] / PLACO_DT)


def kdl(scene: Scene) -> Iterator[Call]:
    """ChainIkSolverVel_wdls after a pose difference, with KDL's own arrays and frames filled beforehand."""
    library = __import__("PyKDL")
    from comparison.libraries.kdl import build, entries, filled

    chain = build(scene.arm)
    solver, pose = library.ChainIkSolverVel_wdls(chain), library.ChainFkSolverPos_recursive(chain)
    solver.setLambda(DAMPING)
    q = [filled(at) for at in scene.q]
    turned = [library.Rotation(*map(float, T[:3, :3].ravel())) for T in scene.goal]
    goal = [library.Frame(R, library.Vector(*T[:3, 3])) for R, T in zip(turned, scene.goal, strict=True)]
    now, out = library.Frame(), library.JntArray(len(scene.rate))

    def step(k: int) -> Any:
        pose.JntToCart(q[k], now)
        solver.CartToJnt(q[k], library.diff(now, goal[k], 1.0 / GAIN), out)
        return out

    yield Call("PyKDL", scene.operation, "wdls, unconverted", step, 2, value=entries)


def toolbox(scene: Scene) -> Iterator[Call]:
    """Its kinematics in C with damped least squares in NumPy, and its pseudo-inverse with ``angle_axis``."""
    from comparison.libraries.toolbox import build

    transforms = build(scene.arm).ets()
    pose, jacobian = transforms.eval, transforms.jacob0
    angle_axis = __import__("roboticstoolbox").angle_axis

    def step(k: int) -> Any:
        at = scene.q[k]
        return damped(jacobian(at), GAIN * pose_error(pose(at), scene.goal[k]))

    def inverse(k: int) -> Any:
        at = scene.q[k]
        return np.linalg.pinv(jacobian(at)) @ (GAIN * angle_axis(pose(at), scene.goal[k]))

    yield Call("roboticstoolbox", scene.operation, "kernels, numpy", step, 2)
    yield Call("roboticstoolbox", scene.operation, "angle_axis, pinv", inverse, 2)


STEPPERS = {"ravengc": ours, "pinocchio": pinocchio, "placo": placo, "PyKDL": kdl, "roboticstoolbox": toolbox}


def urdf(scene: Scene) -> str:
    """The arm as a URDF, for those who read nothing else; a turn about x is all that its frames need."""
    links, parent = ['<link name="base"/>'], "base"
    for link, limit in zip(scene.spec.links, scene.spec.coordinate_limits, strict=True):
        pose = scene.arm.placement(link)
        place = origin(pose[:3, 3], (dh_row(link).alpha, 0.0, 0.0))
        links.append(
            f'<link name="{link.name}"><inertial><mass value="{link.mass}"/>'
            f'<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
            f'<joint name="{link.joint_name}" type="revolute">{between(parent, link.name)}{place}'
            f'<axis xyz="0 0 1"/><limit lower="{limit.lower}" upper="{limit.upper}" velocity="{limit.velocity}"'
            f' effort="{limit.effort}"/></joint>'
        )
        parent = link.name
    tip = f'<joint name="to_tool" type="fixed">{between(parent, "tool")}{origin(scene.arm.tool)}</joint>'
    return f'<robot name="arm">{"".join(links)}<link name="tool"/>{tip}</robot>'


def between(parent: str, child: str) -> str:
    return f'<parent link="{parent}"/><child link="{child}"/>'


def origin(place: Any, turn: Any = (0.0, 0.0, 0.0)) -> str:
    return f'<origin xyz="{" ".join(map(repr, map(float, place)))}" rpy="{" ".join(map(repr, map(float, turn)))}"/>'
