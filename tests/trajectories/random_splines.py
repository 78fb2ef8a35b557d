"""Random splines, wave-like and closed ones, and limits along them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.planned_motor import PlannedMotor
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.motion_limits import MotionLimits, demands
from motionlab.trajectories.reference import Reference

LIMITS: tuple[dict[str, float], ...] = (
    {"v_max": 0.3, "a_max": 2.0, "j_max": 50.0},
    {"v_max": 0.5, "a_max": 5.0, "j_max": 200.0},
    {"v_max": 1.0, "a_max": 10.0, "j_max": 2000.0},
    {"v_max": 0.05, "a_max": 0.3, "j_max": 20.0},
)


def random_splines(seed: int, count: int) -> Iterator[dict[str, Any]]:
    """Yield paths with limits: by turns a wave over the stroke of x and a closed curve."""
    random = np.random.default_rng(seed)
    for index in range(count):
        if index % 2 == 0:
            x = np.linspace(-0.07, 0.07, random.integers(4, 10))
            y = random.uniform(-0.04, 0.04, len(x))
        else:
            corners = random.integers(4, 12)
            turns = np.arange(corners) / corners
            angle = 2 * math.pi * turns + random.uniform(-0.2, 0.2, corners)
            radius = random.uniform(0.012, 0.05, corners)
            x, y = radius * np.cos(angle), radius * np.sin(angle)
        points = np.column_stack((x, y)).round(4).tolist()
        path = {"points": points, "closed": index % 2 == 1, "geometry": "spline"}
        yield path | LIMITS[index // 2 % len(LIMITS)]


def time_optimal(path: dict[str, Any], motor: PlannedMotor) -> DrawnPath:
    """Return a path as fast as its limits and a motor allow."""
    table = path | {"law": "time_optimal", "planned_for": motor.model_dump()}
    return DrawnPath.model_validate(table)


def largest_shares(
    reference: Reference, path: dict[str, Any], limits: MotionLimits
) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return, for every tick, the largest share of any limit, along the path or of an axis."""
    speed = np.hypot(*reference.velocity.T)
    along = np.zeros(reference.ticks)
    np.divide(
        np.sum(reference.velocity * reference.acceleration, axis=1),
        speed,
        out=along,
        where=speed > 1e-9,
    )
    jerk = np.diff(along, prepend=0.0) / CONTROL_PERIOD
    shares = [
        speed / path["v_max"],
        np.abs(along) / path["a_max"],
        np.abs(jerk) / path["j_max"],
    ]
    for axis, demand in enumerate(demands(reference, limits)):
        asked = demand.samples
        signs = np.where(asked.thrust < 0.0, -1.0, 1.0)
        reach = limits.available_thrust(axis, asked.position.copy(), signs)
        shares += [
            np.abs(asked.thrust) / reach,
            np.abs(asked.velocity) / limits.v_max[axis],
            np.abs(asked.acceleration) / limits.a_max[axis],
        ]
    return np.max(shares, axis=0)
