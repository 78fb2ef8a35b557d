"""Theoretical errors, eqs (39) to (42): PD control of a mass without friction.

    E(s)/R(s) = M s^2/(M s^2 + k_d s + k_p)

Gains are SI: N/m and N s/m; the paper's k = 1000 mm/m is in them.
"""

from __future__ import annotations

import math
from typing import NamedTuple


class SineError(NamedTuple):
    """Following error in the steady state of a sine.

    Attributes
    ----------
    amplitude : float
        m.
    phase : float
        Of the error against the reference, rad, in (-pi, pi].
    """

    amplitude: float
    phase: float


def crossover(M: float, k_p: float, k_d: float) -> float:
    """Return the crossover frequency of eq. (39), rad/s.

    ``w_c = sqrt((k_d^2 + sqrt(k_d^4 + 4 M^2 k_p^2))/(2 M^2))``, where the open loop
    ``(k_d s + k_p)/(M s^2)`` has gain one.

    Parameters
    ----------
    M : float
        Moving mass, kg.
    k_p : float
        N/m.
    k_d : float
        N s/m.
    """
    return math.sqrt((k_d**2 + math.sqrt(k_d**4 + (2.0 * M * k_p) ** 2)) / 2.0) / M


def parabola_error(M: float, k_p: float, R: float) -> float:
    """Return the steady-state error of eq. (40) for R t^2, ``2 M R/k_p``, m; steps and ramps: 0.

    Parameters
    ----------
    M : float
        Moving mass, kg.
    k_p : float
        N/m.
    R : float
        Half of the acceleration, m/s^2.
    """
    return 2.0 * M * R / k_p


def sine_error(M: float, k_p: float, k_d: float, *, B: float, w: float) -> SineError:
    """Return the following error of ``B sin(w t)`` in the steady state, eqs (41) and (42).

    The amplitude is ``M w^2 B/sqrt((M w^2 - k_p)^2 + (w k_d)^2)``. The phase as
    printed in (42) needs the quadrant, and so a two-argument arc tangent:
    ``atan2(w k_d, M w^2 - k_p)``.

    Parameters
    ----------
    M : float
        Moving mass, kg.
    k_p : float
        N/m.
    k_d : float
        N s/m.
    B : float
        Amplitude of the reference, m.
    w : float
        Its angular frequency, rad/s.
    """
    stiffness, damping = M * w**2 - k_p, w * k_d
    amplitude = M * w**2 * B / math.hypot(stiffness, damping)
    return SineError(amplitude, math.atan2(damping, stiffness))
