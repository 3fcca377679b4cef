"""Files of the dVRK's control software for tests, as texts and as folders."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

__all__ = ["FILES", "gc_file", "kinematic_mtmr", "kinematic_psm_si", "physical_psm_si", "written"]

FILES: list[dict[str, Any]] = json.loads((Path(__file__).parent / "data" / "dvrk_gc_v2.json").read_text())["files"]
"""The five published files: numbers that the controller reads."""
KEYS = ("safe_upper_torque_limit", "safe_lower_torque_limit", "db_vel_vec", "sat_vec_vec", "fric_comp_ratio_vec")


def gc_file(place: int = 3, **changes: Any) -> dict[str, Any]:
    """One of the five as a file has it, with keys of ``GC_controller`` changed (``None``: left out)."""
    numbers = FILES[place]
    controller = {key: numbers[key] for key in KEYS}
    controller |= {"gc_dynamic_params_pos": numbers["pos"], "gc_dynamic_params_neg": numbers["neg"]} | changes
    kept = {key: value for key, value in controller.items() if value is not None}
    return {"ARM_NAME": numbers["arm"], "SN": numbers["serial"], "GC_controller": kept, "version": "2.0"}


def written(folder: Path, name: str, data: dict[str, Any] | str) -> Path:
    path = folder / name
    path.write_text(data if isinstance(data, str) else json.dumps(data), encoding="utf-8")
    return path


def kinematic_mtmr() -> str:
    """Text of share/kinematic/MTMR.json, comments included."""
    rows = (
        ("outer_yaw", 1.5708, 0.0, 0.0, -1.5708, -1.13446, 0.698132, 1.86082986),
        ("shoulder_pitch", 0.0, 0.2794, 0.0, -1.5708, -0.31416, 1.13446, 3.21661506),
        ("elbow_pitch", -1.5708, 0.3645, 0.0, 1.5708, -0.872665, 0.610865, 1.95978284),
        ("wrist_platform", 1.5708, 0.0, 0.1506, 0.0, -1.658, 3.5779, 0.30901338),
        ("wrist_pitch", -1.5708, 0.0, 0.0, 0.0, -1.658, 3.2288, 0.09684378),
        ("wrist_yaw", 1.5708, 0.0, 0.0, -1.5708, -0.785398, 0.785398, 0.09684378),
        ("wrist_roll", 0.0, 0.0, 0.0, 1.5708, -8.37758, 7.85398, 0.02287592),
    )
    joints = ",\n".join(
        f'{{ // {place}\n"name": "{name}", "alpha": {alpha}, "A": {a}, "theta": 0.0, "D": {d}, /* m */'
        f' "type": "revolute", "mode": "active", "offset": {offset},\n"qmin": {low}, "qmax": {high}, "ftmax": {most}}}'
        for place, (name, alpha, a, d, offset, low, high, most) in enumerate(rows, 1)
    )
    coupling = [[float(i == j) for j in range(7)] for i in range(7)]
    coupling[2][1], coupling[3][1], coupling[3][2] = -1.0, 0.6697, -0.6697
    return (
        '/* -*- Mode: Javascript -*- */\n{\n// "see" the user\'s guide\n"DH": {"convention": "standard", "joints": [\n'
        f'{joints}\n]}},\n"coupling": {{"ActuatorToJointPosition": {coupling}}}\n}}\n'
    )


def kinematic_psm_si() -> dict[str, Any]:
    """share/kinematic/PSM_Si.json."""
    rows = (
        ("yaw", "revolute", 1.5708, 1.5708, -2.964, 2.964, 17.0845),
        ("pitch", "revolute", -1.5708, -1.5708, -1.265, 1.301, 17.0845),
        ("insertion", "prismatic", 1.5708, -0.4826, 0.0, 0.29, 40.9063),
    )
    joints = [
        {"name": name, "type": kind, "alpha": alpha, "A": 0.0, "theta": 0.0, "D": 0.0, "offset": offset}
        | {"qmin": low, "qmax": high, "ftmax": effort, "mode": "active"}
        for name, kind, alpha, offset, low, high, effort in rows
    ]
    return {"DH": {"convention": "modified", "joints": joints}}


def physical_psm_si() -> dict[str, Any]:
    """share/kinematic/PSM_Si_physical.json."""
    right = 1.570796327
    rows = (
        ("yaw", right, 0.0, right, 0.0, 0.994, (-0.094, 0.082, 0.0)),
        ("intermediate yaw", -right, -0.0712, right, 0.0, 0.0, None),
        ("pitch1", 0.0, 0.2913, -2.04193, 0.0, 1.005, (0.011, -0.056, 0.0)),
        ("pitch2", 0.0, 0.20313, 1.83474, 0.0, 2.06, (0.004, -0.02, 0.0)),
        ("pitch3", 0.0, 0.346122, 0.207187, 0.0, 2.041, (0.019, 0.013, 0.0)),
        ("insertion1", -right, 0.0602, 3.14159625, -0.18, 0.0, None),
        ("insertion2", 0.0, -0.032, 0.0, -0.1215, 0.637, (0.018, 0.0, 0.06)),
    )
    joints: list[dict[str, Any]] = []
    for name, alpha, a, theta, d, mass, com in rows:
        joint = {"name": name, "alpha": alpha, "A": a, "theta": theta, "D": d}
        joint["type"] = "prismatic" if name.startswith("insertion") else "revolute"
        joint["mode"] = "passive" if name == "intermediate yaw" else "active"
        if com is not None:
            joint |= {"mass": mass, **dict(zip(("cx", "cy", "cz"), com, strict=True))}
        joints.append(joint)
    return {"DH": {"convention": "modified", "joints": joints}}
