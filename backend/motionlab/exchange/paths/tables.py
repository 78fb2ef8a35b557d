"""Points in CSV: x and y, or time, x and y."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence

import numpy as np

from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.encodings import lines_of, with_whole_cells
from motionlab.exchange.paths.segments import SEGMENTS_MAX, Drawing, line
from motionlab.trajectories.path import Array

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "in": 25.4e-3}
"""Units of length, m."""

_TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0}
_NAMES = {"x": "x", "y": "y", "t": "time", "time": "time"}
_HEADER = re.compile(r"([a-z]+) ?(?:[\[(/_ ] ?([a-z]+) ?[\])]?)?\Z")
"""Of a cell whose blanks are single: several in a row would take cubic time where none fits."""
_SEPARATOR = re.compile(r'"?sep=.?"?')
_LAP_MAX = 3600.0
_FARTHEST = 1e3


def read_points(text: str, *, unit: str, tolerance: float) -> Drawing:
    """Return the straight segments between the points of a table.

    The delimiter is a semicolon, a tab, a comma or blanks, whichever comes first in this list; with
    a semicolon or tab a comma may be the decimal sign. A header names the columns `x`, `y` and `t`
    or `time`, with a unit if there is one, as in `x [mm]`, `x (mm)`, `x_mm` or `x/mm`; others are
    left out. Without a header two columns are x and y, three time, x and y. Lines that begin
    with # are comments.

    Parameters
    ----------
    text : str
        The table.
    unit : str
        Of lengths that have none in the header, one of `UNITS`.
    tolerance : float
        Half of it is the least distance of two points that are both kept, m.

    Raises
    ------
    ConfigError
        With the line that cannot be read.
    """
    drawing = Drawing()
    values, numbers, timed = _values(text, unit, drawing)
    if timed:
        _take_time(values[:, 2], numbers, drawing)
    drawing.read = f"{len(values)} points"
    _chain(values[:, :2], tolerance / 2.0, drawing)
    return drawing


def read_samples(text: str, *, unit: str, drawing: Drawing) -> tuple[Array, Array, Array]:
    """Return times, x and y of a table with a time column, s and m; formats as `read_points`.

    Raises
    ------
    ConfigError
        With the line that cannot be read, or where the table has no time.
    """
    values, numbers, timed = _values(text, unit, drawing)
    if not timed:
        message = "has no column of time, which a motion over time needs"
        raise ConfigError(FieldError("file", message, range="time, x and y"))
    _check_times(values[:, 2], numbers)
    return values[:, 2], values[:, 0], values[:, 1]


def column_units(names: Sequence[str], unit: str) -> dict[str, tuple[int, float]]:
    """Return the column of each of `time`, `x` and `y` among named ones, and its unit in SI."""
    return _header(list(names), 1, unit, Drawing())


def _values(text: str, unit: str, drawing: Drawing) -> tuple[Array, list[int], bool]:
    """Return rows of x, y and, if there is one, time, in SI; their lines; whether there is time."""
    rows = [
        (number, row)
        for number, row in enumerate(with_whole_cells(lines_of(text)), start=1)
        if row.strip() and not row.lstrip().startswith("#")
    ]
    if len(rows) > 1 and _SEPARATOR.fullmatch(
        rows[0][1].strip()
    ):  # of Excel; the cells show it too
        rows = rows[1:]
    if not rows:
        raise _refused(1, "is the end already; x,y or time,x,y is expected")
    delimiter = next((d for d in (";", "\t", ",") if d in rows[0][1]), None)
    first = _without_last(_cells(rows[0][1], delimiter))
    names = None
    if any(_number(cell, delimiter) is None for cell in first):
        names = _header(first, rows[0][0], unit, drawing)
        rows = rows[1:]
    if names is None:
        if len(first) not in {2, 3}:
            what = "has neither two columns, x and y, nor three, time, x and y, and no header"
            raise _refused(rows[0][0], what, len(first), unit="columns")
        names = {"x": (-2, UNITS[unit]), "y": (-1, UNITS[unit])}
        if len(first) == 3:
            names["time"] = (0, 1.0)
    if len(rows) > SEGMENTS_MAX:
        raise _refused(rows[-1][0], "is one row too many", range=f"{SEGMENTS_MAX} rows")
    values = np.array([_row(row, number, delimiter, len(first), names) for number, row in rows])
    if len(values) < 2:
        raise _refused(rows[0][0] if rows else 1, "two rows of numbers or more are expected")
    return values, [number for number, _ in rows], "time" in names


def _refused(
    number: int, message: str, value: object = None, *, range: str = "", unit: str = ""
) -> ConfigError:
    return ConfigError(FieldError(f"line {number}", message, value, range, unit))


def _cells(row: str, delimiter: str | None) -> list[str]:
    return [cell.strip().strip('"').strip() for cell in row.split(delimiter)]


def _without_last(cells: list[str], count: int = 1) -> list[str]:
    """Return cells without the empty ones after the last separators, at least so many."""
    while len(cells) > count and not cells[-1]:
        cells.pop()
    return cells


def _number(cell: str, delimiter: str | None) -> float | None:
    text = cell.replace(",", ".") if delimiter in {";", "\t"} else cell
    if "_" in text:  # which Python takes
        return None
    try:
        return float(text)
    except ValueError:
        return None


def _header(
    cells: list[str], number: int, unit: str, drawing: Drawing
) -> dict[str, tuple[int, float]]:
    """Return the column of each quantity, and its unit in SI."""
    columns: dict[str, tuple[int, float]] = {}
    left_out = []
    for column, cell in enumerate(cells):
        plain = " ".join(cell.lower().replace("\u00b5", "u").replace("\u03bc", "u").split())
        match = _HEADER.match(plain)
        name = _NAMES.get(match[1]) if match else None
        if match is None or name is None:
            left_out.append(cell)
            continue
        if name in columns:
            raise _refused(number, "names a column that was named before", cell)
        units = _TIMES if name == "time" else UNITS
        unit_text = match[2] or ("s" if name == "time" else unit)
        if unit_text not in units:
            raise _refused(number, "has a unit that is not known", cell, range=", ".join(units))
        columns[name] = column, units[unit_text]
    if "x" not in columns or "y" not in columns:
        shown = ", ".join(cells)
        raise _refused(number, "is neither numbers nor a header that names x and y", shown)
    if left_out:
        drawing.notes.append(f"columns left out: {', '.join(left_out)}"[:200])
    return columns


def _row(
    row: str, number: int, delimiter: str | None, count: int, names: dict[str, tuple[int, float]]
) -> list[float]:
    cells = _without_last(_cells(row, delimiter), count)
    if len(cells) != count:
        raise _refused(number, "has another number of cells", len(cells), range=str(count))
    values = []
    for name in ("x", "y", "time"):
        if name not in names:
            continue
        column, unit = names[name]
        value = _number(cells[column], delimiter)
        if value is None or not math.isfinite(value):
            raise _refused(number, f"{name} is no finite number", cells[column])
        value *= unit
        if name != "time" and abs(value) > _FARTHEST:
            raise _refused(number, f"{name} is out of range", value, range="+-1000", unit="m")
        values.append(value)
    return values


def _check_times(times: Array, numbers: list[int]) -> float:
    """Return how long a table lasts, s."""
    back = np.flatnonzero(np.diff(times) <= 0)
    if back.size:
        k = int(back[0])
        what = f"has a time that is not after that of line {numbers[k]}"
        raise _refused(numbers[k + 1], what, float(times[k + 1]), unit="s")
    lap = float(times[-1] - times[0])
    if lap > _LAP_MAX:
        raise _refused(numbers[-1], "is too late", lap, range=f"<= {_LAP_MAX:g}", unit="s")
    return lap


def _take_time(times: Array, numbers: list[int], drawing: Drawing) -> None:
    lap = _check_times(times, numbers)
    drawing.lap_time = lap
    drawing.notes.append(
        f"of the time column its length is kept, {lap:.6g} s, as the time of one lap; "
        "the speed along the path follows the motion profile"
    )


def _chain(places: Array, near: float, drawing: Drawing) -> None:
    """Join points that are apart by more than `near`; the last one is kept."""
    kept = [places[0]]
    for place in places[1:]:
        away = math.dist(place, kept[-1])
        if away > near:
            kept.append(place)
        else:
            drawing.thinned = max(drawing.thinned, away)
    if len(kept) > 2 and math.dist(kept[-1], places[-1]) > 0:
        kept[-1] = places[-1]
    ends = [(float(x), float(y)) for x, y in kept]
    drawing.segments = [line(a, b) for a, b in itertools.pairwise(ends)]
