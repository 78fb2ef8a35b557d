"""Accuracy of the integrator against the stiff solver, in closed loop."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from motionlab.simulation.kernel import SUBSTEPS
from tests.bench.table import Row
from tests.physics import lane_case
from tests.physics.nominal import CONTROL_PERIOD, Y_TRAPEZOID, Axis, X, Y
from tests.physics.stiff_reference import Loop

_TARGET = 5e-9  # m
_CIRCLE_TICKS = 15_000  # the lead-in and two laps
_TRAPEZOID_TICKS = 5_000  # one way and half a second at rest


def accuracy() -> Iterator[Row]:
    """Compare positions after every tick: ideal force held over the tick, exact encoder."""
    circle = lane_case.circle(_CIRCLE_TICKS)
    trapezoid = lane_case.trapezoid(_TRAPEZOID_TICKS)
    yield from _compare("circle", circle, X, Y, axes=(0, 1))
    yield from _compare("trapezoid", trapezoid, X, Y_TRAPEZOID, axes=(1,))


def _compare(
    name: str, motion: lane_case.Array, x: Axis, y: Axis, *, axes: tuple[int, ...]
) -> Iterator[Row]:
    lanes = lane_case.rows(lane_case.off_and_observer(x, y, lane_case.IDEAL))
    start = lane_case.at_rest(motion[0, 0])
    reached = lane_case.positions(lanes, start, lane_case.inputs(motion))
    for variant, compensated in enumerate((False, True)):
        for axis in axes:
            p_ref = motion[:, 0, axis]
            loop = Loop((x, y)[axis], float(p_ref[0]), compensated=compensated)
            difference = np.abs(reached[:, 2 * variant + axis] - loop.follow(p_ref))
            worst = float(difference.max())
            yield Row(
                f"{name} {'xy'[axis]}, {'observer' if compensated else 'PD alone'},"
                f" {len(motion) * CONTROL_PERIOD:g} s, {SUBSTEPS} substeps",
                f"<= {_TARGET * 1e9:g} nm",
                f"{worst * 1e9:.2f} nm",
                "scipy LSODA at 1e-10",
                "",
                worst <= _TARGET,
            )
