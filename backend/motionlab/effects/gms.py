"""Generalised Maxwell-slip friction (Al-Bender, Lampaert, Swevers 2005) with four elements.

Element i has a share alpha_i of the sliding force s and a stiffness k_i. It sticks,
``dF_i/dt = k_i v``, until ``abs(F_i) = alpha_i s``; then it slips until the velocity changes its
sign, ``dF_i/dt = sgn(v) C (alpha_i - abs(F_i)/s)``. The force is ``sum F_i + sigma_2 v``.

The elements have equal shares. Their stiffnesses, which add up to sigma_0, are those of LuGre's
curve before sliding, ``F = s (1 - exp(-sigma_0 x/s))``, cut into four parts of equal force: the
distribution of yield points ``x exp(-x)`` at its quartiles.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from motionlab.effects.effect import OURS, Effect, MidStep, Parameter, Resistance
from motionlab.effects.level import (
    DEPENDENCES,
    STIFFNESS,
    STRIBECK_CURVE,
    VISCOUS,
    lane_of,
    sliding_force,
    steady_level,
    stiction_below,
)
from motionlab.lanes import Lanes, compiled, round_nearest, select
from motionlab.lanes.functions import decay, sign
from motionlab.plant.friction import LuGre, stribeck_level

SHARE = 0.25
_QUARTILES = (0.9612787631147768, 1.678346990016661, 2.692634528889437)
_LEFT = (1.0, *(math.exp(-x) for x in _QUARTILES), 0.0)
K_1, K_2, K_3, K_4 = (_LEFT[i] - _LEFT[i + 1] for i in range(4))
"""Stiffness of each element, in units of sigma_0."""

ATTRACTION = Parameter(
    "attraction",
    "Attraction C of a slipping element towards the sliding force: how fast friction follows it",
    unit="N/s",
    default=1000.0,
    ge=0.1,
    le=1e7,
    usual=(10.0, 1e4),
    source=f"{OURS}: 4 ms at 4 N",
)


class Gms(NamedTuple):
    """Parameters of each lane."""

    sigma_0: Lanes  # stiffness of all elements, N/m
    sigma_2: Lanes  # viscous friction, N s/m
    F_c: Lanes  # Coulomb friction, N
    F_s: Lanes  # stiction, N
    v_s: Lanes  # Stribeck velocity, m/s
    attraction: Lanes  # C, N/s
    mu: Lanes  # friction per normal force, 1
    position_amplitude: Lanes  # 1
    position_period: Lanes  # m


class GmsState(NamedTuple):
    """State of each lane."""

    F_1: Lanes  # forces of the elements, N
    F_2: Lanes
    F_3: Lanes
    F_4: Lanes
    side_1: Lanes  # direction in which each slips, 1 or -1; 0 while it sticks
    side_2: Lanes
    side_3: Lanes
    side_4: Lanes


class Element(NamedTuple):
    """Force of an element at a step's end, its mean over the step, and the direction of slip."""

    force: Lanes  # N
    mean: Lanes  # N
    side: Lanes


@compiled
def _element(stiffness: Lanes, level: Lanes, rate: Lanes, at: Element, seen: MidStep) -> Element:
    """Step an element of stiffness k, N/m, sliding force alpha_i s, N, and rate C/s, 1/s."""
    v, force = seen.velocity, at.force
    side, slip = sign(v), round_nearest(at.side)  # a direction has no slope to linearise
    # A reversal ends the slip.
    slips = (abs(slip) > 0.0) & (slip * v >= 0.0)
    e, phi_1 = decay(rate * seen.h, 1.0 / (rate * seen.h))
    goal = slip * level
    slipped, slip_mean = goal + (force - goal) * e, goal + (force - goal) * phi_1

    sprung = force + stiffness * v * seen.h
    reached = (side * sprung >= level) & (abs(side) > 0.0)
    # One that is beyond a falling level already slips from where it is.
    limit = select(side * force > level, force, side * level)
    stuck = select(reached, limit, sprung)
    return Element(
        select(slips, slipped, stuck),
        select(slips, slip_mean, 0.5 * (force + stuck)),
        select(slips, slip, select(reached, side, 0.0)),
    )


@compiled
def gms(par: Gms, state: GmsState, seen: MidStep) -> tuple[Resistance, GmsState]:
    """Step the elements at the velocity of the middle, and return the mean of their sum."""
    total, k = sliding_force(par, seen), par.sigma_0
    level, rate, s = SHARE * total, par.attraction / total, state
    one = _element(K_1 * k, level, rate, Element(s.F_1, s.F_1, s.side_1), seen)
    two = _element(K_2 * k, level, rate, Element(s.F_2, s.F_2, s.side_2), seen)
    three = _element(K_3 * k, level, rate, Element(s.F_3, s.F_3, s.side_3), seen)
    four = _element(K_4 * k, level, rate, Element(s.F_4, s.F_4, s.side_4), seen)
    force = one.mean + two.mean + three.mean + four.mean + par.sigma_2 * seen.velocity
    after = GmsState(
        one.force,
        two.force,
        three.force,
        four.force,
        one.side,
        two.side,
        three.side,
        four.side,
    )
    return Resistance(force, par.sigma_2), after


def sliding(friction: LuGre, v: float) -> GmsState:
    """Return the state of sliding at `v`."""
    if v == 0.0:
        return GmsState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    side = math.copysign(1.0, v)
    level = stribeck_level(abs(v), friction.F_c, friction.F_s, friction.v_s)
    force = side * SHARE * level
    return GmsState(force, force, force, force, side, side, side, side)


EFFECT = Effect(
    name="gms",
    label="Maxwell-slip friction",
    description="Generalised Maxwell slip: hysteresis before sliding that remembers reversals",
    source="Al-Bender, Lampaert, Swevers, IEEE Trans. Autom. Control 50(11), 2005",
    step=gms,
    Parameters=Gms,
    State=GmsState,
    parameters=(STIFFNESS, VISCOUS, *STRIBECK_CURVE, ATTRACTION, *DEPENDENCES),
    lane=lane_of(Gms),
    level=steady_level,
    sliding=sliding,
    refuse=stiction_below,
)
