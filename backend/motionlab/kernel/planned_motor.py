"""The limits of a motor that time-optimal profiles are planned for."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motionlab.config.controller import ModelConfig
from motionlab.config.planar import AXES
from motionlab.config.planned_motor import PlannedAxis, PlannedMotor
from motionlab.config.plant import PlantConfig
from motionlab.kernel.force_maps import pole_pitch
from motionlab.trajectories.motion_limits import MotionLimits

_POSITIONS = 96  # of a table
_BETWEEN = 16  # positions at which each of its cells is compared with the map
_DECIMALS = 4  # of a thrust in N


def planned_motor(
    plant: PlantConfig, decided: Sequence[tuple[ModelConfig, MotionLimits]]
) -> PlannedMotor:
    """Return the limits that hold with every controller.

    Interpolated linearly, the thrust is nowhere more than what is available.

    Parameters
    ----------
    plant : PlantConfig
        The plant.
    decided : sequence of (ModelConfig, MotionLimits)
        Force maps of each controller's model, and the limits that they lead to.
    """
    axes = []
    for index, name in enumerate(AXES):
        axis = getattr(plant, name)
        friction = axis.friction.parameters()
        pitches = [pole_pitch(getattr(model, name).force_map) for model, _ in decided]
        limits = [each for _, each in decided]
        backward, forward = (_thrusts(index, sign, limits, pitches) for sign in (-1.0, 1.0))
        axes.append(
            PlannedAxis(
                velocity_max=axis.velocity_max,
                acceleration_max=axis.acceleration_max,
                mass=axis.mass,
                F_c=friction.F_c,
                F_s=friction.F_s,
                v_s=friction.v_s,
                sigma_2=friction.sigma_2,
                pitch=pitches[0],
                forward=forward,
                backward=backward,
            )
        )
    return PlannedMotor(x=axes[0], y=axes[1])


def _thrusts(
    axis: int, sign: float, limits: Sequence[MotionLimits], pitches: Sequence[float]
) -> tuple[float, ...]:
    """Return the least thrust over a pole pitch, or everywhere where the pitches differ."""
    tables = [_table(axis, sign, each, pitch) for each, pitch in zip(limits, pitches, strict=True)]
    least = np.min(tables, axis=0)
    if len(set(pitches)) > 1:
        least = np.full_like(least, least.min())
    scale = 10**_DECIMALS
    return tuple(math.floor(value * scale) / scale for value in least.tolist())


def _table(axis: int, sign: float, limits: MotionLimits, pitch: float) -> NDArray[np.float64]:
    """Return thrusts between which a straight line never exceeds what is available, N."""
    count = _POSITIONS * _BETWEEN
    places = np.arange(count, dtype=np.float64) * (pitch / count)
    there = limits.available_thrust(axis, places, np.full(count, sign, dtype=np.float64))
    values = there[::_BETWEEN].copy()
    along = np.arange(_BETWEEN) / _BETWEEN
    line = values[:, None] + (np.roll(values, -1) - values)[:, None] * along
    beyond = np.maximum(line - there.reshape(_POSITIONS, _BETWEEN), 0.0).max(axis=1)
    return np.maximum(values - np.maximum(beyond, np.roll(beyond, 1)), 0.0)
