"""Classical sharing functions of position alone: a phase takes over from the one before it.

It does so in the middle of the half pitch in which it pulls, along a curve from 0 to 1.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from motionlab.force_sharing.functions.function import OURS, Demand, Parameter
from motionlab.lanes import Lanes, compiled, select
from motionlab.lanes.functions import clip

OVERLAP = Parameter(
    "overlap",
    "Share of the pole pitch over which one phase hands over to the next",
    unit="1",
    default=1 / 6,
    ge=0.005,
    le=1 / 6,
    shown="% of pitch",
    source=f"{OURS}: a sixth is all that two phases have in common",
)


class HandOver(NamedTuple):
    """Where a phase stands in both of its handovers."""

    rise: Lanes  # it takes over from the one before: 0 before, 1 after
    fall: Lanes  # the next one takes over from it


@compiled
def hand_over(par: Any, turns: Lanes, demand: Demand) -> HandOver:
    """Return where a phase at `turns` stands in its handovers, of `overlap` in length."""
    place = select(demand.forward, turns, 1.0 - turns)
    per = 1.0 / par.overlap
    start = 1.0 / 12.0 - 0.5 * par.overlap
    rise = clip((place - start) * per, 0.0, 1.0)
    fall = clip((place - start - 1.0 / 3.0) * per, 0.0, 1.0)
    return HandOver(rise, fall)
