"""Read a recording from a bag of sensor_msgs/JointState: rosbag2 (.db3, .mcap, or their folder) or ROS 1 (.bag).

Columns follow the joint names in the messages, or count from 1 where they have none. A topic may carry messages for
different sets of joints (an arm and its gripper): the set that holds the wanted joints is read, else the most frequent
one, and the others are counted. Time is the header's stamp, or the time of recording where the headers carry none; it
starts at 0.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ravengc.errors import ConfigError, MissingExtraError, ParseError
from ravengc.recordings.screening import RawTable

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from ravengc.recordings.recording import FloatArray

__all__ = ["read_bag"]

JOINT_STATE = "sensor_msgs/msg/JointState"
FIELDS = {"q": "position", "qd": "velocity", "tau": "effort"}
OTHER_JOINTS = "message for other joints"
LOST = "message that the bag announces but does not hold"
SQLITE_MAGIC = b"SQLite format 3\x00"


@dataclass(frozen=True, slots=True)
class _Message:
    recorded_ns: int
    stamp_ns: int
    names: tuple[str, ...]
    position: npt.NDArray[np.float64]
    velocity: npt.NDArray[np.float64]
    effort: npt.NDArray[np.float64]


def read_bag(path: Path, *, topic: str | None = None, joints: Sequence[str] | None = None) -> RawTable:
    """The table in a bag; ``topic`` chooses among several, ``joints`` are names that the wanted messages hold.

    Raises MissingExtraError without the package rosbags, ConfigError for a missing or ambiguous topic, ParseError for a
    damaged bag.
    """
    _check_whole(path)
    messages, announced = _messages(path, topic)
    if not any(message.names for message in messages):
        raise ParseError(f"no {JOINT_STATE} message with a joint in it", file=str(path))
    names = _wanted_names(messages, joints or ())
    indexed = [(index, m) for index, m in enumerate(messages, start=1) if frozenset(m.names) == frozenset(names)]
    chosen = [message for _, message in indexed]
    t, note = _stamps(chosen)
    table = RawTable(
        file=str(path),
        t=t,
        arrays={role: _stack(chosen, names, field) for role, field in FIELDS.items()},
        names=names,
        row_word="message",
        row_numbers=np.array([index for index, _ in indexed], dtype=np.int64),
    )
    if note:
        table.notes.append(note)
    _count(table, OTHER_JOINTS, len(messages) - len(chosen))
    _count(table, LOST, announced - len(messages))
    return table


def _count(table: RawTable, reason: str, messages: int) -> None:
    if messages > 0:
        table.skipped[reason] = messages


def _check_whole(path: Path) -> None:
    """Refuse an SQLite file shorter than its header says: SQLite itself may read it with rows missing.

    The header holds the page size at byte 16 and the number of pages at byte 28, valid if the two change counters at
    24 and 92 agree (https://www.sqlite.org/fileformat.html, 1.3).
    """
    for file in path.glob("*.db3") if path.is_dir() else [path]:
        with file.open("rb") as handle:
            header = handle.read(100)
        if not header.startswith(SQLITE_MAGIC) or header[24:28] != header[92:96]:
            continue
        page = int.from_bytes(header[16:18], "big")
        expected = (65536 if page == 1 else page) * int.from_bytes(header[28:32], "big")
        size = file.stat().st_size
        if size < expected:
            raise ParseError(f"not a readable bag: cut off at {size} of {expected} bytes", file=str(file))


def _messages(path: Path, topic: str | None) -> tuple[list[_Message], int]:
    """The messages of the topic, and how many the bag says there are."""
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise MissingExtraError("rosbags", "bags", f"reading the bag {path.name}") from error
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
            connections = _connections(reader, topic, path)
            raw = reader.messages(connections=connections)
            messages = [_message(stamp, reader.deserialize(data, link.msgtype)) for link, stamp, data in raw]
            return messages, sum(connection.msgcount for connection in connections)
    except ConfigError:
        raise
    except Exception as error:  # a damaged bag surfaces as any of the storage's and decoder's own errors
        raise ParseError(f"not a readable bag: {error or type(error).__name__}", file=str(path)) from error


def _connections(reader: Any, topic: str | None, path: Path) -> list[Any]:
    found: dict[str, list[Any]] = {}
    for connection in reader.connections:
        if connection.msgtype == JOINT_STATE:
            found.setdefault(connection.topic, []).append(connection)
    if topic is None and len(found) == 1:
        return next(iter(found.values()))
    if topic in found:
        return found[topic]
    listed = ", ".join(f"{name} ({sum(link.msgcount for link in links)})" for name, links in found.items())
    have = f"JointState topics (messages): {listed}" if found else f"no topic of type {JOINT_STATE}"
    wanted = f"topic '{topic}' is not one of them" if topic else "choose one with --topic"
    raise ConfigError(f"{path}: {have}" + (f"; {wanted}" if found else ""))


def _message(recorded_ns: int, message: Any) -> _Message:
    stamp = message.header.stamp
    numbers = (str(number + 1) for number in range(len(message.position)))
    return _Message(
        recorded_ns=recorded_ns,
        stamp_ns=stamp.sec * 1_000_000_000 + stamp.nanosec,
        names=tuple(message.name or numbers),
        position=np.asarray(message.position, dtype=np.float64),
        velocity=np.asarray(message.velocity, dtype=np.float64),
        effort=np.asarray(message.effort, dtype=np.float64),
    )


def _wanted_names(messages: Sequence[_Message], joints: Sequence[str]) -> tuple[str, ...]:
    """Names, in the order of their first message, of the set of joints to read."""
    first: dict[frozenset[str], tuple[str, ...]] = {}
    for message in messages:
        first.setdefault(frozenset(message.names), message.names)
    counts = Counter(frozenset(message.names) for message in messages)
    named = [names for names in counts if names]
    holding = [names for names in named if names.issuperset(joints)]
    return first[max(holding or named, key=lambda names: counts[names])]


def _stamps(messages: Sequence[_Message]) -> tuple[FloatArray, str | None]:
    stamps = [message.stamp_ns for message in messages]
    note = None
    if not any(stamps):
        stamps = [message.recorded_ns for message in messages]
        note = "the headers carry no stamp: the times of recording are used"
    return np.array([stamp - stamps[0] for stamp in stamps], dtype=np.float64) * 1e-9, note


def _stack(messages: Sequence[_Message], names: tuple[str, ...], field: str) -> FloatArray:
    """One quantity of all messages, columns in the order of ``names``, NaN where a message leaves it out."""
    rows = np.full((len(messages), len(names)), np.nan)
    for row, message in zip(rows, messages, strict=True):
        values = getattr(message, field)
        if values.size == len(names):
            row[:] = values if message.names == names else [values[message.names.index(name)] for name in names]
    return rows
