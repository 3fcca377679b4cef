"""What the pictures of the experiments share: colours and the plain kinds of chart."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

__all__ = ["LAW_COLOURS", "LAW_TITLES", "PALETTE", "STATED_LINE", "bars", "legend_below", "line_axes"]

PALETTE = ("#2a7f9e", "#d1603d", "#5b9a52", "#8a5fa8", "#c9a227", "#3d6cb0", "#7b7f86", "#b5527a")
LAW_COLOURS = {"pd": "#7b7f86", "pd+sg": "#d1603d", "pd+dg": "#2a7f9e", "pd+bm": "#5b9a52"}
LAW_TITLES = {"pd": "PD", "pd+sg": "PD+SG", "pd+dg": "PD+DG", "pd+bm": "PD+full base motion"}
WIDEST_LEGEND, LEGEND_MARK = 185, 8
"""Characters that fit under a picture, and what a mark and a gap take of them."""
STATED_LINE = {"color": "#c9a227", "linestyle": "--", "linewidth": 1.4}
"""How a number that the paper states is drawn."""


def bars(axes: Any, labels: Sequence[str], groups: Mapping[str, NDArray[np.float64]]) -> None:
    """Horizontal bars: a row of the chart per label, a bar per group in it, from the top down."""
    height = 0.8 / len(groups)
    rows = np.arange(len(labels))
    for i, (name, values) in enumerate(groups.items()):
        axes.barh(rows + (i + 0.5) * height - 0.4, values, 0.9 * height, label=name, color=PALETTE[i % len(PALETTE)])
    axes.set_yticks(rows, labels)
    axes.invert_yaxis()
    axes.set_axisbelow(True)
    axes.grid(visible=False, axis="y")


def line_axes(axes: Any, x: str, title: str) -> None:
    """Name the quantity along x below, and the one along y as the title."""
    axes.set_xlabel(x)
    axes.set_title(title)


def legend_below(figure: Any, *several: Any) -> None:
    """One legend for some charts, under all of them: every label once."""
    entries: dict[str, Any] = {}
    for axes in several:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    columns = max(1, WIDEST_LEGEND // (max(map(len, entries)) + LEGEND_MARK))
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=columns, frameon=False)
