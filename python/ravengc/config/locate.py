"""Where a value stands: from a key path such as ``("link", 2, "mass")`` to the line of the text that holds it.

``tomllib`` gives values without lines, so the text is scanned once more, and only when there is something to complain
about. The scan knows strings, comments and nesting; it never fails, at worst it names the line of the enclosing table.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

__all__ = ["KeyPath", "Place", "TextPlaces", "Where", "line_numbers", "nowhere"]

LONGEST_TEXT = 2**18
"""Longest text that is scanned for lines: many times the longest robot file, and a second's work."""

KeyPath = tuple[str | int, ...]
"""Keys and indices (from 0) from the top of a document to a value."""

Where = Callable[[KeyPath], str]
"""Names the place of a key path as the start of a message, such as ``"arm.toml:12: "``, or ``""`` where unknown."""


def nowhere(path: KeyPath) -> str:  # noqa: ARG001
    """Know no place."""
    return ""


@dataclass(frozen=True, slots=True)
class Place:
    """A value, for messages: how a reader calls it, its key path, and who knows its line. ``str`` starts a message."""

    label: str
    path: KeyPath = ()
    where: Where = nowhere

    def __str__(self) -> str:
        return f"{self.where(self.path)}{self.label}"

    def at(self, *keys: str | int) -> Place:
        """Return the place of a value inside this one, called by its keys: ``limits.lower``, ``com[2]``."""
        name = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in keys).removeprefix(".")
        between = "" if name.startswith("[") else ": "
        return Place(f"{self.label}{between}{name}", (*self.path, *keys), self.where)

    def on_line_of(self, *keys: str | int) -> Place:
        """Return the place called as this one, on the line of a value inside it."""
        return Place(self.label, (*self.path, *keys), self.where)


@dataclass(frozen=True)
class TextPlaces:
    """A :data:`Where` for the TOML document ``text`` read from ``file``."""

    file: str
    text: str

    @cached_property
    def lines(self) -> dict[KeyPath, int]:
        """Line (from 1) of every key path of the document; empty where it is too long or too deep to be walked."""
        if len(self.text) > LONGEST_TEXT:
            return {}
        try:
            return line_numbers(self.text)
        except RecursionError:
            return {}

    def __call__(self, path: KeyPath) -> str:
        """Return ``"file:line: "`` for the longest part of the path that the document has."""
        for length in range(len(path), 0, -1):
            if path[:length] in self.lines:
                return f"{self.file}:{self.lines[path[:length]]}: "
        return f"{self.file}: "


def line_numbers(text: str) -> dict[KeyPath, int]:
    """Return the line (from 1) of every table header, key and array element of a valid TOML document."""
    return _Scan(text).document()


class _Token(NamedTuple):
    kind: str
    text: str
    line: int


_LEXEME = r'''(?xs)
    (?P<skip>    [ \t\r]+ | \#[^\n]* )
  | (?P<newline> \n )
  | (?P<string>  """(?:[^"\\]|\\.|"{1,2}(?!"))*"{3,5} | \'\'\'(?:[^']|'{1,2}(?!'))*'{3,5}
               | "(?:[^"\\\n]|\\.)*" | '[^'\n]*' )
  | (?P<mark>    [\[\]{}=,.] )
  | (?P<bare>    [^\s\[\]{}=,."'\#]+ )
  | (?P<other>   . )'''
_END = _Token("end", "", 0)


def _tokens(text: str) -> Iterator[_Token]:
    line = 1
    for match in re.finditer(_LEXEME, text):
        kind = match.lastgroup or "other"
        if kind != "skip":
            yield _Token(kind, match.group(), line)
        line += match.group().count("\n")


class _Scan:
    """A recursive-descent walk over the tokens that notes where every key path begins."""

    def __init__(self, text: str) -> None:
        self.tokens = _tokens(text)
        self.next = next(self.tokens, _END)
        self.lines: dict[KeyPath, int] = {}
        self.last_index: dict[KeyPath, int] = {}

    def take(self) -> _Token:
        token, self.next = self.next, next(self.tokens, _END)
        return token

    def skip_newlines(self) -> None:
        while self.next.kind == "newline":
            self.take()

    def note(self, path: KeyPath, line: int) -> None:
        self.lines.setdefault(path, line)

    def document(self) -> dict[KeyPath, int]:
        table: KeyPath = ()
        while self.next.kind != "end":
            if self.next.text == "[":
                table = self.header()
            elif self.next.kind in {"bare", "string"}:
                self.assignment(table)
            else:
                self.take()
        return self.lines

    def header(self) -> KeyPath:
        """``[a.b]`` or ``[[a.b]]``; below an array of tables a key means its latest table."""
        line = self.take().line
        is_array = self.next.text == "["
        if is_array:
            self.take()
        path: KeyPath = ()
        keys = self.key()
        for key in keys[:-1]:
            path = self.latest((*path, key))
            self.note(path, line)
        path = (*path, *keys[-1:])
        self.note(path, line)
        if is_array:
            self.last_index[path] = self.last_index.get(path, -1) + 1
        path = self.latest(path)
        self.note(path, line)
        while self.next.kind not in {"newline", "end"}:
            self.take()
        return path

    def latest(self, path: KeyPath) -> KeyPath:
        return (*path, self.last_index[path]) if path in self.last_index else path

    def key(self) -> tuple[str, ...]:
        """``a.b."c d"``."""
        parts = []
        while self.next.kind in {"bare", "string"} or self.next.text == ".":
            token = self.take()
            if token.text != ".":
                parts.append(token.text.strip("\"'") if token.kind == "string" else token.text)
        return tuple(parts)

    def assignment(self, table: KeyPath) -> None:
        """``key = value``."""
        line = self.next.line
        path = table
        for part in self.key():
            path = (*path, part)
            self.note(path, line)
        if self.next.text == "=":
            self.take()
            self.value(path)

    def value(self, path: KeyPath) -> None:
        if self.next.text == "[":
            self.array(path)
        elif self.next.text == "{":
            self.inline_table(path)
        else:
            while self.next.kind not in {"newline", "end"} and self.next.text not in {",", "]", "}"}:
                self.take()

    def array(self, path: KeyPath) -> None:
        self.take()
        index = 0
        while True:
            self.skip_newlines()
            if self.next.kind == "end" or self.take_if("]"):
                return
            if self.take_if(","):
                index += 1
                continue
            self.note((*path, index), self.next.line)
            self.value((*path, index))
            if self.next.text == "}":
                self.take()

    def inline_table(self, path: KeyPath) -> None:
        self.take()
        while self.next.kind != "end" and not self.take_if("}"):
            if self.next.kind in {"bare", "string"}:
                self.assignment(path)
            else:
                self.take()

    def take_if(self, mark: str) -> bool:
        found = self.next.kind == "mark" and self.next.text == mark
        if found:
            self.take()
        return found
