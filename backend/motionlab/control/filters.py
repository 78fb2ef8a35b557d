"""Filters on the feedback: a notch against a structural resonance, and three of any second order.

They filter the forces of PD and disturbance observer, one after another. Friction estimate and
acceleration feedforward bypass them: delayed, they would be wrong, and feedforward from the
reference cannot make a loop unstable.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from motionlab.lanes import Lanes, compiled
from motionlab.timing import CONTROL_PERIOD


class Biquad(NamedTuple):
    """A filter of each lane, sampled; ``b_0 = 1`` and zeros otherwise pass everything."""

    b_0: Lanes
    b_1: Lanes
    b_2: Lanes
    a_1: Lanes
    a_2: Lanes


PASS = Biquad(b_0=1.0, b_1=0.0, b_2=0.0, a_1=0.0, a_2=0.0)
"""No filter."""


def sampled_notch(*, frequency: float, damping: float, gain: float) -> Biquad:
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
    return Biquad(
        b_0=(1.0 + zeros + square) * scale,
        b_1=turn,
        b_2=(1.0 - zeros + square) * scale,
        a_1=turn,
        a_2=(1.0 - poles + square) * scale,
    )


def sampled_filter(
    *, zeros_frequency: float, zeros_damping: float, poles_frequency: float, poles_damping: float
) -> Biquad:
    """Return a filter of second order, sampled: bilinear, each pair exact at its own frequency.

    ``B(s) = (s^2/omega_z^2 + 2 zeta_z s/omega_z + 1)/(s^2/omega_p^2 + 2 zeta_p s/omega_p + 1)``,
    whose gain at rest is 1: a notch where both frequencies are the same and the zeros are less
    damped, a lead where the zeros lie lower, a low-pass without zeros.

    Parameters
    ----------
    zeros_frequency, poles_frequency : float
        omega/(2 pi), Hz, below half the control rate. 0 is none: of the zeros, the numerator is 1;
        of the poles, there is no filter.
    zeros_damping, poles_damping : float
        zeta.
    """
    if poles_frequency == 0.0:
        return PASS
    top = _pair(zeros_frequency, zeros_damping)
    bottom = _pair(poles_frequency, poles_damping)
    scale = 1.0 / bottom[0]
    return Biquad(
        b_0=scale * top[0],
        b_1=scale * top[1],
        b_2=scale * top[2],
        a_1=scale * bottom[1],
        a_2=scale * bottom[2],
    )


def _pair(frequency: float, damping: float) -> tuple[float, float, float]:
    """Return ``(z + 1)^2 (s^2/omega^2 + 2 zeta s/omega + 1)`` by powers of z, from 2 down."""
    if frequency == 0.0:
        return 1.0, 2.0, 1.0
    rate = 1.0 / math.tan(math.pi * frequency * CONTROL_PERIOD)
    square, slope = rate * rate, 2.0 * damping * rate
    return square + slope + 1.0, 2.0 - 2.0 * square, square - slope + 1.0


@compiled
def filtered(biquad: Biquad, signal: Lanes, n_1: Lanes, n_2: Lanes) -> tuple[Lanes, Lanes, Lanes]:
    """Return what the filter makes of `signal`, N, and its next two states, N."""
    passed = biquad.b_0 * signal + n_1
    return (
        passed,
        biquad.b_1 * signal - biquad.a_1 * passed + n_2,
        biquad.b_2 * signal - biquad.a_2 * passed,
    )
