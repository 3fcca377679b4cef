"""The [accelerometer] table of a robot file: read with the robot, kept, written, and used by the chain."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

import ravengc as rg
from ravengc.calibration.block import read_block, write_block
from ravengc.cli.run_sensor import block_of, chain_of
from ravengc.config import spec_from_toml, spec_to_toml
from ravengc.errors import ConfigError

if TYPE_CHECKING:
    from pathlib import Path

TABLE = {
    "sensor": "serial:/dev/ttyUSB0?format=line",
    "rate_hz": 200.0,
    "range": 39.2,
    "rotation": [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
    "bias": [0.1, -0.05, 0.2],
    "cutoff_hz": 15,
    "policy": "strict",
    "jerk": 500.0,
    "moving_base": True,
}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "arm.toml"
    rg.load("raven2_gold").to_toml(path)
    write_block(path, TABLE)
    return path


def test_a_robot_file_with_a_sensor_is_still_a_robot(file: Path) -> None:
    robot = rg.from_toml(file)
    assert robot.spec.accelerometer is not None
    assert dict(robot.spec.accelerometer) == TABLE
    assert rg.from_toml(robot.to_toml()).spec.accelerometer == robot.spec.accelerometer
    assert spec_from_toml(spec_to_toml(robot.spec)) == robot.spec


def test_what_is_written_again_says_the_same(file: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.toml"
    rg.from_toml(file).to_toml(again)
    assert read_block(again) == read_block(file)


def test_the_table_makes_the_chain(file: Path) -> None:
    block = block_of(str(file))
    chain = chain_of(block, block.rate_hz or 100.0)
    assert chain.state == "no_data"
    for k in range(1, 500):
        if k % 5 == 0:
            noise = 1e-3 * (k % 7)
            chain.push(k, k * 1_000_000, (0.1 + noise, -0.05 - 2.0 + noise, 9.6 + 0.2 + noise))
        chain.step(k * 1_000_000)
    assert chain.state == "live"
    assert chain.gravity.x == pytest.approx(-2.0, abs=0.02)


def test_what_the_table_declares_of_the_base_reaches_the_chain(tmp_path: Path) -> None:
    """A base on its side is refused by the default, and live where the table lets up be that far away."""
    states = {}
    for limit in ("45 deg", "90 deg"):
        (tmp_path / "arm.toml").write_text(f'[accelerometer]\npose_limit = "{limit}"\n')
        chain = chain_of(block_of(str(tmp_path / "arm.toml")), 100.0)
        for k in range(1, 500):
            if k % 10 == 0:
                noise = 1e-3 * (k % 70)
                chain.push(k, k * 1_000_000, (8.5 + noise, noise, 4.9 + noise))
            chain.step(k * 1_000_000)
        states[limit] = chain.state
    assert states == {"45 deg": "nominal", "90 deg": "live"}


@pytest.mark.parametrize(
    ("line", "words"),
    [("rat_hz = 100.0", "rate_hz"), ("rate_hz = true", "a text, a number"), ("moving_base = 1", "true or false")],
)
def test_a_wrong_key_or_value_is_refused_with_the_robot(line: str, words: str) -> None:
    text = rg.load("raven2_gold").to_toml() + f"\n[accelerometer]\n{line}\n"
    with pytest.raises(ConfigError, match=words):
        rg.from_toml(text)
