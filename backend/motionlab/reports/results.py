"""Metrics with their definitions, and stability margins, as tables."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from motionlab.analysis.metrics import CONTOUR_DEFINITIONS, DEFINITIONS, Definition
from motionlab.analysis.variant_comparison import RATIOS
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.library.gain_sets import margins_at
from motionlab.library.run import RunDetail
from motionlab.loop.linearise import SLIDING
from motionlab.loop.margins import MEANINGS, Margins
from motionlab.reports.markup import Markup, element, joined, right, symbol, table
from motionlab.reports.quantities import digits, number
from motionlab.reports.svg_chart import spanned
from motionlab.reports.units import scale_for

_COLUMNS = 6  # of variants, on a page


class Column(NamedTuple):
    """A column of the table of metrics: its name and the metrics of a variant."""

    name: str
    values: Mapping[str, Any]


def columns_of(run: RunDetail, prefix: str = "") -> list[Column]:
    """Return a column for each variant that has metrics."""
    variants = run.result.get("variants") or {}
    return [Column(f"{prefix}{name}", values) for name, values in variants.items()]


class Line(NamedTuple):
    """A metric of some variants."""

    name: str
    definition: Definition
    values: list[float | None]
    compared: bool


def metrics(columns: Sequence[Column]) -> Markup:
    """Return the metrics of variants side by side, a unit a row, and the definitions of each."""
    blocks = [columns[i : i + _COLUMNS] for i in range(0, len(columns), _COLUMNS)]
    used: dict[str, Definition] = {}
    shown = []
    for block in blocks:
        lines = [line for line in _lines(block) if any(v is not None for v in line.values)]
        used |= {line.definition.meaning: line.definition for line in lines}
        pair = [right(f"{block[1].name} : {block[0].name}")] if len(block) == 2 else []
        head = ["", *(right(column.name) for column in block), "", *pair]
        if lines:
            shown.append(table(head, [_row(line) for line in lines]))
    if not shown:
        return element("p", "None: the run is too short for them, or every variant diverged.")
    terms = [element("li", _term(definition)) for definition in used.values()]
    return joined([*shown, element("h3", "Definitions"), element("ul", *terms)])


def _row(line: Line) -> list[Markup]:
    scale = scale_for([v for v in line.values if v is not None], line.definition.unit)
    cells = [number(value, scale) for value in line.values]
    return [symbol(line.name), *cells, symbol(scale.unit), *_ratio(line)]


def _term(definition: Definition) -> Markup:
    name = definition.label.replace("_$", "").replace(" $", "")
    formula = element("code", definition.formula)
    return joined([symbol(name), ": ", definition.meaning, "; ", formula])


def window_of(run: RunDetail) -> Markup:
    """Return over which part of a run its metrics are."""
    window = run.measured()
    if not window:
        return element("p", "No window to measure.")
    text = f"Over {spanned(*window, 's')}"
    if run.kind in {"live", "drive"}:
        text += ": the latest two periods or ten seconds of the session"
    return element("p", f"{text}.", class_="quiet")


def diverged(run: RunDetail) -> Markup:
    """Return which variants diverged and what is noted of others."""
    parts = []
    for name, values in (run.result.get("variants") or {}).items():
        if divergence := values.get("diverged"):
            text = f"{name} diverged at {digits(divergence['time'], 5)} s: {divergence['channel']}."
            parts.append(element("p", text, class_="warning"))
        parts += [element("p", f"{name}: {note}.") for note in values.get("notes") or ()]
    return joined(parts)


def margins(scenario: Scenario | None, run: RunDetail) -> Markup:
    """Return the stability margins of every loop."""
    if run.kind == "measurement":
        return element("p", "None: the gains of a measured machine are not known.")
    if scenario is None:
        return element("p", "None: its scenario is not valid in this version.")
    rows = []
    for place, speed in (("", SLIDING), (", at rest", 0.0)):
        for name, loop in margins_at(scenario, speed).items():
            label = name.replace(".", " ") + place
            if isinstance(loop, Margins):
                rows.append([label, *_margin_cells(loop)])
            elif speed:
                rows.append([label, element("td", loop, colspan=5)])
    of_scenario = (
        f"Of the open loop L, linearised while it slides at {SLIDING:g} times v_s, and at rest, "
        "where the bristles are springs"
    )
    live = ", with the gains it began with" if run.kind == "live" else ""
    head = ["phase margin \u00b0", "gain margin", "crossover Hz", "M_s", "bandwidth Hz"]
    keys = ("phase_margin", "gain_margin", "crossover", "Ms", "bandwidth")
    terms = [element("li", f"{key.replace('_', ' ')}: {MEANINGS[key]}") for key in keys]
    return joined(
        [
            element("p", symbol(f"{of_scenario}{live}."), class_="quiet"),
            table(["loop", *(right(symbol(cell)) for cell in head)], rows),
            element("ul", *terms),
        ]
    )


def _margin_cells(loop: Margins) -> Iterator[Markup]:
    degrees = None if loop.phase_margin is None else math.degrees(loop.phase_margin)
    for value in (degrees, loop.gain_margin, loop.crossover, loop.Ms, loop.bandwidth):
        exact = "\u2013" if value is None else element("data", digits(value), value=repr(value))
        yield element("td", exact, class_="number")


def _lines(columns: Sequence[Column]) -> Iterator[Line]:
    for key, definition in DEFINITIONS.items():
        for axis in AXES:
            values = [(c.values.get("axes") or {}).get(axis, {}).get(key) for c in columns]
            name = definition.label.replace("$", axis)
            yield Line(name, definition, values, key in RATIOS)
    for key, definition in CONTOUR_DEFINITIONS.items():
        values = [(c.values.get("contour") or {}).get(key) for c in columns]
        yield Line(definition.label, definition, values, compared=True)


def _ratio(line: Line) -> list[Markup]:
    """Return the second of two values as a multiple of the first."""
    if len(line.values) != 2:
        return []
    first, second = line.values
    if not line.compared or not first or second is None:
        return [element("td")]
    return [element("td", digits(second / first), class_="number")]
