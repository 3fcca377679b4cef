"""Commands of ``ravengc`` as tests call them: what they say to misuse, and what is left of their processes."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from ravengc.cli import main

if TYPE_CHECKING:
    import pytest


def refusal(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """The message of bad input."""
    assert main([*words]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("ravengc: error: ")
    return printed.err


def begun(folder: Path, *words: str) -> subprocess.Popen[bytes]:
    """The command at work in a folder, in a group of its own."""
    return subprocess.Popen(  # noqa: S603
        [sys.executable, "-m", "ravengc", *words],
        cwd=folder, start_new_session=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[1] / "python")},
    )  # fmt: skip


def gone(leader: int) -> None:
    """Wait until no process of the group lives."""
    deadline = time.monotonic() + 60.0
    while living(leader):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def living(leader: int) -> list[str]:
    """The living processes of a process group (without its finished ones)."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text(encoding="utf-8").rpartition(")")[2].split()
        except OSError:
            continue
        if fields[2] == str(leader) and fields[0] != "Z":
            found.append(stat.parent.name)
    return found
