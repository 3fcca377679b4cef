"""Units of accelerometers and gyroscopes: exact factors to SI, and how the heads of columns name them."""

from __future__ import annotations

import math

from ravengc import STANDARD_GRAVITY

__all__ = ["ACCELERATION_UNITS", "RATE_UNITS", "name_and_unit"]

ACCELERATION_UNITS = {"m/s^2": 1.0, "g": STANDARD_GRAVITY, "mg": STANDARD_GRAVITY / 1000, "cm/s^2": 0.01}
RATE_UNITS = {"rad/s": 1.0, "mrad/s": 1e-3, "deg/s": math.pi / 180}
SPELLINGS = {
    "m/s2": "m/s^2", "m/s²": "m/s^2", "m/s/s": "m/s^2", "G": "g", "dps": "deg/s", "°/s": "deg/s", "mG": "mg",
    "µs": "us", "sec": "s", "seconds": "s",
}  # fmt: skip


def name_and_unit(cell: str) -> tuple[str, str]:
    """Name and unit of ``Accelerometer X (g)``; the whole cell, and "", where no brackets end it."""
    start = max(cell.rfind("("), cell.rfind("["))
    unit = cell[start + 1 : -1].strip()
    if start < 0 or not cell.endswith((")", "]")) or ")" in unit or "]" in unit:
        return cell, ""
    return cell[:start].strip(), SPELLINGS.get(unit, unit)
