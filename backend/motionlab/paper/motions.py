"""Claims of section IV-A on the motions of Figs 6 to 8."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.moves import Staircase, Trapezoid
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.paper.bands import COUNT, STAIRCASE, TRAPEZOID
from motionlab.paper.experiments import Experiments, Run
from motionlab.paper.printed_number import Compute, PrintedNumber, RowResult, RowSource
from motionlab.paper.tracking import A_LAW, BASIS, MATCHED, TEXT, accuracy, edges

GROUP = TEXT

_TEXT = "IV-A"
_TRUE = "the true acceleration of the simulated motor, a mean over 0.5 ms: nothing to allow for"
_BY_ENCODER = "encoder differenced twice, good to 0.4 m/s^2"
_SMOOTH = "minimum jerk at the same speeds"

_EDGES = {
    "trapezoid-y": (-0.145, 0.145, -0.145),
    "stair-y-50mm": tuple(0.05 * k for k in (*range(6), *range(4, -1, -1))),
}
"""Where the y motions stop, m: the staircase's from its foot."""


def _smooth(scenario: str) -> dict[str, Any]:
    """Return changes from the trapezoidal motion profile to minimum jerk."""
    law = load_scenario(scenario).trajectory
    assert isinstance(law, Trapezoid | Staircase)
    foot = law.start.y - _EDGES[scenario][0]
    points = [(0.0, foot + y) for y in _EDGES[scenario]]
    smooth = {"kind": "waypoints", "points": points, "v_max": law.v_max, "a_max": law.a_max}
    return {"trajectory": smooth}


def _acceleration(run: Run, axis: str, channel: str) -> NDArray[np.float64]:
    """Return the mean acceleration of every control period, m/s^2, from a channel of velocity."""
    velocity = run.recording.variants["B"].channel(channel, axis).astype(np.float64)
    return np.diff(velocity) / CONTROL_PERIOD


def _largest_velocity(scenario: str, axis: str) -> Compute:
    """Return the largest value by the encoder over the main window, as in the paper."""

    def compute(experiments: Experiments) -> RowResult:
        run = experiments.run(scenario, MATCHED)
        window = slice(*run.prepared.window)
        velocity = run.recording.variants["B"].channel("velocity_measured", axis)[window]
        return RowResult(float(np.abs(velocity).max()))

    return compute


def _largest_acceleration(scenario: str, axis: str) -> Compute:
    """Return the largest over the main window: the motor's, and for comparison the encoder's."""

    def compute(experiments: Experiments) -> RowResult:
        run = experiments.run(scenario, MATCHED)
        start, stop = run.prepared.window
        true, shown = (
            float(np.abs(_acceleration(run, axis, channel)[start : stop - 1]).max())
            for channel in ("velocity", "velocity_measured")
        )
        return RowResult(true, {_BY_ENCODER: shown})

    return compute


_NAMES = {"trapezoid-y": "trapezoid", "stair-y-50mm": "staircase"} | {
    name: name for name in ("rhombus", "pentagram")
}


_COUNT_RATE = COUNT / CONTROL_PERIOD
_ONE_COUNT = "one encoder count in 0.5 ms, 0.1 mm/s"


def _below_limits(scenario: str, axis: str, figure: str) -> list[PrintedNumber]:
    v_max, a_max = {"x": (1.58, 7.31), "y": (1.34, 3.10)}[axis]
    speed, acceleration = _largest_velocity(scenario, axis), _largest_acceleration(scenario, axis)
    return [
        PrintedNumber(
            *(f"{scenario}-{what}-{axis}", _TEXT),
            *(f"Largest {what} of the {_NAMES[scenario]}, {axis}", unit, limit),
            f"smaller than the theoretical {limit:.2f} {unit}",
            group=GROUP,
            kind="claim",
            comparison="at_most",
            band=band,
            reason=reason,
            basis=f"{how}; {BASIS}",
            source=RowSource(compute),
            doing=scenario,
            figure=figure,
        )
        for what, unit, limit, band, reason, how, compute in (
            ("velocity", "m/s", v_max, _COUNT_RATE, _ONE_COUNT, "encoder differenced", speed),
            ("acceleration", "m/s^2", a_max, 0.0, _TRUE, "true acceleration", acceleration),
        )
    ]


def _accelerations(experiments: Experiments) -> RowResult:
    """Return the range over both y motions; for comparison the encoder's, and another law's."""
    ours = [experiments.run(name, MATCHED) for name in _EDGES]
    smooth = [experiments.run(name, {**MATCHED, **_smooth(name)}) for name in _EDGES]

    def span(runs: list[Run], channel: str) -> tuple[float, float]:
        every = np.concatenate([_acceleration(run, "y", channel) for run in runs])
        return float(every.min()), float(every.max())

    return RowResult(
        span(ours, "velocity"),
        {_BY_ENCODER: span(ours, "velocity_measured"), _SMOOTH: span(smooth, "velocity")},
    )


_said = partial(accuracy, paper=1.6e-6, place=_TEXT, group=GROUP, reason=A_LAW)

QUANTITIES = (
    PrintedNumber(
        *("y-velocity-range", _TEXT, "Velocities of both y motions"),
        *("m/s", (-0.14, 0.15), "[-0.14, 0.15] m/s"),
        group=GROUP,
        kind="input",
        reason="the paper prints no motion profile; ours takes its velocity from this very range",
    ),
    PrintedNumber(
        *("y-acceleration-range", _TEXT, "Accelerations of both y motions"),
        *("m/s^2", (-3.06, 1.66), "[-3.06, 1.66] m/s^2"),
        group=GROUP,
        comparison="within",
        band=0.0,
        reason=_TRUE,
        basis=f"true acceleration; {BASIS}; motion profile ours",
        source=RowSource(_accelerations),
        doing="trapezoid-y",
        figure="fig6-acceleration",
    ),
    _said(
        *("y-steady-state-trapezoid", "Steady-state error, trapezoid"),
        run=("trapezoid-y", "y"),
        band=TRAPEZOID + COUNT,
        figure="fig6-error",
        note="Table 1 says 1.5 um of the same motion; the figure of trapezoid-y once more",
    ),
    _said(
        *("y-steady-state-staircase", "Steady-state error, staircase"),
        run=("stair-y-50mm", "y"),
        band=STAIRCASE + COUNT,
        figure="fig7-error",
        note="The figure and the bound of stair-y-50mm once more",
    ),
    *_below_limits("trapezoid-y", "y", "fig6-velocity"),
    *_below_limits("stair-y-50mm", "y", "fig7-velocity"),
    *(
        row
        for scenario in ("rhombus", "pentagram")
        for axis in "xy"
        for row in _below_limits(scenario, axis, f"fig8-{scenario}-{axis}")
    ),
    *(
        edges(
            *(f"{name}-all", paper, "y"),
            quantity=f"Following errors, {name}",
            place=_TEXT,
            group=GROUP,
        )
        for name, paper in (("rhombus", 18.2e-6), ("pentagram", 56.8e-6))
    ),
)
