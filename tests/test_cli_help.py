"""Every command's help: it fits a terminal, and its examples are commands that the command line understands."""

from __future__ import annotations

import argparse
import re
import shlex
from typing import TYPE_CHECKING

import pytest

from ravengc.cli import _parser, main
from ravengc.recordings.reading import EXAMPLES as RECORDINGS
from ravengc.sensors.recorded import EXAMPLES as IMUS
from ravengc.targets.files import CLOUDS, MOTIONS

if TYPE_CHECKING:
    from collections.abc import Iterator

BUNDLED = {*RECORDINGS, *IMUS, *CLOUDS, *MOTIONS}


def commands(parser: argparse.ArgumentParser, words: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """The words of every command and subcommand."""
    if words:
        yield words
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, inner in action.choices.items():
                yield from commands(inner, (*words, name))


COMMANDS = list(commands(_parser()))


def shown_help(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]) -> str:
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit) as stop:
        main([*words, "--help"])
    assert stop.value.code == 0
    return capsys.readouterr().out


def examples(text: str) -> list[list[str]]:
    """The words of the lines under "examples:" that run ravengc, joined where they continue, without comments."""
    joined = text.partition("examples:\n")[2].replace("\\\n", " ")
    lines = [line.partition(">")[0] for line in joined.splitlines() if line.startswith("  ravengc ")]
    return [shlex.split(line, comments=True)[1:] for line in lines]


def test_all_commands_are_found() -> None:
    assert ("info",) in COMMANDS
    assert ("calibrate", "accelerometer") in COMMANDS


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_help_has_examples_that_fit_a_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    shown = shown_help(capsys, monkeypatch, words)
    assert examples(shown)[0][0] == words[0]
    assert max(map(len, shown.splitlines())) <= 80


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_examples_are_understood_and_name_what_is_bundled(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    shown = shown_help(capsys, monkeypatch, words)
    for example in examples(shown):
        if "--help" not in example and "--version" not in example:
            assert _parser().parse_args(example).func
    assert set(re.findall(r"example:(\w+)", shown)) - {"NAME"} <= BUNDLED
