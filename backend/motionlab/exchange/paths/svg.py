"""Paths and basic shapes of SVG."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterator
from typing import Any
from xml.etree.ElementTree import tostring

from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.paths.segments import (
    SEGMENTS_MAX,
    SHORTEST,
    Arc,
    Bezier,
    Drawing,
    Segment,
    line,
)
from motionlab.exchange.paths.svg_document import Document, magnitude, read_document
from motionlab.trajectories.path import Vector


def read_svg(text: str) -> Drawing:
    """Return the outlines of a document in the order in which they are drawn.

    The origin is that of the user units, y is turned upwards. A user unit is the width by that of
    the view box, or 1/96 inch. Subpaths are joined by straight moves.

    Raises
    ------
    ConfigError
        With the line of what cannot be read.
    """
    document = read_document(text)
    drawing = Drawing(notes=document.notes)
    at: Vector | None = None
    shapes = 0
    for shape in _shapes(document):
        shapes += 1
        for segment in _segments(shape, document.metres):
            start, end = _ends(segment)
            if at is not None and math.dist(at, start) >= SHORTEST:
                drawing.segments.append(line(at, start))
                drawing.moves += 1
            drawing.segments.append(segment)
            at = end
            if len(drawing.segments) > SEGMENTS_MAX:
                message = "has too many segments"
                raise ConfigError(FieldError("file", message, range=f"{SEGMENTS_MAX} segments"))
    if not drawing.segments:
        message = "draws nothing: a path or basic shape is expected"
        raise ConfigError(FieldError(f"line {text.count(chr(10)) + 1}", message))
    drawing.read = f"{shapes} shapes, {len(drawing.segments) - drawing.moves} segments"
    return drawing


def _shapes(document: Document) -> Iterator[Any]:
    import svgelements  # noqa: PLC0415 - 100 ms, for SVG only

    source = io.StringIO(tostring(document.root, encoding="unicode"))
    for element in svgelements.SVG.parse(source, reify=False, ppi=96.0).elements():
        if isinstance(element, svgelements.Shape):
            yield element


def _segments(shape: Any, metres: float) -> Iterator[Segment]:
    """Yield the segments of a shape, m, y upwards."""
    import svgelements  # noqa: PLC0415

    matrix = shape.transform
    a, b, c, d, e, f = matrix.a, matrix.b, matrix.c, matrix.d, matrix.e, matrix.f

    def turned(x: float, y: float) -> Vector:
        vector = metres * (a * x + c * y), -metres * (b * x + d * y)
        if not magnitude(*vector):
            raise ConfigError(FieldError("file", "has a transform that leaves every range"))
        return vector

    def place(point: Any) -> Vector:
        x, y = turned(point.x, point.y)
        return x + metres * e, y - metres * f

    pieces: list[Any] = shape.segments(transformed=False)
    for each in pieces:
        match each:
            case svgelements.Move():
                continue
            case svgelements.Arc() if each.rx and each.ry:
                yield _arc(each, place, turned)
            case svgelements.QuadraticBezier():
                yield Bezier((place(each.start), place(each.control), place(each.end)))
            case svgelements.CubicBezier():
                ends = each.start, each.control1, each.control2, each.end
                a_, b_, c_, d_ = (place(p) for p in ends)
                yield Bezier((a_, b_, c_, d_))
            case _ if each.start is not None and each.end is not None:
                yield line(place(each.start), place(each.end))


def _arc(each: Any, place: Callable[[Any], Vector], turned: Callable[..., Vector]) -> Arc:
    angle = math.atan2(each.prx.y - each.center.y, each.prx.x - each.center.x)
    cos, sin = math.cos(angle), math.sin(angle)
    u = turned(each.rx * cos, each.rx * sin)
    v = turned(-each.ry * sin, each.ry * cos)
    return Arc(place(each.center), u, v, float(each.get_start_t()), float(each.sweep))


def _ends(segment: Segment) -> tuple[Vector, Vector]:
    if isinstance(segment, Bezier):
        return segment.points[0], segment.points[-1]
    first, last = (
        (
            segment.center[0] + segment.u[0] * math.cos(t) + segment.v[0] * math.sin(t),
            segment.center[1] + segment.u[1] * math.cos(t) + segment.v[1] * math.sin(t),
        )
        for t in (segment.start, segment.start + segment.sweep)
    )
    return first, last
