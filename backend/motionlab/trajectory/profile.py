r"""Time laws: how far along its path a motion is at each instant.

A law returns the path parameter and its first two derivatives. It does not know the unit of time:
`u` and every duration share one unit, and the derivatives are per that unit. Callers count in whole
control periods, so that the corners of a law fall on ticks exactly.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motionlab.config.timing import CONTROL_PERIOD

Samples = NDArray[np.float64]
Law = tuple[Samples, Samples, Samples]
"""Path parameter, its rate and its second derivative, each of the shape of `u`."""

_PEAK_RATE = 15 / 8
_PEAK_CURVATURE = 10 / math.sqrt(3)
_ROUNDING = 1e-9


def minimum_jerk(u: Samples, duration: float) -> Law:
    r"""Go from 0 to 1 at rest at both ends, with the least integral of squared jerk.

    .. math:: s = 10 r^3 - 15 r^4 + 6 r^5, \quad r = u / duration

    The rate peaks at 15/8 of the mean, the second derivative at 10/sqrt(3) / duration^2.

    Parameters
    ----------
    u : ndarray
        Time since the start, 0 <= u <= duration.
    duration : float
        Time from start to end, > 0.

    Returns
    -------
    tuple of ndarray
        s, ds/du and d2s/du2.

    References
    ----------
    Flash, Hogan, "The coordination of arm movements", J. Neurosci. 1985.
    """
    r = u / duration
    s = r**3 * (10 - 15 * r + 6 * r**2)
    rate = 30 * r**2 * (1 - r) ** 2 / duration
    second = 60 * r * (1 - r) * (1 - 2 * r) / duration**2
    return s, rate, second


def trapezoidal(u: Samples, ramp: float, cruise: float) -> Law:
    r"""Go from 0 to 1 with constant acceleration, constant velocity, constant deceleration.

    .. math:: \dot s_{max} = \frac{1}{ramp + cruise}, \quad
              \ddot s_{max} = \frac{\dot s_{max}}{ramp}

    Parameters
    ----------
    u : ndarray
        Time since the start, 0 <= u <= 2 ramp + cruise.
    ramp : float
        Time of acceleration, and of deceleration, > 0.
    cruise : float
        Time at constant velocity, >= 0; zero makes the velocity a triangle.

    Returns
    -------
    tuple of ndarray
        s, ds/du and d2s/du2; at a corner the second derivative is that of the phase that begins,
        and at the very end that of the deceleration.
    """
    total = 2 * ramp + cruise
    top_rate = 1 / (ramp + cruise)
    left = total - u
    speeding_up = u < ramp
    slowing_down = u >= ramp + cruise
    s = np.where(
        speeding_up,
        top_rate * u**2 / (2 * ramp),
        np.where(slowing_down, 1 - top_rate * left**2 / (2 * ramp), top_rate * (u - ramp / 2)),
    )
    rate = top_rate * np.minimum(1.0, np.minimum(u, left) / ramp)
    second = (top_rate / ramp) * (speeding_up.astype(np.float64) - slowing_down)
    return s, rate, second


def smooth_start(u: Samples, lead_in: float) -> Law:
    r"""Let a clock start from rest and run at full rate after the lead-in.

    The rate is the minimum-jerk polynomial, so the path's velocity and acceleration both start from
    zero and nothing jumps where the lead-in ends:

    .. math:: \dot w = 10 r^3 - 15 r^4 + 6 r^5, \quad
              w = lead\_in \cdot r^4 (5/2 - 3 r + r^2), \quad r = \min(1, u / lead\_in)

    The clock stays lead_in/2 behind `u` ever after.

    Parameters
    ----------
    u : ndarray
        Time since the start, u >= 0.
    lead_in : float
        Time until full rate, >= 0; zero starts at full rate.

    Returns
    -------
    tuple of ndarray
        w, dw/du and d2w/du2.
    """
    if lead_in == 0:
        return u.astype(np.float64), np.ones(u.shape), np.zeros(u.shape)
    r = np.minimum(u / lead_in, 1.0)
    w = lead_in * r**4 * (2.5 - 3 * r + r**2) + np.maximum(u - lead_in, 0.0)
    rate = r**3 * (10 - 15 * r + 6 * r**2)
    second = 30 * r**2 * (1 - r) ** 2 / lead_in
    return w, rate, second


def minimum_jerk_ticks(length: float, *, v_max: float, a_max: float) -> int:
    """Find the shortest minimum-jerk move within both limits.

    Parameters
    ----------
    length : float
        Length of the straight path, m, > 0.
    v_max, a_max : float
        Limits of velocity, m/s, and acceleration, m/s^2, along the path.

    Returns
    -------
    int
        Duration in whole control periods, rounded up.
    """
    duration = max(_PEAK_RATE * length / v_max, math.sqrt(_PEAK_CURVATURE * length / a_max))
    return _ticks_at_least(duration)


def trapezoidal_ticks(length: float, *, v_max: float, a_max: float) -> tuple[int, int]:
    """Find the shortest trapezoidal move within both limits whose corners fall on ticks.

    Rounding up lengthens the phases, so the realised velocity and acceleration lie slightly below
    the limits and the move still ends exactly at its end.

    Parameters
    ----------
    length : float
        Length of the straight path, m, > 0.
    v_max, a_max : float
        Limits of velocity, m/s, and acceleration, m/s^2, along the path.

    Returns
    -------
    ramp, cruise : int
        Whole control periods of each ramp and of the cruise between them.
    """
    ramp = _ticks_at_least(v_max / a_max)
    if length >= v_max * ramp * CONTROL_PERIOD:
        return ramp, max(_ticks_at_least(length / v_max) - ramp, 0)
    return _ticks_at_least(math.sqrt(length / a_max)), 0


def _ticks_at_least(seconds: float) -> int:
    """Round a duration up to whole control periods, forgiving the rounding of the division."""
    return max(1, math.ceil(seconds / CONTROL_PERIOD * (1 - _ROUNDING)))
