"""Least copper loss ``sum i_k**2`` for the commanded force.

On the analytic map ``sqrt(x_k)/(1 + B q_k)``, with ``q = (i/I_pk)**2``, is the same for all phases
that carry current; on a table the shares are tabulated.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from motionlab.force_sharing.functions.function import (
    TINY,
    Array,
    Demand,
    SharingFunction,
    Table,
)
from motionlab.force_sharing.tables import SHARE_LEVELS, SHARE_POSITIONS, between, share_cells
from motionlab.lanes import Lanes, compiled, select, square_root
from motionlab.lanes.functions import clip, positive
from motionlab.plant.magnetics import Phases
from motionlab.plant.table_map import cell


@compiled
def force_per_ampere(_par: Any, demand: Demand, tables: Array) -> Phases:
    """Return the shares of least copper loss, by formula or by table."""
    a, b, c = demand.a, demand.b, demand.c
    f = _least_loss(demand)
    sum_f = f.a + f.b + f.c
    per = 1.0 / select(sum_f > TINY, sum_f, TINY)
    whole = a.whole + b.whole + c.whole
    level = clip(demand.magnitude / select(whole > TINY, whole, TINY), 0.0, 1.0) * SHARE_LEVELS
    return Phases(
        select(demand.tabled, _tabled(demand, tables, a.turns, level), f.a * per),
        select(demand.tabled, _tabled(demand, tables, b.turns, level), f.b * per),
        select(demand.tabled, _tabled(demand, tables, c.turns, level), f.c * per),
    )


@compiled
def _least_loss(demand: Demand) -> Phases:
    """Return the forces of least copper loss on the analytic map, up to a common factor.

    With ``F = G (1 - 1/(1 + B q)) x``, ``G = F_pk (1 + B)/B``, the loss sum q is least where
    ``sqrt(x_k)/(1 + B q_k) = 1/w`` for every phase that carries current. At most two phases pull
    the same way: the stronger one alone, or both.
    """
    force_map, a, b, c = demand.formula, demand.a.x, demand.b.x, demand.c.x
    knee = force_map.I_pk * (1.0 / force_map.I_knee)
    asymptote = (1.0 + knee * knee) / (knee * knee)
    y = demand.magnitude / (force_map.F_pk * asymptote)
    r_a, r_b, r_c = square_root(a), square_root(b), square_root(c)
    strongest = select(a > b, a, b)
    strongest = select(c > strongest, c, strongest)
    both = r_a * r_b + r_b * r_c + r_c * r_a > strongest - y
    rest = clip(a + b + c - y, TINY, np.inf)
    inverse_w = rest / (r_a + r_b + r_c)
    return Phases(
        select(both, positive(a - r_a * inverse_w), select(a >= strongest, 1.0, 0.0)),
        select(both, positive(b - r_b * inverse_w), select(b >= strongest, 1.0, 0.0)),
        select(both, positive(c - r_c * inverse_w), select(c >= strongest, 1.0, 0.0)),
    )


@compiled
def _tabled(demand: Demand, tables: Array, turns: Lanes, level: Lanes) -> Lanes:
    """Return the share of a phase by the table, between its nodes."""
    column, u = cell(turns * SHARE_POSITIONS, SHARE_POSITIONS)
    row, w = cell(level, SHARE_LEVELS)
    sheet = select(demand.forward, 0.0, float(SHARE_POSITIONS * SHARE_LEVELS))
    first = select(demand.table > 0.0, demand.table, 0.0)
    return between(tables, first + 4.0 * (sheet + column * SHARE_LEVELS + row), u, w)


FUNCTION = SharingFunction(
    name="force-per-ampere",
    label="force per ampere",
    description="Least copper loss for the force",
    source="maximum force per ampere, the paper's reference [21]",
    shares=force_per_ampere,
    passes_on=True,
    table=Table(
        shape=(2 * SHARE_POSITIONS, SHARE_LEVELS, 4),
        about="share, 1, [sense][position][force][corner]",
        numbers=share_cells,
    ),
)
