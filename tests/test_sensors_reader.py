"""The reader: whatever happens to a sensor, samples go on or an event says why, and nothing leaves the thread."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import pytest

from ravengc.errors import ArgumentError, SensorError
from ravengc.sensors import SensorReader, open_sensor, parse_address
from ravengc.sensors.sample import Sample, Statistics
from sensor_frames import bno08x
from sensor_hosts import Board, Sender, wait_for


class Collected:
    """What a reader has delivered and told."""

    def __init__(self) -> None:
        self.samples: list[Sample] = []
        self.events: list[str] = []

    def tell(self, event: object) -> None:
        self.events.append(event.kind)


def test_the_reader_survives_unplugging(tmp_path: Path) -> None:
    """Unplugged in the middle of a stream and plugged in again: samples, an event, samples; seq rises all along."""
    collected, board = Collected(), Board(tmp_path / "ttyBOARD")
    reader = SensorReader(
        parse_address(f"serial:{board.path}?format=bno08x").prepare(), collected.samples.append, collected.tell
    )
    with reader:
        for _ in range(2):
            with Sender(lambda number: board.send(bno08x(number).data)):
                before = len(collected.samples)
                wait_for(lambda: len(collected.samples) >= before + 20)  # noqa: B023
                board.unplug()
                wait_for(lambda: "failed" in collected.events and not reader.connected)
            collected.events.clear()
            board.plug()
            wait_for(lambda: reader.connected)
    assert reader.reconnects == 2
    assert not reader.running
    numbers = [sample.seq for sample in collected.samples]
    assert numbers == sorted(set(numbers))
    assert reader.statistics.samples == len(collected.samples) == reader.delivered
    assert reader.last_event is not None
    assert reader.last_event.kind == "stopped"
    board.unplug()


class Scripted:
    """A sensor that does what a list says: a sample's number, None, or an error to raise."""

    def __init__(self, script: list[object]) -> None:
        self.name, self.remark = "scripted", ""
        self.statistics = Statistics()
        self.script = script
        self.closed = 0

    @property
    def finished(self) -> bool:
        return not self.script

    def read(self, timeout_s: float) -> Sample | None:  # noqa: ARG002
        step = self.script.pop(0) if self.script else None
        if isinstance(step, BaseException):
            raise step
        return None if step is None else Sample(step, 0, (0.0, 0.0, 9.8))

    def close(self) -> None:
        self.closed += 1


def run_to_its_end(scripts: list[list[object] | Exception]) -> tuple[SensorReader, Collected]:
    collected, remaining = Collected(), list(scripts)

    def open_next() -> Scripted:
        script = remaining.pop(0)
        if isinstance(script, Exception):
            raise script
        return Scripted(script)

    reader = SensorReader(open_next, collected.samples.append, collected.tell).start()
    wait_for(lambda: not reader.running)
    return reader, collected


def test_whatever_a_sensor_raises_stays_in_the_thread() -> None:
    reader, collected = run_to_its_end([[0, 1, SensorError("gone")], OSError("no"), [0, ValueError("bug")], [0, 1, 2]])
    assert [sample.seq for sample in collected.samples] == [0, 1, 2, 3, 4, 5]
    assert collected.events == ["opened", "lost", "failed", "opened", "lost", "opened", "finished", "stopped"]
    assert reader.reconnects == 2


def test_a_callback_that_raises_stops_nothing() -> None:
    events: list[str] = []

    def deliver(_: Sample) -> None:
        raise RuntimeError("bug")

    def tell(event: object) -> None:
        events.append(event.kind)
        raise RuntimeError("another")

    reader = SensorReader(lambda: Scripted([0, 1, 2]), deliver, tell).start()
    wait_for(lambda: not reader.running)
    assert events == ["opened", "error", "finished", "stopped"]
    assert reader.callback_errors >= 3
    assert reader.delivered == 0


def test_the_waits_double_and_a_sample_sets_them_back(monkeypatch: pytest.MonkeyPatch) -> None:
    waits: list[float] = []
    lost = SensorError("gone")
    script = [lost, lost, lost, lost, lost, lost, [0, SensorError("gone")], lost, [None]]
    real = threading.Event.wait

    def wait(self: threading.Event, timeout: float | None = None) -> bool:
        if threading.current_thread().name == "ravengc-sensor":
            waits.append(timeout or 0.0)
            return self.is_set()
        return real(self, timeout)

    monkeypatch.setattr(threading.Event, "wait", wait)
    run_to_its_end(script)
    assert waits == [0.1, 0.2, 0.4, 0.8, 1.6, 2.0, 0.1, 0.2]


def test_stopping_a_reader_that_was_never_started_or_twice_is_no_error() -> None:
    reader = SensorReader(lambda: Scripted([]), lambda _: None)
    assert reader.stop()
    started = SensorReader(lambda: Scripted([None] * 10**6), lambda _: None).start()
    assert started.stop()
    assert started.stop()


def test_a_reader_waiting_to_reopen_stops_at_once() -> None:
    def never() -> Scripted:
        raise SensorError("not there")

    reader = SensorReader(never, lambda _: None).start()
    wait_for(lambda: reader.last_event is not None)
    assert reader.stop()


def test_a_reader_takes_functions() -> None:
    with pytest.raises(ArgumentError, match="deliver is an int; expected a function"):
        SensorReader(lambda: Scripted([]), 3)


class Broken(Scripted):
    """Raises where even a sensor that has lost its link should not."""

    def __init__(self, what: str) -> None:
        super().__init__([None])
        self.what = what
        self.closed_in_time = threading.Event()

    def __getattribute__(self, name: str) -> object:
        if name == object.__getattribute__(self, "__dict__").get("what"):
            raise RuntimeError(f"no {name}")
        return super().__getattribute__(name)

    def close(self) -> None:
        self.closed_in_time.set()


@pytest.mark.parametrize("what", ["name", "read", "finished", "statistics"])
def test_a_sensor_that_cannot_even_tell_its_name_is_a_lost_one(what: str) -> None:
    """The thread goes on to the next opening, and closes what it had opened."""
    collected, broken = Collected(), Broken(what)
    sensors = [broken, Scripted([0, 1])]
    reader = SensorReader(lambda: sensors.pop(0), collected.samples.append, collected.tell).start()
    wait_for(lambda: not reader.running)
    assert [sample.seq for sample in collected.samples] == ([0, 1] if what != "statistics" else [])
    assert broken.closed_in_time.is_set()
    assert collected.events[-1] == "stopped"


def test_what_is_no_sample_is_a_lost_link() -> None:
    collected = Collected()
    odd = Scripted([None])
    odd.read = lambda _: (1, 2, 3)  # type: ignore[method-assign]
    sensors = [odd, Scripted([0])]
    reader = SensorReader(lambda: sensors.pop(0), collected.samples.append, collected.tell).start()
    wait_for(lambda: not reader.running)
    assert "lost" in collected.events
    assert reader.delivered == 1


def test_a_reader_runs_once() -> None:
    reader, _ = run_to_its_end([[0]])
    with pytest.raises(SensorError, match="make another"):
        reader.start()
    with pytest.raises(SensorError, match="make another"), reader:
        pass


def test_stopping_while_the_sensor_is_being_opened_does_not_wait_for_it() -> None:
    """A name server that does not answer, a bus that hangs: what comes of it in the end is closed, and never read."""
    answer, collected, late = threading.Event(), Collected(), Broken("")

    def slow() -> Scripted:
        answer.wait(20.0)
        return late

    reader = SensorReader(slow, collected.samples.append, collected.tell).start()
    begun = time.monotonic()
    assert not reader.stop()
    assert time.monotonic() - begun < 10.0, "it waits a second, not for ever"
    answer.set()
    wait_for(lambda: not reader.running)
    assert late.closed_in_time.is_set()
    assert not collected.samples
    assert reader.stop()


def descriptors() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


def test_a_thousand_reconnections_leave_no_descriptor_open(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A port that is opened, read, and lost; and between two of them one that is busy."""
    monkeypatch.setattr("ravengc.sensors.reader.FIRST_WAIT_S", 0.0)
    monkeypatch.setattr("ravengc.sensors.reader.LONGEST_WAIT_S", 0.0)
    board = Board(tmp_path / "ttyBOARD")
    before, address = descriptors(), f"serial:{board.path}?format=bno08x"

    def opened() -> object:
        sensor = open_sensor(address)
        with pytest.raises(SensorError, match="busy"):
            open_sensor(address)
        sensor.read(0.0)
        sensor._link.receive = lambda _: (_ for _ in ()).throw(SensorError("lost"))
        return sensor

    reader = SensorReader(opened, lambda _: None)
    reader._wait_s = 0.0
    with reader:
        wait_for(lambda: reader.reconnects >= 1000)
    assert not reader.connected
    assert descriptors() == before
    board.unplug()


@pytest.mark.parametrize(
    "address", ["serial:/dev/null", "serial:/", "udp:8.8.8.8:14550", "file:/", "iio:nosuch?root=/nowhere"]
)
def test_openings_that_fail_leave_no_descriptor_open(address: str) -> None:
    before = descriptors()
    for _ in range(200):
        with pytest.raises(SensorError):
            open_sensor(address)
    assert descriptors() == before
