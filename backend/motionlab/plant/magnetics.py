"""Analytic thrust and normal force of three phases; used for the truth and for the model.

Phase k = 0, 1, 2 (a, b, c) at position p has the electrical angle
``theta_k = 2 pi (p + offset)/tau - 2 pi k/3``; its thrust is ``F(i) S(theta_k)`` with
``S = (sin theta + h_2 sin 2 theta + h_3 sin 3 theta)/(1 - h_3)`` and the saturating
``F(i) = F_pk (1 + B) q/(1 + B q)``, ``q = (i/I_pk)**2``, ``B = (I_pk/I_knee)**2``. Thrust
+sin(theta) pulls towards theta = pi, the aligned position. The peak is the paper's; the form of
F(i) and its knee are this project's choice, because it has a closed inverse and follows finite
elements within 5 % of the peak.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from motionlab.lanes import Lanes, compiled, square_root
from motionlab.lanes.functions import sine_cosine

_HALF_SQRT3 = 0.5 * math.sqrt(3.0)


class AnalyticMap(NamedTuple):
    """Force map parameters of each lane."""

    tau: Lanes  # pole pitch, m
    offset: Lanes  # commutation offset, m
    F_pk: Lanes  # thrust of one phase at I_pk, N
    N_pk: Lanes  # normal force of one phase at I_pk, aligned, N
    I_pk: Lanes  # peak current, A
    I_knee: Lanes  # current at which saturation sets in, A
    h_2: Lanes  # second harmonic of the thrust over position, 1
    h_3: Lanes  # third harmonic, 1


class Phases(NamedTuple):
    """One value for each of the three phases."""

    a: Lanes
    b: Lanes
    c: Lanes


@compiled
def electrical_angle(force_map: AnalyticMap, position: Lanes) -> tuple[Phases, Phases]:
    """Return sin and cos of theta_a, theta_b, theta_c at `position`, m."""
    s, c = sine_cosine((position + force_map.offset) * (1.0 / force_map.tau))
    sines = Phases(s, -0.5 * s - _HALF_SQRT3 * c, -0.5 * s + _HALF_SQRT3 * c)
    cosines = Phases(c, -0.5 * c + _HALF_SQRT3 * s, -0.5 * c - _HALF_SQRT3 * s)
    return sines, cosines


@compiled
def thrust_shape(force_map: AnalyticMap, position: Lanes) -> Phases:
    """Return S(theta) of each phase at `position`, m."""
    sines, cosines = electrical_angle(force_map, position)
    s = sines.a
    third = force_map.h_3 * (s * (3.0 - 4.0 * (s * s)))  # sin 3 theta is the same for all phases
    scale = 1.0 / (1.0 - force_map.h_3)
    double = 2.0 * force_map.h_2
    return Phases(
        (sines.a * (1.0 + double * cosines.a) + third) * scale,
        (sines.b * (1.0 + double * cosines.b) + third) * scale,
        (sines.c * (1.0 + double * cosines.c) + third) * scale,
    )


@compiled
def force_fraction(force_map: AnalyticMap, i: Lanes) -> Lanes:
    """Return ``F(i)/F_pk`` at current `i`, A."""
    ratio = i * (1.0 / force_map.I_pk)
    knee = force_map.I_pk * (1.0 / force_map.I_knee)
    q = ratio * ratio
    b = knee * knee
    return (1.0 + b) * q / (1.0 + b * q)


@compiled
def current_for(force_map: AnalyticMap, fraction: Lanes) -> Lanes:
    """Return the current, A, at which F(i) is `fraction` of F_pk: the inverse of force_fraction.

    ``i = I_pk sqrt(y/(1 + B (1 - y)))`` for 0 <= y <= 1.
    """
    knee = force_map.I_pk * (1.0 / force_map.I_knee)
    b = knee * knee
    return force_map.I_pk * square_root(fraction / (1.0 + b * (1.0 - fraction)))


@compiled
def thrust(force_map: AnalyticMap, position: Lanes, current: Phases) -> Lanes:
    """Return the thrust of the three phases, N, at `position`, m, and `current`, A."""
    shape = thrust_shape(force_map, position)
    return force_map.F_pk * (
        force_fraction(force_map, current.a) * shape.a
        + force_fraction(force_map, current.b) * shape.b
        + force_fraction(force_map, current.c) * shape.c
    )


@compiled
def normal_force(force_map: AnalyticMap, position: Lanes, current: Phases) -> Lanes:
    """Return the normal force of the three phases, N, scaled by (1 - cos theta)/2.

    It vanishes at the unaligned position, where finite elements keep 29 % (2 A) to 59 % (10 A).
    """
    _, cosines = electrical_angle(force_map, position)
    half = 0.5 * force_map.N_pk
    return half * (
        force_fraction(force_map, current.a) * (1.0 - cosines.a)
        + force_fraction(force_map, current.b) * (1.0 - cosines.b)
        + force_fraction(force_map, current.c) * (1.0 - cosines.c)
    )
