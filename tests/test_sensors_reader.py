"""The reader: whatever happens to a sensor, samples go on or an event says why, and nothing leaves the thread."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

import pytest

from ravengc.errors import ArgumentError, SensorError
from ravengc.sensors import SensorReader, parse_address
from ravengc.sensors.sample import Sample, Statistics
from sensor_frames import bno08x
from sensor_hosts import Board, Sender, wait_for

if TYPE_CHECKING:
    from pathlib import Path


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
    with pytest.raises(ArgumentError, match="deliver is a int; expected a function"):
        SensorReader(lambda: Scripted([]), 3)
