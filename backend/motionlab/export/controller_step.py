"""One axis of an exported controller, in one control period."""

from __future__ import annotations

from typing import NamedTuple

from numpy.typing import NDArray

from motionlab.kernel.layout import Inputs, Parameters, State
from motionlab.kernel.tick import control, in_effect
from motionlab.lanes import Lanes, Mask
from motionlab.plant.magnetics import Phases


class Reference(NamedTuple):
    """Reference of one axis at the instant of sampling."""

    position: Lanes  # m
    velocity: Lanes  # m/s
    acceleration: Lanes  # m/s^2


class Signals(NamedTuple):
    """Signals of one axis, to be recorded."""

    following_error: Lanes  # m
    velocity: Lanes  # by differences of the measured position, m/s
    pd_force: Lanes  # u, N
    friction_estimate: Lanes  # N
    bristle_estimate: Lanes  # at the end of the period, m
    K: Lanes  # of the friction observer, m/s
    disturbance_estimate: Lanes  # d, N
    force_command: Lanes  # within the force limit, N
    force_realised: Lanes  # what the currents in effect are to give, N
    current_next: Phases  # computed in this period, A; in effect now without delay
    force_saturated: Mask  # the force command is at its limit
    current_saturated: Mask  # some phase is at its current limit
    healthy: Mask  # false: following error beyond its limit, or NaN


def step_axis(
    par: Parameters,
    s: State,
    reference: Reference,
    position: Lanes,
    tables: NDArray | None,
) -> tuple[State, Phases, Signals]:
    """Advance one axis by a control period, from its reference and its measured position, m.

    Return its next state, the currents that are in effect from now on, A, and its signals.
    """
    at = Inputs(
        p_ref=reference.position,
        v_ref=reference.velocity,
        a_ref=reference.acceleration,
        load=0.0,
        encoder_noise=0.0,
        current_a=0.0,
        current_b=0.0,
        current_c=0.0,
    )
    memory, made, signals = control(par, s, at, position, tables, None)
    acting = in_effect(par, s.pending, made)

    force_limit = par.controller.force_limit
    f_command = abs(signals.f_command)
    following = abs(signals.error) <= par.limits.error
    ideal = par.controller.ideal_force > 0.0
    current = Phases(acting.current_a, acting.current_b, acting.current_c)
    return (
        State(s.plant, memory, acting, made, s.age + 1.0, s.failed),
        current,
        Signals(
            following_error=signals.error,
            velocity=signals.v,
            pd_force=signals.u,
            friction_estimate=made.estimate,
            bristle_estimate=memory.z_hat,
            K=made.K,
            disturbance_estimate=signals.d,
            force_command=signals.f_command,
            force_realised=acting.force,
            current_next=Phases(made.current_a, made.current_b, made.current_c),
            force_saturated=f_command >= force_limit,
            current_saturated=signals.limited & ~ideal,
            healthy=following & (f_command <= force_limit),
        ),
    )
