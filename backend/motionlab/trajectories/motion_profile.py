r"""Motion profiles: how far along its path a motion is at each instant.

A law returns the path parameter and its first two derivatives. It does not know the unit of time:
`u` and every duration share one unit, and the derivatives are per that unit. Callers count in whole
control periods, so that the corners of a law fall on ticks exactly.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import cached
from motionlab.timing import CONTROL_PERIOD

Samples = NDArray[np.float64]
Law = tuple[Samples, Samples, Samples]
"""Path parameter, its rate and its second derivative, each of the shape of `u`."""
Instant = tuple[float, float, float]
"""The same at one instant."""

_PEAK_RATE = 15 / 8
_PEAK_CURVATURE = 10 / math.sqrt(3)
_ROUNDING = 1e-9


@cached
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
    law = np.empty_like(u), np.empty_like(u), np.empty_like(u)
    for k in range(len(u)):
        law[0][k], law[1][k], law[2][k] = minimum_jerk_at(u[k], duration)
    return law


@cached
def minimum_jerk_at(u: float, duration: float) -> Instant:
    """Return `minimum_jerk` at one instant."""
    r = u / duration
    left = 1 - r
    square = r * r
    s = square * r * (10 - 15 * r + 6 * square)
    rate = 30 * square * (left * left) / duration
    second = 60 * r * left * (1 - 2 * r) / duration**2
    return s, rate, second


@cached
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
    law = np.empty_like(u), np.empty_like(u), np.empty_like(u)
    for k in range(len(u)):
        law[0][k], law[1][k], law[2][k] = trapezoidal_at(u[k], ramp, cruise)
    return law


@cached
def trapezoidal_at(u: float, ramp: float, cruise: float) -> Instant:
    """Return `trapezoidal` at one instant."""
    top_rate = 1 / (ramp + cruise)
    left = 2 * ramp + cruise - u
    rate = top_rate * min(1.0, min(u, left) / ramp)
    if u < ramp:
        return top_rate * (u * u) / (2 * ramp), rate, top_rate / ramp
    if u >= ramp + cruise:
        return 1 - top_rate * (left * left) / (2 * ramp), rate, -(top_rate / ramp)
    return top_rate * (u - ramp / 2), rate, 0.0


@cached
def jerk_limited(u: Samples, jerk: float, ramp: float, travel: float) -> Law:
    r"""Go from 0 to 1 with constant jerk, acceleration or velocity in each of seven phases.

    The velocity is a box of width `travel` averaged over `ramp` and then over `jerk`, so that

    .. math:: \dot s_{max} = \frac{1}{travel}, \quad
              \ddot s_{max} = \frac{\dot s_{max}}{ramp}, \quad
              \dddot s_{max} = \frac{\ddot s_{max}}{jerk}

    and the move takes travel + ramp + jerk.

    Parameters
    ----------
    u : ndarray
        Time since the start, 0 <= u <= travel + ramp + jerk.
    jerk : float
        Time of each of the four phases of jerk, > 0.
    ramp : float
        Time in which the velocity would be reached without limit of jerk, >= jerk.
    travel : float
        Time that the way would take at full velocity, >= ramp + jerk.

    Returns
    -------
    tuple of ndarray
        s, ds/du and d2s/du2.
    """
    law = np.empty_like(u), np.empty_like(u), np.empty_like(u)
    for k in range(len(u)):
        law[0][k], law[1][k], law[2][k] = jerk_limited_at(u[k], jerk, ramp, travel)
    return law


@cached
def jerk_limited_at(u: float, jerk: float, ramp: float, travel: float) -> Instant:
    """Return `jerk_limited` at one instant."""
    total = travel + ramp + jerk
    slowing_down = u > total / 2
    t = total - u if slowing_down else u
    scale = 1 / (6 * travel * ramp * jerk)
    a, b, c = max(t - jerk, 0.0), max(t - ramp, 0.0), max(t - (ramp + jerk), 0.0)
    s = scale * (t**3 - a**3 - b**3 + c**3)
    rate = 3 * scale * (t**2 - a**2 - b**2 + c**2)
    second = 6 * scale * (t - a - b + c)
    return (1 - s, rate, -second) if slowing_down else (s, rate, second)


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
    return ticks_at_least(duration)


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
    ramp = ticks_at_least(v_max / a_max)
    if length >= v_max * ramp * CONTROL_PERIOD:
        return ramp, max(ticks_at_least(length / v_max) - ramp, 0)
    return ticks_at_least(math.sqrt(length / a_max)), 0


def jerk_limited_ticks(
    length: float, *, v_max: float, a_max: float, j_max: float
) -> tuple[int, int, int]:
    """Find the shortest jerk-limited move within all limits whose corners fall on ticks.

    Parameters
    ----------
    length : float
        Length of the path, m, > 0.
    v_max, a_max, j_max : float
        Limits of velocity, m/s, acceleration, m/s^2, and jerk, m/s^3, along the path.

    Returns
    -------
    jerk, ramp, travel : int
        Whole control periods as `jerk_limited` takes them.
    """
    jerk, ramp, travel = jerk_limited_times(length, v_max=v_max, a_max=a_max, j_max=j_max)
    whole_jerk = ticks_at_least(jerk)
    whole_ramp = max(whole_jerk, ticks_at_least(ramp))
    return whole_jerk, whole_ramp, max(whole_jerk + whole_ramp, ticks_at_least(travel))


def jerk_limited_times(
    length: float, *, v_max: float, a_max: float, j_max: float
) -> tuple[float, float, float]:
    """Find the fastest jerk-limited move within all limits.

    Parameters
    ----------
    length : float
        Length of the path, m, > 0.
    v_max, a_max, j_max : float
        Limits of velocity, m/s, acceleration, m/s^2, and jerk, m/s^3, along the path.

    Returns
    -------
    jerk, ramp, travel : float
        Times as `jerk_limited` takes them, s.
    """
    jerk = a_max / j_max
    ramp = v_max / a_max
    if ramp < jerk:  # full acceleration is never reached
        jerk = ramp = math.sqrt(v_max / j_max)
    travel = length / v_max
    if travel < ramp + jerk:  # full velocity is never reached
        jerk = a_max / j_max
        ramp = 0.5 * (math.sqrt(jerk**2 + 4 * length / a_max) - jerk)
        if ramp < jerk:
            jerk = ramp = (length / (2 * j_max)) ** (1 / 3)
        travel = ramp + jerk
    return jerk, ramp, travel


def cruise_ticks(length: float, *, v_max: float, a_max: float) -> tuple[int, int]:
    """Find the fastest run at constant speed with a smooth start and stop within both limits.

    The speed rises and falls as in `smooth_start`; its acceleration peaks at 15/8 of the mean.

    Parameters
    ----------
    length : float
        Length of the path, m, > 0.
    v_max, a_max : float
        Limits of velocity, m/s, and acceleration, m/s^2, along the path.

    Returns
    -------
    ramp, travel : int
        Whole control periods of each ramp and of the whole path at full speed, travel >= ramp.
    """
    travel = length / v_max
    ramp = _PEAK_RATE * v_max / a_max
    if travel < ramp:
        travel = ramp = math.sqrt(_PEAK_RATE * length / a_max)
    whole_ramp = ticks_at_least(ramp)
    return whole_ramp, max(whole_ramp, ticks_at_least(travel))


def ticks_at_least(seconds: float) -> int:
    """Round a duration up to whole control periods, forgiving the rounding of the division."""
    return max(1, math.ceil(seconds / CONTROL_PERIOD * (1 - _ROUNDING)))


@cached
def mean_acceleration(acceleration: float, now: float, before: float) -> float:
    """Return the analytic acceleration or, where it is larger, the one from the tick before."""
    mean = (now - before) / CONTROL_PERIOD
    return acceleration if abs(acceleration) >= abs(mean) else mean
