"""A progress bar for a loop that must not wait: every picture of it is made before the loop starts."""

from __future__ import annotations

import io
import os
import sys

__all__ = ["PrerenderedBar"]

STEPS = 100
WIDTH = 40


class PrerenderedBar:
    """A bar of a hundred steps on standard error, if that is a terminal.

    Drawing a bar takes milliseconds, many cycles of a control loop; writing a prepared one, a few microseconds.
    """

    def __init__(self, label: str) -> None:
        self._frames = _render(label) if sys.stderr.isatty() else []
        self._shown = -1

    def show(self, done: int, total: int) -> None:
        """Show that ``done`` of ``total`` are done; writes only when that is another step."""
        step = min(STEPS, STEPS * done // total)
        if self._frames and step != self._shown:
            self._shown = step
            os.write(sys.stderr.fileno(), self._frames[step])

    def close(self) -> None:
        """End the line."""
        if self._shown >= 0:
            os.write(sys.stderr.fileno(), b"\n")


def _render(label: str) -> list[bytes]:
    from rich.console import Console
    from rich.progress_bar import ProgressBar

    frames = []
    for step in range(STEPS + 1):
        text = io.StringIO()
        console = Console(file=text, force_terminal=True, width=WIDTH)
        console.print(ProgressBar(total=STEPS, completed=step, width=WIDTH), end="")
        frames.append(f"\r{label}  {text.getvalue()} {step:3d} %".encode())
    return frames
