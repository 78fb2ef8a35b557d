"""Friction of one axis taken apart: what the motor has, what the controller believes, what it adds.

LuGre friction, eqs (20) to (22), has two faces. Sliding, it follows the Stribeck curve over the
velocity. After a reversal the bristles bend the other way first, and friction is a spring over the
displacement: presliding, a hysteresis loop whose slope where it crosses zero is sigma_0 in a slow
motion, and more in a quick one, to which bristle damping sigma_1 adds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.glitches import reversals
from motionlab.plant.friction import LuGre, steady_friction

Array = NDArray[np.float64]

PRESLIDING = 5.0
"""Length of presliding, in F_s/sigma_0: by then the bristles of a slow motion slide."""

PRESLIDING_UNKNOWN = 1e-4
"""The same where the motor's friction is not known, m."""

NEAR_ZERO = 0.25
"""Of the breakaway force: up to which friction the slope of the loop about zero is taken."""

VELOCITIES = 101
"""Points of a Stribeck curve in each direction."""

_BEYOND = 1.1
"""How far a Stribeck curve reaches, in largest velocities that there are ..."""
_STRIBECK = 2.2
"""... and in Stribeck velocities at least: there the fall from F_s to F_c is over."""
_LEAST = 4
"""Least samples of a slope."""


class Branch(NamedTuple):
    """Motion from one turn of an axis to the next.

    Samples [start, stop) go in `direction`, 1 or -1, from the position `turn`, m.
    """

    start: int
    stop: int
    direction: int
    turn: float


class Presliding(NamedTuple):
    """Medians over the reversals, None where none can tell.

    `breakaway` is the largest friction in the new direction within presliding, N; `stiffness` is
    the slope of friction over displacement where friction crosses zero, N/m.
    """

    breakaway: float | None
    stiffness: float | None


def stribeck_curve(friction: LuGre, velocity: Array) -> Array:
    """Return the friction of uniform motion, N, at velocities, m/s: eqs (20) to (22), dz/dt = 0."""
    return steady_friction(
        velocity, friction.F_c, friction.F_s, friction.v_s, friction.sigma_2
    ).astype(np.float64)


def stribeck_velocities(reached: float, v_s: Sequence[float]) -> Array:
    """Return the velocities of a Stribeck curve, m/s: rising, finer towards zero, without zero.

    Parameters
    ----------
    reached : float
        Largest speed that there is, m/s.
    v_s : sequence of float
        Stribeck velocities of the curves, m/s.
    """
    most = max(_BEYOND * reached, *(_STRIBECK * each for each in v_s))
    half = most * (np.arange(1, VELOCITIES + 1) / VELOCITIES) ** 2
    return np.concatenate([-half[::-1], half])


def mismatch(friction: Array, estimate: Array) -> tuple[float, float]:
    """Return RMS and largest size of estimate less friction, N."""
    error = estimate - friction
    return math.sqrt(float(np.mean(error**2))), float(np.abs(error).max())


def compensated(friction: Array, compensation: Array) -> float | None:
    """Return ``1 - RMS(f_f - f_c)/RMS(f_f)``, below 0 where compensation does harm.

    Parameters
    ----------
    friction, compensation : ndarray, shape (samples,)
        True friction and the force that is commanded against it, N.

    Returns
    -------
    float or None
        None where there is no friction.
    """
    whole = float(np.mean(friction**2))
    if whole == 0.0:
        return None
    return 1.0 - math.sqrt(float(np.mean((friction - compensation) ** 2)) / whole)


def branches(velocity_reference: Array, position: Array) -> list[Branch]:
    """Return the motions that begin with a reversal of the reference.

    Parameters
    ----------
    velocity_reference : ndarray, shape (samples,)
        Of the axis, m/s; it says where the axis is to turn.
    position : ndarray, shape (samples,)
        True position, m; its extremum before the next reversal is where the axis does turn.
    """
    return [
        Branch(tick, end, way, way * float((way * position[tick:end]).min()))
        for tick, way, end in reversals(velocity_reference)
    ]


def displacement(parts: Sequence[Branch], position: Array) -> Array:
    """Return the way from the last turn, in the direction of motion, m; NaN before the first."""
    away = np.full(len(position), np.nan)
    for start, stop, way, turn in parts:
        away[start:stop] = way * (position[start:stop] - turn)
    return away


def presliding(
    parts: Sequence[Branch], position: Array, friction: Array, length: float
) -> Presliding:
    """Return breakaway force and stiffness of the loops that reversals begin.

    A motion that does not leave presliding before the next reversal tells neither.

    Parameters
    ----------
    found : sequence of Branch
        From `branches`.
    position : ndarray, shape (samples,)
        True position, m.
    friction : ndarray, shape (samples,)
        Friction, or its estimate, N.
    length : float
        Displacement that presliding takes, m.
    """
    peaks: list[float] = []
    slopes: list[float] = []
    for start, stop, way, turn in parts:
        away = way * (position[start:stop] - turn)
        beyond = np.flatnonzero(away > length)
        if len(beyond) == 0:
            continue
        within = slice(0, int(beyond[0]) + 1)
        away, force = away[within], way * friction[start:stop][within]
        top = int(force.argmax())
        if force[top] <= 0.0:
            continue
        peaks.append(float(force[top]))
        first = int(away[: top + 1].argmin())
        rise = slice(first, top + 1)
        near = np.abs(force[rise]) <= NEAR_ZERO * force[top]
        if np.count_nonzero(near) >= _LEAST and np.ptp(away[rise][near]) > 0.0:
            slopes.append(float(np.polyfit(away[rise][near], force[rise][near], 1)[0]))
    return Presliding(
        float(np.median(peaks)) if peaks else None, float(np.median(slopes)) if slopes else None
    )


def spread_evenly(curves: Sequence[Array], most: int) -> NDArray[np.int64]:
    """Return samples that are about equally far apart along curves over time.

    Each curve, and time, counts as long as its range; so quick changes get many samples, and rest
    few. All samples where there are no more than `most`.

    Parameters
    ----------
    curves : sequence of ndarray, each of shape (samples,)
        What is drawn.
    most : int
        Number of samples, 2 or more.
    """
    count = len(curves[0])
    if count <= most:
        return np.arange(count)
    length = np.full(count - 1, 1.0 / (count - 1))
    for curve in curves:
        range_ = float(np.ptp(curve))
        if range_ > 0.0:
            length += np.abs(np.diff(curve)) / range_
    along = np.concatenate([[0.0], np.cumsum(length)])
    targets = np.linspace(0.0, along[-1], most)
    return np.unique(np.searchsorted(along, targets).clip(0, count - 1)).astype(np.int64)
