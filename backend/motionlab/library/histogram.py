"""How a metric is spread over the runs that a search finds."""

from __future__ import annotations

import dataclasses

import sqlalchemy as sa
from pydantic import BaseModel, Field

from motionlab.library.query import conditions_on
from motionlab.library.search import Search
from motionlab.library.tables import METRICS, RUNS

_PER_DECADE = 8
_FIRST, _LAST = -9, 3  # decades of edges, SI
EDGES = tuple(10.0 ** (k / _PER_DECADE) for k in range(_FIRST * _PER_DECADE, _LAST * _PER_DECADE))
"""Edges of all bins; what is below the first or above the last has bins of its own."""


class RunHistogram(BaseModel):
    """Runs by a metric, in bins of equal ratio."""

    metric: str = Field(description="Full name, such as B.x.max_abs_following_error")
    edges: list[float] = Field(description="Edges of the bins, SI; one more than bins")
    counts: list[int] = Field(description="Runs in each bin, from an edge to below the next")
    total: int = Field(description="Runs with the metric")
    least: float | None = Field(description="Least value, SI; null where no run has it")
    greatest: float | None = Field(description="Greatest value, SI")


def histogram(connection: sa.Connection, search: Search, metric: str) -> RunHistogram:
    """Return the histogram of a metric over what a search finds, its own bounds left out.

    One query, which reads the rows of the metric.
    """
    bounds = tuple(each for each in search.bounds if each.metric != metric)
    search = dataclasses.replace(search, bounds=bounds)
    value = METRICS.c.value
    bins = sa.case(
        *((value < edge, place) for place, edge in enumerate(EDGES)), else_=len(EDGES)
    ).label("bin")
    rows = (
        sa.select(bins, value.label("value"))
        .join(RUNS, RUNS.c.number == METRICS.c.run)
        .where(METRICS.c.metric == metric, *conditions_on(connection, search, METRICS.c.run))
        .subquery()
    )
    query = sa.select(
        rows.c.bin, sa.func.count(), sa.func.min(rows.c.value), sa.func.max(rows.c.value)
    ).group_by(rows.c.bin)
    per_bin = connection.execute(query).all()
    counts = {place: count for place, count, _, _ in per_bin}
    total = sum(counts.values())
    if not counts:
        return RunHistogram(metric=metric, edges=[], counts=[], total=0, least=None, greatest=None)
    # Outermost values lie in the bins at the ends.
    inner = [min(max(place, 1), len(EDGES) - 1) for place in counts]
    first, last = min(inner), max(inner)
    runs = [0] * (last - first + 1)
    for place, count in counts.items():
        runs[min(max(place, first), last) - first] += count
    return RunHistogram(
        metric=metric,
        edges=list(EDGES[first - 1 : last + 1]),
        counts=runs,
        total=total,
        least=min(low for _, _, low, _ in per_bin),
        greatest=max(high for _, _, _, high in per_bin),
    )
