"""Motion of one axis under thrust, load, friction and end stops: eq. (16), exponential midpoint."""

from __future__ import annotations

from typing import NamedTuple

from motionlab.lanes import Lanes, compiled, select
from motionlab.lanes.functions import decay, exponential
from motionlab.plant.friction import LuGre, stribeck


class Mechanics(NamedTuple):
    """Mechanical parameters of each lane."""

    M: Lanes  # moving mass, kg
    stop: Lanes  # distance of the end stops from mid-stroke, m
    stop_stiffness: Lanes  # N/m
    stop_damping: Lanes  # N s/m


class Mover(NamedTuple):
    """State of the mover of each lane."""

    p: Lanes  # position, m
    v: Lanes  # velocity, m/s
    z: Lanes  # bristle state, m


@compiled
def end_stop_force(mechanics: Mechanics, position: Lanes, v: Lanes) -> Lanes:
    """Return the force of the end stops on the mover, N: it pushes back and never pulls."""
    depth = abs(position) - mechanics.stop
    outward = select(position < 0.0, -1.0, 1.0)
    push = mechanics.stop_stiffness * depth + mechanics.stop_damping * (v * outward)
    push = select(push > 0.0, push, 0.0)
    return select(depth > 0.0, -(push * outward), 0.0)


@compiled
def advance(mechanics: Mechanics, friction: LuGre, s: Mover, force: Lanes, h: float) -> Mover:
    """Advance a mover by `h` seconds under a constant `force`, N.

    At constant velocity the bristle relaxes exactly, ``z(t) = g + (z - g) exp(-lambda t)`` with
    ``lambda = abs(v)/g(v)`` at up to 5e5 1/s and g signed like v; its mean over a step is
    ``g + (z - g) phi1``. So it is stepped exactly, first to the middle of the step and then, with
    the velocity found there, over the whole of it::

        x = lambda(v) h/2;   z_m = g + (z - g) e^-x
        v_m = v + ((h/2) (f - s0 z_m - s2 v) - s1 (z_m - z))/M
        x = lambda(v_m) h;   z_n = g + (z - g) e^-x;   z_a = g + (z - g) phi1(x)
        v_n = (M v + h (f - s0 z_a - s2 v/2) - s1 (z_n - z))/(M + h s2/2)
        p_n = p + h (v + v_n)/2

    The exponential midpoint rule: second order; no step is too long for the bristle, and the rest
    is stable while h sigma_1 and h^2 sigma_0 stay below the mass. What does not depend on the
    bristle is gathered first, because the chain of operations that does is what a step waits for.
    """
    M, s0, s1, s2 = mechanics.M, friction.sigma_0, friction.sigma_1, friction.sigma_2
    half = 0.5 * h
    v, z = s.v, s.z

    level = stribeck(friction, v)
    g = select(v < 0.0, -level, level) * (1.0 / s0)
    z_mid = g + (z - g) * exponential(-(s0 * half * abs(v) / level))
    v_free = v + (half * (force - s2 * v) + s1 * z) * (1.0 / M)
    v_mid = v_free - ((half * s0 + s1) * (1.0 / M)) * z_mid

    level = stribeck(friction, v_mid)
    g = select(v_mid < 0.0, -level, level) * (1.0 / s0)
    sliding = s0 * h * abs(v_mid)
    e, phi_1 = decay(sliding / level, level / sliding)
    z_new = g + (z - g) * e
    z_mean = g + (z - g) * phi_1
    heavier = 1.0 / (M + half * s2)
    v_free = (M * v + h * force - (half * s2) * v + s1 * z) * heavier
    v_new = v_free - (h * s0 * heavier) * z_mean - (s1 * heavier) * z_new
    return Mover(s.p + half * (v + v_new), v_new, z_new)
