"""LuGre friction as an effect: eqs (20) to (22), with normal force and position.

Both scale the force of the bristle, ``f = r (sigma_0 z + sigma_1 dz/dt) + sigma_2 v`` with
``r = s(v, p, N)/s(v)``. In g(v) they would let the damping of the bristle push the mover where the
normal force falls, as it does within a commutation. The friction of ``plant.x.friction`` is the
same without them, and faster.
"""

from __future__ import annotations

from typing import NamedTuple

from motionlab.effects.effect import PAPER, Effect, MidStep, Resistance
from motionlab.effects.level import (
    BRISTLE_DAMPING,
    DEPENDENCES,
    STIFFNESS,
    STRIBECK_CURVE,
    VISCOUS,
    bristle_step,
    curve,
    dependent,
    lane_of,
    steady_level,
    stiction_below,
)
from motionlab.lanes import Lanes, compiled


class GuideLuGre(NamedTuple):
    """Parameters of each lane."""

    sigma_0: Lanes  # bristle stiffness, N/m
    sigma_1: Lanes  # bristle damping, N s/m
    sigma_2: Lanes  # viscous friction, N s/m
    F_c: Lanes  # Coulomb friction, N
    F_s: Lanes  # stiction, N
    v_s: Lanes  # Stribeck velocity, m/s
    mu: Lanes  # friction per normal force, 1
    position_amplitude: Lanes  # 1
    position_period: Lanes  # m


class GuideState(NamedTuple):
    """State of each lane."""

    z: Lanes  # bristle state, m


@compiled
def lugre(par: GuideLuGre, state: GuideState, seen: MidStep) -> tuple[Resistance, GuideState]:
    """Return ``r (sigma_0 z + sigma_1 dz/dt) + sigma_2 v``, z stepped by its exact exponential."""
    level = curve(par, seen)
    ratio = dependent(par, seen, level) / level
    z, mean, left = bristle_step(par.sigma_0, level, state.z, seen)
    rate = (z - state.z) / seen.h
    force = ratio * (par.sigma_0 * mean + par.sigma_1 * rate) + par.sigma_2 * seen.velocity
    # A bristle at rest follows the velocity, one that slides does not.
    damping = par.sigma_2 + ratio * par.sigma_1 * left
    return Resistance(force, damping), GuideState(z)


EFFECT = Effect(
    name="lugre",
    label="LuGre friction",
    description="The LuGre model, which may depend on normal force and position",
    source=f"{PAPER}, eqs (20) to (22)",
    step=lugre,
    Parameters=GuideLuGre,
    State=GuideState,
    parameters=(
        STIFFNESS,
        BRISTLE_DAMPING,
        VISCOUS,
        *STRIBECK_CURVE,
        *DEPENDENCES,
    ),
    lane=lane_of(GuideLuGre),
    level=steady_level,
    refuse=stiction_below,
)
