"""LuGre friction, eqs (20) to (22) of Huang et al. 2019; used for the truth and for the model."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from motionlab.lanes import Lanes, compiled
from motionlab.lanes.functions import exponential


class LuGre(NamedTuple):
    """Friction parameters of each lane."""

    sigma_0: Lanes  # bristle stiffness, N/m
    sigma_1: Lanes  # bristle damping, N s/m
    sigma_2: Lanes  # viscous friction, N s/m
    F_c: Lanes  # Coulomb friction, N
    F_s: Lanes  # stiction, N
    v_s: Lanes  # Stribeck velocity, m/s


FRICTIONLESS = LuGre(sigma_0=1.0, sigma_1=0.0, sigma_2=0.0, F_c=1e-60, F_s=1e-60, v_s=1.0)
"""A bristle that gives way at 1e-60 N: below the last bit of any force, and no 0/0."""


@compiled
def stribeck(friction: LuGre, v: Lanes) -> Lanes:
    """Return the steady sliding force ``sigma_0 g(v)`` of eq. (22), N, without viscous friction."""
    w = 1.0 / (friction.v_s * friction.v_s)
    return friction.F_c + (friction.F_s - friction.F_c) * exponential(-(v * v * w))


@compiled
def bristle_decay(friction: LuGre, v: Lanes) -> Lanes:
    """Return the decay rate ``abs(v)/g(v)`` of the bristle state in eq. (21), 1/s."""
    return friction.sigma_0 * abs(v) / stribeck(friction, v)


@compiled
def friction_force(friction: LuGre, v: Lanes, z: Lanes) -> Lanes:
    """Return the friction force, N, at velocity `v`, m/s, and bristle state `z`, m: eqs (20), (21).

    ``f_f = sigma_0 z + sigma_1 (v - abs(v)/g(v) z) + sigma_2 v``
    """
    z_rate = v - bristle_decay(friction, v) * z
    return friction.sigma_0 * z + friction.sigma_1 * z_rate + friction.sigma_2 * v


# The same curve on floats and arrays, which lanes are not.


@compiled
def stribeck_fade(v: Any, v_s: float) -> Any:
    """Return ``exp(-(v/v_s)^2)``, the share of stiction above Coulomb friction left at `v`, m/s."""
    return np.exp(-((v / v_s) ** 2))


@compiled
def stribeck_level(v: Any, F_c: float, F_s: float, v_s: float) -> Any:
    """Return the sliding force ``sigma_0 g(v)`` of eq. (22), N, a magnitude without viscosity."""
    return F_c + (F_s - F_c) * stribeck_fade(v, v_s)


def steady_friction(v: Any, F_c: float, F_s: float, v_s: float, sigma_2: float) -> Any:
    """Return the friction at constant velocity, N: eqs (20) to (22) with dz/dt = 0; 0 at rest.

    ``f = sgn(v) (F_c + (F_s - F_c) exp(-(v/v_s)^2)) + sigma_2 v``
    """
    return np.sign(v) * stribeck_level(v, F_c, F_s, v_s) + sigma_2 * v
