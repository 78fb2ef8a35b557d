"""Metrics with their definitions, and stability margins, as lines of tables."""

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
from motionlab.loop.margins import Margins
from motionlab.reports.units import Scale, scale_for

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
    """A metric of some variants, in a common scale, and the second over the first of two.

    `key` is its place in the metrics of a variant, such as ``x.rms_force``.
    """

    key: str
    name: str
    definition: Definition
    values: list[float | None]
    scale: Scale
    ratio: float | None


Table = tuple[list[str], list[Line]]
"""Names of variants and their metrics."""


def metrics(columns: Sequence[Column]) -> list[Table]:
    """Return the metrics of variants side by side, some variants a table."""
    blocks = [columns[i : i + _COLUMNS] for i in range(0, len(columns), _COLUMNS)]
    tables = [([column.name for column in block], list(_lines(block))) for block in blocks]
    return [(names, lines) for names, lines in tables if lines]


def definitions(tables: Sequence[Table]) -> list[Definition]:
    """Return the definitions of the metrics in some tables, once each."""
    return list(
        {line.definition.meaning: line.definition for _, ls in tables for line in ls}.values()
    )


def loops(scenario: Scenario) -> Iterator[tuple[str, str | list[float | None]]]:
    """Yield each loop with its margins, or why it has none."""
    for place, speed in (("", SLIDING), (", at rest", 0.0)):
        for name, loop in margins_at(scenario, speed).items():
            label = name.replace(".", " ") + place
            if isinstance(loop, Margins):
                degrees = None if loop.phase_margin is None else math.degrees(loop.phase_margin)
                yield label, [degrees, loop.gain_margin, loop.crossover, loop.Ms, loop.bandwidth]
            elif speed:
                yield label, loop


def _lines(columns: Sequence[Column]) -> Iterator[Line]:
    for key, definition in DEFINITIONS.items():
        for axis in AXES:
            values = [(c.values.get("axes") or {}).get(axis, {}).get(key) for c in columns]
            name = definition.label.replace("$", axis)
            yield from _line(f"{axis}.{key}", name, definition, values, compared=key in RATIOS)
    for key, definition in CONTOUR_DEFINITIONS.items():
        values = [(c.values.get("contour") or {}).get(key) for c in columns]
        yield from _line(f"contour.{key}", definition.label, definition, values, compared=True)


def _line(
    key: str, name: str, definition: Definition, values: list[float | None], *, compared: bool
) -> Iterator[Line]:
    """Yield a line, unless no variant has the metric."""
    present = [value for value in values if value is not None]
    if present:
        both = compared and len(values) == len(present) == 2 and present[0]
        ratio = present[1] / present[0] if both else None
        yield Line(key, name, definition, values, scale_for(present, definition.unit), ratio)
