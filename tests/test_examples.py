"""The examples that need nothing but the library run, and do what they say."""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


def test_a_breathing_target_is_followed_better_than_where_it_was_last_seen(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(EXAMPLES / "breathing_target.py"), run_name="__main__")
    errors = {
        name: float(rms) for name, rms in re.findall(r"(\w+): hold error ([\d.]+) mm RMS", capsys.readouterr().out)
    }
    assert errors["switch"] < 0.35
    assert errors["switch"] < 0.4 * errors["hold"]
