"""The report on the experiments: one HTML file with everything in it, what the paper states beside what was found."""

from __future__ import annotations

import base64
import math
import platform
from dataclasses import dataclass
from html import escape
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING

from ravengc.config.files import write_atomically
from ravengc.experiments.experiment import settings_table
from ravengc.reports.experiment_page import STYLE_SHEET

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from ravengc.experiments import Experiment, Finding, Outcome, Settings, Table

__all__ = ["Section", "expected_text", "found_text", "report_html", "write_report"]

PAPER = "A. Lewis and B. Hannaford, “Dynamically Evaluated Gravity Compensation for the RAVEN Surgical Robot”"
INTRODUCTION = """\
The paper’s three experiments, its two open questions and the moving-base literature it builds on, run in simulation.
Each section says what was run, on which assumptions, what came out, and how that compares. A <b>verdict</b> is about
the paper’s statement. <b>Expected</b> is the number that this software is held to, known beforehand from independent
computations; a value outside its tolerance is marked and makes the command fail. What the paper does not state,
friction above all, is assumed and said so."""
MOST_DECIMALS = 6
PACKAGES = ("ravengc", "numpy", "mujoco", "matplotlib")


@dataclass(frozen=True)
class Section:
    """One experiment of a report: with which settings it was run, what came out, its picture (PNG), the command."""

    experiment: Experiment
    settings: Settings
    outcome: Outcome
    picture: bytes
    command: str


def write_report(path: Path, sections: Sequence[Section]) -> None:
    """Write :func:`report_html` to ``path``, whole or not at all; ConfigError where that fails."""
    write_atomically(path, report_html(sections))


def report_html(sections: Sequence[Section]) -> str:
    """Return one HTML document that needs no other file and no network."""
    body = [_head(sections), _statements(sections), *map(_section, sections), _foot()]
    title = "Gravity compensation on a moving base: experiments"
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<style>{STYLE_SHEET}</style></head>\n'
        f"<body>\n<main>\n{''.join(body)}</main>\n</body></html>\n"
    )


def number(value: float) -> str:
    """A number for a reader: four significant digits, no more than are there."""
    if value == 0.0:
        return "0"
    return f"{value:.1e}" if abs(value) < 1e-3 else f"{value:.4g}"


def found_text(finding: Finding) -> str:
    """What was found, with its unit, to one decimal more than the tolerance."""
    digits = _decimals(finding)
    is_plain = digits is None or abs(finding.value) < 10.0**-digits
    value = number(finding.value) if is_plain else f"{finding.value:.{(digits or 0) + 1}f}"
    return f"{value} {finding.unit}".strip()


def expected_text(finding: Finding) -> str:
    """What was expected, with its tolerance; empty where nothing was."""
    digits = _decimals(finding)
    return "" if digits is None else f"{finding.expected:.{digits}f} ± {finding.tolerance:g}"


def _decimals(finding: Finding) -> int | None:
    if finding.expected is None or finding.tolerance is None:
        return None
    digits = max(0, -math.floor(math.log10(finding.tolerance)))
    return digits if finding.expected or digits < MOST_DECIMALS else 0


def _head(sections: Sequence[Section]) -> str:
    links = "".join(f'<a href="#{s.experiment.name}">{escape(s.experiment.title)}</a>' for s in sections)
    findings = [finding for section in sections for finding in section.outcome.findings]
    missed = sum(not finding.holds for finding in findings)
    checked = sum(finding.expected is not None for finding in findings)
    state = (
        f"all {checked} expected numbers within tolerance" if not missed else f"{missed} of {checked} numbers missed"
    )
    return (
        f"<header><h1>Gravity compensation on a moving base</h1><p class=source>{PAPER}</p>"
        f'<p>{INTRODUCTION}</p><p class="{"bad" if missed else "good"} state">{state}</p><nav>{links}</nav></header>\n'
    )


def _statements(sections: Sequence[Section]) -> str:
    """The paper's statements, all in one table."""
    rows = [
        (
            f'<a href="#{section.experiment.name}">{escape(finding.stated)}</a>',
            f"{escape(finding.quantity)}: <b>{escape(found_text(finding))}</b>",
            _verdict(finding),
            escape(finding.why),
        )
        for section in sections
        for finding in section.outcome.findings
        if finding.stated
    ]
    if not rows:
        return ""
    table = _grid(("the paper states", "we get", "verdict", "why"), rows, kind="findings")
    return f"<section><h2>What the paper states, what we get</h2>{table}</section>\n"


def _section(section: Section) -> str:
    experiment, outcome = section.experiment, section.outcome
    picture = base64.b64encode(section.picture).decode()
    return (
        f'<section id="{experiment.name}"><h2>{escape(experiment.title)}</h2>'
        f"<p class=source>{escape(experiment.source)}</p><p>{escape(experiment.about)}</p>"
        f'<figure><img alt="{escape(experiment.title)}" src="data:image/png;base64,{picture}"></figure>'
        f"<h3>Findings</h3>{_findings(outcome.findings)}"
        f"{''.join(map(_table, outcome.tables))}"
        f"<details><summary>Command and settings</summary><pre>{escape(section.command)}</pre>"
        f"{_settings(section.settings)}</details></section>\n"
    )


def _findings(findings: Iterable[Finding]) -> str:
    rows = [
        (
            escape(finding.quantity),
            f"<b>{escape(found_text(finding))}</b>",
            _expected(finding),
            escape(finding.stated) or "–",
            _verdict(finding),
            escape(finding.why),
        )
        for finding in findings
    ]
    return _grid(("quantity", "we get", "expected", "the paper states", "verdict", "why"), rows, kind="findings")


def _expected(finding: Finding) -> str:
    mark = "" if finding.holds else ' <span class="bad">missed</span>'
    return (expected_text(finding) or "–") + mark


def _verdict(finding: Finding) -> str:
    kind = {"reproduced": "good", "not reproduced": "bad"}.get(finding.verdict, "none")
    return f'<span class="{kind}">{escape(finding.verdict)}</span>'


def _table(table: Table) -> str:
    rows = [[escape(cell if isinstance(cell, str) else number(cell)) for cell in row] for row in table.rows]
    note = f"<p class=note>{escape(table.note)}</p>" if table.note else ""
    return f"<h3>{escape(table.title)}</h3>{_grid(map(escape, table.columns), rows)}{note}"


def _settings(settings: Settings) -> str:
    rows = [
        (f"<code>{key}</code>", escape(_plain(value)), escape(unit), escape(text), escape(allowed))
        for key, value, unit, allowed, text in settings_table(settings)
    ]
    return _grid(("setting", "value", "unit", "what it is", "allowed"), rows)


def _plain(value: object) -> str:
    if isinstance(value, tuple):
        return ", ".join(map(_plain, value))
    return f"{value:g}" if isinstance(value, float) else str(value)


def _grid(heads: Iterable[str], rows: Iterable[Iterable[str]], kind: str = "numbers") -> str:
    head = "".join(f"<th>{name}</th>" for name in heads)
    lines = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    return f'<div class=wide><table class="{kind}"><thead><tr>{head}</tr></thead><tbody>{lines}</tbody></table></div>'


def _foot() -> str:
    versions = ", ".join(f"{name} {found}" for name in PACKAGES if (found := _version(name)))
    return f"<footer>Made by <code>ravengc reproduce</code>: {versions}, Python {platform.python_version()}.</footer>\n"


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""
