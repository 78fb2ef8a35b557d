"""Static friction: the Stribeck curve with a smooth sign, ``f = s(v) tanh(v/v_0) + sigma_2 v``."""

from __future__ import annotations

from typing import NamedTuple

from motionlab.declarations import OURS
from motionlab.effects.effect import Effect, MidStep, NoState, Parameter, Resistance
from motionlab.effects.level import (
    DEPENDENCES,
    STRIBECK_CURVE,
    VISCOUS,
    lane_of,
    sliding_force,
    steady_level,
    stiction_below,
)
from motionlab.lanes import Lanes, compiled
from motionlab.lanes.functions import hyperbolic_tangent

SMOOTHING = Parameter(
    "smoothing_velocity",
    "Velocity v_0 over which static friction changes its sign",
    unit="m/s",
    shown="mm/s",
    default=2e-4,
    ge=1e-5,
    le=0.1,
    source=f"{OURS}: a step of the plant changes the velocity by up to 0.2 mm/s",
)


class StaticStribeck(NamedTuple):
    """Parameters of each lane."""

    F_c: Lanes  # Coulomb friction, N
    F_s: Lanes  # stiction, N
    v_s: Lanes  # Stribeck velocity, m/s
    sigma_2: Lanes  # viscous friction, N s/m
    smoothing_velocity: Lanes  # v_0, m/s
    mu: Lanes  # friction per normal force, 1
    position_amplitude: Lanes  # 1
    position_period: Lanes  # m


@compiled
def static_stribeck(
    par: StaticStribeck, state: NoState, seen: MidStep
) -> tuple[Resistance, NoState]:
    """Return ``s tanh(v/v_0) + sigma_2 v``; its steep part is damping."""
    level = sliding_force(par, seen)
    side = hyperbolic_tangent(seen.velocity / par.smoothing_velocity)
    damping = level * (1.0 - side * side) / par.smoothing_velocity + par.sigma_2
    return Resistance(level * side + par.sigma_2 * seen.velocity, damping), state


EFFECT = Effect(
    name="static-stribeck",
    label="static Stribeck friction",
    description="Friction that velocity alone decides: the Stribeck curve with a smooth sign",
    source="Armstrong-Helouvry et al., Automatica 30(7), 1994",
    step=static_stribeck,
    Parameters=StaticStribeck,
    parameters=(*STRIBECK_CURVE, VISCOUS, SMOOTHING, *DEPENDENCES),
    lane=lane_of(StaticStribeck),
    level=steady_level,
    refuse=stiction_below,
)
