"""Plots as SVG: exact envelopes, round ticks, units and a legend."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.reports.markup import Markup, element, joined
from motionlab.reports.quantities import digits
from motionlab.reports.units import Scale, scale_for

Values = NDArray[np.floating[Any]]

WIDTH = 720
"""Of every plot, in units of its own; A4 shows it at about 0.26 mm each."""
LEFT, RIGHT = 72, 712
"""Edges of what curves are drawn in."""

_HEIGHT = 150
_HEAD = 20  # of a title, and of each row of a legend below it
_ROW = 15
_FOOT = 34
_LETTER = 6.1  # mean width of one
_SWATCH = 24
_PADDING = 0.06
_MARKERS = 7
_TICKS = {"x": 9, "y": 5}

LOOKS = {
    "reference": "#6b7680",
    "a": "#d55e00",
    "b": "#0072b2",
    "c": "#009e73",
    "d": "#b07d00",
    "e": "#3d93c9",
    "one": "#4b5560",
    "two": "#7b4bb3",
    "phase-a": "#009e73",
    "phase-b": "#c98600",
    "phase-c": "#3d93c9",
}
"""Colour of each look on white."""
DARK_LOOKS = {
    "reference": "#97a3ad",
    "a": "#ff8a4c",
    "b": "#5cb3ec",
    "c": "#3fc49b",
    "d": "#e0b040",
    "e": "#8ecbf0",
    "one": "#a8b3bd",
    "two": "#c3a3f0",
    "phase-a": "#3fc49b",
    "phase-b": "#f0b84a",
    "phase-c": "#8ecbf0",
}
"""The same on a dark ground."""
VARIANT_LOOKS = ("a", "b", "c", "d", "e")

_CIRCLE, _SQUARE = "m-3 0a3 3 0 1 0 6 0a3 3 0 1 0 -6 0", "m-3 -3h6v6h-6z"
_TRIANGLE, _DIAMOND = "m0 -4l3.5 6h-7z", "m0 -4l4 4l-4 4l-4 -4z"
_MARKER = {
    "b": _CIRCLE,
    "c": _SQUARE,
    "d": _TRIANGLE,
    "e": _DIAMOND,
    "two": _CIRCLE,
    "phase-b": _CIRCLE,
    "phase-c": _SQUARE,
}
"""Tells a curve from others without its colour; those left out have none."""


class Source(NamedTuple):
    """A column of a simulated run, and the sample of it at the first of a chart's instants."""

    column: str
    first: int = 0


class Grid(NamedTuple):
    """Instants `start + k * step` of a chart's axis, and how many of them each bin has."""

    start: float
    step: float
    samples: int


@dataclass(frozen=True)
class Curve:
    """Least and largest value of each bin; NaN is a gap.

    Of a chart with a grid, `source` is what the curve shows, less the source `less`, if any.
    """

    label: str
    look: str
    low: Values
    high: Values
    source: Source | None = None
    less: Source | None = None


class Mark(NamedTuple):
    """An instant with the number of its row in the table of events."""

    at: float
    number: str


@dataclass(frozen=True)
class Chart:
    """Curves over a common axis.

    Attributes
    ----------
    title : str
        What they show.
    unit : str
        Of their values, SI.
    x : ndarray, shape (bins,)
        Middle of each bin.
    span : tuple of float
        Ends of the axis.
    x_label, x_unit : str
        What the axis is.
    curves : sequence of Curve
        Those drawn later lie above.
    marks : sequence of Mark
        Vertical lines.
    band : ndarray, shape (bins,), optional
        Half width of a band about zero: a tolerance.
    width : float
        Width of the plot, in its own units.
    grid : Grid, optional
        The instants, of curves with a source.
    """

    title: str
    unit: str
    x: Values
    span: tuple[float, float]
    curves: Sequence[Curve]
    x_label: str = "time"
    x_unit: str = "s"
    marks: Sequence[Mark] = ()
    band: Values | None = None
    width: float = WIDTH
    grid: Grid | None = None


class Axis(NamedTuple):
    """Values to places: ``begin`` and ``end`` are the places of ``low`` and ``high``."""

    low: float
    high: float
    begin: float
    end: float

    def at(self, values: Values) -> Values:
        """Return places."""
        share = (np.asarray(values, dtype=np.float64) - self.low) / (self.high - self.low)
        return self.begin + share * (self.end - self.begin)


def svg(chart: Chart) -> Markup:
    """Return a chart as an SVG element: every curve passes through the extremes of its bins."""
    legend, rows = legend_of([(curve.label, curve.look) for curve in chart.curves], chart.width)
    top = _HEAD + rows * _ROW + 10
    bottom = top + _HEIGHT
    x = Axis(*_widened(*chart.span), LEFT, chart.width - WIDTH + RIGHT)
    low, high = _range(chart)
    scale = scale_for([low, high], chart.unit)
    y = Axis(low, high, bottom, top)
    places = x.at(chart.x)
    drawn = [_curve(curve, places, y, 0.2 * i) for i, curve in enumerate(chart.curves)]
    return framed(
        chart.title,
        [
            legend,
            axes(x, y, (chart.x_label, scale_for(chart.span, chart.x_unit)), scale),
            _band(chart, places, y),
            *drawn,
            *(_mark(mark, x, top, bottom) for mark in chart.marks),
        ],
        width=chart.width,
        height=bottom + _FOOT,
        **_data(chart, x, y, scale),
    )


def _data(chart: Chart, x: Axis, y: Axis, scale: Scale) -> dict[str, object]:
    """Return what a script needs to draw other curves of the same columns."""
    if chart.grid is None:
        return {}
    return {
        "data_grid": " ".join(map(repr, chart.grid)),
        "data_x": ends_of(x),
        "data_y": ends_of(y),
        "data_size": repr(scale.size),
        "data_unit": _pretty(scale.unit),
    }


def ends_of(axis: Axis) -> str:
    """Return the ends of an axis and their places, as a script reads them."""
    return " ".join(map(repr, axis))


def framed(
    title: str,
    inside: Sequence[object],
    *,
    height: float,
    width: float = WIDTH,
    **attributes: object,
) -> Markup:
    """Return an SVG element with a title."""
    return element(
        "svg",
        element("title", title),
        element("text", title, x=0, y=14, class_="title", font_weight=600, fill="#111"),
        *inside,
        viewBox=f"0 0 {width:g} {height:g}",
        role="img",
        font_family="system-ui, sans-serif",
        font_size=11,
        xmlns="http://www.w3.org/2000/svg",
        **attributes,
    )


def legend_of(entries: Sequence[tuple[str, str]], width: float = WIDTH) -> tuple[Markup, int]:
    """Return the legend of labels with looks, in rows below the title, and their number.

    Of a single curve without a label there is none.
    """
    if [label for label, _ in entries] == [""]:
        return Markup(""), 0
    parts, row, at = [], 0, 0.0
    for label, look in entries:
        wide = _SWATCH + 6 + _LETTER * len(label) + 16
        if at + wide > width and at > 0.0:
            row, at = row + 1, 0.0
        middle = _HEAD + 8 + row * _ROW
        parts += [
            _stroked(f"M{at:g} {middle}h{_SWATCH}", look, width=1.6),
            *_markers([(at + _SWATCH / 2, middle)], look),
            element("text", label, x=f"{at + _SWATCH + 6:.1f}", y=middle + 4, fill="#111"),
        ]
        at += wide
    return joined(parts), row + 1 if entries else 0


def axes(x: Axis, y: Axis, along: tuple[str, Scale], scale: Scale) -> Markup:
    """Return grid, ticks, numbers and names of two axes."""
    left, right, bottom, top = x.begin, x.end, y.begin, y.end
    parts: list[Markup] = []
    most = max(2, round(_TICKS["x"] * (right - left) / (RIGHT - LEFT)))
    for value, text in ticks(x.low, x.high, along[1], most):
        at = _round(float(x.at(np.array(value))))
        parts.append(_line(at, top, at, bottom))
        parts.append(_text(text, at, bottom + 14, "middle"))
    levels, of_levels = ticks(y.low, y.high, scale, _TICKS["y"]), []
    for value, text in levels:
        at = _round(float(y.at(np.array(value))))
        unit = f" {_pretty(scale.unit)}".rstrip() if value == levels[-1][0] else ""
        of_levels.append(_line(left, at, right, at, strong=value == 0.0))
        of_levels.append(_text(f"{text}{unit}", left - 6, at + 4, "end", name="y"))
    parts.append(element("g", *of_levels, class_="levels"))
    name = " ".join(part for part in (along[0], along[1].unit) if part)
    parts.append(_text(name, (left + right) / 2, bottom + 28, "middle"))
    return joined(parts)


def ticks(low: float, high: float, scale: Scale, most: int) -> list[tuple[float, str]]:
    """Return the round values within a range, `most` at most, with their text."""
    begin, end = low / scale.size, high / scale.size
    rough = (end - begin) / most
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= rough * (1.0 - 1e-9))
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    first, last = math.ceil(begin / step - 1e-9), math.floor(end / step + 1e-9)
    return [
        (k * step * scale.size, f"{k * step:.{decimals}f}".replace("-", "\u2212"))
        for k in range(first, last + 1)
    ]


def path_of(x: Values, low: Values, high: Values) -> str:
    """Return a path through the least and the largest value of each bin, in places; NaN is a gap.

    Of the two, the one nearer to where the path is comes first.
    """
    return "".join(_steps(x, low, high))


def _steps(x: Values, low: Values, high: Values) -> Iterator[str]:
    pen, before = False, 0.0
    for at, a, b in zip(x.tolist(), low.tolist(), high.tolist(), strict=True):
        if not math.isfinite(a + b):
            pen = False
            continue
        first, second = (b, a) if pen and abs(b - before) < abs(a - before) else (a, b)
        yield f"{'L' if pen else 'M'}{_short(at)} {_short(first)}"
        if _short(first) != _short(second):
            yield f"V{_short(second)}"
        pen, before = True, second


def stroked(path: str, look: str, points: Sequence[tuple[float, float]]) -> Markup:
    """Return a curve with markers at some points."""
    return joined([_stroked(path, look), *_markers(points, look)])


def _curve(curve: Curve, places: Values, y: Axis, shift: float) -> Markup:
    low, high = y.at(curve.low), y.at(curve.high)
    seen = np.flatnonzero(np.isfinite(low + high)) if curve.label else np.empty(0, dtype=int)
    shares = (np.arange(_MARKERS) + 0.1 + shift % 0.9) / _MARKERS
    picked = seen[(shares * len(seen)).astype(int)] if len(seen) else seen
    points = [(float(places[i]), float(low[i] + high[i]) / 2) for i in picked]
    drawn = stroked(path_of(places, low, high), curve.look, points)
    if curve.source is None:
        return drawn
    less = curve.less or Source("")
    return element(
        "g",
        drawn,
        data_column=curve.source.column,
        data_first=curve.source.first,
        data_less=less.column or None,
        data_less_first=less.first or None,
        data_look=curve.look,
    )


def _band(chart: Chart, places: Values, y: Axis) -> Markup | None:
    if chart.band is None or not np.isfinite(chart.band).any() or not np.any(chart.band > 0.0):
        return None
    ends = (y.at(np.clip(band, y.low, y.high)) for band in (chart.band, -chart.band))
    upper, lower = ([f"{_short(a)} {_short(b)}" for a, b in _finite(places, end)] for end in ends)
    return element(
        "path", d=f"M{'L'.join(upper)}L{'L'.join(reversed(lower))}Z", class_="band", fill="#0001"
    )


def _finite(x: Values, y: Values) -> list[tuple[float, float]]:
    return [(float(a), float(b)) for a, b in zip(x, y, strict=True) if math.isfinite(a + b)]


def _mark(mark: Mark, x: Axis, top: float, bottom: float) -> Markup:
    at = _round(float(x.at(np.array(mark.at))))
    line = element(
        "line",
        x1=at,
        y1=top,
        x2=at,
        y2=bottom,
        class_="mark",
        stroke="#666",
        stroke_dasharray="2 3",
    )
    return joined([line, _text(mark.number, at, top - 2, "middle")])


def _markers(points: Sequence[tuple[float, float]], look: str) -> Iterator[Markup]:
    shape = _MARKER.get(look)
    if shape is None or not points:
        return
    path = "".join(f"M{_short(x)} {_short(y)}{shape}" for x, y in points)
    yield element("path", d=path, class_=f"marker {look}", fill="#fff", stroke=LOOKS[look])


def _stroked(path: str, look: str, width: float = 1.2) -> Markup:
    return element(
        "path",
        d=path or "M0 0",
        class_=f"curve {look}",
        fill="none",
        stroke=LOOKS[look],
        stroke_width=width,
        stroke_linejoin="round",
        stroke_dasharray="5 3" if look == "reference" else None,
    )


def _line(x: float, y: float, to_x: float, to_y: float, *, strong: bool = False) -> Markup:
    return element(
        "line",
        x1=x,
        y1=y,
        x2=to_x,
        y2=to_y,
        class_="zero" if strong else "grid",
        stroke="#8a949e" if strong else "#dde2e6",
    )


def _text(text: str, x: float, y: float, anchor: str, name: str | None = None) -> Markup:
    return element(
        "text", text, x=_round(x), y=_round(y), text_anchor=anchor, class_=name, fill="#333"
    )


def _range(chart: Chart) -> tuple[float, float]:
    every = [curve.low for curve in chart.curves] + [curve.high for curve in chart.curves]
    values = np.concatenate(every) if every else np.empty(0)
    finite = values[np.isfinite(values)].astype(np.float64)
    if not finite.size:
        return -1.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    if low > 0.0 and low < 0.5 * high:
        low = 0.0
    if high < 0.0 and high > 0.5 * low:
        high = 0.0
    low, high = _widened(low, high)
    room = _PADDING * (high - low)
    return low - room, high + room


def _widened(low: float, high: float) -> tuple[float, float]:
    """Return ends that are apart."""
    if high - low > 1e-9 * max(abs(low), abs(high)):
        return low, high
    room = abs(low) * 0.1 or 1.0
    return low - room, high + room


def _pretty(unit: str) -> str:
    return unit.replace("^2", "\u00b2").replace("^3", "\u00b3")


def _round(value: float) -> float:
    return round(value, 2)


def _short(value: float) -> str:
    return f"{value:.2f}".rstrip("0").rstrip(".")


def spanned(low: float, high: float, unit: str) -> str:
    """Return both ends of a range in one unit."""
    scale = scale_for([low, high], unit)
    begin, end = digits(low / scale.size, 4), digits(high / scale.size, 4)
    return f"{begin} to {end} {scale.unit}"
