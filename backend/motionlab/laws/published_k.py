"""K by eq. (25) as printed, which does not work in discrete time.

It needs an acceleration that K itself causes, its denominator crosses zero, and V of eq. (37) is
only semidefinite.
"""

from __future__ import annotations

import dataclasses

from motionlab.lanes import compiled, select
from motionlab.laws import lugre_observer
from motionlab.laws.law import PAPER, Estimate, Seen
from motionlab.laws.lugre_observer import (
    LuGreObserver,
    LuGreState,
    observed_velocity,
    step_observer,
)
from motionlab.laws.reversed_k import SMALLEST_DENOMINATOR
from motionlab.plant.friction import bristle_decay


@compiled
def published_k(par: LuGreObserver, state: LuGreState, seen: Seen) -> tuple[Estimate, LuGreState]:
    """Estimate friction with ``K = u (M a - u)/(sigma_1 u + e k_d D)``."""
    model, u = seen.friction, seen.u
    v = observed_velocity(par.from_reference, seen)
    D = model.sigma_1 * bristle_decay(model, v) - model.sigma_0
    denominator = model.sigma_1 * u + seen.error * seen.k_d * D
    tiny = abs(denominator) < SMALLEST_DENOMINATOR
    K = u * (seen.M * seen.a - u) / select(tiny, SMALLEST_DENOMINATOR, denominator)
    estimate = step_observer(model, par.z_limit, state.z, v, K)
    return estimate, LuGreState(estimate.z)


LAW = dataclasses.replace(
    lugre_observer.LAW,
    name="published-k",
    label="K as published",
    description="Eq. (25) as printed, which does not work in discrete time",
    source=f"{PAPER}, eq. (25)",
    step=published_k,
    quotient=lambda _: "law",
)
