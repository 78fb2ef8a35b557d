"""Text in a font of single strokes."""

from __future__ import annotations

import functools
import itertools
import math
from importlib import resources

from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.paths.segments import Bezier, Drawing, line
from motionlab.trajectories.path import Vector
from motionlab.trajectories.spline import cubics

CHARACTERS_MAX = 500
"""Most characters of a text."""

_CAPITAL = 21.0
"""Height of capital letters in units of the font."""

_LINE = 34.0
_BASE = 9.0
_ROUND = math.radians(50.0)
"""Sharpest turn within a round stroke: an o is a polygon of sixteen corners."""

_FIRST = 32

Stroke = tuple[Vector, ...]


def read_text(text: str, *, height: float) -> Drawing:
    """Return a text in Hershey Roman simplex; the baseline of its first line begins at the origin.

    Round strokes are splines through the points of the font, the pen moves straight between
    strokes.

    Parameters
    ----------
    text : str
        Printable ASCII, and line breaks.
    height : float
        Of capital letters, m.

    Raises
    ------
    ConfigError
        With the line of a character that the font does not have.
    """
    if len(text) > CHARACTERS_MAX:
        message = "is too long a text"
        raise ConfigError(
            FieldError("text", message, len(text), f"{CHARACTERS_MAX} characters at most")
        )
    font = _font()
    unit = height / _CAPITAL
    drawing = Drawing()
    at: Vector | None = None
    for number, content in enumerate(text.splitlines()):
        along = 0.0
        for column, character in enumerate(content, start=1):
            code = ord(character) - _FIRST
            if not 0 <= code < len(font) - 1:
                message = f"has a character at column {column} that the font lacks"
                raise ConfigError(
                    FieldError(f"line {number + 1}", message, character, "printable ASCII")
                )
            left, right, strokes = font[code]
            for stroke in strokes:
                points = [
                    (unit * (along + x - left), unit * (_BASE - y - number * _LINE))
                    for x, y in stroke
                ]
                if at is not None:
                    drawing.segments.append(line(at, points[0]))
                    drawing.moves += 1
                drawing.segments += _rounded(points)
                at = points[-1]
            along += right - left
    if not drawing.segments:
        raise ConfigError(FieldError("text", "has nothing to write", range="printable ASCII"))
    drawing.read = f"{len(text)} characters, {drawing.moves + 1} strokes"
    return drawing


def _rounded(points: list[Vector]) -> list[Bezier]:
    """Return a stroke with splines through its points where it turns little."""
    inner = range(1, len(points) - 1)
    corners = [k for k in inner if _turn(*points[k - 1 : k + 2]) > _ROUND]
    closed = points[0] == points[-1] and len(points) > 3
    if closed and _turn(points[-2], points[0], points[1]) > _ROUND:
        corners = [0, *corners]
    control = cubics(points[:-1] if closed else points, closed=closed, corners=corners)
    return [Bezier(tuple((float(x), float(y)) for x, y in edge)) for edge in control]


def _turn(a: Vector, b: Vector, c: Vector) -> float:
    u, w = (b[0] - a[0], b[1] - a[1]), (c[0] - b[0], c[1] - b[1])
    return abs(math.atan2(u[0] * w[1] - u[1] * w[0], u[0] * w[0] + u[1] * w[1]))


@functools.cache
def _font() -> list[tuple[float, float, list[Stroke]]]:
    """Return left edge, right edge and strokes of each glyph, y downwards."""
    data = resources.files("motionlab.exchange.paths").joinpath("rowmans.jhf").read_text("ascii")
    glyphs = []
    for row in data.splitlines():
        pairs = [row[k : k + 2] for k in range(8, len(row) - 1, 2)]
        (left, right), *drawn = ([ord(c) - ord("R") for c in pair] for pair in pairs)
        lifted = itertools.groupby(zip(pairs[1:], drawn, strict=True), lambda each: each[0] == " R")
        strokes = [tuple((x, y) for _, (x, y) in group) for up, group in lifted if not up]
        glyphs.append((left, right, [_distinct(s) for s in strokes if len(_distinct(s)) > 1]))
    return glyphs


def _distinct(stroke: Stroke) -> Stroke:
    return tuple(place for place, _ in itertools.groupby(stroke))
