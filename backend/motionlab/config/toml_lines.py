"""Lines of a TOML file, for errors that say where in it a field stands."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from motionlab.config.bounds import FILE_MAX, TOKEN
from motionlab.errors import FieldError

_TOKEN = re.compile(TOKEN.pattern + r"""|[^\s\[\]{}.,="'\#]+""", re.DOTALL)
_NOWHERE = 1 << 30  # line of what the file does not hold, behind all others


def add_places(
    errors: Sequence[FieldError], path: Path, elsewhere: Iterable[str]
) -> Sequence[FieldError]:
    """Return the errors of a scenario's file with its name and their lines, in its order.

    Values of the dotted paths `elsewhere`, such as those of ``--set``, are not the file's.
    """
    try:
        lines = lines_of(path.read_bytes()[:FILE_MAX].decode("utf-8-sig"))
    except (OSError, ValueError):
        return errors  # which say so
    results = []
    for error in errors:
        place, line = "", _NOWHERE
        outside = error.loc == str(path) or any(
            _inside(error.loc, each.removesuffix(".base")) for each in elsewhere
        )
        if not outside:
            line = _line("base" if error.loc == "scenario" else error.loc, lines)
            place = str(path) if line == _NOWHERE else f"{path}:{line}"
        results.append((line, replace(error, place=place)))
    return [error for _, error in sorted(results, key=lambda each: each[0])]


def _inside(loc: str, path: str) -> bool:
    return loc == path or loc.startswith(f"{path}.")


def _line(loc: str, lines: dict[str, int]) -> int:
    """Return the line of a field, or of the innermost table about it that the file holds."""
    if f"{loc}.base" in lines:
        return lines[f"{loc}.base"]
    while loc:
        if loc in lines:
            return lines[loc]
        loc = loc.rpartition(".")[0]
    return _NOWHERE


def lines_of(text: str) -> dict[str, int]:
    """Return the line of each table, key and item of a valid TOML text by its dotted path."""
    reader = _Reader()
    for match in _TOKEN.finditer(f"{text}\n"):
        reader.take(match[0])
    return reader.lines


class _Reader:
    """Follows the tokens of a TOML text."""

    def __init__(self) -> None:
        self.lines: dict[str, int] = {}  # by dotted path
        self._line = 1
        self._read = self._key
        self._keys: list[str] = []
        self._key_line = 1
        self._double = False  # [[header]]
        self._last: dict[str, int] = {}  # index of the last table of each array of tables
        self._table: tuple[str, ...] = ()  # of the last header
        self._path: tuple[str, ...] = ()  # of the value
        self._open: list[tuple[str, tuple[str, ...], int]] = []  # bracket, its path, item

    def take(self, token: str) -> None:
        """Take the next token."""
        if not token.startswith("#"):
            self._read(token)
        self._line += token.count("\n")

    def _key(self, token: str) -> None:
        """Read a key of a table up to its equals sign, or the begin of a header."""
        if token == "[" and not self._open:
            self._read, self._double = self._header, False
        elif token == "=":
            table = self._open[-1][1] if self._open else self._table
            self._path = table + tuple(self._keys)
            self._note(self._path, self._key_line)
            self._read, self._keys = self._value, []
        elif token == "}" and self._open:  # an empty table
            self._path = self._open.pop()[1]
            self._read = self._value
        elif token not in "\n.,":
            self._key_line = self._key_line if self._keys else self._line
            self._keys.append(_plain(token))

    def _header(self, token: str) -> None:
        if token == "\n":
            self._table = self._indexed()
            self._note(self._table, self._line)
            self._read, self._keys = self._key, []
        elif token == "[":
            self._double = True
        elif token not in "].":
            self._keys.append(_plain(token))

    def _value(self, token: str) -> None:
        bracket, whole, index = self._open[-1] if self._open else ("", (), 0)
        if bracket == "[" and token not in "\n,]":
            self.lines.setdefault(".".join(self._path), self._line)
        if token == "[":
            self._open.append(("[", self._path, 0))
            self._path = (*self._path, "0")
        elif token == "{":
            self._open.append(("{", self._path, 0))
            self._read = self._key
        elif token in "]}" and self._open:
            self._path = self._open.pop()[1]
        elif token == "," and bracket == "[":
            self._open[-1] = ("[", whole, index + 1)
            self._path = (*whole, str(index + 1))
        elif token == ("," if bracket else "\n"):
            self._read = self._key

    def _note(self, path: tuple[str, ...], line: int) -> None:
        """Record the line of a path, and of each enclosing table without one."""
        for end in range(len(path), 0, -1):
            self.lines.setdefault(".".join(path[:end]), line)

    def _indexed(self) -> tuple[str, ...]:
        """Return the path of the header, with the index of each array of tables in it."""
        path: tuple[str, ...] = ()
        for depth, key in enumerate(self._keys, 1):
            path = (*path, key)
            joined = ".".join(path)
            if self._double and depth == len(self._keys):
                self._last[joined] = self._last.get(joined, -1) + 1
            if joined in self._last:
                path = (*path, str(self._last[joined]))
        return path


def _plain(token: str) -> str:
    """Return a key without its quotes."""
    if token[0] not in "\"'":
        return token
    try:
        return str(tomllib.loads(f"key = {token}")["key"])
    except ValueError:
        return token
