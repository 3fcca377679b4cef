"""Write the cloud that ravengc carries as ``example:organ``: what a scanner would see of a bumpy ellipsoid, with flaws.

python examples/organ_phantom.py organ.ply
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

COUNT, SEED = 4000, 7
HALF_MM = (75.0, 100.0, 42.0)
BUMP_MM, WAVE_MM = 2.5, (55.0, 70.0)
RIM = 0.86
"""The points end where the ellipsoid, seen from above, is so far from its middle to its edge."""
DISTANCE_MM = 500.0
WITHOUT_NORMAL, LOST, TWICE = 40, 20, 15
HEADER = """\
ply
format binary_little_endian 1.0
comment units: mm
element vertex {count}
property float x
property float y
property float z
property float nx
property float ny
property float nz
end_header
"""


def surface() -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3), mm, z up, and their unit normals."""
    i = np.arange(COUNT)
    radius, angle = RIM * np.sqrt((i + 0.5) / COUNT), np.pi * (3.0 - np.sqrt(5.0)) * i
    a, b, c = HALF_MM
    x, y = a * radius * np.cos(angle), b * radius * np.sin(angle)
    dome = np.sqrt(1.0 - (x / a) ** 2 - (y / b) ** 2)
    kx, ky = 2.0 * np.pi / np.array(WAVE_MM)
    z = c * dome + BUMP_MM * np.sin(kx * x) * np.cos(ky * y)
    slope_x = -c * x / a**2 / dome + BUMP_MM * kx * np.cos(kx * x) * np.cos(ky * y)
    slope_y = -c * y / b**2 / dome - BUMP_MM * ky * np.sin(kx * x) * np.sin(ky * y)
    normals = np.column_stack((-slope_x, -slope_y, np.ones(COUNT)))
    return np.column_stack((x, y, z)), normals / np.linalg.norm(normals, axis=1, keepdims=True)


def scan() -> np.ndarray:
    """Rows x y z nx ny nz (float32) in the scanner's axes, mm, flaws included."""
    points, normals = surface()
    turned = np.diag((1.0, -1.0, -1.0))
    rows = np.hstack((points @ turned + (0.0, 0.0, DISTANCE_MM), normals @ turned)).astype("<f4")
    flawed = np.random.default_rng(SEED).permutation(COUNT)
    rows[flawed[:WITHOUT_NORMAL], 3:] = 0.0
    rows[flawed[WITHOUT_NORMAL : WITHOUT_NORMAL + LOST]] = np.nan
    again = rows[flawed[-TWICE:]]
    return np.vstack((rows, again))


def main(target: Path) -> None:
    """Scan, write, and say so."""
    cloud = scan()
    target.write_bytes(HEADER.format(count=len(cloud)).encode("ascii") + cloud.tobytes())
    print(f"{target}: {len(cloud)} points")  # noqa: T201 -- a program that says what it did


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", nargs="?", type=Path, default=Path("organ.ply"), help="default: %(default)s")
    try:
        main(parser.parse_args().file)
    except OSError as error:
        sys.exit(str(error))
