"""Recordings from ROS bags: by joint name, by stamp, whole or not at all."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from ravengc.errors import ConfigError, MissingExtraError, ParseError
from ravengc.recordings import read_recording
from ravengc.recordings.bag_file import JOINT_STATE

HEAD = Path(__file__).parent / "data" / "panda_unisa_head.db3"
TYPES = ("builtin_interfaces/msg/Time", "std_msgs/msg/Header", JOINT_STATE)


def joint_states(folder: Path, messages: list[tuple], kind: str = "mcap") -> Path:
    """A bag of (topic, time of recording ns, stamp ns, names, position, velocity, effort)."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    time, header_type, state = (store.types[name] for name in TYPES)
    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    with Writer(folder / "bag", version=9, storage_plugin=plugin) as writer:
        names = dict.fromkeys(topic for topic, *_ in messages)
        topics = {name: writer.add_connection(name, JOINT_STATE, typestore=store) for name in names}
        for topic, recorded, stamp, names, *values in messages:
            header = header_type(stamp=time(sec=stamp // 10**9, nanosec=stamp % 10**9), frame_id="")
            arrays = (np.array(value, dtype=np.float64) for value in values)
            message = state(header, names, *arrays)
            writer.write(topics[topic], recorded, store.serialize_cdr(message, JOINT_STATE))
    return folder / "bag"


AB = ["a", "b"]
SECOND = 10**9


def test_bag_of_the_bundled_recording_holds_the_same_numbers() -> None:
    bag, whole = read_recording(HEAD), read_recording("example:panda")
    assert bag.names == tuple(f"fer_joint{number}" for number in range(1, 8))
    np.testing.assert_array_equal(bag.t, whole.t[:40])
    for name in ("q", "qd", "tau"):
        np.testing.assert_array_equal(getattr(bag, name), getattr(whole, name)[:40])


@pytest.mark.parametrize("kind", ["mcap", "db3"])
@pytest.mark.parametrize("bare", [False, True])
def test_bags_are_read_by_joint_name(tmp_path: Path, kind: str, bare: bool) -> None:
    messages = [
        ("/js", 5 * SECOND, 100 * SECOND, AB, [1, 2], [3, 4], [5, 6]),
        ("/js", 6 * SECOND, 101 * SECOND, ["b", "a"], [20, 10], [40, 30], [60, 50]),
        ("/js", 7 * SECOND, 102 * SECOND, ["finger"], [0.1], [], []),
        ("/js", 8 * SECOND, 103 * SECOND, AB, [7, 8], [9, 10], []),
    ]
    bag = joint_states(tmp_path, messages, kind)
    recording = read_recording(next(bag.glob(f"*.{kind}")) if bare else bag)
    assert recording.names == ("a", "b")
    np.testing.assert_array_equal(recording.t, [0.0, 1.0])
    np.testing.assert_array_equal(recording.q, [[1, 2], [10, 20]])
    np.testing.assert_array_equal(recording.tau, [[5, 6], [50, 60]])
    assert recording.skipped == {"message for other joints": 1, "missing or non-finite number": 1}
    finger = read_recording(bag, joints=["finger"])
    assert (finger.names, finger.qd, finger.tau) == (("finger",), None, None)


def test_joints_without_names_are_numbered(tmp_path: Path) -> None:
    recording = read_recording(joint_states(tmp_path, [("/js", 0, 1, [], [4, 5], [], [])]))
    assert recording.names == ("1", "2")


def test_stamps_of_zero_give_way_to_the_time_of_recording(tmp_path: Path) -> None:
    bag = joint_states(tmp_path, [("/js", k * SECOND // 4, 0, AB, [k, k], [], []) for k in range(3)])
    recording = read_recording(bag)
    np.testing.assert_array_equal(recording.t, [0.0, 0.25, 0.5])
    assert any("times of recording" in note for note in recording.notes)


def test_several_topics_need_a_choice(tmp_path: Path) -> None:
    bag = joint_states(tmp_path, [("/left", 0, 1, AB, [1, 2], [], []), ("/right", 1, 2, AB, [3, 4], [], [])])
    with pytest.raises(ConfigError, match=r"/left \(1\), /right \(1\); choose one with --topic"):
        read_recording(bag)
    with pytest.raises(ConfigError, match="topic '/up' is not one of them"):
        read_recording(bag, topic="/up")
    np.testing.assert_array_equal(read_recording(bag, topic="/right").q, [[3, 4]])


def test_ros1_bags_are_read_too(tmp_path: Path) -> None:
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    time, header, state = (store.types[name] for name in TYPES)
    with Writer(tmp_path / "log.bag") as writer:
        topic = writer.add_connection("/js", JOINT_STATE, typestore=store)
        for k in range(2):
            stamp = header(seq=k, stamp=time(sec=7 + k, nanosec=0), frame_id="")
            message = state(stamp, AB, np.array([k, 2.0]), np.array([]), np.array([5.0, k]))
            writer.write(topic, k, store.serialize_ros1(message, JOINT_STATE))
    recording = read_recording(tmp_path / "log.bag")
    np.testing.assert_array_equal(recording.tau, [[5, 0], [5, 1]])


@pytest.mark.parametrize("cut", [0.1, 0.5, 0.99])
def test_a_truncated_bag_is_never_read_in_part(tmp_path: Path, cut: float) -> None:
    mcap = next(joint_states(tmp_path, [("/js", k, k + 1, AB, [k, k], [], []) for k in range(50)]).glob("*.mcap"))
    for source, name in ((mcap, "cut.mcap"), (HEAD, "cut.db3")):
        content = source.read_bytes()
        path = tmp_path / name
        path.write_bytes(content[: int(cut * len(content))])
        with pytest.raises(ParseError, match="not a readable bag"):
            read_recording(path)


def test_bags_without_joint_states_and_folders_without_a_bag(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "empty" / "notes.txt").write_text("x")
    with pytest.raises(ParseError, match=r"a folder without metadata\.yaml"):
        read_recording(tmp_path / "empty")
    (tmp_path / "empty" / "metadata.yaml").write_text("x")
    with pytest.raises(ParseError, match="not a readable bag"):
        read_recording(tmp_path / "empty")
    with pytest.raises(ParseError, match="no sensor_msgs/msg/JointState message with a joint"):
        read_recording(joint_states(tmp_path, [("/js", 0, 1, [], [], [], [])]), joints=["a"])


def test_reading_bags_names_the_missing_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'ravengc\[bags\]'"):
        read_recording(HEAD)
