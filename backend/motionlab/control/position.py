"""Position control: motion estimates, the PD law of eq. (15), the disturbance observer."""

from __future__ import annotations

from typing import NamedTuple

from motionlab.lanes import Lanes, Mask, compiled, select
from motionlab.lanes.functions import clip
from motionlab.timing import CONTROL_PERIOD


class PositionController(NamedTuple):
    """Parameters of each lane."""

    k_p: Lanes  # N/m
    k_d: Lanes  # N s/m
    M: Lanes  # mass in the controller's model, kg
    force_limit: Lanes  # largest force command, N
    feedforward: Lanes  # 1: add M a_ref to the command; 0: do not
    observer: Lanes  # 1: add the disturbance observer's force; 0: do not
    observer_alpha: Lanes  # 1 - exp(-2 pi f T_s) of the disturbance observer
    delay: Lanes  # 1: a command acts one tick after its measurement; 0: at once
    ideal_force: Lanes  # 1: the plant gives any force commanded, without currents; 0: it has phases
    learnt: Lanes  # 1: add the force that was learnt of the motion; 0: do not


class MeasuredMotion(NamedTuple):
    """Position, velocity and acceleration derived from the encoder."""

    error: Lanes  # following error, m
    error_rate: Lanes  # m/s
    v: Lanes  # velocity, m/s
    a: Lanes  # acceleration, m/s^2


class Last(NamedTuple):
    """Measurements of the last period."""

    p: Lanes  # position, m
    v: Lanes  # velocity, m/s
    error: Lanes  # following error, m


@compiled
def estimate_motion(p_ref: Lanes, p_meas: Lanes, last: Last, first: Mask) -> MeasuredMotion:
    """Difference the encoder twice, as the paper does; differences are zero on the first tick."""
    error = p_ref - p_meas
    error_rate = select(first, 0.0, (error - last.error) * (1.0 / CONTROL_PERIOD))
    v = select(first, 0.0, (p_meas - last.p) * (1.0 / CONTROL_PERIOD))
    a = select(first, 0.0, (v - last.v) * (1.0 / CONTROL_PERIOD))
    return MeasuredMotion(error, error_rate, v, a)


@compiled
def pd_force(controller: PositionController, motion: MeasuredMotion) -> Lanes:
    """Return ``u = k_p e + k_d de/dt`` of eq. (15), N, within the force limit."""
    u = controller.k_p * motion.error + controller.k_d * motion.error_rate
    return clip(u, -controller.force_limit, controller.force_limit)


@compiled
def disturbance_estimate(
    controller: PositionController, d: Lanes, known_force: Lanes, a: Lanes
) -> Lanes:
    """Return the next estimate of the force that opposes the motion, N.

    ``d += alpha (f - f_f* - M a - d)``, where `known_force` = ``f - f_f*`` is the realised force of
    the last period less the friction compensation in it, or friction would count twice.
    """
    return d + controller.observer_alpha * (known_force - controller.M * a - d)
