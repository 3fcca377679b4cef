"""Functions of C that ``ravengc symbolic`` wrote, compiled with the system's compiler and called."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from typing import TYPE_CHECKING

import numpy as np
import pytest

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

__all__ = ["compiled"]

STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1")


def compiled(source: str, name: str, shape: tuple[int, ...], folder: Path) -> Callable[..., np.ndarray]:
    """The function ``name`` of a C source, warnings being errors; skips the test where there is no compiler."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler")
    (folder / "formulas.c").write_text(source, encoding="utf-8")
    library = folder / "formulas.so"
    command = [compiler, *STRICT, "-shared", "-fPIC", "-o", str(library), str(folder / "formulas.c"), "-lm"]
    subprocess.run(command, check=True)  # noqa: S603
    function = getattr(ctypes.CDLL(str(library)), name)

    def call(*inputs: float | list[float]) -> np.ndarray:
        out = np.full(shape, np.nan)
        function(*map(_argument, inputs), out.ctypes.data_as(ctypes.POINTER(ctypes.c_double)))
        return out

    return call


def _argument(value: float | list[float]) -> object:
    return ctypes.c_double(value) if isinstance(value, float) else (ctypes.c_double * len(value))(*value)
