"""Time-optimal motion profiles beside the seven phases along the same path."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import planned_for
from motionlab.trajectories.exchange.reading import ReadOptions, read_trajectory
from motionlab.trajectories.reference import sample
from tests.bench.table import Row

_BY_LIMITS = {"v_max": 0.05, "a_max": 0.3, "j_max": 20.0}
_BY_THRUST = {"v_max": 0.5, "a_max": 5.0, "j_max": 200.0}
_POINTS = 200
_SEGMENTS = 5000
_REPETITIONS = 3


def trajectories() -> Iterator[Row]:
    """Plan and sample a spline and a G-code file, bound by limits along the path or by thrust."""
    motor = planned_for(load_scenario("circle"))
    read = read_trajectory(_gcode(), ReadOptions(format="gcode")).trajectory
    assert isinstance(read, DrawnPath)
    paths: tuple[tuple[str, dict[str, Any], float], ...] = (
        (f"spline of {_POINTS} points", {"points": _flower(), "closed": True}, 0.1),
        (f"G-code of {_SEGMENTS} lines", {"points": read.points, "corners": read.corners}, 2.0),
    )
    for name, path, target in paths:
        for bound, limits in (("limits", _BY_LIMITS), ("thrust", _BY_THRUST)):
            table = path | {"geometry": "spline"} | limits
            fast = table | {"law": "time_optimal", "planned_for": motor.model_dump()}
            taken = _best(DrawnPath.model_validate(fast))
            reference = _best(DrawnPath.model_validate(table | {"law": "jerk_limited"}))
            yield Row(
                f"time-optimal, {name}, by {bound}",
                f"< {target:g} s",
                f"{taken:.3f} s",
                f"seven phases: {reference:.3f} s",
                f"{taken / reference:.1f}",
                taken < target,
            )


def _best(path: DrawnPath) -> float:
    """Return the processor's time, s: that of one thread on a machine without other work."""
    taken = []
    for _ in range(_REPETITIONS):
        before = time.process_time()
        sample(path)
        taken.append(time.process_time() - before)
    return min(taken)


def _flower() -> list[list[float]]:
    """Return points of a closed curve with narrow and wide bends, m."""
    angle = np.arange(_POINTS) * (2 * math.pi / _POINTS)
    radius = 0.03 * (1 + 0.25 * np.sin(5 * angle) + 0.1 * np.sin(11 * angle + 1))
    return np.column_stack((radius * np.cos(angle), radius * np.sin(angle))).tolist()


def _gcode() -> bytes:
    """Return short lines that turn by 20 to 180 degrees, each of which ends in a stop."""
    random = np.random.default_rng(2019)
    place, heading, lines = np.zeros(2), 0.0, ["G21 G90", "G0 X0 Y0", "G1 F6000"]
    while len(lines) < _SEGMENTS + 3:
        turned = heading + random.choice((-1.0, 1.0)) * random.uniform(math.pi / 9, math.pi)
        length = random.uniform(1.0, 6.0)
        then = place + length * np.array([math.cos(turned), math.sin(turned)])
        if abs(then[0]) < 70 and abs(then[1]) < 120:
            place, heading = then, turned
            lines.append(f"X{then[0]:.3f} Y{then[1]:.3f}")
    return "\n".join(lines).encode()
