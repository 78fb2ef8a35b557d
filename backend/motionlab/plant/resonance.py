"""A structural resonance: one flexible mode between the guides and the encoder.

The thrust, acting at a part of the mover that is not the one the encoder sees, excites the mode::

    d^2w/dt^2 + 2 zeta omega dw/dt + omega^2 w = F/M,    p_seen = p + kappa w

Friction, load and end stops act at the guides, a node of the mode, and depend on p alone. From
thrust to the seen position that is ``(1/s^2 + kappa/(s^2 + 2 zeta omega s + omega^2))/M``; kappa =
-1 is the far end of two masses on a spring.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from motionlab.lanes import Lanes, compiled


class Resonance(NamedTuple):
    """The mode of each lane, sampled at the plant's step; see `sampled`."""

    compliance: Lanes  # kappa/(M omega^2): deflection under a constant thrust, m/N
    hold: Lanes  # deflection after a step, of a deflection, 1
    drift: Lanes  # of a deflection rate, s
    pull: Lanes  # deflection rate after a step, of a deflection, 1/s
    keep: Lanes  # of a deflection rate, 1


def sampled(
    *, frequency: float, damping: float, coupling: float, mass: float, h: float
) -> Resonance:
    """Return the mode sampled at steps of `h` seconds: the exponential of its matrix, exactly.

    Parameters
    ----------
    frequency : float
        Undamped natural frequency omega/(2 pi), Hz.
    damping : float
        Damping ratio zeta, in [0, 1).
    coupling : float
        kappa; 0 is no resonance.
    mass : float
        M, kg.
    h : float
        Step, s.
    """
    omega = 2.0 * math.pi * frequency
    damped = omega * math.sqrt(1.0 - damping**2)
    fade = math.exp(-damping * omega * h)
    turn, swing = fade * math.cos(damped * h), fade * math.sin(damped * h) / damped
    return Resonance(
        compliance=coupling / (mass * omega**2),
        hold=turn + damping * omega * swing,
        drift=swing,
        pull=-(omega**2) * swing,
        keep=turn - damping * omega * swing,
    )


@compiled
def natural(resonance: Resonance, h: float) -> tuple[float, float]:
    """Return ``omega^2`` and ``2 zeta omega`` of a mode sampled at steps of `h` seconds."""
    fade = math.sqrt(resonance.hold * resonance.keep - resonance.drift * resonance.pull)
    turn = 0.5 * (resonance.hold + resonance.keep)
    rate = -math.log(fade) / h
    damped = math.acos(turn / fade) / h
    return rate**2 + damped**2, 2.0 * rate


@compiled
def ring(resonance: Resonance, y: Lanes, y_rate: Lanes, thrust: Lanes) -> tuple[Lanes, Lanes]:
    """Return the deflection ``y = kappa w``, m, and its rate, m/s, a step of constant `thrust` on.

    The mode swings about its deflection under that thrust, so the step is exact::

        y_n - y_F = hold (y - y_F) + drift dy/dt,   dy_n/dt = pull (y - y_F) + keep dy/dt
    """
    settled = resonance.compliance * thrust
    away = y - settled
    return (
        settled + (resonance.hold * away + resonance.drift * y_rate),
        resonance.pull * away + resonance.keep * y_rate,
    )
