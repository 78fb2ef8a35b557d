"""Motion of one axis under thrust, load, friction and end stops: eq. (16), exponential midpoint."""

from __future__ import annotations

from typing import NamedTuple

from motionlab.lanes import Lanes, compiled, select
from motionlab.lanes.functions import decay
from motionlab.plant.friction import LuGre, stribeck


class Mechanics(NamedTuple):
    """Mechanical parameters of each lane."""

    M: Lanes  # moving mass, kg
    stop: Lanes  # distance of the end stops from mid-stroke, m
    stop_stiffness: Lanes  # N/m
    stop_damping: Lanes  # N s/m


@compiled
def end_stop_force(mechanics: Mechanics, position: Lanes, v: Lanes) -> Lanes:
    """Return the force of the end stops on the mover, N: it pushes back and never pulls."""
    depth = abs(position) - mechanics.stop
    outward = select(position < 0.0, -1.0, 1.0)
    push = mechanics.stop_stiffness * depth + mechanics.stop_damping * (v * outward)
    push = select(push > 0.0, push, 0.0)
    return select(depth > 0.0, -(push * outward), 0.0)


@compiled
def advance(  # noqa: PLR0913, PLR0917 - one argument for each state and input of the equation
    mechanics: Mechanics,
    friction: LuGre,
    position: Lanes,
    v: Lanes,
    z: Lanes,
    force: Lanes,
    h: float,
) -> tuple[Lanes, Lanes, Lanes]:
    """Advance position, velocity and bristle state by `h` seconds under a constant `force`, N.

    The bristle state decays at up to 5e5 1/s, so it is stepped by its exact exponential, first to
    the middle of the step and then, with the velocity found there, over the whole of it::

        x = abs(v)/g(v) h/2;   z_m = z e^-x + (h/2) v phi1(x)
        v_m = v + ((h/2) (f - s0 z_m - s2 v) - s1 (z_m - z))/M
        x = abs(v_m)/g(v_m) h; z_n = z e^-x + h v_m phi1;  z_a = z phi1 + h v_m phi2
        v_n = (M v + h (f - s0 z_a - s2 v/2) - s1 (z_n - z))/(M + h s2/2)
        p_n = p + h (v + v_n)/2

    Second order; no step is too long for its stability.
    """
    sliding = friction.sigma_0 * abs(v) * (0.5 * h)
    level = stribeck(friction, v)
    e, phi_1, _ = decay(sliding / level, level / sliding)
    z_mid = z * e + (0.5 * h) * v * phi_1
    impulse = (0.5 * h) * (force - friction.sigma_0 * z_mid - friction.sigma_2 * v)
    v_mid = v + (impulse - friction.sigma_1 * (z_mid - z)) * (1.0 / mechanics.M)

    sliding = friction.sigma_0 * abs(v_mid) * h
    level = stribeck(friction, v_mid)
    e, phi_1, phi_2 = decay(sliding / level, level / sliding)
    z_new = z * e + h * v_mid * phi_1
    z_mean = z * phi_1 + h * v_mid * phi_2
    impulse = h * (force - friction.sigma_0 * z_mean - (0.5 * friction.sigma_2) * v)
    v_new = (mechanics.M * v + impulse - friction.sigma_1 * (z_new - z)) * (
        1.0 / (mechanics.M + (0.5 * h) * friction.sigma_2)
    )
    return position + (0.5 * h) * (v + v_new), v_new, z_new
