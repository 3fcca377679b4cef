"""The look of every picture, and how one is written."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ravengc.atomic import check_writable, replacing
from ravengc.errors import ConfigError, MissingExtraError

if TYPE_CHECKING:
    from pathlib import Path

__all__ = [
    "AXIS_COLOURS",
    "FAINT",
    "INK",
    "MEASURED",
    "PREDICTED",
    "STYLE",
    "check_picture",
    "require_matplotlib",
    "save_figure",
]

FORMATS = (".png", ".svg", ".pdf")

INK, FAINT = "#2b2f36", "#aab0b8"
MEASURED, PREDICTED = "#aab0b8", "#2a7f9e"
AXIS_COLOURS = ("#d1603d", "#5b9a52", "#3d6cb0")
STYLE = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titlecolor": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "axes.grid": True,
    "grid.color": "#e8eaed",
    "grid.linewidth": 0.7,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "lines.linewidth": 1.1,
}


def require_matplotlib(purpose: str) -> Any:
    """Return the package matplotlib; MissingExtraError if it is not installed."""
    try:
        import matplotlib.figure
    except ImportError as error:
        raise MissingExtraError("matplotlib", "plot", purpose) from error
    return matplotlib


def check_picture(path: Path, purpose: str) -> None:
    """Raise ConfigError or MissingExtraError if a picture could not be written to ``path``, before it is worked out."""
    _check_kind(path)
    require_matplotlib(purpose)
    check_writable(path)


def save_figure(figure: Any, path: Path) -> None:
    """Write a figure as .png, .svg or .pdf, whole or not at all; ConfigError for another suffix or a failed write."""
    _check_kind(path)
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=150)


def _check_kind(path: Path) -> None:
    if path.suffix.lower() not in FORMATS:
        known = f"{', '.join(FORMATS[:-1])} or {FORMATS[-1]}"
        raise ConfigError(f"{path}: unknown kind of picture; expected a name ending in one of {known}")
