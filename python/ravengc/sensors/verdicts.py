"""What is wrong with a sensor's stream, in words that say what to do about it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from ravengc import STANDARD_GRAVITY
from ravengc.sensors.decoders.base import SAYS
from ravengc.sensors.units import ACCELERATION_UNITS, NEAR, RATE_UNITS, mistaken_unit

if TYPE_CHECKING:
    from ravengc.sensors.address import Address
    from ravengc.sensors.seen import Watch

__all__ = ["as_data", "complaints", "likely_unit", "size_words", "verdicts"]

RIGHT_SIZE = 0.15
"""How far from gravity a norm may be, relative: as the chain's."""
RIGHT_RATE, SURE = 0.2, 0.05
"""How far the scale of an angular velocity may be from that of a unit, relative, and its standard error."""
RANGES = (2.0, 4.0, 8.0, 0.5, 0.25, 0.125)
NO_BYTES = {
    "serial": "not one byte: is the sensor on, and its TX on our RX?",
    "udp": "no datagram: is this the port it sends to? udp:PORT hears this machine alone, udp:0.0.0.0:PORT others too",
    "file": "no bytes",
    "stdin": "no bytes",
}
TURNS = {"x": "y,z,x", "-x": "z,y,-x", "y": "z,x,y", "-y": "x,z,-y", "-z": "x,-y,-z"}
"""By the sensor's axis that points up: axes that make it z."""
BENIGN = (SAYS, "finished: ")
FEW = 2
"""Frames that are broken because the stream was joined in the middle of one."""


def verdicts(found: Watch) -> list[str]:
    """What is wrong, most telling first; what is right, if nothing is."""
    wrong = complaints(found)
    remark = [found.remark] if found.remark else []
    if not wrong and (not remark or found.remark.startswith(BENIGN)):
        wrong = ["nothing wrong was seen"]
    return [*remark, *wrong]


def complaints(found: Watch) -> list[str]:
    """What is wrong, most telling first, apart from what the sensor or its link has to say; [] if nothing is."""
    return _stream(found) if found.count else [_silence(found)]


def as_data(found: Watch) -> dict[str, Any]:
    """Everything that was seen, and what is wrong with it, as plain data."""
    size = {"median": found.norm, "lowest": found.lowest, "highest": found.highest}
    return {
        "state": found.state,
        "samples": found.count,
        "rate_hz": found.rate_hz,
        "jitter_s": found.jitter_s,
        "norm_m_s2": size if math.isfinite(found.norm) else None,
        "tilt_deg": found.tilt,
        "gyroscope": found.has_gyro,
        "seconds": found.seconds,
        "alarm_count": found.alarms,
        "alarms": [
            {"begin_s": one.begin, "end_s": one.end, "alarms": one.alarms, "explained": one.explained()}
            for one in found.episodes
        ],
        "counters": found.counters,
        "link": found.link,
        "likely_unit": likely_unit(found),
        "verdicts": verdicts(found),
    }


def size_words(norm: float, address: Address | None, likely: str | None) -> str:
    """Why specific force at rest has this norm (m/s²), "" if it has the right one.

    ``likely`` is what the chain takes it for. Where the address has a unit, a wrong one is looked for first.
    """
    ratio = norm / STANDARD_GRAVITY
    if not ratio > 0.0 or abs(ratio - 1.0) <= RIGHT_SIZE:
        return ""
    unit = _declared(address)
    if _takes_unit(address) and (mistake := mistaken_unit(norm, unit)):
        return _unit_words(norm, *mistake)
    if factor := next((factor for factor in RANGES if abs(ratio / factor - 1.0) <= NEAR), None):
        return (
            f"norm {norm:.4g} m/s², {factor:g} times gravity: the sensor is set to another range than its scale is for"
        )
    if likely is not None and ACCELERATION_UNITS.get(unit, 1.0) == 1.0:
        return f"norm {norm:.4g}: looks like {likely}, which cannot be set as unit: convert it where it is sent"
    return f"norm {norm:.4g} m/s², gravity has {STANDARD_GRAVITY:.2f}: another unit or scale"


def likely_unit(found: Watch) -> str | None:
    """The unit that the sensor seems to send, if it is not the one that is declared: one to set, or what it may be."""
    if found.seconds["live"] > 0.0:
        return None
    mistake = mistaken_unit(found.norm, _declared(found.address)) if _takes_unit(found.address) else None
    return mistake[1] if mistake else found.likely_unit


def _declared(address: Address | None) -> str:
    """The unit that the address says, "" where it says none."""
    return "" if address is None else str(address.options.get("unit", ""))


def _takes_unit(address: Address | None) -> bool:
    return address is None or address.takes("unit")


def _unit_words(norm: float, declared: str, sent: str) -> str:
    """The norm as it was sent, and the unit to set."""
    factor = ACCELERATION_UNITS[sent]
    near = [unit for unit, other in ACCELERATION_UNITS.items() if unit != sent and abs(other / factor - 1.0) <= NEAR]
    either = f" (or {near[0]}: the two are 2 % apart)" if near else ""
    shown = declared.replace("^2", "²")
    return f"norm {norm / ACCELERATION_UNITS[declared]:.4g}: looks like {sent}, not {shown}: set unit = {sent}{either}"


def _stream(found: Watch) -> list[str]:
    said = [_size(found), _direction(found), _rates(found), *_times(found), *_frames(found)]
    if count := found.alarms:
        said.append("1 alarm" if count == 1 else f"{count} alarms")
    if found.state != "live":
        said.append(f"at the end the sensor was not live but {found.state}: {found.count} samples had come")
    return [words for words in said if words]


def _size(found: Watch) -> str:
    return "" if found.seconds["live"] > 0.0 else size_words(found.norm, found.address, found.likely_unit)


def _direction(found: Watch) -> str:
    """Where up is, if it is not where it was declared to be."""
    if not {"sign", "axes"} & found.alarm_names:
        return ""
    axis = found.up
    turn = "" if found.address is not None and "axes" in found.address.options else TURNS.get(axis, "")
    how = f"axes={turn} makes it z" if turn else "see axes= and, in the robot file, rotation"
    gravity = found.address is not None and found.address.takes("sends") and axis == "-z"
    also = "; or it sends the gravity vector: sends=gravity" if gravity else ""
    return f"up is along {axis} of the sensor: {how}{also}"


def _rates(found: Watch) -> str:
    """The unit of the angular velocity, if gravity turned as it says in another one than was declared."""
    scale, error = found.turning.scale
    if not {"gyro", "turn", "range"} & found.alarm_names or not error <= SURE * abs(scale):
        return ""
    declared = "rad/s" if found.address is None else str(found.address.options.get("gyro_unit", "rad/s"))
    for unit, factor in RATE_UNITS.items():
        if unit != declared and abs(scale * RATE_UNITS[declared] / factor - 1.0) <= RIGHT_RATE:
            takes = found.address is not None and found.address.takes("gyro_unit")
            how = f"set gyro_unit = {unit}" if takes else f"convert it to {declared} where it is sent"
            turns = f"gravity turns {scale:.3g} times as fast as the gyroscope says"
            return f"{turns}: looks like {unit}, not {declared}: {how}"
    return ""


def _times(found: Watch) -> list[str]:
    said = []
    if abs(found.rate_hz / found.declared_hz - 1.0) > 0.1:
        said.append(f"{found.rate_hz:.4g} samples per second, declared are {found.declared_hz:g}: set rate_hz (--rate)")
    if found.jitter_s * found.rate_hz > 0.5:
        said.append(f"samples come unevenly: {1e3 * found.jitter_s:.1f} ms around {1e3 / found.rate_hz:.1f} ms")
    return said


def _frames(found: Watch) -> list[str]:
    said = []
    bad = sum(found.link.get(name, 0) for name in ("bad_checksum", "bad_content"))
    if bad > max(FEW, found.count // 100):
        said.append(f"{bad} frames with a wrong checksum or content: a bad cable, another baud rate or format")
    if (lost := found.link.get("frames_lost", 0)) > max(FEW, found.count // 100):
        said.append(f"{lost} frames that the sensor counted did not come")
    if foreign := found.link.get("foreign_datagrams", 0):
        said.append(f"{foreign} datagrams of another sender were left out: do two send to this port?")
    return said


def _silence(found: Watch) -> str:
    """Why there was no sample: nothing came, nothing that was understood, or nothing that was asked for."""
    kind = "" if found.address is None else found.address.kind
    received, other = found.link.get("bytes_received", 0), found.link.get("other_frames", 0)
    if other:
        return f"no sample came: {other} good frames, but none with an acceleration; tell the sensor to send it"
    if received:
        rate = " or baud=" if kind == "serial" else ""
        return f"no sample came: {received} bytes, but no frame of this format in them; try another format={rate}"
    reason = NO_BYTES.get(kind, "") if not found.remark else ""
    return f"no sample came: {reason}" if reason else "no sample came"
