"""Open a recording by its path or its example name, whatever the format."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ravengc._convert import as_number, as_path, as_texts, check_choice
from ravengc.errors import ArgumentError, ConfigError, ParseError
from ravengc.messages import did_you_mean, shown
from ravengc.recordings.bag_file import read_bag
from ravengc.recordings.csv_file import read_csv
from ravengc.recordings.npz_file import read_npz
from ravengc.recordings.screening import RawTable, check_time, screen

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.recordings.recording import Recording

__all__ = ["EXAMPLES", "LARGEST_BYTES", "example_path", "read_recording"]

LARGEST_BYTES = 512 * 2**20
FASTEST_HZ = 1e9
BAG_METADATA = "metadata.yaml"
EXAMPLE_PREFIX = "example:"
EXAMPLES = {
    "panda": "panda_unisa/panda_bag.npz",
    "mtmr_level": "simulated_logs/mtmr_level.csv",
    "mtmr_tilts": "simulated_logs/mtmr_tilts.csv",
    "ur5_unloaded": "simulated_logs/ur5_unloaded.npz",
    "ur5_loaded": "simulated_logs/ur5_loaded.npz",
}
TEXT = (".csv", ".txt", ".tsv")
BAGS = (".db3", ".mcap", ".bag")


def read_recording(
    source: str | Path,
    *,
    topic: str | None = None,
    joints: Sequence[str] | None = None,
    rate_hz: float | None = None,
    strict: bool = False,
) -> Recording:
    """The recording in a file, a rosbag2 folder, or ``example:NAME``.

    ``topic`` chooses the JointState topic of a bag and ``joints`` names joints that its messages must hold; ``rate_hz``
    (Hz) makes stamps for a table without a time column, and is refused where there are stamps; ``strict`` refuses a
    recording with a row that would be skipped. Raises ParseError (file, line, column), ConfigError and ArgumentError;
    nothing is left out without being counted in :attr:`Recording.skipped`.
    """
    name = source if isinstance(source, str) else str(as_path(source, "source"))
    wanted = None if joints is None else as_texts(joints, "joints")
    if rate_hz is not None and not 0.0 < as_number(rate_hz, "rate_hz") <= FASTEST_HZ:
        raise ConfigError(f"the sample rate is {rate_hz} Hz; expected a positive number of at most {FASTEST_HZ:g}")
    try:
        path = _existing(name)
        _check_size(path)
        _check_topic(path, name, topic)
        table = _table(path, topic=topic, joints=wanted, rate_hz=rate_hz)
    except OSError as error:
        raise ParseError(f"cannot be read: {error.strerror or error}", file=name) from error
    table.file = name
    return screen(table, strict=strict)


def example_path(name: str) -> Path:
    """Where the bundled recording ``name`` lies; raises ConfigError for an unknown name."""
    check_choice(name, EXAMPLES, "bundled recording")
    return Path(__file__).parent.parent / "examples" / EXAMPLES[name]


def _existing(text: str) -> Path:
    if text.startswith(EXAMPLE_PREFIX):
        return example_path(text.removeprefix(EXAMPLE_PREFIX))
    if not text or "\0" in text:
        raise ParseError("no such file: a path has at least one character, and no NUL", file=text)
    path = _expanded(text)
    if path.exists():
        return path
    if path.is_symlink():
        raise ParseError(f"a link to nowhere: {path.readlink()}", file=text)
    siblings = [entry.name for entry in path.parent.iterdir()] if path.parent.is_dir() else []
    raise ParseError(f"no such file{did_you_mean(path.name, siblings)}", file=text)


def _expanded(text: str) -> Path:
    try:
        return Path(text).expanduser()
    except RuntimeError as error:  # ~user for somebody unknown
        raise ParseError(f"no such file: {error}", file=text) from error


def _check_size(path: Path) -> None:
    if path.is_dir() and not (path / BAG_METADATA).is_file():
        raise ParseError(f"a folder without {BAG_METADATA}; expected a recording, or a rosbag2 folder", file=str(path))
    if not path.is_dir() and not path.is_file():
        raise ParseError("a pipe or a device; expected a file", file=str(path))
    files = [entry for entry in path.iterdir() if entry.is_file()] if path.is_dir() else [path]
    size = sum(file.stat().st_size for file in files)
    if size == 0:
        raise ParseError("empty: expected a recording", file=str(path))
    if size > LARGEST_BYTES:
        message = f"{size / 2**20:.0f} MiB; at most {LARGEST_BYTES / 2**20:.0f} MiB are read (cut the recording)"
        raise ParseError(message, file=str(path))


def _check_topic(path: Path, source: str, topic: str | None) -> None:
    if topic is not None and not isinstance(topic, str):
        raise ArgumentError(f"topic is {shown(topic)}; expected a text")
    if topic is not None and not path.is_dir() and path.suffix.lower() not in BAGS:
        raise ConfigError(f"{source}: topic {topic!r} chooses a part of a bag, and this is none")


def _table(path: Path, *, topic: str | None, joints: Sequence[str] | None, rate_hz: float | None) -> RawTable:
    kind = path.suffix.lower()
    if path.is_dir() or kind in BAGS:
        check_time("in the messages", rate_hz, str(path))
        return read_bag(path, topic=topic, joints=joints)
    if kind == ".npz":
        return read_npz(path, largest=LARGEST_BYTES, rate_hz=rate_hz)
    if kind in TEXT:
        return read_csv(path, rate_hz=rate_hz)
    known = ", ".join((*TEXT, ".npz", *BAGS))
    raise ConfigError(f"{path}: unknown kind of recording '{kind}'; expected one of {known}, or a rosbag2 folder")
