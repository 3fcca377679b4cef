"""A thread that keeps a sensor read: opens it, hands its samples on, and opens it again when its link is lost."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, Literal, NamedTuple, Self

from ravengc.errors import ArgumentError, SensorError
from ravengc.messages import kind_of
from ravengc.sensors.sample import Sample, Sensor, Statistics

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["ReaderEvent", "SensorReader"]

FIRST_WAIT_S, LONGEST_WAIT_S = 0.1, 2.0
READ_S = 0.1
JOIN_S = 1.0

Kind = Literal["opened", "failed", "lost", "finished", "error", "stopped"]


class ReaderEvent(NamedTuple):
    """What happened: ``opened``, ``failed`` to open, ``lost``, ``finished``, ``error`` in a callback, ``stopped``.

    ``stamp_ns`` is CLOCK_MONOTONIC; ``message`` says more in words.
    """

    kind: Kind
    stamp_ns: int
    message: str


class SensorReader:
    """Reads a sensor in a thread of its own and gives every sample to ``deliver``, with ``seq`` rising all along.

    ``open_sensor`` makes the sensor, each time anew; ``on_event`` hears of every ReaderEvent. Both callbacks run in
    the reader's thread. When the link is lost the reader waits 0.1 s, then twice as long each time up to 2 s, and
    opens it again; a sample sets the wait back. Nothing is raised out of the thread: what a callback raises is an
    event, and reading goes on; whatever a sensor raises counts as a lost link. A reader runs once.
    """

    def __init__(
        self,
        open_sensor: Callable[[], Sensor],
        deliver: Callable[[Sample], None],
        on_event: Callable[[ReaderEvent], None] | None = None,
    ) -> None:
        for name, given in (("open_sensor", open_sensor), ("deliver", deliver), ("on_event", on_event)):
            if not callable(given) and (given is not None or name != "on_event"):
                raise ArgumentError(f"{name} is {kind_of(given)}; expected a function")
        self.reconnects = 0
        self.delivered = 0
        self.callback_errors = 0
        self.last_event: ReaderEvent | None = None
        self._open_sensor = open_sensor
        self._deliver = deliver
        self._on_event = on_event
        self._sensor: Sensor | None = None
        self._past = Statistics()
        self._lock = threading.Lock()
        self._offset = 0
        self._seq = -1
        self._opened = 0
        self._blamed = False
        self._wait_s = FIRST_WAIT_S
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="ravengc-sensor", daemon=True)

    def start(self) -> Self:
        """Start the thread, and return the reader; SensorError for one that was started before."""
        if self._thread.ident is not None:
            raise SensorError("this reader was started before; a reader runs once, so make another")
        self._thread.start()
        return self

    def stop(self) -> bool:
        """Stop, wait at most 1 s for the thread, and tell whether it has ended. More than once is no error."""
        self._stopping.set()
        if self._thread.ident is not None and self._thread is not threading.current_thread():
            self._thread.join(JOIN_S)
        return not self._thread.is_alive()

    def __enter__(self) -> Self:
        """Start."""
        return self.start()

    def __exit__(self, *_: object) -> None:
        """Stop."""
        self.stop()

    @property
    def running(self) -> bool:
        """Whether samples may still come."""
        return self._thread.is_alive()

    @property
    def connected(self) -> bool:
        """Whether the sensor is open."""
        return self._sensor is not None

    @property
    def remark(self) -> str:
        """What the open sensor has to say about its stream."""
        sensor = self._sensor
        return "" if sensor is None else sensor.remark

    @property
    def statistics(self) -> Statistics:
        """Counts over all openings."""
        total = Statistics()
        with self._lock:
            total.add(self._past)
            if self._sensor is not None:
                total.add(self._sensor.statistics)
        return total

    def _run(self) -> None:
        while not self._stopping.is_set():
            self._session()
        self._tell("stopped", "the reader has ended")

    def _session(self) -> None:
        """One opening, and the wait behind it if it failed or was lost."""
        try:
            sensor = self._open_sensor()
        except Exception as error:  # noqa: BLE001 - nothing is raised out of the thread
            self._tell("failed", _words(error))
            self._back_off()
            return
        self._sensor = sensor
        self._opened += 1
        self.reconnects = self._opened - 1
        self._offset = self._seq + 1
        reason = None
        try:
            self._read_on(sensor)
        except Exception as error:  # noqa: BLE001 - nothing is raised out of the thread
            reason = _words(error)
        self._close(sensor)
        if reason is not None:
            self._tell("lost", reason)
            self._back_off()

    def _read_on(self, sensor: Sensor) -> None:
        """Read until the sensor has ended or the reader is to stop; whatever the sensor raises is for the caller."""
        self._tell("opened", sensor.name)
        while not self._stopping.is_set():
            sample = sensor.read(READ_S)
            if sample is not None:
                self._hand_on(sample)
            elif sensor.finished:
                self._tell("finished", f"{sensor.name} has ended")
                self._stopping.set()

    def _hand_on(self, sample: Sample) -> None:
        self._wait_s = FIRST_WAIT_S
        self._seq = self._offset + sample.seq
        numbered = sample._replace(seq=self._seq)
        try:
            self._deliver(numbered)
            self.delivered += 1
        except Exception as error:  # noqa: BLE001 - nothing is raised out of the thread
            self._blame(error)

    def _close(self, sensor: Sensor) -> None:
        """Keep the counts and let go; the link is closed whether or not the sensor can still count."""
        try:
            with self._lock:
                self._sensor = None
                self._past.add(sensor.statistics)
        except Exception as error:  # noqa: BLE001 - nothing is raised out of the thread
            self._tell("error", f"counting: {_words(error)}")
        try:
            sensor.close()
        except Exception as error:  # noqa: BLE001 - nothing is raised out of the thread
            self._tell("error", f"closing: {_words(error)}")

    def _back_off(self) -> None:
        self._stopping.wait(self._wait_s)
        self._wait_s = min(2.0 * self._wait_s, LONGEST_WAIT_S)

    def _blame(self, error: Exception) -> None:
        """Tell of the first time only: a callback that fails once may fail a hundred times a second."""
        self.callback_errors += 1
        if not self._blamed:
            self._blamed = True
            self._tell("error", f"deliver: {_words(error)}")

    def _tell(self, kind: Kind, message: str) -> None:
        event = ReaderEvent(kind, time.monotonic_ns(), message)
        self.last_event = event
        if self._on_event is None:
            return
        try:
            self._on_event(event)
        except Exception:  # noqa: BLE001 - who hears of events cannot stop the sensor
            self.callback_errors += 1


def _words(error: Exception) -> str:
    return str(error) if isinstance(error, SensorError) else f"{type(error).__name__}: {error}"
