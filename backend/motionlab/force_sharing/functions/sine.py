"""A phase takes over along a sine."""

from __future__ import annotations

from typing import Any

from motionlab.force_sharing.functions.function import Array, Demand, SharingFunction
from motionlab.force_sharing.functions.hand_over import OVERLAP, hand_over
from motionlab.lanes import Lanes, compiled
from motionlab.lanes.functions import sine_cosine
from motionlab.plant.magnetics import Phases


@compiled
def sine(par: Any, demand: Demand, _tables: Array) -> Phases:
    """Return the shares, which rise along ``(1 - cos pi z)/2``."""
    a, b, c = demand.a.turns, demand.b.turns, demand.c.turns
    return Phases(_share(par, a, demand), _share(par, b, demand), _share(par, c, demand))


@compiled
def _share(par: Any, turns: Lanes, demand: Demand) -> Lanes:
    z = hand_over(par, turns, demand)
    _, cos_rise = sine_cosine(0.5 * z.rise)
    _, cos_fall = sine_cosine(0.5 * z.fall)
    return 0.5 * (cos_fall - cos_rise)


FUNCTION = SharingFunction(
    name="sine",
    label="sine",
    description="Classical, one phase hands over to the next along a sine",
    source="classical",
    shares=sine,
    parameters=(OVERLAP,),
)
