"""The errors of the package: one place, one base, and each a kind that Python knows."""

from __future__ import annotations

import inspect
from pathlib import Path

import pytest

import ravengc
from ravengc import errors
from ravengc.errors import CalibrationError, RavenGCError

NAMES = sorted(name for name, kind in vars(errors).items() if inspect.isclass(kind) and issubclass(kind, Exception))


def test_all_of_them_are_public() -> None:
    assert sorted(errors.__all__) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_each_is_one_of_ours_and_says_what_it_is_for(name: str) -> None:
    kind = getattr(errors, name)
    assert issubclass(kind, RavenGCError)
    assert kind.__doc__
    assert kind is RavenGCError or issubclass(kind, (ValueError, OSError, ImportError))


def test_data_that_determine_no_calibration_are_a_wrong_value() -> None:
    assert issubclass(CalibrationError, ValueError)


def test_no_other_module_makes_errors() -> None:
    package = Path(ravengc.__file__).parent
    makers = [path.name for path in package.rglob("*.py") if "Error(RavenGCError" in path.read_text(encoding="utf-8")]
    assert makers == ["errors.py"]
