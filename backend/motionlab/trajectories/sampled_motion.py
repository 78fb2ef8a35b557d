"""Motion through samples over time: a cubic spline, so that velocity and acceleration fit it."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from motionlab.config.samples import Samples
from motionlab.lanes import cached
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.motion import Piece
from motionlab.trajectories.motion_profile import smooth_start
from motionlab.trajectories.path import Array
from motionlab.trajectories.spline import locate

_ROUNDING = 1e-9


def sampled_motion(config: Samples) -> Piece:
    """Return the motion through samples over time, from rest at the first one to the last."""
    time = np.array(config.time) - config.time[0]
    place = np.column_stack((config.x, config.y))
    second = _second_derivatives(time, place)
    ticks = max(1, math.ceil(time[-1] / CONTROL_PERIOD * (1 - _ROUNDING)))
    return Piece(partial(_between, time, place, second), partial(smooth_start, lead_in=0), ticks)


@cached
def _second_derivatives(time: Array, place: Array) -> Array:
    """Return the second derivatives of the spline at its knots; it starts at rest."""
    n = len(time)
    diagonal, upper, right = np.empty(n), np.zeros(n), np.zeros((n, 2))
    width = time[1] - time[0]
    diagonal[0], upper[0] = 2.0 * width, width
    right[0] = 6.0 * (place[1] - place[0]) / width
    for k in range(1, n - 1):
        width, further = time[k] - time[k - 1], time[k + 1] - time[k]
        slope = (place[k + 1] - place[k]) / further - (place[k] - place[k - 1]) / width
        ratio = width / diagonal[k - 1]
        diagonal[k] = 2.0 * (width + further) - ratio * upper[k - 1]
        upper[k] = further
        right[k] = 6.0 * slope - ratio * right[k - 1]
    # The acceleration is constant between the last two samples.
    diagonal[n - 2] += upper[n - 2]
    upper[n - 2] = 0.0
    second = np.zeros((n, 2))
    for k in range(n - 2, -1, -1):
        second[k] = (right[k] - upper[k] * second[k + 1]) / diagonal[k]
    second[n - 1] = second[n - 2]
    return second


@cached
def _between(time: Array, place: Array, second: Array, ticks: Array) -> tuple[Array, Array, Array]:
    """Return places and their derivatives by ticks."""
    seconds = np.minimum(ticks * CONTROL_PERIOD, time[len(time) - 1])
    cell = locate(time, seconds)
    shape = len(ticks), 2
    at, slope, bend = np.empty(shape), np.empty(shape), np.empty(shape)
    for k in range(len(ticks)):
        i = cell[k]
        width = time[i + 1] - time[i]
        u = seconds[k] - time[i]
        v = time[i + 1] - seconds[k]
        for axis in range(2):
            before, after = second[i, axis], second[i + 1, axis]
            chord = (place[i + 1, axis] - place[i, axis]) / width
            bulge = u * v * (before * (width + v) + after * (width + u)) / (6.0 * width)
            at[k, axis] = place[i, axis] + chord * u - bulge
            left, right = 3.0 * v * v - width * width, 3.0 * u * u - width * width
            speed = chord - (before * left - after * right) / (6.0 * width)
            slope[k, axis] = speed * CONTROL_PERIOD
            bend[k, axis] = (before * v + after * u) / width * CONTROL_PERIOD**2
    return at, slope, bend
