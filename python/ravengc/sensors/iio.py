"""Accelerometers that Linux drives itself (ADXL345, ADXL355, LSM6DS, BMI160 ...), through the files of sysfs.

value = mount_matrix * (raw + offset) * scale, in m/s^2 and rad/s (Linux, Documentation/ABI/testing/sysfs-bus-iio). It
is specific force: a device that lies flat reads +g along z (Documentation/devicetree/bindings/iio/mount-matrix.txt).
Axes: those of the mount matrix, else the chip's. The axes are read one after the other, so they are some tenths of a
millisecond apart; the stamp is the middle. The sensor's own data rate is left as it is: set sampling_frequency.
"""

from __future__ import annotations

import errno
import math
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ravengc._convert import as_number
from ravengc.errors import ConfigError, SensorError
from ravengc.messages import did_you_mean, listed, shown
from ravengc.sensors.pacing import wait_until
from ravengc.sensors.sample import Sample, Statistics

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ravengc.sensors.sample import Triple

__all__ = ["ROOT", "IioSensor", "check_rate"]

ROOT = "/sys/bus/iio/devices"
FASTEST_HZ = 10_000.0
LONGEST_VALUE = 256
MOST_FAILURES = 20
"""So many readings may fail in a row (a bus that times out) before the device counts as gone."""
PASSING = (errno.EIO, errno.ETIMEDOUT, errno.EAGAIN, errno.EREMOTEIO, errno.EINTR)
TOLERANCE = 0.02
"""Kernel descriptions round their matrices to two or three decimals."""


class Channel(NamedTuple):
    """One quantity: three files, and per axis an offset and a scale."""

    files: tuple[str, ...]
    offset: tuple[float, ...]
    scale: tuple[float, ...]
    mount: NDArray[np.float64]

    def read(self) -> Triple:
        """The vector, SI; OSError or ValueError if it cannot be read."""
        raw = [float(_text(file)) for file in self.files]
        values = ((x + offset) * scale for x, offset, scale in zip(raw, self.offset, self.scale, strict=True))
        x, y, z = (self.mount @ np.fromiter(values, float)).tolist()
        return (x, y, z)


class IioSensor:
    """Reads device ``device`` (its name, such as ``adxl345``, its folder ``iio:device0`` or its number) at ``rate_hz``.

    ``gyro`` names a second device where the gyroscope is one of its own; else the device's own is read if it has one.
    ``mount`` false leaves the mount matrix out. ``root`` is the folder of the devices. Raises SensorError if there is
    no such device or it lacks what is needed.
    """

    def __init__(
        self, device: str, *, rate_hz: float = 100.0, gyro: str = "", mount: bool = True, root: str = ROOT
    ) -> None:
        check_rate(rate_hz)
        folder = _find(device, root)
        self.name = f"iio:{folder.name}"
        self.statistics = Statistics()
        self.remark = _own_rate(folder, rate_hz)
        self.finished = False
        matrix = _mount(folder, "accel") if mount else None
        matrix = np.eye(3) if matrix is None else matrix
        self._force = _channel(folder, "accel", matrix)
        second = _find(gyro, root) if gyro else folder
        self._rate = _rate_channel(second, matrix, required=bool(gyro), mounted=mount)
        self._period_ns = round(1e9 / rate_hz)
        self._due_ns = time.monotonic_ns()
        self._seq = 0
        self._failures = 0

    def read(self, timeout_s: float) -> Sample | None:
        """Wait for the next reading that is due. A bus error is counted; SensorError if the device is gone."""
        if not wait_until(self._due_ns, timeout_s):
            return None
        self._due_ns = max(self._due_ns + self._period_ns, time.monotonic_ns())
        try:
            sample = self._sample()
        except ValueError as error:
            self._fail(f"a value that is no number: {error}", OSError(errno.EIO, str(error)))
            return None
        except OSError as error:
            self._fail(error.strerror or str(error), error)
            return None
        self._failures = 0
        return sample

    def close(self) -> None:
        """Nothing is held open between readings."""

    def _sample(self) -> Sample:
        before = time.monotonic_ns()
        force = self._force.read()
        stamp = (before + time.monotonic_ns()) // 2
        rate = None if self._rate is None else self._rate.read()
        self._seq += 1
        self.statistics.samples += 1
        return Sample(self._seq - 1, stamp, force, rate)

    def _fail(self, reason: str, error: OSError) -> None:
        self._failures += 1
        self.statistics.bad_content += 1
        if error.errno == errno.EBUSY:
            reason = "busy: another program has switched the device to its buffer (buffer/enable)"
        self.remark = f"reading failed: {reason}"
        if error.errno not in PASSING or self._failures >= MOST_FAILURES:
            raise SensorError(f"{self.name}: lost: {reason}") from error


def check_rate(rate_hz: float) -> None:
    """ConfigError for a rate that nobody can read at."""
    if not 0.0 < as_number(rate_hz, "rate") <= FASTEST_HZ:
        raise ConfigError(f"rate {rate_hz:g} Hz: expected a positive number of at most {FASTEST_HZ:g}")


def _own_rate(folder: Path, rate_hz: float) -> str:
    """What to say of a device that measures less often than it is read: it gives each value again and again."""
    text = _attribute(folder, "in_accel_sampling_frequency", "sampling_frequency")
    try:
        own = float(text or "nan")
    except ValueError:
        return ""
    advice = f"write a rate to {folder.name}/sampling_frequency or read it at rate={own:g}"
    return f"it measures {own:g} times per second and is read {rate_hz:g} times: {advice}" if own < rate_hz else ""


def _text(path: str) -> str:
    """The text of a sysfs attribute, read anew."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    try:
        return os.read(descriptor, LONGEST_VALUE).decode("ascii", "replace")
    finally:
        os.close(descriptor)


def _find(device: str, root: str) -> Path:
    """The folder of a device, by name, folder or number."""
    folders = _folders(root)
    wanted = f"iio:device{device}" if device.isdecimal() else device
    found = [folder for folder, name in folders.items() if wanted in (name, folder.name)]
    if len(found) == 1:
        return found[0]
    there = listed(f"{folder.name} ({name})" for folder, name in folders.items()) or "none"
    if found:
        raise SensorError(f"IIO device {shown(device)} is there {len(found)} times; give the folder: {there}")
    near = did_you_mean(device, [*folders.values(), *(folder.name for folder in folders)])
    raise SensorError(f"no IIO device {shown(device)} in {root}{near} (devices: {there})")


def _folders(root: str) -> dict[Path, str]:
    try:
        folders = sorted(Path(root).glob("iio:device*"))
        return {folder: _attribute(folder, "name") or "" for folder in folders}
    except (OSError, ValueError) as error:
        raise SensorError(f"IIO devices in {shown(root)} cannot be listed: {error}") from error


def _attribute(folder: Path, *names: str) -> str | None:
    """The text of the first of these attributes that is there."""
    for name in names:
        try:
            return _text(str(folder / name)).strip()
        except FileNotFoundError:
            continue
        except OSError as error:
            raise SensorError(f"{folder / name}: {error.strerror or error}") from error
    return None


def _channel(folder: Path, kind: str, mount: NDArray[np.float64]) -> Channel:
    axes = [f"in_{kind}_{axis}" for axis in "xyz"]
    files = tuple(str(folder / f"{axis}_raw") for axis in axes)
    if missing := [Path(file).name for file in files if not Path(file).exists()]:
        raise SensorError(f"IIO device {folder.name} has no {listed(missing)} in {folder}")
    scale = tuple(_number(folder, f"{axis}_scale", f"in_{kind}_scale") for axis in axes)
    if 0.0 in scale:
        raise SensorError(f"IIO device {folder.name}: in_{kind}_scale is 0: the driver does not know the chip's range")
    offset = tuple(_number(folder, f"{axis}_offset", f"in_{kind}_offset", default="0") for axis in axes)
    return Channel(files, offset, scale, mount)


def _rate_channel(folder: Path, mount: NDArray[np.float64], *, required: bool, mounted: bool) -> Channel | None:
    """The gyroscope; a chip whose two devices share one matrix has it in the accelerometer's folder alone."""
    if not required and not (folder / "in_anglvel_x_raw").exists():
        return None
    own = _mount(folder, "anglvel") if mounted else None
    return _channel(folder, "anglvel", mount if own is None else own)


def _number(folder: Path, *names: str, default: str | None = None) -> float:
    text = _attribute(folder, *names)
    text = default if text is None else text
    try:
        number = float(text or "")
    except ValueError:
        number = math.nan
    if math.isfinite(number):
        return number
    found = "missing" if text is None else f"{shown(text)}, no number"
    raise SensorError(f"IIO device {folder.name}: {names[-1]} is {found}")


def _mount(folder: Path, kind: str) -> NDArray[np.float64] | None:
    """The rotation from the chip's axes to the device's, as rows; None if there is none."""
    text = _attribute(folder, f"in_{kind}_mount_matrix", "in_mount_matrix", "mount_matrix")
    if not text:
        return None
    try:
        matrix = np.array([[float(entry) for entry in row.split(",")] for row in text.split(";")])
        is_rotation = np.abs(matrix @ matrix.T - np.eye(3)).max() <= TOLERANCE and np.linalg.det(matrix) > 0.0
    except ValueError:
        is_rotation = False
    if not is_rotation:
        expected = "expected three rows of a rotation, such as 1, 0, 0; 0, 1, 0; 0, 0, 1 (mount=no leaves it out)"
        raise SensorError(f"IIO device {folder.name}: mount matrix {shown(text)}: {expected}")
    return matrix
