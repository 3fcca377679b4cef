"""Set keys of one table in TOML text and leave every other byte as it is: comments, order, line ends, everything.

The text is cut into its top-level statements, which are headers and ``key = value`` lines; only those of the table are
touched. What comes out is read back and compared with what it should be: an edit that would change anything else, or
not take, is refused.
"""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ravengc.config.toml_values import toml_value
from ravengc.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

__all__ = ["set_keys"]

LEXEME = re.compile(
    r'''(?xs)
    (?P<comment> \#[^\n]* )
  | (?P<newline> \n )
  | (?P<string>  """(?:[^"\\]|\\.|"{1,2}(?!"))*"{3,5} | \'\'\'(?:[^']|'{1,2}(?!'))*'{3,5}
               | "(?:[^"\\\n]|\\.)*" | '[^'\n]*' )
  | (?P<open>    [\[{] )
  | (?P<close>   [\]}] )
  | (?P<space>   [ \t\r]+ )
  | (?P<other>   [^\s\[\]{}"'\#]+ )'''
)
HEADER = re.compile(r"\[\s*(?P<quote>[\"']?)(?P<name>[\w-]+)(?P=quote)\s*\]")
ASSIGNMENT = re.compile(r"(?P<quote>[\"']?)(?P<key>[\w-]+)(?P=quote)[ \t]*=[ \t]*")


@dataclass(frozen=True, slots=True)
class _Statement:
    """``text[start:stop]``: a header, or a key with its value, without the space and comment that follow."""

    start: int
    stop: int
    text: str

    @property
    def header(self) -> str | None:
        """The name of the table that begins here ("" for one of another form); None for ``key = value``."""
        if not self.text.startswith("["):
            return None
        match = HEADER.fullmatch(self.text)
        return match["name"] if match else ""


def set_keys(text: str, table: str, values: Mapping[str, Any], *, file: str) -> str:
    """Return the text with these keys of ``[table]`` set: replaced where they stand, else added at the table's end.

    Where there is no such table, it is put at the end of the text. Raises ConfigError for a table that is written in
    another form than ``[table]``, which this does not edit.
    """
    before = tomllib.loads(text)
    edited = _edited(text, table, values)
    expected = before | {table: before.get(table, {}) | dict(values)}
    try:
        done = tomllib.loads(edited)
    except tomllib.TOMLDecodeError:
        done = {}
    if repr(done) != repr(expected):  # unlike the dictionaries, alike where both hold a NaN
        raise ConfigError(
            f"{file}: cannot be edited safely: write its table as [{table}] with one 'key = value' per line"
        )
    return edited


def _edited(text: str, table: str, values: Mapping[str, Any]) -> str:
    end_of_line = "\r\n" if "\r\n" in text else "\n"
    statements = list(_statements(text))
    own = _of_table(statements, table)
    if not own:
        between = "" if not text or text.endswith("\n") else end_of_line
        blank = end_of_line if text.strip() else ""
        return text + between + blank + f"[{table}]{end_of_line}" + _lines(values, end_of_line)
    missing = dict(values)
    for statement in reversed(own[1:]):
        match = ASSIGNMENT.match(statement.text)
        if match and match["key"] in values:
            missing.pop(match["key"])
            start = statement.start + match.end()
            text = text[:start] + toml_value(values[match["key"]]) + text[statement.stop :]
    return _added(text, own[-1] if len(own) == 1 else _last(text, table), missing, end_of_line)


def _last(text: str, table: str) -> _Statement:
    return _of_table(list(_statements(text)), table)[-1]


def _added(text: str, last: _Statement, missing: Mapping[str, Any], end_of_line: str) -> str:
    """New lines below the line on which the table's last statement ends."""
    if not missing:
        return text
    end = text.find("\n", last.stop) + 1
    if not end:
        return text + end_of_line + _lines(missing, end_of_line)
    return text[:end] + _lines(missing, end_of_line) + text[end:]


def _lines(values: Mapping[str, Any], end_of_line: str) -> str:
    return "".join(f"{key} = {toml_value(value)}{end_of_line}" for key, value in values.items())


def _of_table(statements: list[_Statement], table: str) -> list[_Statement]:
    """The header of the table and the statements below it."""
    own: list[_Statement] = []
    for statement in statements:
        if statement.header is not None:
            if own:
                break
            own = [statement] if statement.header == table else []
        elif own:
            own.append(statement)
    return own


def _statements(text: str) -> Iterator[_Statement]:
    """Statements of valid TOML: a line each, but brackets and long strings carry a value over several lines."""
    depth, start, stop = 0, -1, -1
    for token in LEXEME.finditer(text):
        kind = token.lastgroup
        if kind == "newline" and depth == 0 and start >= 0:
            yield _Statement(start, stop, text[start:stop])
            start = -1
        elif kind not in {"newline", "comment", "space"}:
            depth += (kind == "open") - (kind == "close")
            start, stop = (token.start() if start < 0 else start), token.end()
    if start >= 0:
        yield _Statement(start, stop, text[start:stop])
