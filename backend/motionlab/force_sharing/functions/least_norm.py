"""Each phase gives in proportion to the square of what it can give.

``F_k = abs(f) c_k**2 / sum c_j**2`` with c_k the force of phase k at its current limit.
"""

from __future__ import annotations

from typing import Any

from motionlab.force_sharing.functions.function import (
    OURS,
    TINY,
    Array,
    Demand,
    Share,
    SharingFunction,
)
from motionlab.lanes import Lanes, Mask, compiled, select
from motionlab.lanes.functions import clip
from motionlab.plant.magnetics import AnalyticMap, Phases, current_for, force_fraction, thrust_shape


@compiled
def least_norm(_par: Any, demand: Demand, _tables: Array) -> Phases:
    """Return the shares ``c_k**2 / sum c_j**2``."""
    a, b, c = demand.a.most, demand.b.most, demand.c.most
    squares = a * a + b * b + c * c
    scale = 1.0 / select(squares > TINY, squares, TINY)
    return Phases(a * a * scale, b * b * scale, c * c * scale)


@compiled
def share_in_closed_form(
    force_map: AnalyticMap, current_limit: Lanes, position: Lanes, force: Lanes
) -> Share:
    """Share `force`, N, at the measured `position`, m, among the phases of that direction.

    With ``x_k = max(0, sgn(f) S(theta_k))`` each phase gives ``F_k = abs(f) x_k / sum x_j**2``, so
    that ``sum F_k S_k = f`` exactly until a phase reaches its current limit; there is no
    singular position. The current comes from the closed inverse of F(i).
    """
    shape = thrust_shape(force_map, position)
    forward = force > 0.0
    x_a = _pull(shape.a, forward)
    x_b = _pull(shape.b, forward)
    x_c = _pull(shape.c, forward)
    squares = x_a * x_a + x_b * x_b + x_c * x_c
    scale = abs(force) / (force_map.F_pk * squares)
    most = force_fraction(force_map, current_limit)
    y_a = clip(scale * x_a, 0.0, most)
    y_b = clip(scale * x_b, 0.0, most)
    y_c = clip(scale * x_c, 0.0, most)
    current = Phases(
        current_for(force_map, y_a), current_for(force_map, y_b), current_for(force_map, y_c)
    )
    realised = force_map.F_pk * (y_a * x_a + y_b * x_b + y_c * x_c)
    limited = (scale * x_a > most) | (scale * x_b > most) | (scale * x_c > most)
    return Share(current, select(forward, realised, -realised), limited)


@compiled
def _pull(shape: Lanes, forward: Mask) -> Lanes:
    along = select(forward, shape, -shape)
    return select(along > 0.0, along, 0.0)


FUNCTION = SharingFunction(
    name="least-norm",
    label="least norm",
    description="In proportion to the square of what each phase can give",
    source=OURS,
    shares=least_norm,
    closed=share_in_closed_form,
)
