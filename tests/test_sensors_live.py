"""A live sensor: read by a thread, stepped by whoever asks; what it has to say is said after its end, too."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ravengc.monitored import STATES, chain_for
from ravengc.sensors import parse_address
from ravengc.sensors.live import LiveSensor
from sensor_frames import bno08x
from sensor_hosts import Board, Sender, wait_for

if TYPE_CHECKING:
    from pathlib import Path


def test_a_recording_that_has_ended_says_so(tmp_path: Path) -> None:
    path = tmp_path / "imu.csv"
    path.write_text("t,ax,ay,az\n0,0,0,9.8\n0.01,0,0,9.81\n", encoding="ascii")
    sensor = LiveSensor(chain_for(100.0), parse_address(f"replay:{path}").prepare())
    wait_for(lambda: not sensor.reader.running)
    assert sensor.remark.startswith("finished: replay:")
    assert sensor.norm == 9.81
    sensor.close()


def test_a_port_that_comes_and_goes_is_said_to(tmp_path: Path) -> None:
    board = Board(tmp_path / "ttyBOARD")
    board.unplug()
    sensor = LiveSensor(chain_for(100.0), parse_address(f"serial:{board.path}?format=bno08x").prepare())
    wait_for(lambda: "not there" in sensor.remark)
    board.plug()
    wait_for(lambda: sensor.reader.connected)
    wait_for(lambda: sensor.remark == "")
    board.unplug()
    wait_for(lambda: "lost:" in sensor.remark or "failed:" in sensor.remark)
    sensor.close()
    assert "board" in sensor.remark.lower(), "still, when it is closed"


def test_the_chain_is_warm_as_soon_as_it_may_be_armed(tmp_path: Path) -> None:
    board = Board(tmp_path / "ttyBOARD")
    sensor = LiveSensor(
        chain_for(100.0, policy="strict"), parse_address(f"serial:{board.path}?format=bno08x").prepare()
    )
    still = [bno08x(41 * number) for number in range(256)]
    with Sender(lambda number: board.send(_level(number % 256, still)), period_s=0.01):
        wait_for(lambda: sensor.reader.delivered > 3)
        sensor.warm_up(20.0)
        assert STATES[sensor.state] == "live"
    sensor.close()
    assert not sensor.reader.running
    board.unplug()


def _level(index: int, frames: list) -> bytes:
    """A frame of a chip that lies flat, with this index: a few mg of noise."""
    body = bytearray(frames[0].data)
    body[2] = index
    for place, value in zip((9, 11, 13), (index * 7 % 5 - 2, index * 3 % 5 - 2, 1000 + index % 3), strict=True):
        body[place : place + 2] = value.to_bytes(2, "little", signed=True)
    body[-1] = sum(body[2:-1]) % 256
    return bytes(body)
