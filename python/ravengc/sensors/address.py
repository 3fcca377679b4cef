"""Which sensor, in one line of text: ``KIND:ADDRESS[?key=value&key=value...]``.

``serial:/dev/ttyUSB0?format=line&baud=115200``, ``udp:14550?format=mavlink``, ``replay:example:xio``,
``sim:rocking:10:20:1?noise=0.03``, ``iio:adxl345?rate=100``. A percent sign and two hexadecimal digits stand for a
character that would end a value. Keys and values are checked when the text is read, before anything is opened.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote

from ravengc._convert import check_type
from ravengc.errors import ConfigError
from ravengc.messages import did_you_mean, listed, shown
from ravengc.sensors.kinds import KINDS

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from ravengc.sensors.options import Reader
    from ravengc.sensors.sample import Sensor

__all__ = ["Address", "open_sensor", "parse_address"]

LONGEST = 4096
FORM = "write KIND:ADDRESS?key=value&key=value, such as serial:/dev/ttyUSB0?format=line"
PATHS = {"/dev/": "serial:", ".csv": "replay:", ".csv.gz": "replay:", ".bin": "file:"}
"""What a text without a kind may be: by its beginning or end."""


@dataclass(frozen=True, slots=True)
class Address:
    """A sensor that can be opened: its kind, what stands behind the colon, and its keys' values."""

    text: str
    kind: str
    place: str
    options: Mapping[str, Any]

    def takes(self, key: str) -> bool:
        """Whether the address may have this key."""
        return key in _keys(self.kind, self.options.get("format"))

    @property
    def is_recording(self) -> bool:
        """Whether it can be read to its end at once: a recording that is told neither to keep a pace nor to repeat."""
        return KINDS[self.kind].is_recorded(self.place) and not {"speed", "repeat"} & set(self.options)

    def with_defaults(self, **values: Any) -> Address:
        """The same sensor, with these values for the keys that it takes and does not give."""
        names = KINDS[self.kind].defaults_as
        added = {key: value for key, value in values.items() if self.takes(key) and key not in self.options}
        renamed = {names.get(key, key): value for key, value in added.items()}
        return Address(self.text, self.kind, self.place, {**renamed, **self.options})

    def prepare(self) -> Callable[[], Sensor]:
        """A function that opens the sensor, as often as it is called.

        Here is what needs to be done once: a recording is read, a missing package found out. Raises ConfigError,
        ParseError, MissingExtraError. The function raises SensorError if the sensor cannot be opened.
        """
        return KINDS[self.kind].prepare(self.place, dict(self.options))

    def open(self) -> Sensor:
        """Open the sensor now; the errors are those of ``prepare`` and of what it returns."""
        return self.prepare()()


def open_sensor(text: str, **defaults: Any) -> Sensor:
    """Open the sensor that an address names; ``defaults`` are values for keys that it takes and does not give.

    Raises ConfigError for an address that cannot be followed, SensorError if the sensor cannot be opened.
    """
    return parse_address(text).with_defaults(**defaults).open()


def parse_address(text: str) -> Address:
    """Read an address. Raises ConfigError that names the kind, key or value that is wrong, and the near one."""
    check_type(text, str, "sensor")
    if len(text) > LONGEST or not text.isprintable():
        raise ConfigError(f"sensor {shown(text)}: too long, or with characters that cannot be printed; {FORM}")
    front, _, query = text.partition("?")
    kind, colon, place = front.partition(":")
    if kind not in KINDS:
        what = f": unknown kind {shown(kind)}" if colon and not _likely(front) else " has no kind"
        near = _likely(front) or did_you_mean(kind, KINDS)
        raise ConfigError(f"sensor {shown(text)}{what}{near} (known: {listed(KINDS)}); {FORM}")
    pairs = _pairs(query, text)
    readers = _keys(kind, _format(kind, pairs, text))
    options = {key: _value(key, value, kind, readers, text) for key, value in pairs.items()}
    _check_place(kind, unquote(place), text)
    return Address(text, kind, unquote(place), options)


def _likely(path: str) -> str:
    """What a path that stands there without a kind may have meant; a drive's letter looks like a kind."""
    guess = next((kind for mark, kind in PATHS.items() if path.startswith(mark) or path.lower().endswith(mark)), "")
    return f"; did you mean {guess + path!r}?" if guess else ""


def _pairs(query: str, text: str) -> dict[str, str]:
    pairs: dict[str, str] = {}
    for part in query.split("&") if query else ():
        key, equals, value = part.partition("=")
        if not (key and equals):
            raise ConfigError(f"sensor {shown(text)}: {shown(part)} is no key=value; {FORM}")
        if key in pairs:
            raise ConfigError(f"sensor {shown(text)}: key {key!r} stands there twice")
        pairs[key] = unquote(value)
    return pairs


def _format(kind: str, pairs: Mapping[str, str], text: str) -> str | None:
    """The format of a kind that has formats, checked."""
    reader = KINDS[kind].keys.get("format")
    return _value("format", pairs["format"], kind, {"format": reader}, text) if reader and "format" in pairs else None


def _keys(kind: str, form: str | None) -> Mapping[str, Reader]:
    """The keys that an address of this kind and format may have, and how to read their values."""
    found = KINDS[kind]
    return {**found.keys, **found.format_keys(form)}


def _value(key: str, value: str, kind: str, readers: Mapping[str, Any], text: str) -> Any:
    if key not in readers:
        near, form = did_you_mean(key, readers), KINDS[kind].owner(key)
        other = f"; it belongs to format={form}" if form else ""
        raise ConfigError(f"sensor {shown(text)}: unknown key {shown(key)}{near}{other} (known: {listed(readers)})")
    try:
        return readers[key](value)
    except ConfigError as error:
        raise ConfigError(f"sensor {shown(text)}: key {key!r}: {error}") from None


def _check_place(kind: str, place: str, text: str) -> None:
    try:
        KINDS[kind].check(place)
    except ConfigError as error:
        raise ConfigError(f"sensor {shown(text)}: {error}") from None
