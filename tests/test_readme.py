"""What README.md shows is what happens: its Python runs, its commands exist, its numbers come from where it says."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from ravengc.cli import main

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PYTHON = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
SHELL = [line for block in re.findall(r"```sh\n(.*?)```", README, re.DOTALL) for line in block.splitlines() if line]


def test_readme_has_what_it_promises():
    assert PYTHON
    assert any(line.startswith("make run") for line in SHELL)
    assert any(line.startswith("make test") for line in SHELL)


@pytest.mark.parametrize("code", PYTHON)
def test_python_runs(code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shown: list[str] = []
    exec(compile(code, "README.md", "exec"), {"print": lambda *values: shown.append(" ".join(map(str, values)))})  # noqa: S102
    expected = re.findall(r"print\(.*\)\s+# (.*)", code)
    assert shown == expected


@pytest.mark.parametrize("line", [line for line in SHELL if line.startswith("ravengc ")])
def test_commands_run(line, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    arguments = shlex.split(line.split("#")[0])[1:]
    if arguments[0] == "run":
        arguments += ["--fast", "--duration", "0.2"]
    if arguments == ["reproduce"]:
        arguments += ["ship", "base-wrench"]
    assert main(arguments) == 0
    assert capsys.readouterr().out


@pytest.mark.parametrize("line", [line for line in SHELL if line.startswith("make ")])
def test_make_targets_exist(line):
    target = line.split("#")[0].split()[1]
    assert re.search(rf"^{target}:", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)


@pytest.mark.parametrize("line", [*SHELL, *(line for block in PYTHON for line in block.splitlines())])
def test_examples_fit_the_page(line):
    assert len(line) <= 100


@pytest.mark.parametrize("path", re.findall(r"\]\(([^)#:]+)\)", README))
def test_links_lead_to_files(path):
    assert (ROOT / path).exists()


@pytest.mark.parametrize("path", sorted(set(re.findall(r"\b(?:examples|benches)/\w+\.py", README))))
def test_scripts_that_are_named_exist(path):
    assert (ROOT / path).is_file()
