"""Sensors that send datagrams over loopback: one sender is heard, and whatever else comes costs nothing."""

from __future__ import annotations

import errno
import socket
from typing import TYPE_CHECKING

import pytest

from ravengc.errors import SensorError
from ravengc.sensors import open_sensor
from ravengc.sensors.links import UdpLink
from sensor_frames import line
from sensor_hosts import Sender, read_samples, wait_for

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture
def udp() -> Iterator[tuple[UdpLink, socket.socket]]:
    link = UdpLink(0)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.connect(("127.0.0.1", link.port))
        yield link, sender
    link.close()


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def test_a_line_in_a_datagram_needs_no_end() -> None:
    port = free_port()
    sensor = open_sensor(f"udp:{port}?format=line")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for number in range(3):
            sender.sendto(line(number).data.rstrip(), ("127.0.0.1", port))
        assert [sample.specific_force for sample in read_samples(sensor, 3)] == [line(n).force for n in range(3)]
    sensor.close()


def test_only_the_first_sender_is_heard_while_it_speaks(
    udp: tuple[UdpLink, socket.socket], monkeypatch: pytest.MonkeyPatch
) -> None:
    link, sender = udp
    monkeypatch.setattr("ravengc.sensors.links.udp.SILENCE_NS", 10**15)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        sender.send(b"one")
        assert link.receive(5.0) == b"one"
        other.sendto(b"false", ("127.0.0.1", link.port))
        sender.send(b"two")
        assert link.receive(5.0) == b"two"
        assert link.foreign == 1
        link.send(b"answer")
        assert sender.recv(100) == b"answer"
        monkeypatch.setattr("ravengc.sensors.links.udp.SILENCE_NS", 0)
        other.sendto(b"three", ("127.0.0.1", link.port))
        assert link.receive(5.0) == b"three"


def test_a_port_that_is_taken_is_a_sensor_error(udp: tuple[UdpLink, socket.socket]) -> None:
    with pytest.raises(SensorError, match="busy: another program has the port"):
        UdpLink(udp[0].port)


@pytest.mark.parametrize(
    ("host", "port", "words"),
    [
        ("no such host.invalid", 14550, "udp:"),
        ("8.8.8.8", 14550, "no address of this machine: give one that it has, or 0.0.0.0"),
        ("127.0.0.1", 70000, "udp:127.0.0.1:70000"),
        ("127.0.0.1", -1, "udp:127.0.0.1:-1"),
        ("a\0b", 14550, "udp:"),
        ("a" * 70 + ".b", 14550, "udp:"),
    ],
)
def test_what_cannot_be_listened_to_is_a_sensor_error(host: str, port: int, words: str) -> None:
    with pytest.raises(SensorError, match=words):
        UdpLink(port, host)


def test_a_port_for_the_superuser_alone_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(socket.socket, "bind", refuse)
    with pytest.raises(SensorError, match="ports from 1024 on are free to all"):
        UdpLink(80)


def test_the_largest_datagram_is_read_whole_and_an_empty_one_is_nothing() -> None:
    port = free_port()
    sensor = open_sensor(f"udp:{port}?format=line")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(b"", ("127.0.0.1", port))
        sender.sendto(b"x" * (65_507 - len(line(1).data)) + line(1).data, ("127.0.0.1", port))
        sender.sendto(line(2).data, ("127.0.0.1", port))
        assert [sample.specific_force for sample in read_samples(sensor, 2)] == [line(1).force, line(2).force]
    assert sensor.statistics.bytes_received == 65_507 + len(line(2).data)
    sensor.close()


def test_strangers_that_never_stop_do_not_keep_the_reader_busy(monkeypatch: pytest.MonkeyPatch) -> None:
    """A read returns when its time is over, however many datagrams of others come meanwhile."""
    monkeypatch.setattr("ravengc.sensors.links.udp.SILENCE_NS", 10**15)
    link = UdpLink(0)
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other,
    ):
        sender.sendto(b"ours", ("127.0.0.1", link.port))
        assert link.receive(5.0) == b"ours"
        with Sender(lambda _: other.sendto(b"not ours", ("127.0.0.1", link.port)), period_s=0.0005):
            wait_for(lambda: link.receive(0.02) == b"" and link.foreign > 10)
    link.close()
