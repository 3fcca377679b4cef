"""The report on a run over a moving surface: one HTML file with everything in it."""

from __future__ import annotations

import base64
import platform
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc.config.files import write_atomically
from ravengc.reports.experiment_page import STYLE_SHEET
from ravengc.reports.track_numbers import ROWS, cell, means, setting_text
from ravengc.track import OUTCOMES

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path

    from ravengc.track import TrackResult

__all__ = ["Report", "report_html", "write_report"]

INTRODUCTION = """\
The surface moves; the tool goes to one of its points after another, stays there with no motion relative to it, and goes
on. <b>Covered</b> is a point at which the true distance stayed within the limit during the whole dwell; points of
which later pictures do not show it are visited again, and the last visit counts. In the
<b>hold tests</b> the tool stays at single points for seconds. All errors are true distances from the moving point, not
what the controller believed."""


@dataclass(frozen=True, kw_only=True)
class Report:
    """What goes into a report: runs by name with a summary per seed, the first run of each, a picture, how it came."""

    title: str
    summaries: Mapping[str, Sequence[dict[str, Any]]]
    runs: Mapping[str, TrackResult]
    picture: bytes
    command: str
    notes: Sequence[str] = ()
    links: Mapping[str, str] = field(default_factory=dict)


def write_report(path: Path, report: Report) -> None:
    """Write :func:`report_html` to ``path``, whole or not at all; ConfigError where that fails."""
    write_atomically(path, report_html(report))


def report_html(report: Report) -> str:
    """Return one HTML document that needs no other file and no network."""
    body = [_head(report), _numbers(report), _picture(report), *map(_run, report.runs.items()), _foot(report)]
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(report.title)}</title>\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<style>{STYLE_SHEET}</style></head>\n'
        f"<body>\n<main>\n{''.join(body)}</main>\n</body></html>\n"
    )


def _head(report: Report) -> str:
    notes = "".join(f"<p class=note>{escape(note)}</p>" for note in report.notes)
    links = "".join(f'<a href="{escape(to, quote=True)}">{escape(text)}</a>' for text, to in report.links.items())
    return (
        f"<header><h1>{escape(report.title)}</h1><p>{INTRODUCTION}</p>{notes}"
        f"{f'<nav>{links}</nav>' if links else ''}</header>\n"
    )


def _numbers(report: Report) -> str:
    """One row per number, one column per run: the mean of its seeds."""
    found = {name: means(summaries) for name, summaries in report.summaries.items()}
    rows = [(escape(row.name), *(f"<b>{cell(row, numbers)}</b>" for numbers in found.values())) for row in ROWS]
    seeds = {len(summaries) for summaries in report.summaries.values()}
    of_seeds = f"<p class=note>Means of {max(seeds)} seeds; limits: the sum.</p>" if max(seeds) > 1 else ""
    return f"<section><h2>Numbers</h2>{_grid(('', *map(escape, found)), rows)}{of_seeds}</section>\n"


def _picture(report: Report) -> str:
    picture = base64.b64encode(report.picture).decode()
    return (
        "<section><h2>Picture</h2>"
        f'<figure><img alt="{escape(report.title)}" src="data:image/png;base64,{picture}"></figure></section>\n'
    )


def _run(named: tuple[str, TrackResult]) -> str:
    """A run: on what, how the visits ended, every one that did not end well, the hold tests, the settings."""
    name, run = named
    counts = ", ".join(f"{run.visits.count(outcome)} {outcome}" for outcome in OUTCOMES if run.visits.count(outcome))
    about = f"{run.robot}, {run.surface.name}, {run.motion}; {len(run.visits)} points: {counts}"
    return (
        f"<section><h2>{escape(name)}</h2><p class=source>{escape(about)}</p>{_unfinished(run)}{_holds(run)}"
        f"<details><summary>Settings</summary>{_settings(run)}</details></section>\n"
    )


def _unfinished(run: TrackResult) -> str:
    visits = run.visits
    which = np.flatnonzero(visits.outcome != "covered")
    if not len(which):
        return ""
    rows = [
        (
            str(int(visits.point[i])),
            ", ".join(f"{1e3 * x:.1f}" for x in run.surface.points[visits.point[i]]),
            escape(str(visits.outcome[i])),
            str(int(visits.tries[i])),
            escape(str(visits.verdict[i])) or "–",
            _number(visits.start_s[i], 1.0, 1),
            _number(visits.error_max_m[i], 1e3, 3),
            _number(np.rad2deg(visits.direction_max_rad[i]), 1.0, 2),
        )
        for i in which
    ]
    heads = (
        "point",
        "at, mm",
        "outcome",
        "visits",
        "pictures say",
        "set out, s",
        "largest error, mm",
        "largest angle, deg",
    )
    return f"<details><summary>{len(rows)} points were not covered</summary>{_grid(heads, rows)}</details>"


def _holds(run: TrackResult) -> str:
    if not run.holds:
        return ""
    rows = [
        (str(hold.point), *(_number(x, 1e3, 3) for x in (hold.error_rms_m, hold.error_p95_m, hold.error_max_m)))
        for hold in run.holds
    ]
    table = _grid(("point", "RMS, mm", "95 %, mm", "largest, mm"), rows)
    return f"<details><summary>{len(rows)} hold tests</summary>{table}</details>"


def _settings(run: TrackResult) -> str:
    from ravengc.experiments.settings import settings_table

    rows = [
        (f"<code>{key}</code>", escape(setting_text(value)), escape(unit), escape(text))
        for key, value, unit, _, text in settings_table(run.settings)
    ]
    return _grid(("setting", "value", "unit", "what it is"), rows)


def _number(value: float, factor: float, digits: int) -> str:
    return f"{factor * value:.{digits}f}" if np.isfinite(value) else "–"


def _grid(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    head = "".join(f"<th>{name}</th>" for name in heads)
    lines = "".join(f"<tr>{''.join(f'<td>{text}</td>' for text in row)}</tr>" for row in rows)
    return f'<div class=wide><table class="numbers"><thead><tr>{head}</tr></thead><tbody>{lines}</tbody></table></div>'


def _foot(report: Report) -> str:
    return (
        f"<footer><pre>{escape(report.command)}</pre>Python {platform.python_version()}, "
        f"NumPy {np.__version__}.</footer>\n"
    )
