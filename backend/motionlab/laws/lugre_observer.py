"""The LuGre observer of eqs (23) and (24) with K = 0, and what the laws with a K have in common.

The observer is ``dz*/dt = v - abs(v)/g(v) z* + K``, stepped by its exact exponential: an explicit
step at 0.5 ms diverges above 46 mm/s.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from motionlab.lanes import Lanes, compiled, select
from motionlab.lanes.functions import clip, decay
from motionlab.laws.law import PAPER, Estimate, Law, Parameter, Seen
from motionlab.plant.friction import LuGre, bristle_decay, stribeck_level
from motionlab.timing import CONTROL_PERIOD

VELOCITY = Parameter(
    "velocity",
    "Velocity that drives the observer",
    default="measured",
    choices=("measured", "reference"),
)
BRISTLE_LIMIT = Parameter(
    "bristle_limit",
    "Largest bristle estimate, in units of F_s/sigma_0; left out: 1.2 for residual-k and "
    "reversed-k, none otherwise",
    unit="1",
    gt=0,
    le=1000,
    usual=(0.1, 10.0),
)


class LuGreObserver(NamedTuple):
    """LuGreObserver of each lane."""

    from_reference: Lanes  # 1: the observer uses the reference's velocity; 0: the measured one
    z_limit: Lanes  # largest bristle estimate, m; inf for none


class LuGreState(NamedTuple):
    """LuGreState of each lane."""

    z: Lanes  # bristle estimate, m


@compiled
def observed_velocity(from_reference: Lanes, seen: Seen) -> Lanes:
    """Return the velocity that drives the observer, m/s."""
    return select(from_reference > 0.0, seen.v_ref, seen.v)


@compiled
def step_observer(model: LuGre, z_limit: Lanes, z: Lanes, v: Lanes, K: Lanes) -> Estimate:
    """Step the observer over one period and return its friction estimate, eq. (23).

    With ``l = abs(v)/g(v)``::

        z_n = z* e^-lT + T (v + K) phi1(lT)
        f_f* = sigma_0 z_n + sigma_1 (z_n - z*)/T + sigma_2 v
    """
    T_s = CONTROL_PERIOD
    x = bristle_decay(model, v) * T_s
    e, phi_1 = decay(x, 1.0 / select(x > 0.0, x, 1.0))  # at rest nothing divides by zero
    z_new = clip(z * e + T_s * (v + K) * phi_1, -z_limit, z_limit)
    z_rate = (z_new - z) * (1.0 / T_s)
    force = model.sigma_0 * z_new + model.sigma_1 * z_rate + model.sigma_2 * v
    return Estimate(force, z_new, K)


@compiled
def lugre_observer(
    par: LuGreObserver, state: LuGreState, seen: Seen
) -> tuple[Estimate, LuGreState]:
    """Estimate friction by the model alone, driven by the velocity."""
    v = observed_velocity(par.from_reference, seen)
    estimate = step_observer(seen.friction, par.z_limit, state.z, v, 0.0)
    return estimate, LuGreState(estimate.z)


def z_limit(values: Mapping[str, Any], friction: LuGre, default: float = math.inf) -> float:
    """Return the largest bristle estimate, m; `default` in units of F_s/sigma_0."""
    limit = values["bristle_limit"]
    return (default if limit is None else limit) * friction.F_s / friction.sigma_0


def lane(values: Mapping[str, Any], friction: LuGre) -> LuGreObserver:
    """Return the parameters of one lane."""
    return LuGreObserver(
        from_reference=float(values["velocity"] == "reference"),
        z_limit=z_limit(values, friction),
    )


@compiled
def sliding_bristle(friction: LuGre, v: float) -> float:
    """Return the bristle state of sliding at `v`, m; eq. (21) with dz/dt = 0."""
    if v == 0.0:
        return 0.0
    level = float(stribeck_level(abs(v), friction.F_c, friction.F_s, friction.v_s))
    return math.copysign(level, v) / friction.sigma_0


LAW = Law(
    name="lugre-observer",
    label="LuGre observer, K = 0",
    description="The LuGre model driven by the velocity alone",
    source=f"{PAPER}, eqs (23), (24)",
    step=lugre_observer,
    Parameters=LuGreObserver,
    State=LuGreState,
    parameters=(VELOCITY, BRISTLE_LIMIT),
    lane=lane,
    sliding=lambda friction, v: LuGreState(sliding_bristle(friction, v)),
    limits=("z_limit",),
)
