"""URDF text to elements with line numbers, by the standard library's expat, refusing what a robot file never needs.

No document type, no entities, no more than 8 MiB, 64 levels and 100,000 elements; nothing is opened or fetched.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ravengc.config.files import MAX_BYTES
from ravengc.errors import ConfigError, ParseError
from ravengc.messages import shown

__all__ = ["MAX_DEPTH", "MAX_ELEMENTS", "Element", "parse_xml"]

ENCODINGS = ("utf-8", "utf-16", "us-ascii", "ascii", "iso-8859-1", "latin-1", "windows-1252")
MAX_DEPTH = 64
MAX_ELEMENTS = 100_000


@dataclass(slots=True, eq=False)
class Element:
    """An XML element: its attributes, its children in order and the line where it begins; text is not kept."""

    tag: str
    attributes: dict[str, str]
    file: str
    line: int
    children: list[Element] = field(default_factory=list)

    def all(self, tag: str) -> list[Element]:
        """Return the children with this tag, in order."""
        return [child for child in self.children if child.tag == tag]

    def first(self, tag: str) -> Element | None:
        """Return the first child with this tag."""
        return next((child for child in self.children if child.tag == tag), None)

    def get(self, name: str) -> str:
        """Return an attribute that must be there and not be empty."""
        value = self.attributes.get(name, "").strip()
        if not value:
            raise self.error(f"attribute {name!r} is missing")
        return value

    def numbers(self, name: str, default: tuple[float, ...]) -> tuple[float, ...]:
        """Return the numbers of an attribute, as many as there are defaults, which hold where it is not given."""
        if name not in self.attributes:
            return default
        words = self.attributes[name].split()
        values = tuple(map(_finite, words))
        if len(values) != len(default) or None in values:
            count = f"{len(default)} finite numbers" if len(default) > 1 else "a finite number"
            hint = "; this looks like xacro, expand it first" if "${" in self.attributes[name] else ""
            raise self.error(f"{name}: got {shown(self.attributes[name])}, expected {count}{hint}")
        return tuple(value for value in values if value is not None)

    def number(self, name: str, default: float | None = None) -> float:
        """Return the number in an attribute; without default it must be there."""
        if default is None:
            self.get(name)
        return self.numbers(name, (default or 0.0,))[0]

    def error(self, problem: str) -> ConfigError:
        """Return the error that says what is wrong with this element."""
        return ConfigError(f"{self.file}:{self.line}: <{self.tag}>: {problem}")


def parse_xml(data: bytes, file: str) -> Element:
    """Return the root element; ParseError with line and column for anything that is not a plain XML document."""
    return _Reader(file).read(data)


class _Reader:
    """The handlers of one parse and the elements that are open."""

    def __init__(self, file: str) -> None:
        from xml.parsers import expat

        self.file = file
        self.open = [Element("", {}, file, 0)]
        self.count = 0
        self.expat_error, self.error_text = expat.ExpatError, expat.ErrorString
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end
        self.parser.StartDoctypeDeclHandler = self.refuse_doctype
        self.parser.XmlDeclHandler = self.check_encoding

    def read(self, data: bytes) -> Element:
        if len(data) > MAX_BYTES:
            raise ParseError(
                f"larger than {MAX_BYTES // 2**20} MiB, the largest robot file that is read", file=self.file
            )
        try:
            self.parser.Parse(data, True)
        except self.expat_error as error:
            raise ParseError(
                f"not valid XML: {self.error_text(error.code)}",
                file=self.file,
                line=error.lineno,
                column=error.offset + 1,
            ) from error
        return self.open[0].children[0]

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self.count += 1
        if len(self.open) > MAX_DEPTH:
            raise self.complain(f"nested more than {MAX_DEPTH} deep")
        if self.count > MAX_ELEMENTS:
            raise self.complain(f"more than {MAX_ELEMENTS} elements")
        element = Element(tag, attributes, self.file, self.parser.CurrentLineNumber)
        self.open[-1].children.append(element)
        self.open.append(element)

    def end(self, tag: str) -> None:  # noqa: ARG002
        self.open.pop()

    def check_encoding(self, version: str, encoding: str | None, standalone: int) -> None:  # noqa: ARG002
        if encoding is not None and encoding.lower() not in ENCODINGS:
            raise self.complain(f"encoding {shown(encoding)} is not read; save the file as UTF-8")

    def refuse_doctype(self, *_: object) -> None:
        raise self.complain("<!DOCTYPE ...> (and with it <!ENTITY ...>) is refused; a URDF needs neither")

    def complain(self, problem: str) -> ParseError:
        line, column = self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1
        return ParseError(problem, file=self.file, line=line, column=column)


def _finite(word: str) -> float | None:
    try:
        value = float(word) if word.isascii() and "_" not in word else float("nan")
    except ValueError:
        return None
    return value if value - value == 0.0 else None
