"""The programs of `benches/native/`: built, given one file of inputs, asked for numbers or for a time."""

from __future__ import annotations

import hashlib
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from comparison.arm import LEVEL, along_a_path
from comparison.command import ROOT, example, output
from comparison.machine import installed, processor

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from comparison.arm import Arm, Array
    from ravengc.spec import LinkSpec

SOURCE = ROOT / "benches" / "native" / "pinocchio.cpp"
STANDARD = ("-std=c++17", "-DNDEBUG", "-w")
"""Without assertions, as it is shipped; without warnings, as Eigen's AVX-512 part has hundreds."""
HEADERS = {"pinocchio/config.hpp": "pin", "boost/version.hpp": "pin", "eigen3/Eigen/Core": "cmeel-eigen"}
"""What the C++ needs, and the package that brings it."""


class MissingToolError(Exception):
    """Something that this machine lacks; the message says how to get it."""


@dataclass(frozen=True)
class Program:
    """A program with one set of instructions; ``command`` is followed by inputs, operation and milliseconds."""

    library: str
    build: str
    command: tuple[str, ...]

    def numbers(self, inputs: Path, operation: str) -> Array:
        """What it computes, a row per sample."""
        lines = output([*self.command, str(inputs), operation, "0"]).splitlines()
        return np.array([line.split() for line in lines], dtype=np.float64)

    def nanoseconds(self, inputs: Path, operation: str, milliseconds: int) -> float:
        """Time of one call, the median of the passes that fit into so many milliseconds."""
        return float(output([*self.command, str(inputs), operation, str(milliseconds)]))


def ours(*builds: str, release: bool = True) -> list[Program]:
    """Our kernels in these builds: one program, told which."""
    program = str(example("native", release=release))
    return [Program("ravengc", build, (program, build)) for build in builds]


def pinocchio(*flags: str, build: bool = True) -> Program:
    """pinocchio's C++ compiled with these flags, once: that takes a minute or two, so the program is kept.

    Raises:
        MissingToolError: There is no compiler, a header is not installed, or nothing is to be built and none was yet.
    """
    compiler = shutil.which("g++")
    if compiler is None:
        raise MissingToolError("g++ is not installed: pinocchio's C++ left out (Debian: apt install g++)")
    folders = [option for header in HEADERS for option in ("-isystem", include(header))]
    command = [compiler, *STANDARD, *flags, *folders, str(SOURCE)]
    program = ROOT / "target" / "native" / f"pinocchio-{digest(command)}"
    if not program.exists():
        if not build:
            raise MissingToolError("pinocchio's C++ is not compiled yet: left out (run without --smallest)")
        print(f"compiling pinocchio with {' '.join(flags)}, a minute or two and 3 GB ...", file=sys.stderr, flush=True)
        compile_to(program, command)
    return Program("pinocchio", " ".join(flags), (str(program),))


def include(header: str) -> str:
    """The folder to be searched for Eigen's or another library's headers, among those that pip fills."""
    prefix = "eigen3" if header.startswith("eigen3") else ""
    for entry in sys.path:
        folder = Path(entry, "cmeel.prefix", "include")
        if (folder / header).exists():
            return str(folder / prefix)
    raise MissingToolError(f"no {header} here: pinocchio's C++ left out (pip install {HEADERS[header]})")


def digest(command: list[str]) -> str:
    """A name for what this command makes of this source, with these versions, on this processor."""
    versions = [str(installed(package)) for package in ("libpinocchio", "cmeel-eigen", "cmeel-boost")]
    parts = [*command, str(compiler_version("g++")), processor(), *versions, SOURCE.read_text()]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]


def compiler_version(compiler: str) -> str | None:
    """What a compiler calls itself; ``None`` where there is none."""
    return output([compiler, "--version"]).splitlines()[0] if shutil.which(compiler) else None


def compile_to(program: Path, command: list[str]) -> None:
    program.parent.mkdir(parents=True, exist_ok=True)
    unfinished = program.with_suffix(".unfinished")
    output([*command, "-o", str(unfinished)])
    unfinished.replace(program)


def write_inputs(arm: Arm, path: Path) -> None:
    """The arm and the samples as plain numbers: links and samples are counted, then listed; matrices by rows."""
    lines: list[Iterable[float]] = [[len(arm.spec.links), len(arm.q)]]
    lines += [link_numbers(arm, link) for link in arm.spec.links]
    lines += [arm.tool, LEVEL]
    lines += sample_numbers(arm)
    path.write_text("".join(" ".join(str(number) for number in line) + "\n" for line in lines))


def link_numbers(arm: Arm, link: LinkSpec) -> Array:
    pose = arm.placement(link)
    return np.concatenate([pose[:3, :3].ravel(), pose[:3, 3], [link.mass], link.com, link.inertia])


def sample_numbers(arm: Arm) -> Iterator[Array]:
    parts = (arm.q, arm.qd, arm.qdd, arm.g, arm.f, arm.w, arm.dw, along_a_path(arm))
    return (np.concatenate(sample) for sample in zip(*parts, strict=True))
