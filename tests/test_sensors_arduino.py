"""The Arduino sketch, compiled for this machine with an I2C bus of registers, against the decoder of its lines."""

from __future__ import annotations

import itertools
import os
import shutil
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from ravengc.sensors.decoders import make_decoder

if TYPE_CHECKING:
    from ravengc.sensors.sample import Measurement

ROOT = Path(__file__).parents[1]
G = 9.80665
DEGREE = 0.017453293


@pytest.fixture(scope="module")
def sketch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    compiler = shutil.which(os.environ.get("CXX", "c++"))
    if compiler is None:
        pytest.skip("no C++ compiler: the sketch is not compiled")
    program = tmp_path_factory.mktemp("arduino") / "host"
    folders = (ROOT / "tests" / "arduino", ROOT / "examples" / "arduino" / "ravengc_imu")
    options = ["-std=c++11", "-Wall", "-Wextra", "-Werror", *(f"-I{folder}" for folder in folders)]
    subprocess.run([compiler, *options, str(folders[0] / "host.cpp"), "-o", str(program)], check=True)  # noqa: S603
    return program


def run(
    sketch: Path,
    address: int,
    registers: dict[int, int],
    *,
    seconds: float = 1.0,
    start_us: int = 0,
    away: tuple[float, float] = (1e9, 1e9),
) -> tuple[list[Measurement], bytes]:
    words = [str(seconds), str(start_us), *map(str, away), hex(address)]
    words += [f"{number:#x}={value:#x}" for number, value in registers.items()]
    output = subprocess.run([str(sketch), *words], check=True, capture_output=True).stdout  # noqa: S603
    decoder = make_decoder("line")
    found = decoder.feed(output)
    assert decoder.statistics.bad_checksum == decoder.statistics.bad_content == decoder.statistics.bytes_skipped == 0
    return found, output


def words16(first: int, values: list[int]) -> dict[int, int]:
    """Registers that hold these numbers, low byte first."""
    pairs = itertools.chain.from_iterable((value & 255, value >> 8 & 255) for value in values)
    return {first + number: byte for number, byte in enumerate(pairs)}


@pytest.mark.parametrize("address", [0x40, 0x41])
def test_bma180(sketch: Path, address: int) -> None:
    """14 bits, 4096 counts per g, in the upper bits of each word, whose lowest says that it is new."""
    registers = {
        0x00: 0x03,
        0x20: 0x4F,
        0x35: 0xF1,
        **words16(0x02, [(-4096 << 2) | 1, (1024 << 2) | 1, (8191 << 2) | 1]),
    }
    found, output = run(sketch, address, registers)
    assert found[0].specific_force == pytest.approx((-G, G / 4, 8191 * G / 4096), abs=1e-4)
    assert found[0].angular_velocity is None
    assert b"# BMA180\r\n" in output
    for setting in (b"0x0D=0x10", b"0x20=0x2F", b"0x35=0xF5"):
        assert setting in output, "the bits of other settings stay"


def test_adxl345(sketch: Path) -> None:
    found, output = run(sketch, 0x53, {0x00: 0xE5, **words16(0x32, [-256, 3, 300])})
    assert found[0].specific_force == pytest.approx((-G, 3 * G / 256, 300 * G / 256), abs=1e-4)
    for setting in (b"0x2C=0x0A", b"0x2D=0x08", b"0x31=0x09"):
        assert setting in output


@pytest.mark.parametrize("identity", [0x69, 0x6A, 0x6B, 0x6C])
def test_lsm6ds(sketch: Path, identity: int) -> None:
    registers = {0x0F: identity, **words16(0x22, [1000, -2000, 32767]), **words16(0x28, [-32768, 0, 8197])}
    found, _ = run(sketch, 0x6B, registers)
    assert found[0].specific_force == pytest.approx((-32768 * 0.000122 * G, 0, 8197 * 0.000122 * G), abs=1e-4)
    assert found[0].angular_velocity == pytest.approx([0.00875 * DEGREE * v for v in (1000, -2000, 32767)], abs=1e-4)


def test_a_hundred_samples_a_second_through_the_wrap_of_the_clock(sketch: Path) -> None:
    registers = {0x00: 0xE5, **words16(0x32, [0, 0, 256])}
    found, _ = run(sketch, 0x1D, registers, seconds=2.0, start_us=2**32 - 1_000_000)
    assert 198 <= len(found) <= 200
    clocks = [measurement.clock_ns for measurement in found]
    assert all(abs(later - sooner - 10_000_000) <= 100_000 for sooner, later in itertools.pairwise(clocks))


def test_a_sensor_that_vanishes_is_silence_and_comes_back(sketch: Path) -> None:
    registers = {0x00: 0xE5, **words16(0x32, [0, 0, 256])}
    found, output = run(sketch, 0x53, registers, seconds=6.0, away=(1.0, 3.0))
    clocks = [measurement.clock_ns for measurement in found]
    gaps = [later - sooner for sooner, later in itertools.pairwise(clocks)]
    assert sum(gap > 11_000_000 for gap in gaps) == 1
    assert 1.9e9 < max(gaps) < 3.2e9
    assert output.count(b"# ADXL345\r\n") == 2
    assert output.count(b"# sensor lost\r\n") == 1


def test_no_sensor_is_said_once_a_second(sketch: Path) -> None:
    found, output = run(sketch, 0x10, {}, seconds=5.0)
    assert found == []
    assert 4 <= output.count(b"check power, SDA and SCL") <= 6
