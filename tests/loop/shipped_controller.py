"""The best controller shipped, on the circle with a resonance: what test and bench measure."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from motionlab.config.load import load_scenario
from motionlab.loop.family import SPEEDS
from motionlab.loop.linearise import SLIDING, linearise
from motionlab.loop.margins import margins
from tests.simulated import play

SCENARIO, VARIANT = "circle-resonant", "B"
PLACES = 8
POLE_PITCH = 7.2e-3  # m
TARGETS = {"x": (1.5e-6, 1.6e-6), "y": (2.5e-6, 3.0e-6)}
"""Largest following error at mid-stroke, and anywhere in the pole pitch, m."""
GAIN_MARGIN, PHASE_MARGIN = 6.0, 30.0
"""dB, degrees"""


class LoopMargins(NamedTuple):
    """Margins of one loop, the smaller of more and of less gain."""

    gain: float  # dB
    phase: float  # degrees


def errors_over_the_pitch() -> list[dict[str, float]]:
    """Return the largest following error per axis, m, by the circle's centre; mid-stroke first."""
    found = []
    for place in range(PLACES):
        shift = place * POLE_PITCH / PLACES
        played = play(
            SCENARIO, {"trajectory.center.x": shift, "trajectory.center.y": shift}
        )  # the axes do not know of each other
        found.append({axis: played.largest_error(VARIANT, axis) for axis in "xy"})
    return found


def loop_margins(
    axis: str, velocity: float = SLIDING, changes: dict[str, Any] | None = None
) -> LoopMargins:
    """Return the margins while sliding at `velocity`, in Stribeck velocities of the truth."""
    scenario = load_scenario(SCENARIO, changes)
    v = velocity * getattr(scenario.plant, axis).friction.v_s
    loop = linearise(scenario, VARIANT, axis, v=v)
    if not loop.stable:
        return LoopMargins(-math.inf, -math.inf)
    m = margins(loop.open)
    factor = min(m.gain_margin or math.inf, 1.0 / (m.gain_reduction or 1e-9))
    assert m.phase_margin is not None
    return LoopMargins(20.0 * math.log10(factor), math.degrees(m.phase_margin))


def least_margins(axis: str, changes: dict[str, Any] | None = None) -> LoopMargins:
    """Return the least of both margins from 0.5 to 4 Stribeck velocities."""
    found = [loop_margins(axis, velocity, changes) for velocity in SPEEDS]
    return LoopMargins(min(m.gain for m in found), min(m.phase for m in found))
