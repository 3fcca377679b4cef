"""Progress bars on standard error: for work in steps, and for a loop that must not wait."""

from __future__ import annotations

import io
import os
import shutil
import sys
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["PrerenderedBar", "steps"]

STEPS = 100
LONGEST, SHORTEST = 40, 5


@contextmanager
def steps(label: str, total: int) -> Iterator[Callable[[str], None]]:
    """A bar of so many steps while the ``with`` lasts, if standard error is a terminal; call what it gives after each.

    The text that is handed over stands behind the label: what was done last.
    """
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.completed}/{task.total}"))
    bar = Progress(
        *columns, TimeElapsedColumn(), console=Console(stderr=True), transient=True, disable=not _is_terminal()
    )
    with bar as progress:
        task = progress.add_task(label, total=total)
        yield lambda done: progress.update(task, advance=1, description=escape(f"{label}: {done}"[:60]))


class PrerenderedBar:
    """A bar of a hundred steps on standard error, if that is a terminal.

    Drawing a bar takes milliseconds, many cycles of a control loop; writing a prepared one, a few microseconds. What
    ``note`` says, in at most ``NOTE`` characters, stands behind it.
    """

    NOTE = 40

    def __init__(self, label: str, note: Callable[[], str] | None = None) -> None:
        self._frames = _render(label, 0 if note is None else self.NOTE) if _is_terminal() else []
        self._note = note
        self._shown = -1

    def show(self, done: int, total: int) -> None:
        """Show that ``done`` of ``total`` are done; writes only when that is another step."""
        step = min(STEPS, STEPS * done // total)
        if self._frames and step != self._shown:
            self._shown = step
            _write(self._frames[step] + self._noted())

    def _noted(self) -> bytes:
        return b"" if self._note is None else f"  {self._note()[: self.NOTE - 2]:<{self.NOTE - 2}}".encode()

    def close(self) -> None:
        """End the line."""
        if self._shown >= 0:
            _write(b"\n")


def _is_terminal() -> bool:
    """Standard error is one, also while rich shows a status there and stands in its place."""
    try:
        return os.isatty(sys.stderr.fileno())
    except (OSError, ValueError):
        return False


def _write(frame: bytes) -> None:
    """Write to the terminal; a loop does not end because its terminal is gone."""
    with suppress(OSError):
        os.write(sys.stderr.fileno(), frame)


def _render(label: str, note: int) -> list[bytes]:
    """The pictures of a bar that fits beside the label and a note on one line; none where there is no room for one."""
    from rich.console import Console
    from rich.progress_bar import ProgressBar

    room = shutil.get_terminal_size().columns - len(label) - len("   100 % ") - note
    width, frames = min(LONGEST, room), []
    if width < SHORTEST:
        return []
    for step in range(STEPS + 1):
        text = io.StringIO()
        console = Console(file=text, force_terminal=True, width=width)
        console.print(ProgressBar(total=STEPS, completed=step, width=width), end="")
        frames.append(f"\r{label}  {text.getvalue()} {step:3d} %".encode())
    return frames
