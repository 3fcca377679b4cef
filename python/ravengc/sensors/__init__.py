"""Base sensors: accelerometers and inertial units over serial ports, UDP, Linux IIO; recorded and simulated ones.

>>> from ravengc.sensors import SensorReader, parse_address
>>> reader = SensorReader(parse_address("serial:/dev/ttyUSB0?format=line").prepare(), deliver=print)

Every sensor gives :class:`Sample`: specific force in m/s^2 in the sensor's axes, +9.81 along up at rest.
"""

from __future__ import annotations

from ravengc.sensors.address import Address, open_sensor, parse_address
from ravengc.sensors.decoders import FORMATS
from ravengc.sensors.kinds import KINDS
from ravengc.sensors.live import LiveSensor
from ravengc.sensors.reader import ReaderEvent, SensorReader
from ravengc.sensors.sample import Sample, Sensor, Statistics

__all__ = [
    "FORMATS",
    "KINDS",
    "Address",
    "LiveSensor",
    "ReaderEvent",
    "Sample",
    "Sensor",
    "SensorReader",
    "Statistics",
    "open_sensor",
    "parse_address",
]
