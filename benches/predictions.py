"""How well targets are predicted: every method and the switch, on every recording, at each horizon.

`python benches/predictions.py` takes breathing after Lujan (15 mm in 4 s, seen at 30 Hz with 0.3 mm of noise) and the
two recordings of chest markers in `tests/data/respiration`. `--chest FOLDER` takes all recordings of a folder in that
form (27 are published with Pohl et al. 2022, arXiv 2106.01100), `--heart FOLDER` the points on a beating heart of Zhang
et al. 2022 (doi 10.1109/LSP.2022.3154317, `measuresInvivo.mat`, `measuresPhantom.mat`; needs scipy). The code is 1 if
the switch is somewhere worse than the best single method by more than 5 %, or worse than holding still. Spikes are
drawn several times: the row, and the judgement, are the median's, and the worst draw is printed with them.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

import ravengc as rg

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SHIPPED = Path(__file__).parents[1] / "tests" / "data" / "respiration"
SINGLE = ("hold", "velocity", "acceleration", "fourier", "autoregressive", "periodic")
DIRECTION = np.array([0.95, 0.27, 0.15]) / np.linalg.norm([0.95, 0.27, 0.15])
RATE, NOISE = 30.0, 3e-4
BAR = 1.05
DRAWS = 5
"""Of spikes."""


class Recording(NamedTuple):
    """Samples of a target, m, and where it truly was, which for a recording is what was recorded."""

    name: str
    stamps: Array
    places: Array
    clean_stamps: Array
    clean: Array
    rate: float
    horizons: tuple[float, ...]
    from_s: float = 25.0
    band: tuple[float, float] = (0.08, 1.0)
    noise: float = 1e-4
    harmonics: int = 2


def lujan(seed: int, spread: float, seconds: float = 120.0) -> Recording:
    """Breaths A sin^4(pi (t - t_k)/T_k), each with its own size and length, as seen by a camera."""
    rng, breaths, begin = np.random.default_rng(seed), [], 0.0
    while begin < seconds + 2:
        size, length = 1 + spread * np.clip(rng.normal(size=2), -2.5, 2.5)
        breaths.append((begin, 0.015 * size, 4.0 * length))
        begin += 4.0 * length
    fine = np.arange(0.0, seconds + 1.0, 1e-3)
    begins, sizes, lengths = np.array(breaths).T
    k = np.searchsorted(begins, fine, side="right") - 1
    clean = (sizes[k] * np.sin(np.pi * (fine - begins[k]) / lengths[k]) ** 4)[:, None] * DIRECTION
    stamps = np.arange(0.0, seconds, 1 / RATE)
    seen = _between(stamps, fine, clean) + np.random.default_rng(10_000 + seed).normal(0, NOISE, (len(stamps), 3))
    name = f"Lujan, {100 * spread:.0f} % varied, seed {seed}"
    return Recording(name, stamps, seen, fine, clean, RATE, (0.05, 0.077, 0.1, 0.2, 0.4), noise=NOISE)


def chest(path: Path) -> Recording:
    """Markers: stamps in ms, places in mm, with decimal commas; the last rows may be padding."""
    rows = [line.replace(",", ".").split(";") for line in path.read_text(encoding="utf-8").splitlines()[1:] if line]
    table = np.array([[float(entry) for entry in row[1:5]] for row in rows if len(row) >= 5])
    stamps, places = table[:, 0] / 1e3, table[:, 1:] / 1e3
    while stamps[-1] <= stamps[-2]:
        stamps, places = stamps[:-1], places[:-1]
    kept = _in_order(stamps)
    return Recording(path.stem[8:19], stamps, places, stamps[kept], places[kept], 10.0, (0.1, 0.5))


def spiky(recording: Recording, seed: int) -> Recording:
    """The same at half the rate, with a spike of about 20 mm in every twentieth sample."""
    rng = np.random.default_rng(seed)
    stamps, places = recording.stamps[::2], recording.places[::2].copy()
    places[19::20] += 0.02 * rng.standard_normal(places[19::20].shape)
    return recording._replace(name=recording.name + ", spiky", stamps=stamps, places=places, rate=5.0, horizons=(0.2,))


def heart(path: Path) -> Recording:
    """Three coordinates of a point, mm, at 25 Hz."""
    from scipy.io import loadmat

    places = loadmat(path)["measures"][:3].T / 1e3
    stamps, beats = np.arange(len(places)) / 25.0, "Phantom" in path.stem
    return Recording(
        path.stem.removeprefix("measures"), stamps, places, stamps, places, 25.0, (0.08,), 15.0,
        (0.5, 3.0) if beats else (0.08, 1.0), harmonics=5,
    )  # fmt: skip


def _in_order(stamps: Array) -> list[int]:
    kept = [0]
    for i in range(1, len(stamps)):
        if 0 < stamps[i] - stamps[kept[-1]] < 5:
            kept.append(i)
    return kept


def _between(at: Array, stamps: Array, places: Array) -> Array:
    return np.stack([np.interp(at, stamps, axis) for axis in places.T], axis=1)


def errors(recording: Recording, horizon: float, method: str) -> Array:
    """Distances (m) of predictions from where the target was, one per sample."""
    way: dict[str, Any] = {"method": method}
    predictor = rg.Predictor(
        recording.rate, **way, horizon_s=horizon, band=recording.band, noise=recording.noise,
        harmonics=recording.harmonics, start_s=12.0,
    )  # fmt: skip
    asked, said, last = [], [], recording.clean_stamps[-1]
    newest = -np.inf
    for stamp, place in zip(recording.stamps, recording.places, strict=True):
        predictor.update(stamp, place)
        if newest < stamp < newest + 5 or newest == -np.inf:
            newest = stamp
            if recording.from_s < stamp <= last - horizon:
                asked.append(stamp + horizon)
                said.append(predictor.predict(stamp + horizon))
    truth = _between(np.array(asked), recording.clean_stamps, recording.clean)
    found: Array = np.linalg.norm(np.array(said) - truth, axis=1)
    return found


def rms(distances: Array) -> float:
    """Root mean square, mm."""
    return 1e3 * float(np.sqrt(np.mean(distances**2)))


def cases(options: argparse.Namespace) -> Iterator[list[Recording]]:
    """All that are there, each with its draws: one, but for spikes."""
    yield [lujan(0, 0.0)]
    yield from ([lujan(seed, 0.1)] for seed in range(options.seeds))
    for path in sorted((options.chest or SHIPPED).glob("*.csv")):
        recording = chest(path)
        yield [recording]
        yield [spiky(recording, seed) for seed in range(DRAWS)]
    if options.heart:
        yield from ([heart(options.heart / f"measures{name}.mat")] for name in ("Invivo", "Phantom"))


def compared(recording: Recording, horizon: float) -> Array:
    """RMS of each method, of the switch, its 95th percentile (mm), and its ratio to the best of them and to hold."""
    single = [rms(errors(recording, horizon, method)) for method in SINGLE]
    found = errors(recording, horizon, "switch")
    switch = rms(found)
    return np.array([*single, switch, 1e3 * np.quantile(found, 0.95), switch / min(single), switch / single[0]])


def marked(ratio: float, bar: float, digits: int) -> str:
    """The ratio, with a star if it is beyond the bar."""
    return f"{ratio:.{digits}f}" + ("*" if ratio > bar else "")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--chest", type=Path, help="folder with recordings of markers (*.csv)")
    parser.add_argument("--heart", type=Path, help="folder with measuresInvivo.mat and measuresPhantom.mat")
    parser.add_argument("--seeds", type=int, default=3, help="breathing patients (3)")
    options = parser.parse_args()
    table = Table(
        "target", "ahead ms", *SINGLE, "switch", "p95", "/best", "/hold", box=SIMPLE_HEAD, title="RMS error, 3-D, mm"
    )
    judged, drawn = [], []
    for draws in cases(options):
        for horizon in draws[0].horizons:
            each = np.array([compared(recording, horizon) for recording in draws])
            *numbers, to_best, to_hold = np.median(each, axis=0)
            judged.append((to_best, to_hold))
            drawn += each[:, -2:].tolist()
            marks = [marked(to_best, BAR, 3), marked(to_hold, 1.0, 2)]
            table.add_row(draws[0].name, f"{1e3 * horizon:.0f}", *(f"{number:.2f}" for number in numbers), *marks)
    console = Console(width=None if sys.stdout.isatty() else 160)
    console.print(table)
    (best, hold), (best_drawn, hold_drawn) = np.max(judged, axis=0), np.max(drawn, axis=0)
    mean = np.mean(judged, axis=0)[0]
    print(f"the switch to the best single method: mean {mean:.3f}, worst {best:.3f} (bar {BAR})", end=", ")
    print(f"worst draw {best_drawn:.3f}")
    print(f"the switch to hold: worst {hold:.3f} (bar 1), worst draw {hold_drawn:.3f}")
    return int(best > BAR or hold > 1)


if __name__ == "__main__":
    sys.exit(main())
