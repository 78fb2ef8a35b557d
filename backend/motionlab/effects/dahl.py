"""Dahl's friction: a bristle without Stribeck effect and without damping of its own.

``f = sigma_0 z + sigma_2 v, dz/dt = v - sigma_0 abs(v)/s z`` with ``s = F_c``
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from motionlab.effects.effect import Effect, MidStep, Resistance
from motionlab.effects.level import (
    COULOMB,
    DEPENDENCES,
    STIFFNESS,
    VISCOUS,
    bristle_step,
    dependent,
    lane_of,
)
from motionlab.lanes import Lanes, compiled
from motionlab.plant.friction import LuGre, steady_friction


class Dahl(NamedTuple):
    """Parameters of each lane."""

    sigma_0: Lanes  # stiffness before sliding, N/m
    sigma_2: Lanes  # viscous friction, N s/m
    F_c: Lanes  # Coulomb friction, N
    mu: Lanes  # friction per normal force, 1
    position_amplitude: Lanes  # 1
    position_period: Lanes  # m


class DahlState(NamedTuple):
    """State of each lane."""

    z: Lanes  # deflection, m


@compiled
def dahl(par: Dahl, state: DahlState, seen: MidStep) -> tuple[Resistance, DahlState]:
    """Return ``sigma_0 z + sigma_2 v``, z stepped by its exact exponential."""
    level = dependent(par, seen, par.F_c)
    z, mean, _ = bristle_step(par.sigma_0, level, state.z, seen)
    force = par.sigma_0 * mean + par.sigma_2 * seen.velocity
    return Resistance(force, par.sigma_2), DahlState(z)


def level(par: Dahl, v: Any) -> Any:
    """Return the steady force at velocities, N, at its largest along the stroke."""
    F_c = (1.0 + par.position_amplitude) * par.F_c
    return steady_friction(v, F_c, F_c, 1.0, par.sigma_2)


def sliding(friction: LuGre, v: float) -> DahlState:
    """Return the deflection of sliding at `v`."""
    return DahlState(0.0 if v == 0.0 else math.copysign(friction.F_c / friction.sigma_0, v))


EFFECT = Effect(
    name="dahl",
    label="Dahl friction",
    description="A bristle that gives way at F_c: presliding without Stribeck effect",
    source="Dahl, Aerospace Corp. TOR-0158, 1968",
    step=dahl,
    Parameters=Dahl,
    State=DahlState,
    parameters=(STIFFNESS, VISCOUS, COULOMB, *DEPENDENCES),
    lane=lane_of(Dahl),
    level=level,
    sliding=sliding,
)
