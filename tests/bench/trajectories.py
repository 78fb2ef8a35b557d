"""Time-optimal motion profiles beside the seven phases along the same path."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from typing import Any

import numpy as np

import motionlab
from motionlab.config.drawn_path import DrawnPath
from motionlab.config.load import epochs, load_scenario
from motionlab.config.planar import AXES
from motionlab.config.planned_motor import PlannedMotor
from motionlab.exchange.paths.reading import ReadOptions, read_trajectory
from motionlab.simulation.prepare import limit_sets, planned_for
from motionlab.trajectories.reference import sample
from tests.bench.table import Row
from tests.trajectories.random_splines import largest_shares, random_splines, time_optimal

_BY_LIMITS = {"v_max": 0.05, "a_max": 0.3, "j_max": 20.0}
_BY_THRUST = {"v_max": 0.5, "a_max": 5.0, "j_max": 200.0}
_POINTS = 200
_SEGMENTS = 5000
_REPETITIONS = 3
_SPLINES = 64
_LEAST_SHARE = 0.6
_AT_LIMIT = 0.95
_FAST = {"v_max": 1.0, "a_max": 10.0, "j_max": 2000.0}
_LOOPS: dict[str, dict[str, Any]] = {
    "K = 0": {},
    "lugre-full": {"variants.B.controller": "lugre-full"},
}


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
    yield _converging(motor)
    yield from _with_reserve()


def _converging(motor: PlannedMotor) -> Row:
    """Plan random splines; almost every tick of a time-optimal motion is at a limit."""
    limits = limit_sets(tuple(epochs(load_scenario("circle"))))[0][1]
    shares, taken = [], []
    for path in random_splines(seed=64, count=_SPLINES):
        fast = time_optimal(path, motor)
        before = time.process_time()
        reference = sample(fast)
        taken.append(time.process_time() - before)
        at_limit = np.mean(largest_shares(reference, path, limits) >= _AT_LIMIT)
        shares.append(0.0 if reference.notes else float(at_limit))
    met = sum(share >= _LEAST_SHARE for share in shares)
    usual, most = np.percentile(taken, (50, 95)) * 1e3
    return Row(
        f"time-optimal, {_SPLINES} random splines converged",
        f"{_SPLINES}",
        f"{met}",
        f"least share of ticks at a limit: {min(shares):.2f}",
        f"p50 {usual:.0f} ms, p95 {most:.0f} ms",
        met == _SPLINES,
    )


def _with_reserve() -> Iterator[Row]:
    """Run splines at the limit of thrust under B, without and with a reserve for feedback."""
    for name, set_ in _LOOPS.items():
        for reserve in (0.0, 0.12, 0.3):
            worst, limited, ticks = 0.0, 0, 0
            for path in random_splines(seed=902, count=8):
                motion = path | _FAST | {"kind": "path", "law": "time_optimal"}
                run = motionlab.run(
                    "circle", set={"trajectory": motion, "thrust_reserve": reserve} | set_
                )
                # NaN after a divergence counts as limited.
                free = [run[f"B.{axis}.current_saturated"] == 0.0 for axis in AXES]
                limited += int((~np.min(free, axis=0)).sum())
                ticks += len(free[0])
                errors = [run[f"B.{axis}.following_error"] for axis in AXES]
                worst = max(worst, float(np.nanmax(np.abs(errors))))
            yield Row(
                f"splines at the limit of thrust, {name}, reserve {reserve:.0%}",
                "",
                f"{worst * 1e6:.0f} um",
                f"currents limited: {limited / ticks:.1%} of ticks",
                "",
                True,
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
