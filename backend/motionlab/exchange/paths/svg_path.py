"""Path data of SVG, written out: absolute commands, without shorthands."""

from __future__ import annotations

import re
from collections.abc import Iterator

NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_NUMBERS = re.compile(NUMBER)
_BETWEEN = re.compile(r"[\s,]*")
_COMMANDS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
_FLAGS = frozenset({3, 4})  # of the arguments of an arc
_SHOWN = 20


class PathError(Exception):
    """Path data that do not follow the grammar: what is wrong, and the text there."""

    def __init__(self, message: str, text: str, allowed: str = "") -> None:
        super().__init__(message)
        self.message, self.text, self.allowed = message, text, allowed


def absolute(text: str, largest: float) -> tuple[str, int]:
    """Return path data with M, L, C, Q, A and Z alone, absolute, and the number of segments.

    Parameters
    ----------
    text : str
        The attribute ``d``.
    largest : float
        Largest number.

    Raises
    ------
    PathError
        If the data do not follow the grammar; by the standard they end there.
    """
    pen, parts, segments = _Pen(), [], 0
    for command, numbers in _commands(text, largest):
        segments += 1
        parts.append(pen.draw(command, numbers))
    return " ".join(parts), segments


def _commands(text: str, largest: float) -> Iterator[tuple[str, list[float]]]:
    """Yield each command with its arguments; those that repeat a letter have it."""
    at, letter = skipped(text, 0), ""
    then = {"M": "L", "m": "l"}  # what a letter repeats as
    while at < len(text):
        if text[at].upper() in _COMMANDS:
            if not letter and text[at] not in "Mm":
                raise PathError("path does not begin with M", text[:_SHOWN])
            letter, at = text[at], skipped(text, at + 1)
        elif letter in {"", "Z", "z"}:
            what = "path has no command where one is expected"
            raise PathError(what, text[at : at + _SHOWN])
        else:
            letter = then[letter] if letter in then else letter
        numbers = []
        for k in range(_COMMANDS[letter.upper()]):
            value, at = _number(text, at, letter.upper(), k)
            if not abs(value) <= largest:
                allowed = f"+-{largest:g}"
                raise PathError("path has a number out of range", repr(value), allowed)
            numbers.append(value)
        yield letter, numbers


def _number(text: str, at: int, command: str, k: int) -> tuple[float, int]:
    """Return an argument of a command, and where the next begins; flags are one digit."""
    if command == "A" and k in _FLAGS:
        if text[at : at + 1] not in {"0", "1"}:
            raise PathError("path has no flag, 0 or 1, in an arc", text[at : at + _SHOWN])
        return float(text[at]), skipped(text, at + 1)
    match = _NUMBERS.match(text, at)
    if match is None:
        what = f"path lacks a number: {command} takes {_COMMANDS[command]}"
        raise PathError(what, text[at : at + _SHOWN])
    return float(match[0]), skipped(text, match.end())


def skipped(text: str, at: int) -> int:
    """Return where the next sign stands after blanks and commas."""
    match = _BETWEEN.match(text, at)
    return match.end() if match else at


class _Pen:
    """Where the pen is, where its subpath began, and the control point that S or T mirrors."""

    def __init__(self) -> None:
        self.x = self.y = 0.0
        self._begin = 0.0, 0.0
        self._control: tuple[str, float, float] | None = None
        self._closed = False

    def draw(self, letter: str, numbers: list[float]) -> str:
        """Return a command written out."""
        command = letter.upper()
        places = self._absolute(letter, numbers)
        control = self._control
        self._control = None
        text = ""
        if self._closed and command != "M":  # a subpath that begins where the one before was closed
            text = f"M{self.x!r} {self.y!r} "
        self._closed = command == "Z"
        match command:
            case "M":
                self._begin = places[-2], places[-1]
            case "Z":
                self.x, self.y = self._begin
                return text + "Z"
            case "S" | "T":
                command = "C" if command == "S" else "Q"
                places = [*self._mirrored(control, command), *places]
            case _:
                command = "L" if command in {"H", "V"} else command
        if command in {"C", "Q"}:
            self._control = command, places[-4], places[-3]
        self.x, self.y = places[-2], places[-1]
        return text + command + " ".join(map(_written, places))

    def _mirrored(self, control: tuple[str, float, float] | None, kind: str) -> tuple[float, float]:
        """Return the control point opposite to that of the curve before, if it is of that kind."""
        if control is None or control[0] != kind:
            return self.x, self.y
        return 2.0 * self.x - control[1], 2.0 * self.y - control[2]

    def _absolute(self, letter: str, numbers: list[float]) -> list[float]:
        dx, dy = (self.x, self.y) if letter.islower() else (0.0, 0.0)
        match letter.upper():
            case "H":
                return [numbers[0] + dx, self.y]
            case "V":
                return [self.x, numbers[0] + dy]
            case "A":
                return [*numbers[:5], numbers[5] + dx, numbers[6] + dy]
        return [value + (dy if k % 2 else dx) for k, value in enumerate(numbers)]


def _written(value: float) -> str:
    return repr(int(value)) if value in {0.0, 1.0} else repr(value)
