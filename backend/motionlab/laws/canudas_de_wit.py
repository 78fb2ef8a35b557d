"""The observer of Canudas de Wit et al.: K in proportion to the following error.

Canudas de Wit, Olsson, Astrom, Lischinsky, "A new model for control of systems with friction",
IEEE Trans. Autom. Control 40(3), 1995, doi 10.1109/9.376053.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from motionlab.lanes import Lanes, compiled
from motionlab.laws.law import Estimate, Law, Parameter, Seen
from motionlab.laws.lugre_observer import (
    BRISTLE_LIMIT,
    VELOCITY,
    LuGreState,
    observed_velocity,
    sliding_bristle,
    step_observer,
    z_limit,
)
from motionlab.plant.friction import LuGre

GAIN = Parameter(
    "gain",
    "Gain of K; left out: 300/s for canudas-de-wit; for residual-k 40/s, or 0.9 of its limit, "
    "below which its residual does not feed itself: 2 c sigma_0/sigma_1 of the controller's "
    "model, 1 + c^2 instead of 2 c from c = 1 on, c being the regularisation",
    label="gain of K",
    unit="1/s",
    ge=0,
    le=1e5,
    usual=(1.0, 3e3),
)
_USUAL = 300.0  # 1/s


class CanudasDeWit(NamedTuple):
    """CanudasDeWit of each lane."""

    from_reference: Lanes  # 1: the observer uses the reference's velocity; 0: the measured one
    z_limit: Lanes  # largest bristle estimate, m; inf for none
    gain: Lanes  # of K, 1/s


@compiled
def canudas_de_wit(par: CanudasDeWit, state: LuGreState, seen: Seen) -> tuple[Estimate, LuGreState]:
    """Estimate friction with ``K = gain e``."""
    v = observed_velocity(par.from_reference, seen)
    K = par.gain * seen.error
    estimate = step_observer(seen.friction, par.z_limit, state.z, v, K)
    return estimate, LuGreState(estimate.z)


def lane(values: Mapping[str, Any], friction: LuGre) -> CanudasDeWit:
    """Return the parameters of one lane."""
    gain = values["gain"]
    return CanudasDeWit(
        from_reference=float(values["velocity"] == "reference"),
        z_limit=z_limit(values, friction),
        gain=_USUAL if gain is None else gain,
    )


LAW = Law(
    name="canudas-de-wit",
    label="Canudas de Wit",
    description="K in proportion to the following error, 1995",
    source="Canudas de Wit et al., IEEE Trans. Autom. Control 40(3), 1995",
    step=canudas_de_wit,
    Parameters=CanudasDeWit,
    State=LuGreState,
    parameters=(VELOCITY, BRISTLE_LIMIT, GAIN),
    lane=lane,
    sliding=lambda friction, v: LuGreState(sliding_bristle(friction, v)),
    limits=("z_limit",),
)
