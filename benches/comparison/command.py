"""What the commands share: their options, the file that each writes, the programs that they build and run."""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

from rich.console import Console

from ravengc.atomic import replacing

ROOT = Path(__file__).parents[2]

SMALLEST = "run each part once or twice, at ordinary priority: shows that all runs, measures nothing"


def parser(about: str | None, name: str) -> argparse.ArgumentParser:
    """A command that writes `out/NAME.json`, or where ``--json`` says."""
    found = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    out = ROOT / "out" / f"{name}.json"
    found.add_argument(
        "--json", type=Path, default=out, metavar="FILE", help=f"where to write the results (default out/{name}.json)"
    )
    return found


def console(least: int = 120) -> Console:
    """Where tables are printed, at least so many characters wide: a narrow terminal breaks lines, and no cell."""
    return Console(width=max(Console().width, least), highlight=False)


def write(path: Path, results: Any) -> None:
    with replacing(path) as unfinished:
        unfinished.write_text(json.dumps(results, indent=1) + "\n")
    print(f"written to {path}")


def example(name: str, *, release: bool = True) -> Path:
    """Build a program of the Rust core (`[[example]]` in crates/gravcomp/Cargo.toml), and say where it is.

    What is not for release is what `cargo test` has built already.
    """
    if shutil.which("cargo") is None:
        raise SystemExit(f"cargo is not installed: the program '{name}' cannot be built (https://rustup.rs)")
    command = ["cargo", "build", *(["--release"] if release else []), "-p", "gravcomp", "--example", name]
    for line in output([*command, "--message-format=json-render-diagnostics"]).splitlines():
        message = json.loads(line)
        if message.get("executable") and message["target"]["name"] == name:
            return Path(message["executable"])
    raise SystemExit(f"cargo built no program: is [[example]] {name} still in crates/gravcomp/Cargo.toml?")


def output(command: list[str], environment: dict[str, str] | None = None) -> str:
    """What a program printed; its own complaints go to the terminal, and its failure ends this one."""
    done = subprocess.run(  # noqa: S603
        command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True, check=False
    )
    if done.returncode:
        raise SystemExit(f"{' '.join(command)}: failed with code {done.returncode}")
    return done.stdout
