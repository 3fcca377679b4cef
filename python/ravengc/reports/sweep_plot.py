"""One number of a sweep against one or two of the settings that were swept: lines, a map of colours, or dots."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ravengc.errors import ConfigError
from ravengc.messages import did_you_mean, listed, shown
from ravengc.reports.figures import AXIS_COLOURS, FAINT, PREDICTED, STYLE, require_matplotlib, save_figure
from ravengc.sweep.summary import check_number

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from ravengc.sweep import SweepTable

__all__ = ["check_against", "plot_sweep"]

Array = NDArray[np.float64]

FEW = 25
"""As many different values along an axis are points of a grid; more are draws."""
LINES = 4
"""As many values of a second setting are a line each; more, a map."""
BINS, LEAST_PER_BIN = 12, 5
COLOURS = (PREDICTED, *AXIS_COLOURS)
DECADES = 50.0
LOW = 0.25
"""An axis is logarithmic where the largest value is so many times the least, and the median is so far down."""


class _Axis(NamedTuple):
    """A swept setting: a position per trial, and names of the positions where they are no numbers."""

    key: str
    at: Array
    names: tuple[str, ...] = ()
    unit: str = ""

    @property
    def label(self) -> str:
        """The setting with its unit."""
        return f"{self.key}, {self.unit}" if self.unit else self.key

    @property
    def values(self) -> Array:
        """The different positions."""
        return np.unique(self.at)

    @property
    def gridded(self) -> bool:
        """Tell whether trials share positions, as those of a grid do."""
        return len(self.values) <= FEW and (len(self.values) < len(self.at) or len(self.at) <= FEW)


def plot_sweep(
    path: Path, table: SweepTable, *, number: str | None = None, against: Sequence[str] | None = None
) -> None:
    """Draw a number (None: the first) against one or two settings (None: the first that vary) into a file.

    Raises ConfigError for a number or setting that the table does not have, and where no trial has a finite value.
    """
    matplotlib = require_matplotlib("a picture of the sweep")
    check_against(table.swept, against)
    name = _number(table, number)
    values = np.asarray(table.columns[name], dtype=np.float64)
    seen = np.isfinite(values)
    if not seen.any():
        raise ConfigError(f"{name} is finite in no trial; there is nothing to draw")
    axes_of = [_axis(table, key, seen) for key in _chosen(table, against)]
    with matplotlib.rc_context({**STYLE, "svg.hashsalt": table.experiment}):
        figure = matplotlib.figure.Figure(figsize=(7.2, 4.6), layout="constrained")
        axes = figure.subplots()
        _draw(figure, axes, axes_of, values[seen])
        missing = f", {int((~seen).sum())} without it" if not seen.all() else ""
        axes.set_title(f"{table.experiment}: {name}\n{len(table)} trials{missing}")
        save_figure(figure, path)


def check_against(swept: Sequence[str], against: Sequence[str] | None) -> None:
    """Raise ConfigError unless these are one or two different settings of those that are swept."""
    if against is None:
        return
    for key in against:
        if key not in swept:
            raise ConfigError(f"{shown(key)} is not swept{did_you_mean(key, swept)} (swept: {listed(swept)})")
    if len(against) not in {1, 2} or len(set(against)) < len(against):
        raise ConfigError(f"{listed(against)} to draw against; expected one or two different settings")


def _number(table: SweepTable, number: str | None) -> str:
    if number is None and table.numbers:
        return table.numbers[0]
    check_number(table, number or "")
    return number or ""


def _chosen(table: SweepTable, against: Sequence[str] | None) -> list[str]:
    """What was asked for, or the first two settings that have more than one value."""
    if against is not None:
        return list(against)
    return [key for key in table.swept if len(set(map(str, table.columns[key]))) > 1][:2]


def _axis(table: SweepTable, key: str, seen: NDArray[np.bool_]) -> _Axis:
    column = table.columns[key]
    if isinstance(column, np.ndarray) and column.dtype.kind in "iuf":
        return _Axis(key, column[seen].astype(np.float64), unit=table.units.get(key, ""))
    texts = ["/".join(map(str, value)) if isinstance(value, tuple) else str(value) for value in column]
    names = tuple(dict.fromkeys(texts))
    return _Axis(key, np.array([names.index(text) for text in texts], dtype=np.float64)[seen], names)


def _draw(figure: Any, axes: Any, settings: list[_Axis], values: Array) -> None:
    match settings:
        case []:
            _histogram(axes, values)
        case [x] if x.gridded:
            _curve(axes, x.at, values, PREDICTED, "")
            _name_axis(axes, "x", x)
        case [x]:
            _dots(axes, x, values)
        case [x, y] if x.gridded and y.gridded and len(y.values) <= LINES:
            _lines(axes, x, y, values)
        case [x, y] if x.gridded and y.gridded:
            _map(figure, axes, x, y, values)
        case [x, y]:
            _coloured_dots(figure, axes, x, y, values)


def _histogram(axes: Any, values: Array) -> None:
    axes.hist(values, bins=min(BINS, len(values)), color=PREDICTED)
    axes.set_ylabel("trials")


def _curve(axes: Any, at: Array, values: Array, colour: str, label: str) -> None:
    """Means over a grid, and, where there are several trials at a point, from the least to the largest of them."""
    places = np.unique(at)
    groups = [values[at == place] for place in places]
    axes.plot(places, [group.mean() for group in groups], "o-", color=colour, markersize=3.5, label=label)
    if max(map(len, groups)) > 1:
        least, largest = [group.min() for group in groups], [group.max() for group in groups]
        axes.fill_between(places, least, largest, color=colour, alpha=0.15, linewidth=0.0)


def _lines(axes: Any, x: _Axis, y: _Axis, values: Array) -> None:
    for i, second in enumerate(y.values):
        among = y.at == second
        _curve(axes, x.at[among], values[among], COLOURS[i], f"{y.key} {_text(y, second)}")
    axes.legend()
    _name_axis(axes, "x", x)


def _dots(axes: Any, x: _Axis, values: Array) -> None:
    """Every draw a dot; where there are enough of them, the median and the middle 80 % along the axis."""
    axes.plot(x.at, values, "o", color=FAINT, markersize=3.0)
    bins = min(BINS, len(values) // LEAST_PER_BIN)
    if bins > 1:
        groups = np.array_split(np.argsort(x.at, kind="stable"), bins)
        middle = [np.median(x.at[group]) for group in groups]
        low, median, high = (np.array([np.quantile(values[group], q) for group in groups]) for q in (0.1, 0.5, 0.9))
        axes.fill_between(middle, low, high, color=PREDICTED, alpha=0.2, linewidth=0.0, label="middle 80 %")
        axes.plot(middle, median, color=PREDICTED, label="median")
        axes.legend()
    _name_axis(axes, "x", x)


def _map(figure: Any, axes: Any, x: _Axis, y: _Axis, values: Array) -> None:
    """Mean at every point of the grid; a point that no trial has stays empty."""
    cells = np.full((len(y.values), len(x.values)), np.nan)
    for row, second in enumerate(y.values):
        for column, first in enumerate(x.values):
            among = values[(x.at == first) & (y.at == second)]
            cells[row, column] = among.mean() if among.size else np.nan
    drawn = axes.imshow(cells, origin="lower", aspect="auto", cmap="viridis")
    axes.grid(visible=False)
    for axis, setting in ((axes.xaxis, x), (axes.yaxis, y)):
        every = -(-len(setting.values) // 10)
        axis.set_ticks(range(0, len(setting.values), every), [_text(setting, v) for v in setting.values[::every]])
        axis.set_label_text(setting.label)
    figure.colorbar(drawn, ax=axes)


def _coloured_dots(figure: Any, axes: Any, x: _Axis, y: _Axis, values: Array) -> None:
    axes.set_axisbelow(True)
    drawn = axes.scatter(x.at, y.at, c=values, s=14.0, cmap="viridis")
    _name_axis(axes, "x", x)
    _name_axis(axes, "y", y)
    figure.colorbar(drawn, ax=axes)


def _name_axis(axes: Any, which: str, setting: _Axis) -> None:
    """Name the axis "x" or "y", and choose its scale or the names along it."""
    least, largest = setting.at.min(), setting.at.max()
    axes.set(**{f"{which}label": setting.label})
    if setting.names:
        axes.set(**{f"{which}ticks": range(len(setting.names)), f"{which}ticklabels": setting.names})
    elif least > 0.0 and largest / least > DECADES and np.median(setting.at) < LOW * (least + largest):
        axes.set(**{f"{which}scale": "log"})


def _text(setting: _Axis, value: float) -> str:
    return setting.names[int(value)] if setting.names else f"{value:.4g}"
