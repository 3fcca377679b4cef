"""The bundled UR5 against another description of it: the joint frames of the published URDF.

ros-industrial/universal_robot@9238b2c4 (BSD-3-Clause) ``ur_description/config/ur5/default_kinematics.yaml``: where each
joint's frame is in its parent, x y z and roll pitch yaw, from the controller's Base to the flange.
"""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ravengc
from ravengc import reference
from ravengc.reference.kinematics import rotate, translate

JOINTS = (
    (0.0, 0.0, 0.089159, 0.0, 0.0, 0.0),
    (0.0, 0.0, 0.0, 1.570796327, 0.0, 0.0),
    (-0.425, 0.0, 0.0, 0.0, 0.0, 0.0),
    (-0.39225, 0.0, 0.10915, 0.0, 0.0, 0.0),
    (0.0, -0.09465, -1.941303950897609e-11, 1.570796327, 0.0, 0.0),
    (0.0, 0.0823, -1.688001216681175e-11, 1.570796326589793, pi, pi),
)
ANGLES = st.tuples(*[st.floats(-2.0 * pi, 2.0 * pi)] * 6)
X, Y, Z = np.eye(3)
UR5 = ravengc.load("ur5")


def flange(q: tuple[float, ...]) -> np.ndarray:
    """Controller's Base <- flange, by the URDF."""
    pose = np.eye(4)
    for (x, y, z, roll, pitch, yaw), turn in zip(JOINTS, q, strict=True):
        pose = pose @ translate(np.array([x, y, z])) @ rotate(Z, yaw) @ rotate(Y, pitch) @ rotate(X, roll)
        pose = pose @ rotate(Z, turn)
    return pose


@given(q=ANGLES)
def test_the_flange_is_where_the_published_urdf_has_it(q: tuple[float, ...]) -> None:
    np.testing.assert_allclose(UR5.forward_kinematics(q), flange(q), atol=3e-9)


@pytest.mark.parametrize(
    ("q", "place"),
    [
        ((0.0,) * 6, (-0.81725, -0.19145, -0.005491)),
        ((0.0, -pi / 2.0, 0.0, -pi / 2.0, 0.0, 0.0), (0.0, -0.19145, 1.001059)),
    ],
)
def test_the_flange_in_poses_that_sums_of_lengths_tell(q: tuple[float, ...], place: tuple[float, ...]) -> None:
    """Lying along -x at the height d1 - d5, and standing up to d1 - a2 - a3 + d5; d4 + d6 to the side."""
    np.testing.assert_allclose(UR5.forward_kinematics(q)[:3, 3], place, atol=1e-9)


@given(q=ANGLES)
def test_the_mount_carries_all_links_and_the_pan_joint_none(q: tuple[float, ...]) -> None:
    """17.0489 kg in any pose; the axis of the first joint is vertical."""
    wrench = UR5.base_wrench(q, [0.0] * 6, [0.0] * 6, ravengc.Gravity.level())
    assert wrench[2] == pytest.approx(17.0489 * ravengc.STANDARD_GRAVITY)
    assert UR5.gravity_torque(q, ravengc.Gravity.level())[0] == pytest.approx(0.0, abs=1e-12)


def test_the_reference_agrees_with_the_core_on_it() -> None:
    q = (0.3, -1.2, 1.6, -1.9, -1.5, 0.4)
    expected = reference.gravity_torque(UR5.spec, q, (0.0, 0.0, -9.80665))
    np.testing.assert_allclose(UR5.gravity_torque(q, (0.0, 0.0, -9.80665)), expected, atol=1e-12)
