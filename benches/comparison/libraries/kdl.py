"""Orocos KDL: gravity is given to a solver's constructor, so a new vector takes a new solver.

Its own arrays are filled beforehand and its results stay in them, but for the Jacobian, which is copied to an array.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import PyKDL as kdl  # noqa: N813

from comparison.arm import LEVEL, Arm
from comparison.call import Call

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    Arrays = list[kdl.JntArray]


def build(arm: Arm) -> kdl.Chain:
    """The chain, a joint at the root of each segment."""
    chain = kdl.Chain()
    for link in arm.spec.links:
        pose = arm.placement(link)
        rotation = kdl.Rotation(*map(float, pose[:3, :3].ravel()))
        tip = kdl.Frame(rotation, kdl.Vector(*map(float, pose[:3, 3])))
        xx, xy, xz, yy, yz, zz = link.inertia
        body = kdl.RigidBodyInertia(link.mass, kdl.Vector(*link.com), kdl.RotationalInertia(xx, yy, zz, xy, xz, yz))
        joint = kdl.Joint(link.name, tip.p, rotation.UnitZ(), kdl.Joint.RotAxis)
        chain.addSegment(kdl.Segment(link.name, joint, tip, body))
    chain.addSegment(kdl.Segment("tool", kdl.Joint("to tool", kdl.Joint.Fixed), kdl.Frame(kdl.Vector(*arm.tool))))
    return chain


def filled(x: Any) -> kdl.JntArray:
    array = kdl.JntArray(len(x))
    for i, number in enumerate(x):
        array[i] = float(number)
    return array


def entries(array: kdl.JntArray) -> Any:
    return np.array([array[i] for i in range(array.rows())])


def calls(arm: Arm) -> Iterator[Call]:
    """All but the moving base and the regressor."""
    chain, level = build(arm), kdl.Vector(*LEVEL)
    Q, V, A = ([filled(x) for x in values] for values in (arm.q, arm.qd, arm.qdd))

    def call(operation: str, way: str, run: Callable[[int], Any], fetches: int, value: Any = np.asarray) -> Call:
        return Call("PyKDL", operation, way, run, fetches, value)

    yield call("gravity", "new ChainDynParam, JntToGravity", gravity(chain, arm, Q), 2, entries)
    yield call("kinematics", "JntToCart, unconverted", kinematics(chain, Q), 1, homogeneous)
    yield call("jacobian", "JntToJac, copied", jacobian(chain, Q), 1)
    yield call("inverse_dynamics", "CartToJnt", inverse_dynamics(chain, level, Q, V, A), 3, entries)
    matrix, mass = kdl.JntSpaceInertiaMatrix(arm.n), kdl.ChainDynParam(chain, level).JntToMass

    def square(_: Any) -> Any:
        return np.array([[matrix[i, j] for j in range(arm.n)] for i in range(arm.n)])

    yield call("mass_matrix", "JntToMass, unconverted", lambda k: mass(Q[k], matrix), 1, square)


def gravity(chain: kdl.Chain, arm: Arm, Q: Arrays) -> Callable[[int], Any]:
    G, out, solver = [kdl.Vector(*map(float, g)) for g in arm.g], kdl.JntArray(arm.n), kdl.ChainDynParam

    def run(k: int) -> Any:
        solver(chain, G[k]).JntToGravity(Q[k], out)
        return out

    return run


def kinematics(chain: kdl.Chain, Q: Arrays) -> Callable[[int], Any]:
    solver, out = kdl.ChainFkSolverPos_recursive(chain), kdl.Frame()

    def run(k: int) -> Any:
        solver.JntToCart(Q[k], out)
        return out

    return run


def homogeneous(frame: kdl.Frame) -> Any:
    return np.array([[frame[i, j] for j in range(4)] for i in range(3)] + [[0.0, 0.0, 0.0, 1.0]])


def jacobian(chain: kdl.Chain, Q: Arrays) -> Callable[[int], Any]:
    n = chain.getNrOfJoints()
    solver, columns, out = kdl.ChainJntToJacSolver(chain), kdl.Jacobian(n), np.empty((6, n))
    places = [(i, j) for i in range(6) for j in range(n)]

    def run(k: int) -> Any:
        solver.JntToJac(Q[k], columns)
        out.flat[:] = [columns[place] for place in places]
        return out

    return run


def inverse_dynamics(chain: kdl.Chain, level: kdl.Vector, Q: Arrays, V: Arrays, A: Arrays) -> Callable[[int], Any]:
    solver, out = kdl.ChainIdSolver_RNE(chain, level), kdl.JntArray(chain.getNrOfJoints())
    no_loads = [kdl.Wrench() for _ in range(chain.getNrOfSegments())]

    def run(k: int) -> Any:
        solver.CartToJnt(Q[k], V[k], A[k], no_loads, out)
        return out

    return run
