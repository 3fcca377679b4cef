"""The vertices of a PLY file: ASCII, or binary of either byte order, with anything else in it left alone."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ravengc.errors import ParseError
from ravengc.messages import did_you_mean, listed, shown

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

__all__ = ["Vertices", "read_ply"]

KINDS = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
LONGEST_HEADER = 65536
MOST_VERTICES = 100_000_000
NAMES = ("x", "y", "z", "nx", "ny", "nz")


class Vertices(NamedTuple):
    """``numbers`` (n, 3 or 6): x y z and, where the file has them, nx ny nz; ``lines`` of an ASCII file (n,)."""

    numbers: NDArray[np.float64]
    lines: NDArray[np.int64] | None
    comments: str


class _Property(NamedTuple):
    name: str
    kind: str
    count_kind: str = ""
    """Of a list: the type of its length."""


class _Element(NamedTuple):
    name: str
    size: int
    properties: list[_Property]

    @property
    def fixed(self) -> bool:
        """Tell whether no property is a list."""
        return not any(entry.count_kind for entry in self.properties)


class _Header(NamedTuple):
    order: str
    elements: list[_Element]
    comments: str
    end: int
    lines: int


def read_ply(data: bytes, path: Path) -> Vertices:
    """Return the vertices in a PLY file's bytes; ParseError for a wrong header, and for fewer vertices than it says."""
    header = _header(data, path)
    vertex = _vertex(header, path)
    names = NAMES if all(any(entry.name == name for entry in vertex.properties) for name in NAMES) else NAMES[:3]
    if header.order:
        numbers = _binary(data, header, vertex, names, path)
        return Vertices(numbers, None, header.comments)
    return _ascii(data, header, vertex, names, path)


def _header(data: bytes, path: Path) -> _Header:
    end, texts = _header_lines(data, path)
    order, comments = None, []
    elements: list[_Element] = []
    for line, text in enumerate(texts[1:], start=2):
        words = text.split()
        match words:
            case [] | ["obj_info", *_]:
                pass
            case ["comment", *_]:
                comments.append(text)
            case ["format", kind, *_] if kind in FORMATS:
                order = FORMATS[kind]
            case ["element", name, count]:
                elements.append(_Element(name, _count(count, path, line), []))
            case ["property", "list", count_kind, kind, name] if elements:
                elements[-1].properties.append(_Property(name, _kind(kind, path, line), _kind(count_kind, path, line)))
            case ["property", kind, name] if elements:
                elements[-1].properties.append(_Property(name, _kind(kind, path, line)))
            case _:
                known = "format, comment, element NAME COUNT, property TYPE NAME"
                raise ParseError(f"{shown(text[:60])} in the header; expected {known}", file=str(path), line=line)
    if order is None:
        raise ParseError(f"no line 'format'; expected one of {listed(FORMATS)}", file=str(path), line=2)
    return _Header(order, elements, "\n".join(comments), end, len(texts) + 1)


def _header_lines(data: bytes, path: Path) -> tuple[int, list[str]]:
    """Where the vertices begin, and the lines before ``end_header``."""
    head = data[:LONGEST_HEADER]
    if not head.startswith((b"ply\n", b"ply\r")):
        raise ParseError("does not begin with 'ply'; expected a PLY file", file=str(path), line=1)
    mark = b"\r" if head.startswith(b"ply\r") and not head.startswith(b"ply\r\n") else b"\n"
    before, found, _ = head.partition(mark + b"end_header")
    after = head.find(mark, len(before) + len(found))
    if not found or after < 0:
        raise ParseError("no line 'end_header' after its header; the file is cut, or none", file=str(path))
    return after + 1, before.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n").split("\n")


def _count(text: str, path: Path, line: int) -> int:
    count = int(text) if text.isdecimal() and text.isascii() and len(text) < 12 else -1
    if not 0 <= count <= MOST_VERTICES:
        message = f"{shown(text[:20])} elements; expected a whole number up to {MOST_VERTICES}"
        raise ParseError(message, file=str(path), line=line)
    return count


def _kind(text: str, path: Path, line: int) -> str:
    if text not in KINDS:
        near = did_you_mean(text, KINDS)
        raise ParseError(f"unknown type {shown(text[:20])} of a property{near}", file=str(path), line=line)
    return KINDS[text]


def _vertex(header: _Header, path: Path) -> _Element:
    names = [element.name for element in header.elements]
    if "vertex" not in names:
        raise ParseError(f"no element 'vertex' (elements: {listed(names) or 'none'})", file=str(path))
    vertex = header.elements[names.index("vertex")]
    properties = [entry.name for entry in vertex.properties]
    if missing := [name for name in "xyz" if name not in properties]:
        raise ParseError(f"a vertex has no {', '.join(missing)} (it has {listed(properties)})", file=str(path))
    if len(set(properties)) < len(properties) or not vertex.fixed:
        raise ParseError("a vertex has a property twice, or a list; expected single numbers", file=str(path))
    if vertex.size == 0:
        raise ParseError("0 vertices", file=str(path))
    return vertex


def _binary(data: bytes, header: _Header, vertex: _Element, names: tuple[str, ...], path: Path) -> NDArray[np.float64]:
    kind = _row_kind(header.order, vertex)
    start = _start(header, path)
    whole = max(0, len(data) - start) // kind.itemsize
    if whole < vertex.size:
        message = (
            f"cut off: {whole} of the {vertex.size} vertices that its header promises ({kind.itemsize} bytes each); "
            "copy the file again, as binary"
        )
        raise ParseError(message, file=str(path))
    rows = np.frombuffer(data, dtype=kind, count=vertex.size, offset=start)
    return np.column_stack([rows[name].astype(np.float64) for name in names])


def _row_kind(order: str, element: _Element) -> np.dtype[np.void]:
    return np.dtype([(entry.name, order + entry.kind) for entry in element.properties])


def _start(header: _Header, path: Path) -> int:
    """Where the vertices begin, behind the elements that stand before them."""
    at = header.end
    for element in header.elements:
        if element.name == "vertex":
            break
        if element.size and not element.fixed:
            message = f"lists of element '{element.name}' stand before the vertices; expected the vertices first"
            raise ParseError(message, file=str(path))
        at += element.size * sum(np.dtype(entry.kind).itemsize for entry in element.properties)
    return at


def _ascii(data: bytes, header: _Header, vertex: _Element, names: tuple[str, ...], path: Path) -> Vertices:
    properties = [entry.name for entry in vertex.properties]
    places = [properties.index(name) for name in names]
    texts = data[header.end :].decode("latin-1").replace("\r\n", "\n").replace("\r", "\n").split("\n")
    numbered = [(i, text) for i, text in enumerate(texts, start=header.lines + 1) if text.strip()]
    before = 0
    for element in header.elements[: header.elements.index(vertex)]:
        before += element.size
    rows = numbered[before : before + vertex.size]
    if len(rows) < vertex.size:
        message = f"cut off: {len(rows)} of the {vertex.size} vertices that its header promises"
        raise ParseError(message, file=str(path), line=header.lines + len(texts))
    lines = np.array([i for i, _ in rows], dtype=np.int64)
    return Vertices(_numbers([text for _, text in rows], lines, len(properties), places, path), lines, header.comments)


def _numbers(
    rows: list[str], lines: NDArray[np.int64], width: int, places: list[int], path: Path
) -> NDArray[np.float64]:
    try:
        table = np.loadtxt(rows, comments=None, ndmin=2)
    except ValueError as error:
        raise _fault(rows, lines, width, path) from error
    if table.shape[1] != width:
        raise _fault(rows, lines, width, path)
    return np.ascontiguousarray(table[:, places])


def _fault(rows: list[str], lines: NDArray[np.int64], width: int, path: Path) -> ParseError:
    """What is wrong with the first line that is no vertex."""
    for text, line in zip(rows, lines.tolist(), strict=True):
        cells = text.split()
        if len(cells) != width:
            message = f"{len(cells)} numbers; expected {width} for a vertex, as the header says"
            return ParseError(message, file=str(path), line=line)
        for column, cell in enumerate(cells, start=1):
            try:
                float(cell)
            except ValueError:
                return ParseError(f"{shown(cell[:40])} is not a number", file=str(path), line=line, column=column)
    return ParseError("the vertices cannot be read", file=str(path))
