"""Current amplifiers: each phase follows its command through a first-order loop."""

from __future__ import annotations

from typing import NamedTuple

from motionlab.lanes import Lanes, compiled
from motionlab.lanes.functions import clip
from motionlab.plant.magnetics import Phases


class Amplifiers(NamedTuple):
    """Amplifier parameters of each lane."""

    half_step: Lanes  # exp(-omega h/2): what remains of a deviation after half a substep, 1
    gain_a: Lanes  # current per commanded current, 1
    gain_b: Lanes
    gain_c: Lanes
    offset_a: Lanes  # current at zero command, A
    offset_b: Lanes
    offset_c: Lanes
    limit: Lanes  # largest current either way, A


@compiled
def settled_current(amplifiers: Amplifiers, command: Phases, disturbance: Phases) -> Phases:
    """Return the current each loop settles at, A, for a `command` and a `disturbance`, A."""
    limit = amplifiers.limit
    return Phases(
        clip(amplifiers.gain_a * command.a + amplifiers.offset_a + disturbance.a, -limit, limit),
        clip(amplifiers.gain_b * command.b + amplifiers.offset_b + disturbance.b, -limit, limit),
        clip(amplifiers.gain_c * command.c + amplifiers.offset_c + disturbance.c, -limit, limit),
    )


@compiled
def half_step(amplifiers: Amplifiers, current: Phases, target: Phases) -> Phases:
    """Return the current half a substep later: ``di/dt = omega (target - i)``, exactly."""
    rest = amplifiers.half_step
    return Phases(
        target.a + rest * (current.a - target.a),
        target.b + rest * (current.b - target.b),
        target.c + rest * (current.c - target.c),
    )
