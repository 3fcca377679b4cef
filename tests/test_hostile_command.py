"""The command ``ravengc`` where streams are closed, full or of another encoding, and names are not what they seem."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import ravengc as rg
from ravengc.atomic import replacing
from ravengc.cli import main

PYPROJECT = Path(__file__).parents[1] / "pyproject.toml"
linux = pytest.mark.skipif(sys.platform != "linux", reason="pipes, limits and devices of Linux")


def command(*words: str, encoding: str = "utf-8", **options: Any) -> subprocess.CompletedProcess[str]:
    """Run ``ravengc`` as a user does, in a process of its own that prints in this encoding."""
    env = os.environ | {"COLUMNS": "140", "PYTHONIOENCODING": encoding}
    kept = {"capture_output": True, "encoding": encoding.partition(":")[0], "timeout": 120, "env": env} | options
    line = [sys.executable, "-m", "ravengc", *words]
    return subprocess.run(line, check=False, **kept)  # noqa: S603 -- this very program


def python(code: str, *words: str) -> subprocess.CompletedProcess[str]:
    """Run Python code, with these words behind it, in a process of its own."""
    line = [sys.executable, "-c", code, *words]
    return subprocess.run(line, check=False, capture_output=True, text=True, timeout=120)  # noqa: S603 -- our own


@linux
@pytest.mark.parametrize("words", ["info", "info panda", "info panda --json", "info panda --toml"])
def test_a_reader_that_goes_away_ends_the_command_in_silence(words: str) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    done = command(*words.split(), stdout=writer, capture_output=False, stderr=subprocess.PIPE)
    os.close(writer)
    assert (done.returncode, done.stderr) == (141, "")


@linux
@pytest.mark.parametrize("words", ["info panda", "info panda --json", "torque rrbot --q 0 0", "--version"])
def test_a_full_disk_behind_the_output_is_named(words: str) -> None:
    with Path("/dev/full").open("w") as full:
        done = command(*words.split(), stdout=full, capture_output=False, stderr=subprocess.PIPE)
    assert (done.returncode, done.stderr) == (2, "ravengc: error: cannot print: No space left on device\n")


@linux
@pytest.mark.parametrize(("words", "code"), [("info rrbot", 0), ("info rrbot --json", 0), ("info rrbott", 2), ("", 2)])
def test_closed_streams_swallow_what_is_printed(words: str, code: int) -> None:
    line = f"exec {sys.executable} -m ravengc {words} >&- 2>&- <&-"
    assert subprocess.run(["/bin/sh", "-c", line], check=False, timeout=120).returncode == code  # noqa: S603


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "ascii:surrogateescape"])
@pytest.mark.parametrize(
    "words", ["torque rrbot --q 0 0", "info raven2_gold", "info raven2_gold --json", "info --json"]
)
def test_a_terminal_without_the_characters_gets_escapes(encoding: str, words: str) -> None:
    done = command(*words.split(), encoding=encoding)
    assert (done.returncode, done.stderr) == (0, "")


@linux
def test_a_path_that_is_no_text_is_printed_with_escapes(tmp_path: Path) -> None:
    out = os.fsdecode(bytes(tmp_path) + b"/\xff.csv")
    done = command("replay", "panda", "example:panda", "--out", out)
    assert (done.returncode, done.stderr) == (0, "")
    assert r"\udcff.csv" in done.stdout
    assert Path(out).exists()


def test_ctrl_c_ends_a_command_in_silence(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(rg, "load", interrupted)
    assert main(["info", "panda"]) == 130
    assert capsys.readouterr() == ("", "")


INTERRUPTED = """
import signal, sys

class Interrupt:
    def find_spec(self, name, *_):
        if name == sys.argv[1]:
            print("interrupted", flush=True)
            signal.raise_signal(signal.SIGINT)

sys.meta_path.insert(0, Interrupt())
from _ravengc_command import main
sys.exit(main())
"""


@pytest.mark.parametrize("module", ["ravengc", "ravengc._core", "ravengc.cli", "argparse", "ravengc.cli.info", "numpy"])
def test_ctrl_c_is_quiet_whatever_is_just_being_imported(module: str) -> None:
    done = python(INTERRUPTED, module)
    assert (done.returncode, done.stdout, done.stderr) == (130, "interrupted\n", "")


def test_the_command_starts_in_the_module_that_is_quiet() -> None:
    project = tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))
    assert project["project"]["scripts"] == {"ravengc": "_ravengc_command:main"}
    assert project["tool"]["maturin"]["python-packages"] == ["_ravengc_command.py"]


@pytest.mark.parametrize(
    ("level", "near"), [("AVX2", "; did you mean 'avx2'?"), ("avx512 ", "; did you mean 'avx512'?"), ("sse", "")]
)
def test_a_misspelt_level_is_refused_at_import(monkeypatch: pytest.MonkeyPatch, level: str, near: str) -> None:
    monkeypatch.setenv("RAVENGC_LEVEL", level)
    choices = "(choose 'portable', 'avx2', 'avx512', or unset it for the best that this processor has)"
    message = f"environment variable RAVENGC_LEVEL: got {level!r}{near} {choices}\n"
    assert python("import ravengc").stderr.endswith(f"ravengc.errors.ConfigError: {message}")
    done = python("from _ravengc_command import main; raise SystemExit(main())", "info")
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"ravengc: error: {message}")


@pytest.mark.parametrize("level", ["", "portable", "avx2", "avx512"])
def test_levels_that_there_are_can_be_asked_for(monkeypatch: pytest.MonkeyPatch, level: str) -> None:
    monkeypatch.setenv("RAVENGC_LEVEL", level)
    done = python("import ravengc; print(ravengc.INSTRUCTIONS)")
    assert done.stdout.strip() in ({level} if level == "portable" else {"portable", "avx2", "avx512"})


def test_ctrl_c_leaves_no_half_file(tmp_path: Path) -> None:
    def write() -> None:
        with replacing(tmp_path / "log.npz") as temporary:
            temporary.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write()
    assert list(tmp_path.iterdir()) == []


def test_names_with_brackets_are_names_not_markup(tmp_path: Path) -> None:
    spec = replace(rg.load("rrbot").spec, name="[/bold]")
    links = tuple(replace(link, joint_name=f"[red]{link.name}[/red]") for link in spec.links)
    rg.Robot(replace(spec, links=links)).to_toml(tmp_path / "[/arm].toml")
    (tmp_path / "[/log].csv").write_text("t,q1,q2,tau1,tau2\n0,0,0,1,1\n1,0,0,1,1\n")
    robot, log = str(tmp_path / "[/arm].toml"), str(tmp_path / "[/log].csv")
    for words in (["info", robot], ["torque", robot, "--q", "0", "0"], ["replay", robot, log]):
        done = command(*words)
        assert (done.returncode, done.stderr) == (0, "")
        assert "[/bold]" in done.stdout
        assert "[red]link1[/red]" in done.stdout
