"""The report on an identification: one HTML file with everything in it, the pictures and the numbers beside it."""

from __future__ import annotations

import base64
import io
import json
import platform
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc.config.files import write_atomically
from ravengc.reports.experiment_page import STYLE_SHEET
from ravengc.reports.figures import save_figure
from ravengc.reports.identify_plot import draw_torques, draw_uncertainty

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path

    from ravengc.identify import Identification, Recording

__all__ = ["report_html", "write_report"]

INTRODUCTION = """\
Parameters were fitted to one part of the logs and tested on the other, which is <b>held out</b>. Torques show sums of
parameters only; what no torque shows stays as it was in the robot's file. The <b>formal</b> standard deviation takes
errors for independent noise, which they seldom are; the <b>cross-validated</b> one is how far the result moves when a
fifth of the logs is left out."""
PICTURES = {"torques": "Torques", "uncertainty": "How sure it is"}


def write_report(
    folder: Path,
    found: Identification,
    train: Sequence[Recording],
    held: Sequence[Recording],
    about: Mapping[str, Any],
) -> None:
    """Write report.html, torques and uncertainty as .png and .svg, and results.json to a folder, each whole or not.

    ``about`` are the numbers as plain data. Raises MissingExtraError without matplotlib and
    ConfigError for a failed write.
    """
    figures = {"torques": draw_torques(found, train, held), "uncertainty": draw_uncertainty(found, train)}
    for name, figure in figures.items():
        for suffix in (".png", ".svg"):
            save_figure(figure, folder / f"{name}{suffix}")
    numbers = json.dumps(dict(about), indent=2, ensure_ascii=False, allow_nan=False)
    write_atomically(folder / "results.json", f"{numbers}\n")
    write_atomically(folder / "report.html", report_html(about, {name: _png(one) for name, one in figures.items()}))


def _png(figure: Any) -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=150)
    return buffer.getvalue()


def report_html(about: Mapping[str, Any], pictures: Mapping[str, bytes]) -> str:
    """Return one HTML document that needs no other file and no network; ``pictures`` are PNG by name."""
    title = f"{about['robot']}: {about['model']} from recorded torques"
    body = [_head(title, about), _joints(about), *(_picture(name, data) for name, data in pictures.items())]
    body += [_open(about), _parameters(about), _foot(about)]
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<style>{STYLE_SHEET}</style></head>\n'
        f"<body>\n<main>\n{''.join(body)}</main>\n</body></html>\n"
    )


def _head(title: str, about: Mapping[str, Any]) -> str:
    samples = about["samples"]
    counts = f"{samples['read']} samples read, {samples['fitted']} fitted, {samples['held_out']} held out"
    skipped = (f"left out: {rows} x {reason}" for reason, rows in about["skipped_rows"].items())
    said = "".join(f"<p class=note>{escape(text)}</p>" for text in (counts, *skipped, *about["notes"]))
    logs = ", ".join(dict.fromkeys([*about["logs"], *about["held_out_log"]]))
    return (
        f"<header><h1>{escape(title)}</h1><p class=source>{escape(logs)}; estimator {escape(about['estimator'])}</p>"
        f"<p>{INTRODUCTION}</p>{_state(about)}{said}</header>\n"
    )


def _state(about: Mapping[str, Any]) -> str:
    if about["refused"] is not None:
        return f'<p class="bad state">refused</p><p>{escape(about["refused"])}</p>'
    held = f"{100.0 * about['overall']['held_out']:.2f} % error held out"
    weak = "".join(f"<p>{escape(text)}</p>" for text in about["warnings"])
    if about["no_robot_file"] is not None:
        return f'<p class="none state">{held}; no robot file</p><p>{escape(about["no_robot_file"])}</p>{weak}'
    if weak:
        return f'<p class="none state">{held}; weak</p>{weak}'
    return f'<p class="good state">{held}</p>'


def _joints(about: Mapping[str, Any]) -> str:
    heads = ("joint", "unit", "RMS torque", "error, fitted", "error, held out", "held out, %", "floor", "± at a tilt")
    rows = [
        (
            escape(joint["name"]),
            joint["unit"],
            *(_number(joint[key]) for key in ("rms_torque", "train_rms", "held_out_rms")),
            _share(joint["held_out_relative"]),
            _number(joint["floor_rms"]),
            "unknown" if joint["sd_at_tilt"] is None else _number(joint["sd_at_tilt"]),
        )
        for joint in about["joints"]
    ]
    note = (
        "RMS; % of the joint's RMS torque; floor: how well the motion repeats itself, where it does; ± at a tilt:"
        f" standard deviation of the holding torque with the base tilted {about['tilt_deg']:g} degrees, any way"
    )
    return f"<section><h2>Errors</h2>{_grid(heads, rows)}<p class=note>{note}</p></section>\n"


def _picture(name: str, data: bytes) -> str:
    title, encoded = PICTURES.get(name, name), base64.b64encode(data).decode()
    image = f'<img alt="{escape(title)}" src="data:image/png;base64,{encoded}">'
    return f"<section><h2>{escape(title)}</h2><figure>{image}</figure></section>\n"


def _open(about: Mapping[str, Any]) -> str:
    if not about["not_identifiable"]:
        return ""
    lines = "".join(f"<p>{escape(text)}</p>" for text in about["not_identifiable"])
    return f"<section><h2>What the logs do not show</h2>{lines}</section>\n"


def _parameters(about: Mapping[str, Any]) -> str:
    keys = ("value", "cross_sd", "formal_sd", "in_file")
    rows = [(escape(row["name"]), *(_number(row[key]) for key in keys)) for row in about["parameters"]]
    heads = ("parameter", "found", "± cross-validated", "± formal", "in the file")
    summary = (
        f"{about['rank']} sums of {about['columns']} parameters show in the torques; condition"
        f" {about['condition']:.3g}. m in kg, h in kg·m, I in kg·m², friction in N·m (N) and per rad/s (m/s)"
    )
    return f"<section><h2>Parameters</h2><p class=note>{summary}</p>{_grid(heads, rows)}</section>\n"


def _share(value: float | None) -> str:
    return "–" if value is None else f"<b>{100.0 * value:.2f}</b>"


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"


def _grid(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    head = "".join(f"<th>{name}</th>" for name in heads)
    lines = "".join(f"<tr>{''.join(f'<td>{text}</td>' for text in row)}</tr>" for row in rows)
    return f'<div class=wide><table class="numbers"><thead><tr>{head}</tr></thead><tbody>{lines}</tbody></table></div>'


def _foot(about: Mapping[str, Any]) -> str:
    made = f"<footer><pre>{escape(about['command'])}</pre>"
    return f"{made}Python {platform.python_version()}, NumPy {np.__version__}.</footer>\n"
