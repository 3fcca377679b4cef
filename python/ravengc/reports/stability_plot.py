"""A certificate as a picture: Nyquist and Bode of the loci, the poles, and what is left of the base's damping."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ravengc.reports.figures import AXIS_COLOURS, FAINT, INK, PREDICTED, STYLE, require_matplotlib, save_figure
from ravengc.stability.loop_margins import base_eigenvalues, frequency_grid, loci
from ravengc.stability.roots import poles

if TYPE_CHECKING:
    from pathlib import Path

    from ravengc.stability import Certificate, System

__all__ = ["plot_stability"]

Array = NDArray[np.float64]
BAD, GOOD = "#d1603d", "#5b9a52"
SILENT = 1e-6
"""Loci that stay smaller are not drawn."""
LOWEST_DB = -40.0


def plot_stability(path: Path, system: System, certificate: Certificate, *, title: str) -> None:
    """Draw a certificate into a file (png, svg, pdf)."""
    matplotlib = require_matplotlib("a picture of the certificate")
    colour = GOOD if certificate.certified else BAD
    with matplotlib.rc_context(STYLE):
        figure = matplotlib.figure.Figure(figsize=(10.5, 7.2), layout="constrained")
        axes = figure.subplots(2, 2)
        figure.suptitle(
            f"{title}\n{certificate.verdict}", x=0.01, ha="left", fontsize=11.5, fontweight="bold", color=colour
        )
        w = frequency_grid(system)
        with np.errstate(all="ignore"):
            followed = _followed(loci(system, w))
            _draw_nyquist(axes[0, 0], followed, certificate)
            _draw_bode(axes[0, 1], w, followed, certificate)
            _draw_poles(axes[1, 0], system, certificate)
            _draw_damping(axes[1, 1], system, certificate)
        save_figure(figure, path)


def _followed(values: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """The loci in columns: every eigenvalue stays in the column of the one that it came from."""
    rows = [values[0][np.argsort(-np.abs(values[0]))]]
    for row in values[1:]:
        left = list(row)
        rows.append(np.array([left.pop(int(np.argmin(np.abs(np.array(left) - before)))) for before in rows[-1]]))
    found = np.array(rows)
    return found[:, np.abs(found).max(axis=0) > SILENT]


def _draw_nyquist(axes: Any, followed: NDArray[np.complex128], certificate: Certificate) -> None:
    for i, locus in enumerate(followed.T):
        for sign, line in ((1.0, "-"), (-1.0, ":")):
            axes.plot(locus.real, sign * locus.imag, line, color=AXIS_COLOURS[i % 3], linewidth=1.0)
    axes.plot([-1.0], [0.0], "+", color=INK, markersize=11, markeredgewidth=1.8)
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    distance = certificate.margins.distance
    axes.plot(-1.0 + distance * np.cos(angle), distance * np.sin(angle), color=FAINT, linewidth=0.8)
    reach = float(np.clip(1.2 * np.abs(followed).max(initial=0.0), 1.6, 6.0))
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    worst = certificate.margins.worst_hz
    where = "" if math.isnan(worst) else f", nearest to −1 at {worst:.3g} Hz"
    axes.set_title(f"Nyquist: loci of L(iω){where}")


def _draw_bode(axes: Any, w: Array, followed: NDArray[np.complex128], certificate: Certificate) -> None:
    hz, phase = w / (2.0 * np.pi), axes.twinx()
    for i, locus in enumerate(followed.T):
        gain = 20.0 * np.log10(np.abs(locus))
        axes.semilogx(hz, gain, color=AXIS_COLOURS[i % 3])
        heard = gain > LOWEST_DB
        turned = np.degrees(np.angle(locus[heard]))
        phase.semilogx(hz[heard], turned, ".", color=AXIS_COLOURS[i % 3], markersize=1.2, alpha=0.6)
    axes.axhline(0.0, color=INK, linewidth=0.8)
    axes.set(ylim=(LOWEST_DB, max(10.0, axes.get_ylim()[1])), xlabel="Hz")
    phase.set(ylim=(-190.0, 190.0), yticks=(-180, -90, 0, 90, 180))
    phase.grid(visible=False)
    if not math.isnan(certificate.margins.worst_hz):
        axes.axvline(certificate.margins.worst_hz, color=FAINT, linewidth=0.8)
    margin = certificate.margin_db
    text = f"{margin:+.2f} dB" if math.isfinite(margin) else "unlimited" if margin > 0.0 else "none"
    axes.set_title(f"Bode: gain, dB, and phase, ° (dots); gain margin {text}")


def _draw_poles(axes: Any, system: System, certificate: Certificate) -> None:
    found = poles(system)
    edge = 1.6 * max((mode.frequency_hz for mode in certificate.modes if mode.frequency_hz > 0.0), default=1.0)
    edge = max(edge, certificate.pole.frequency_hz * 1.2) * 2.0 * np.pi
    near = found[(np.abs(found.imag) <= edge) & (found.real > -edge)]
    axes.axvspan(0.0, edge, color=BAD, alpha=0.07, linewidth=0.0)
    axes.axvline(0.0, color=INK, linewidth=0.8)
    for s in near:
        axes.plot([s.real] * 2, [s.imag, -s.imag], "x", color=BAD if s.real > 0.0 else PREDICTED, markersize=6)
    right = max(0.15 * edge, 1.5 * certificate.pole.growth)
    axes.set(xlim=(min(near.real.min(initial=-1.0), -0.1 * edge) * 1.1, right), ylim=(-edge, edge))
    axes.set_xlabel("1/s")
    s = certificate.pole.s
    axes.set_title(f"poles, 1/s and rad/s; rightmost {s.real:+.4f} ± {abs(s.imag):.3f}i")


def _draw_damping(axes: Any, system: System, certificate: Certificate) -> None:
    """Damping ratios that the base would have if it swung at each frequency, Im lambda / 2 w^2."""
    modes = certificate.modes
    if not modes:
        return
    hz = np.linspace(0.5 * modes[0].frequency_hz, 1.5 * modes[-1].frequency_hz, 500)
    w = 2.0 * np.pi * hz
    axes.plot(hz, base_eigenvalues(system, w)[0].imag / (2.0 * w * w)[:, None], ".", color=FAINT, markersize=1.5)
    for i, mode in enumerate(modes):
        colour = AXIS_COLOURS[i % 3]
        axes.plot([mode.frequency_hz], [mode.effective_ratio], "o", color=colour, markersize=5)
        axes.axhline(mode.own_ratio, color=colour, linewidth=0.7, linestyle=":")
    ratios = [0.0, *(ratio for mode in modes for ratio in (mode.effective_ratio, mode.own_ratio))]
    room = 0.6 * (max(ratios) - min(ratios))
    axes.set_ylim(min(ratios) - room, max(ratios) + room)
    axes.axhline(0.0, color=INK, linewidth=0.8)
    axes.set_xlabel("Hz")
    axes.set_title("damping ratio of the base; dots: where it swings; dotted: its own")
