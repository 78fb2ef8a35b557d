"""The field of three phases that pull one after the other: a table of currents, as a stepper's.

One phase with current draws the mover to where it is aligned; two share an angle between them.
Angles are electrical, in thirds of a turn: 0 for phase a, 1 for b, 2 for c, 3 for a again, one
pitch on.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motionlab.config.controller import ModelConfig
from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.kernel.force_maps import pole_pitch
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]

SCENARIO, VARIANT = "circle", "A"
"""Whose controller and whose force map commissioning takes."""

DRAW = 0.3
"""Largest current that draws the mover, of the largest current of the axis."""

EDGE = 0.2
"""Time in which a field reaches its speed, s."""

_LARGEST = 2.0 / math.sqrt(3.0)  # force of one of two phases, of what both have together


def reference_model() -> ModelConfig:
    """Return the model of the controller that commissioning takes."""
    return load_scenario(SCENARIO).variants[VARIANT].controller.model


class Field:
    """Pole pitch and aligned positions of an axis, as the force map of the controller has them."""

    def __init__(self, axis: str, model: ModelConfig) -> None:
        force_map = getattr(model, axis).force_map
        self.pitch = float(pole_pitch(force_map))
        self._aligned = self.pitch / 2.0 - getattr(force_map, "offset", 0.0)

    def position(self, angle: float) -> float:
        """Return the position that is aligned with a field at an angle, m."""
        return self._aligned + self.pitch * angle / 3.0

    def angle(self, position: float) -> float:
        """Return the angle of a field that is aligned with a position, m."""
        return 3.0 * (position - self._aligned) / self.pitch


def turned(begin: float, end: float, speed: float) -> Array:
    """Return angles from one to another at a speed, thirds of a turn and a second.

    Speed rises and falls evenly over `EDGE`, or over half of the time where that is short.
    """
    way = abs(end - begin)
    edge = max(min(EDGE, way / speed), CONTROL_PERIOD)
    whole = way / speed + edge
    ticks = max(int(np.ceil(whole / CONTROL_PERIOD)), 1)
    t = whole * np.arange(1, ticks + 1) / ticks
    left = whole - t
    gone = np.where(
        t < edge,
        t**2 / (2 * edge),
        np.where(left < edge, way / speed - left**2 / (2 * edge), t - edge / 2),
    )
    return begin + np.sign(end - begin) * speed * gone


def held(angle: float, seconds: float) -> Array:
    """Return an angle for some time."""
    return np.full(round(seconds / CONTROL_PERIOD), float(angle))


def drawn(angles: Array, current: float, ramp: float = 0.3) -> Array:
    """Return the currents of a field along angles: from zero up, along, and down to zero.

    Thrust of a phase grows with the square of a current that is small. With ``u`` of a third of a
    turn from the phase before, two phases have the shares ``sin(2 pi (1 - u)/3)`` and
    ``sin(2 pi u/3)`` of one force in the direction of the angle.

    Parameters
    ----------
    angles : ndarray, shape (ticks,)
        Thirds of a turn.
    current : float
        Largest current of a phase, A.
    ramp : float
        Time up and down, s.

    Returns
    -------
    ndarray, shape (ticks, 3)
        Currents of a, b, c, A.
    """
    count = round(ramp / CONTROL_PERIOD)
    up = np.linspace(0.0, 1.0, count, endpoint=False)
    share = np.concatenate((up, np.ones(len(angles)), up[::-1]))
    angles = np.concatenate((np.full(count, angles[0]), angles, np.full(count, angles[-1])))
    before = np.floor(angles)
    u = angles - before
    currents = np.zeros((len(angles), 3))
    ticks, phase = np.arange(len(angles)), before.astype(int) % 3
    third = 2.0 * np.pi / 3.0
    for place, force in ((phase, np.sin(third * (1 - u))), ((phase + 1) % 3, np.sin(third * u))):
        currents[ticks, place] += current * share * np.sqrt(force / (_LARGEST * math.sin(third)))
    return currents


def of_axis(currents: Array, axis: int) -> Array:
    """Return currents of one axis, the other without: shape (ticks, 3, 2)."""
    both = np.zeros((len(currents), 3, len(AXES)))
    both[:, :, axis] = currents
    return both
