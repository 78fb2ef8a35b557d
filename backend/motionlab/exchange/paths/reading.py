"""A file of another program as a trajectory."""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass, replace
from typing import Literal, assert_never

import numpy as np
from pydantic import ValidationError

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.load import validate_trajectory
from motionlab.config.moves import Dwell
from motionlab.config.samples import Samples
from motionlab.config.trajectory import Sequence
from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.encodings import decoded, lines_of
from motionlab.exchange.paths.fit import Fitted, fit
from motionlab.exchange.paths.gcode import read_gcode
from motionlab.exchange.paths.lettering import read_text
from motionlab.exchange.paths.samples import samples_table
from motionlab.exchange.paths.segments import (
    Bezier,
    Chain,
    Drawing,
    Segment,
    without_short,
)
from motionlab.exchange.paths.svg import read_svg
from motionlab.exchange.paths.tables import read_points, read_samples
from motionlab.trajectories.path import Array, Vector

Format = Literal["csv", "svg", "gcode", "text"]
Unit = Literal["m", "cm", "mm", "um", "nm", "in"]
Placement = Literal["file", "centre", "fit"]

BYTES_MAX = 1_000_000
"""Largest file, bytes."""

SAMPLES_BYTES_MAX = 8_000_000
"""Largest table whose times are kept, bytes."""

SPEED = 0.08
"""Speed where the file has none, m/s."""

ACCELERATION, JERK = 0.8, 20.0
"""Limits of the motion profile of whatever is imported, m/s^2 and m/s^3."""

PARTS_MAX = 100

_REACH = 1.0
_FILL = 0.95
"""Share of the stroke that a fitted path takes."""

_FIRST_GCODE = re.compile(r"^\s*(?:%|\(|;|[/]?N\d+|[GMTFSXYZ]\s*[+-]?[\d.])", re.IGNORECASE)
_ENDINGS: dict[str, Format] = {
    "csv": "csv",
    "txt": "csv",
    "tsv": "csv",
    "svg": "svg",
    **dict.fromkeys(("ngc", "nc", "gcode", "gc", "g", "tap", "cnc"), "gcode"),
}


@dataclass(frozen=True, kw_only=True)
class ReadOptions:
    """What is said of a file; the rest it says itself.

    Attributes
    ----------
    format : str or None
        None to find it out from the name, or the content.
    unit : str
        Of lengths in CSV that name none.
    scale : float
        Factor on all lengths.
    tolerance : float
        Largest distance of the path from the drawing, m.
    placement : str
        ``file`` leaves the path where it is, ``centre`` moves its middle to mid-stroke, ``fit``
        scales it into the stroke as well.
    stroke : tuple of float
        Half of the stroke per axis, m.
    height : float
        Of capital letters of a text, m.
    samples : bool
        Whether a table keeps its times, and becomes a motion of kind `samples`.
    """

    format: Format | None = None
    unit: Unit = "mm"
    scale: float = 1.0
    tolerance: float = 5e-6
    placement: Placement = "file"
    stroke: Vector = (0.085, 0.145)
    height: float = 0.01
    samples: bool = False


@dataclass(frozen=True)
class Reading:
    """What became of a file.

    Attributes
    ----------
    trajectory : DrawnPath, Sequence or Samples
        A path, paths with dwells between them, or samples over time.
    format : str
        Its format.
    read : str
        What the file has, for people.
    segments : int
        Segments of the drawing, connecting moves included.
    moves : int
        Connecting moves between strokes among them.
    points, corners : int
        Of the path.
    deviation : float
        Largest distance of the drawing from the path, m.
    notes : list of str
        What was left out or taken otherwise.
    """

    trajectory: DrawnPath | Sequence | Samples
    format: Format
    read: str
    segments: int
    moves: int
    points: int
    corners: int
    deviation: float
    notes: list[str]


def read_trajectory(content: bytes, options: ReadOptions, *, name: str = "") -> Reading:
    """Return a trajectory from a file of another program.

    Parameters
    ----------
    content : bytes
        Text in any encoding of `encodings.decoded`.
    options : ReadOptions
        What is said of it.
    name : str
        Its file name, whose ending tells the format.

    Raises
    ------
    ConfigError
        With the line that cannot be read and what is expected, or the option that does not fit.
    """
    text, notes = _text(content, SAMPLES_BYTES_MAX if options.samples else BYTES_MAX)
    format = options.format or _format(text, name)
    if options.samples:
        return _sampled(text, format, options, notes)
    drawing = _drawing(text, format, options)
    drawing.notes[:0] = notes
    kept, numbers = without_short(drawing.segments)
    if not kept:
        raise ConfigError(FieldError("file", "has no way between its points", range="> 0 m"))
    dwells = {numbers[k]: seconds for k, seconds in drawing.dwells.items()}
    segments = _placed(kept, options, drawing.notes)
    scale = options.tolerance
    fitted = fit(segments, tolerance=scale - min(drawing.thinned, 0.5 * scale), stops=dwells)
    _refuse_far(fitted)
    timing = _timing(drawing)
    trajectory, fits = _timed(segments, fitted, dwells, timing, options)
    return Reading(
        trajectory=trajectory,
        format=format,
        read=drawing.read,
        segments=len(drawing.segments),
        moves=drawing.moves,
        points=sum(len(each.points) for each in fits),
        corners=sum(len(each.corners) for each in fits),
        deviation=max(each.deviation for each in fits) + drawing.thinned,
        notes=drawing.notes,
    )


def _sampled(text: str, format: Format, options: ReadOptions, notes: list[str]) -> Reading:
    """Return a table with times as the motion that it is, scaled and moved as wanted."""
    if format != "csv":
        message = "keeps times of tables only"
        raise ConfigError(FieldError("samples", message, format, "csv"))
    drawing = Drawing(notes=notes)
    time, x, y = read_samples(text, unit=options.unit, drawing=drawing)
    places = np.column_stack((x, y))
    low, high = places.min(axis=0), places.max(axis=0)
    middle, scale = np.zeros(2), options.scale
    if options.placement != "file":
        middle = 0.5 * (low + high)
        if options.placement == "fit":
            scale = _fitting(options, high - low, drawing.notes)
    places = scale * (places - middle)
    table = samples_table(time, places[:, 0], places[:, 1])
    trajectory = validate_trajectory(table)
    assert isinstance(trajectory, Samples)  # its kind says so
    return Reading(
        trajectory=trajectory,
        format=format,
        read=f"{len(time)} samples over {time[-1] - time[0]:.6g} s, with their times",
        segments=0,
        moves=0,
        points=len(time),
        corners=0,
        deviation=0.0,
        notes=drawing.notes,
    )


def _fitting(options: ReadOptions, ways: Array, notes: list[str]) -> float:
    """Return the factor with which a drawing as wide and high as `ways` fits into the stroke."""
    pairs = zip(options.stroke, ways.tolist(), strict=True)
    scale = min((2.0 * _FILL * half / way for half, way in pairs if way > 0.0), default=1.0)
    notes.append(f"scaled by {scale:.6g} into the stroke")
    return scale


def _text(content: bytes, most: int) -> tuple[str, list[str]]:
    """Return the text of a file, and a note on its encoding."""
    if len(content) > most:
        bounds = {"maximum": float(most)}
        raise ConfigError(
            FieldError("file", "is too large", len(content), unit="bytes", bounds=bounds)
        )
    text, encoding = decoded(content)
    plain = encoding in {"utf-8", "utf-8-sig"}
    return text, [] if plain else [f"read as {encoding.upper()}"]


def _format(text: str, name: str) -> Format:
    ending = name.rpartition(".")[2].lower() if "." in name else ""
    known = _ENDINGS.get(ending)
    if known:
        return known
    if text.lstrip().startswith("<"):
        return "svg"
    first = next((row for row in lines_of(text) if row.strip()), "")
    return "gcode" if _FIRST_GCODE.match(first) else "csv"


def _drawing(text: str, format: Format, options: ReadOptions) -> Drawing:
    match format:
        case "csv":
            near = options.tolerance / options.scale
            return read_points(text, unit=options.unit, tolerance=near)
        case "svg":
            return read_svg(text)
        case "gcode":
            return read_gcode(text)
        case "text":
            return read_text(text, height=options.height)
        case _:
            assert_never(format)


def _placed(segments: list[Segment], options: ReadOptions, notes: list[str]) -> list[Segment]:
    """Return the segments scaled and moved as wanted."""
    scale, middle = options.scale, (0.0, 0.0)
    if options.placement != "file":
        chain = Chain(segments)
        places = chain.at(chain.samples(options.tolerance / options.scale))
        low, high = places.min(axis=0), places.max(axis=0)
        middle = tuple((0.5 * (low + high)).tolist())
        if options.placement == "fit":
            scale = _fitting(options, high - low, notes)
    if scale == 1.0 and middle == (0.0, 0.0):
        return segments
    return [_moved(each, scale, middle) for each in segments]


def _moved(segment: Segment, scale: float, middle: Vector) -> Segment:
    def place(p: Vector) -> Vector:
        return scale * (p[0] - middle[0]), scale * (p[1] - middle[1])

    if isinstance(segment, Bezier):
        return Bezier(tuple(place(p) for p in segment.points))
    u, v = ((scale * a[0], scale * a[1]) for a in (segment.u, segment.v))
    return replace(segment, center=place(segment.center), u=u, v=v)


def _refuse_far(fitted: Fitted) -> None:
    reach = float(np.abs(np.array(fitted.points)).max())
    if not reach <= _REACH:
        message = "puts the path too far from mid-stroke: centre it, fit it, or scale it"
        raise ConfigError(FieldError("placement", message, reach, f"<= {_REACH:g}", "m"))


def _timing(drawing: Drawing) -> dict[str, float | str]:
    if drawing.lap_time is not None:
        return {"law": "jerk_limited", "lap_time": drawing.lap_time}
    speed = drawing.v_max or SPEED
    return {"law": "jerk_limited", "v_max": speed, "a_max": ACCELERATION, "j_max": JERK}


def _timed(
    segments: list[Segment],
    fitted: Fitted,
    dwells: dict[int, float],
    timing: dict[str, float | str],
    options: ReadOptions,
) -> tuple[DrawnPath | Sequence, list[Fitted]]:
    """Return the path, and with dwells at some of its stops only, its parts around them."""
    inner = {k: s for k, s in dwells.items() if 0 < k < len(segments)}
    times = set(dwells.values())
    if not dwells:
        return _path(fitted, timing), [fitted]
    everywhere = {0, len(segments)} <= set(dwells) and len(inner) == _stops(fitted)
    if len(times) == 1 and everywhere:
        return _path(fitted, timing | {"dwell": times.pop()}), [fitted]
    parts: list[DrawnPath | Dwell] = []
    fits = []
    for first, last in itertools.pairwise(sorted({0, *inner, len(segments)})):
        if first in dwells:
            parts.append(Dwell(duration=dwells[first]))
        fits.append(fit(segments[first:last], tolerance=options.tolerance))
        parts.append(_path(fits[-1], timing))
    if len(segments) in dwells:
        parts.append(Dwell(duration=dwells[len(segments)]))
    if len(parts) > PARTS_MAX:
        message = "has more dwells between moves than a sequence can hold"
        raise ConfigError(FieldError("file", message, len(dwells), f"{PARTS_MAX} parts"))
    return Sequence(parts=tuple(parts)), fits


def _stops(fitted: Fitted) -> int:
    """Return the number of stops between the first and the last."""
    return len([k for k in fitted.corners if k > 0])


def _path(fitted: Fitted, timing: dict[str, float | str]) -> DrawnPath:
    try:
        return DrawnPath.model_validate(
            {
                "points": fitted.points,
                "closed": fitted.closed,
                "geometry": "spline",
                "corners": fitted.corners,
                **timing,
            }
        )
    except ValidationError as error:
        problem = error.errors()[0]
        where = ".".join(str(part) for part in problem["loc"])
        message = f"makes no path: {where} {problem['msg']}".rstrip()
        raise ConfigError(FieldError("file", message)) from None
