"""Linux IIO devices, on folders that look like those of the kernel."""

from __future__ import annotations

import errno
import os
import shutil
from typing import TYPE_CHECKING

import pytest

from ravengc.errors import ConfigError, SensorError
from ravengc.sensors import open_sensor
from ravengc.sensors.iio import IioSensor

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

ADXL345 = {
    "name": "adxl345",
    "in_accel_x_raw": "-3",
    "in_accel_y_raw": "16",
    "in_accel_z_raw": "256",
    "in_accel_scale": "0.038300000",
}
LSM6DSL_GYRO = {
    "name": "lsm6dsl_gyro",
    "in_anglvel_x_raw": "10",
    "in_anglvel_y_raw": "20",
    "in_anglvel_z_raw": "-30",
    "in_anglvel_scale": "0.000152717",
}


def device(root: Path, number: int, attributes: dict[str, str]) -> Path:
    folder = root / f"iio:device{number}"
    folder.mkdir(exist_ok=True)
    for name, text in attributes.items():
        (folder / name).write_text(text + "\n", encoding="ascii")
    return folder


def read(sensor: IioSensor) -> tuple[float, ...]:
    sample = sensor.read(5.0)
    assert sample is not None
    return sample.specific_force


def read_until(sensor: IioSensor, condition: Callable[[], bool]) -> None:
    """Read, and find nothing, until the condition holds."""
    for _ in range(1000):
        if condition():
            return
        assert sensor.read(1.0) is None


@pytest.mark.parametrize("name", ["adxl345", "iio:device2", "2"])
def test_a_device_is_found_by_name_folder_and_number(tmp_path: Path, name: str) -> None:
    device(tmp_path, 0, {"name": "ads1115"})
    device(tmp_path, 2, ADXL345)
    sensor = open_sensor(f"iio:{name}?root={tmp_path}&rate=500")
    sample = sensor.read(5.0)
    assert sample is not None
    assert sample.specific_force == pytest.approx((-3 * 0.0383, 16 * 0.0383, 256 * 0.0383))
    assert sample.angular_velocity is None
    assert sensor.name == "iio:iio:device2"


def test_offsets_count_before_scales_and_axes_may_have_their_own(tmp_path: Path) -> None:
    own = {"in_accel_x_scale": "2", "in_accel_y_scale": "3", "in_accel_z_scale": "4", "in_accel_z_offset": "-6"}
    device(tmp_path, 0, {**ADXL345, **own, "in_accel_offset": "10"})
    assert read(IioSensor("adxl345", root=str(tmp_path))) == ((-3 + 10) * 2, (16 + 10) * 3, (256 - 6) * 4)


def test_the_mount_matrix_turns_both_sensors_of_a_chip(tmp_path: Path) -> None:
    """x' is the first row times the reading; a gyroscope that is a device of its own may lack the chip's matrix."""
    device(tmp_path, 0, {**ADXL345, "in_accel_scale": "1", "in_mount_matrix": "0, 1, 0; -1, 0, 0; 0, 0, 1"})
    device(tmp_path, 1, {**LSM6DSL_GYRO, "in_anglvel_scale": "0.5"})
    sensor = open_sensor(f"iio:adxl345?root={tmp_path}&gyro=lsm6dsl_gyro")
    sample = sensor.read(5.0)
    assert sample is not None
    assert sample.specific_force == (16, 3, 256)
    assert sample.angular_velocity == (10, -5, -15)
    as_it_is = open_sensor(f"iio:adxl345?root={tmp_path}&gyro=lsm6dsl_gyro&mount=no").read(5.0)
    assert as_it_is is not None
    assert as_it_is.specific_force == (-3, 16, 256)


def test_a_gyroscope_of_the_same_device_is_read(tmp_path: Path) -> None:
    device(tmp_path, 0, {**LSM6DSL_GYRO, **ADXL345, "in_anglvel_mount_matrix": "1, 0, 0; 0, -1, 0; 0, 0, -1"})
    sample = IioSensor("0", root=str(tmp_path)).read(5.0)
    assert sample is not None
    assert sample.angular_velocity == pytest.approx((0.00152717, -0.00305434, 0.00458151))


def test_a_value_that_fails_is_counted_and_a_device_that_is_gone_is_an_error(tmp_path: Path) -> None:
    folder = device(tmp_path, 0, ADXL345)
    sensor = IioSensor("adxl345", root=str(tmp_path), rate_hz=1000.0)
    (folder / "in_accel_y_raw").write_text("", encoding="ascii")
    read_until(sensor, lambda: sensor.statistics.bad_content >= 3)
    assert "no number" in sensor.remark
    device(tmp_path, 0, ADXL345)
    assert read(sensor)[1] == pytest.approx(16 * 0.0383)
    shutil.rmtree(folder)
    with pytest.raises(SensorError, match="lost"):
        read(sensor)


def test_a_device_that_fails_again_and_again_is_gone(tmp_path: Path) -> None:
    folder = device(tmp_path, 0, ADXL345)
    sensor = IioSensor("adxl345", root=str(tmp_path), rate_hz=1000.0)
    (folder / "in_accel_x_raw").write_text("?", encoding="ascii")
    with pytest.raises(SensorError):
        read_until(sensor, lambda: False)


@pytest.mark.parametrize(
    ("name", "changes", "words"),
    [
        ("adxl354", {}, "did you mean 'adxl345'"),
        ("7", {}, "devices: 'iio:device0 \\(adxl345\\)'"),
        ("adxl345", {"in_accel_z_raw": None}, "has no 'in_accel_z_raw'"),
        ("adxl345", {"in_accel_scale": None}, "in_accel_scale is missing"),
        ("adxl345", {"in_accel_scale": "one"}, "in_accel_scale is 'one', no number"),
        ("adxl345", {"in_accel_scale": "nan"}, "in_accel_scale is 'nan', no number"),
        ("adxl345", {"in_accel_scale": ""}, "in_accel_scale is '', no number"),
        ("adxl345", {"in_accel_scale": "0.000000000"}, "in_accel_scale is 0"),
        ("adxl345", {"in_accel_offset": "inf"}, "in_accel_offset is 'inf', no number"),
        ("adxl345", {"mount_matrix": "1, 0; 0, 1"}, "mount matrix"),
        ("adxl345", {"mount_matrix": "nan, 0, 0; 0, 1, 0; 0, 0, 1"}, "mount matrix"),
        ("adxl345", {"mount_matrix": "1, 0, 0; 0, 1, 0; 0, 0, -1"}, "three rows of a rotation"),
    ],
)
def test_what_is_missing_is_said(tmp_path: Path, name: str, changes: dict[str, str | None], words: str) -> None:
    attributes = {key: value for key, value in {**ADXL345, **changes}.items() if value is not None}
    device(tmp_path, 0, attributes)
    with pytest.raises(SensorError, match=words):
        IioSensor(name, root=str(tmp_path))


def test_two_devices_of_one_name_need_the_folder(tmp_path: Path) -> None:
    device(tmp_path, 0, ADXL345)
    device(tmp_path, 1, ADXL345)
    with pytest.raises(SensorError, match="there 2 times"):
        IioSensor("adxl345", root=str(tmp_path))
    assert IioSensor("iio:device1", root=str(tmp_path)).read(5.0) is not None


def test_no_devices_at_all_and_a_rate_that_is_none(tmp_path: Path) -> None:
    with pytest.raises(SensorError, match="devices: none"):
        IioSensor("adxl345", root=str(tmp_path / "nowhere"))
    with pytest.raises(ConfigError, match="rate"):
        IioSensor("adxl345", rate_hz=0.0)


def test_a_device_that_measures_less_often_than_it_is_read_is_said_to(tmp_path: Path) -> None:
    """A LSM6DS starts at 13 Hz: read a hundred times a second, it looks as if it were stuck."""
    device(tmp_path, 0, {**ADXL345, "sampling_frequency": "13.000000"})
    sensor = IioSensor("adxl345", root=str(tmp_path))
    assert "measures 13 times per second and is read 100 times" in sensor.remark
    assert "rate=13" in sensor.remark
    assert IioSensor("adxl345", root=str(tmp_path), rate_hz=10.0).remark == ""


def test_a_device_in_the_hands_of_another_program_is_said_to_be(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    device(tmp_path, 0, ADXL345)
    sensor, real = IioSensor("adxl345", root=str(tmp_path)), os.open

    def busy(path: str, *rest: int) -> int:
        if "in_accel" in str(path):
            raise OSError(errno.EBUSY, os.strerror(errno.EBUSY), path)
        return real(path, *rest)

    monkeypatch.setattr(os, "open", busy)
    with pytest.raises(SensorError, match="another program has switched the device to its buffer"):
        sensor.read(5.0)


PUBLISHED = [
    (
        {"name": "adis16505-2", "in_accel_scale": "0.000000037", "in_anglvel_scale": "0.000000006"},
        ("-275924", "-30142222", "261265769"),
        (-0.010209188, -1.115262214, 9.666833453),
        ("-3324626", "1336980", "-602983"),
        (-0.019947756, 0.00802188, -0.003617898),
    ),
    (
        {"name": "adis16545-1", "in_accel_scale": "0.000000037", "in_anglvel_scale": "0.000000001"},
        ("1376728", "4487621", "262773792"),
        (0.050938936, 0.166041977, 9.722630304),
        ("-1041702", "-273013", "2745116"),
        (-0.001041702, -0.000273013, 0.002745116),
    ),
    (
        {"name": "adxl382", "in_accel_scale": "0.004903325"},
        ("-1771", "282", "-1523"),
        (-8.683788575, 1.38273765, -7.467763975),
        None,
        None,
    ),
    (
        {"name": "adxl313", "in_accel_scale": "0.009576806"},
        ("2", "-57", "2"),
        (0.0191536, -0.5458779, 0.0191536),
        None,
        None,
    ),
]
"""Files and what they mean, from the kernel's documentation ("Usage examples" in Documentation/iio/adis16475.rst,
adis16480.rst, adxl380.rst and adxl313.rst)."""


@pytest.mark.parametrize(("attributes", "raw", "force", "turning", "rate"), PUBLISHED)
def test_the_examples_in_the_kernels_documentation(
    tmp_path: Path,
    attributes: dict[str, str],
    raw: tuple[str, ...],
    force: tuple[float, ...],
    turning: tuple[str, ...] | None,
    rate: tuple[float, ...] | None,
) -> None:
    files = {f"in_accel_{axis}_raw": text for axis, text in zip("xyz", raw, strict=True)}
    files |= {f"in_anglvel_{axis}_raw": text for axis, text in zip("xyz", turning or (), strict=False)}
    device(tmp_path, 0, {**attributes, **files})
    sample = IioSensor(attributes["name"], root=str(tmp_path)).read(5.0)
    assert sample is not None
    assert sample.specific_force == pytest.approx(force, rel=1e-5)
    assert sample.angular_velocity == (None if rate is None else pytest.approx(rate))
