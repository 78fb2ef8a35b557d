"""A phase takes over along a cubic."""

from __future__ import annotations

from typing import Any

from motionlab.force_sharing.functions.function import Array, Demand, SharingFunction
from motionlab.force_sharing.functions.hand_over import OVERLAP, hand_over
from motionlab.lanes import Lanes, compiled
from motionlab.plant.magnetics import Phases


@compiled
def cubic(par: Any, demand: Demand, _tables: Array) -> Phases:
    """Return the shares, which rise along ``3 z**2 - 2 z**3``."""
    a, b, c = demand.a.turns, demand.b.turns, demand.c.turns
    return Phases(_share(par, a, demand), _share(par, b, demand), _share(par, c, demand))


@compiled
def _share(par: Any, turns: Lanes, demand: Demand) -> Lanes:
    rise, fall = hand_over(par, turns, demand)
    return rise * rise * (3.0 - 2.0 * rise) - fall * fall * (3.0 - 2.0 * fall)


FUNCTION = SharingFunction(
    name="cubic",
    label="cubic",
    description="Classical, one phase hands over to the next along a cubic",
    source="classical",
    shares=cubic,
    parameters=(OVERLAP,),
)
