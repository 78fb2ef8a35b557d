"""Eq. (25) with the opposite sign and its force balance filtered.

``K = -r/(sigma_1 + c k_d D e/u)`` with ``r`` the filtered ``M a - u`` and ``D = sigma_1 abs(v)/g(v)
- sigma_0``; c is a share of k_d, and c = 0 leaves ``K = -r/sigma_1``, which has no pole.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from motionlab.lanes import Lanes, compiled, select
from motionlab.laws.law import Estimate, Law, Parameter, Seen
from motionlab.laws.lugre_observer import (
    BRISTLE_LIMIT,
    VELOCITY,
    observed_velocity,
    sliding_bristle,
    step_observer,
    z_limit,
)
from motionlab.laws.residual_k import (
    BRISTLES,
    RESIDUAL_BANDWIDTH,
    ResidualState,
    filtered,
    low_pass,
)
from motionlab.plant.friction import LuGre, bristle_decay

SMALLEST_DENOMINATOR = 1e-12
"""The paper's rho: (25) is 0/0 at rest on the reference."""

K_D_SHARE = Parameter(
    "k_d_share",
    "Share of k_d in the denominator of (25) (reversed-k): 0 leaves K = -(M a - u)/sigma_1; "
    "0.001 takes the number of Table 1, in N s/mm, as N s/m",
    label="share of k_d",
    unit="1",
    default=0.0,
    ge=0,
    le=1,
)


class ReversedK(NamedTuple):
    """ReversedK of each lane."""

    from_reference: Lanes  # 1: the observer uses the reference's velocity; 0: the measured one
    z_limit: Lanes  # largest bristle estimate, m; inf for none
    alpha: Lanes  # 1 - exp(-2 pi f T_s) of the residual's filter
    k_d_share: Lanes  # c in the denominator of K, 1


@compiled
def reversed_k(par: ReversedK, state: ResidualState, seen: Seen) -> tuple[Estimate, ResidualState]:
    """Estimate friction with ``K = -r/(sigma_1 + c k_d D e/u)``; balance ``M a - (f - f_f*)``."""
    model = seen.friction
    balance = seen.M * seen.a - (seen.f_acting - seen.estimate_acting)
    residual = filtered(state.residual, par.alpha, balance, seen)

    v = observed_velocity(par.from_reference, seen)
    D = model.sigma_1 * bristle_decay(model, v) - model.sigma_0
    tiny = abs(seen.u) < SMALLEST_DENOMINATOR
    u = select(tiny, SMALLEST_DENOMINATOR, seen.u)
    slope = model.sigma_1 + par.k_d_share * seen.k_d * seen.error / u * D
    K = -residual / select(abs(slope) < SMALLEST_DENOMINATOR, np.inf, slope)
    estimate = step_observer(model, par.z_limit, state.z, v, K)
    return estimate, ResidualState(estimate.z, residual)


def lane(values: Mapping[str, Any], friction: LuGre) -> ReversedK:
    """Return the parameters of one lane."""
    return ReversedK(
        from_reference=float(values["velocity"] == "reference"),
        z_limit=z_limit(values, friction, BRISTLES),
        alpha=low_pass(values["residual_bandwidth"]),
        k_d_share=values["k_d_share"],
    )


LAW = Law(
    name="reversed-k",
    label="K, sign reversed",
    description="Eq. (25) with the opposite sign and a filtered balance",
    source="this project's form of eq. (25)",
    step=reversed_k,
    Parameters=ReversedK,
    State=ResidualState,
    parameters=(VELOCITY, BRISTLE_LIMIT, RESIDUAL_BANDWIDTH, K_D_SHARE),
    lane=lane,
    sliding=lambda friction, v: ResidualState(sliding_bristle(friction, v), 0.0),
    limits=("z_limit",),
    quotient=lambda values: "k_d_share" if values["k_d_share"] > 0.0 else None,
)
