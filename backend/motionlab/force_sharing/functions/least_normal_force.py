"""Nearly the least normal force for the commanded force: a phase pulls early, as much as it can.

On the analytic map with ``S = sin theta`` a phase has the normal force
``N_k = F_k N_pk/(2 F_pk) tan(theta_k/2)``, whatever its current. It is least where the phase at the
smaller angle gives all that it can, and the other one the rest. To its current limit that would be
a step of the current at ``theta = 0``, where the phase has no thrust; here it rises to its limit,
and falls from it, along a cubic over a share of the pole pitch.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from motionlab.force_sharing.functions.function import (
    OURS,
    TINY,
    Array,
    Demand,
    Parameter,
    Phase,
    SharingFunction,
)
from motionlab.lanes import Lanes, compiled, select
from motionlab.lanes.functions import clip, positive
from motionlab.plant.magnetics import Phases

RISE = Parameter(
    "rise",
    "Share of the pole pitch over which a phase rises to its current limit, and falls from it",
    unit="1",
    default=0.034,
    ge=0.005,
    le=1 / 6,
    shown="% of pitch",
    source=f"{OURS}: on the nominal motor currents as steep as those of force-per-ampere",
)

_ROUND = 0.1
"""Half the width, in commands, of the round corner where a phase comes to give all the command."""


class _Part(NamedTuple):
    """What a phase may give, over the command."""

    early: Lanes  # 1 in the first half of where it pulls, 0 in the second
    first: Lanes  # what it gives before all others in the first half
    most: Lanes  # what it may give in the second half


@compiled
def least_normal_force(par: Any, demand: Demand, _tables: Array) -> Phases:
    """Return the shares: of the phase at the smaller angle what it can, of the other the rest."""
    a, b, c = (
        _part(par, demand.a, demand),
        _part(par, demand.b, demand),
        _part(par, demand.c, demand),
    )
    left = positive(1.0 - (a.first + b.first + c.first))
    late = Phases(clip(a.most, 0.0, left), clip(b.most, 0.0, left), clip(c.most, 0.0, left))
    rest = 1.0 - (late.a + late.b + late.c)
    return Phases(late.a + a.early * rest, late.b + b.early * rest, late.c + c.early * rest)


@compiled
def _part(par: Any, phase: Phase, demand: Demand) -> _Part:
    place = select(demand.forward, phase.turns, 1.0 - phase.turns)
    early = place < 0.25
    z = clip(select(early, place, 0.5 - place) * (1.0 / par.rise), 0.0, 1.0)
    command = select(demand.magnitude > TINY, demand.magnitude, TINY)
    most = z * z * (3.0 - 2.0 * z) * phase.most / command
    # The corner at the whole command is a parabola: the current of the other phase is as the root
    # of what it gives, which has to end as a square for a finite slope.
    corner = clip((most - (1.0 - _ROUND)) * (0.5 / _ROUND), 0.0, 1.0)
    first = clip(most, 0.0, 1.0 + _ROUND) - _ROUND * corner * corner
    return _Part(select(early, 1.0, 0.0), select(early, first, 0.0), select(early, 0.0, most))


FUNCTION = SharingFunction(
    name="least-normal-force",
    label="least normal force",
    description="Nearly the least normal force for the force, each phase as early as it can",
    source=OURS,
    shares=least_normal_force,
    parameters=(RISE,),
    passes_on=True,
)
