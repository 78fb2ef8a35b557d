"""A notch filter on the feedback, against a structural resonance of the motor.

It filters the forces of PD and disturbance observer. Friction estimate and acceleration feedforward
bypass it: delayed, they would be wrong, and feedforward from the reference cannot make a loop
unstable.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from motionlab.lanes import Lanes, compiled
from motionlab.timing import CONTROL_PERIOD


class Notch(NamedTuple):
    """The filter of each lane, sampled; ``b_0 = 1`` and zeros otherwise pass everything."""

    b_0: Lanes
    b_1: Lanes
    b_2: Lanes
    a_1: Lanes
    a_2: Lanes


PASS = Notch(b_0=1.0, b_1=0.0, b_2=0.0, a_1=0.0, a_2=0.0)
"""No notch."""


def sampled_notch(*, frequency: float, damping: float, gain: float) -> Notch:
    """Return the sampled notch: bilinear, and exact at its frequency.

    ``N(s) = (s^2 + 2 gain zeta omega s + omega^2)/(s^2 + 2 zeta omega s + omega^2)``

    Parameters
    ----------
    frequency : float
        omega/(2 pi), Hz, below half the control rate.
    damping : float
        zeta of the poles: half the notch's relative width.
    gain : float
        abs(N) at its frequency; 1 is no notch.
    """
    if gain == 1.0:
        return PASS
    k = math.tan(math.pi * frequency * CONTROL_PERIOD)
    zeros, poles, square = 2.0 * gain * damping * k, 2.0 * damping * k, k * k
    scale = 1.0 / (1.0 + poles + square)
    turn = 2.0 * (square - 1.0) * scale
    return Notch(
        b_0=(1.0 + zeros + square) * scale,
        b_1=turn,
        b_2=(1.0 - zeros + square) * scale,
        a_1=turn,
        a_2=(1.0 - poles + square) * scale,
    )


@compiled
def notched(
    notch: Notch, force: Lanes, feedback: Lanes, n_1: Lanes, n_2: Lanes
) -> tuple[Lanes, Lanes, Lanes]:
    """Return `force`, N, with its part `feedback` filtered, and the filter's next two states, N.

    The filter's change is added, so that a filter of gain 1 leaves every bit of `force`.
    """
    passed = notch.b_0 * feedback + n_1
    return (
        force + (passed - feedback),
        notch.b_1 * feedback - notch.a_1 * passed + n_2,
        notch.b_2 * feedback - notch.a_2 * passed,
    )
