"""What the text of section IV-A says of the motions of Figs 6 to 8."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.moves import Staircase, Trapezoid
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.studies.paper.bands import COUNT, STAIRCASE, TRAPEZOID
from motionlab.studies.paper.experiments import Experiments, Run
from motionlab.studies.paper.printed_number import Compute, Found, Quantity, not_comparable
from motionlab.studies.paper.tracking import (
    A_LAW,
    BASIS,
    MATCHED,
    PENTAGRAM_Y,
    RHOMBUS_Y,
    TEXT,
    accuracy,
    edges,
)

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
    """Return changes that put minimum jerk in place of the trapezoidal time law."""
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
    """Return the largest that the encoder shows over the main window, as the paper would see it."""

    def compute(experiments: Experiments) -> Found:
        run = experiments.run(scenario, MATCHED)
        window = slice(*run.prepared.window)
        velocity = run.recording.variants["B"].channel("velocity_measured", axis)[window]
        return Found(float(np.abs(velocity).max()))

    return compute


def _largest_acceleration(scenario: str, axis: str) -> Compute:
    """Return the largest over the main window: the motor's, and beside it the encoder's."""

    def compute(experiments: Experiments) -> Found:
        run = experiments.run(scenario, MATCHED)
        start, stop = run.prepared.window
        true, shown = (
            float(np.abs(_acceleration(run, axis, channel)[start : stop - 1]).max())
            for channel in ("velocity", "velocity_measured")
        )
        return Found(true, {_BY_ENCODER: shown})

    return compute


_NAMES = {"trapezoid-y": "trapezoid", "stair-y-50mm": "staircase"} | {
    name: name for name in ("rhombus", "pentagram")
}


def _below_limits(scenario: str, axis: str, figure: str) -> tuple[Quantity, Quantity]:
    limits = {"x": (1.58, 7.31), "y": (1.34, 3.10)}[axis]
    kinds = (
        (
            "velocity",
            "m/s",
            limits[0],
            COUNT / CONTROL_PERIOD,
            "one encoder count in 0.5 ms, 0.1 mm/s",
        ),
        (
            "acceleration",
            "m/s^2",
            limits[1],
            0.0,
            _TRUE,
        ),
    )
    ways = (
        ("encoder differenced", _largest_velocity),
        ("true acceleration", _largest_acceleration),
    )
    first, second = (
        Quantity(
            id=f"{scenario}-{what}-{axis}",
            group=GROUP,
            kind="claim",
            place=_TEXT,
            quantity=f"Largest {what} of the {_NAMES[scenario]}, {axis}",
            unit=unit,
            paper=limit,
            printed=f"smaller than the theoretical {limit:.2f} {unit}",
            comparison="at_most",
            band=band,
            reason=reason,
            basis=f"{how}; {BASIS}",
            compute=compute(scenario, axis),
            doing=scenario,
            figure=figure,
        )
        for (what, unit, limit, band, reason), (how, compute) in zip(kinds, ways, strict=True)
    )
    return first, second


def _accelerations(experiments: Experiments) -> Found:
    """Return the range over both y motions; beside it the encoder's, and that of another law."""
    ours = [experiments.run(name, MATCHED) for name in _EDGES]
    smooth = [experiments.run(name, {**MATCHED, **_smooth(name)}) for name in _EDGES]

    def span(runs: list[Run], channel: str) -> tuple[float, float]:
        every = np.concatenate([_acceleration(run, "y", channel) for run in runs])
        return float(every.min()), float(every.max())

    return Found(
        span(ours, "velocity"),
        {_BY_ENCODER: span(ours, "velocity_measured"), _SMOOTH: span(smooth, "velocity")},
    )


QUANTITIES = (
    not_comparable(
        "y-velocity-range",
        GROUP,
        _TEXT,
        "Velocities of both y motions",
        kind="input",
        unit="m/s",
        paper=(-0.14, 0.15),
        printed="[-0.14, 0.15] m/s",
        reason="the paper prints no time law; ours takes its velocity from this very range",
    ),
    Quantity(
        id="y-acceleration-range",
        group=GROUP,
        place=_TEXT,
        quantity="Accelerations of both y motions",
        unit="m/s^2",
        paper=(-3.06, 1.66),
        printed="[-3.06, 1.66] m/s^2",
        comparison="within",
        band=0.0,
        reason=_TRUE,
        basis=f"true acceleration; {BASIS}; time law ours",
        compute=_accelerations,
        doing="trapezoid-y",
        figure="fig6-acceleration",
    ),
    accuracy(
        "y-steady-state-trapezoid",
        "Steady-state error, trapezoid",
        "trapezoid-y",
        "y",
        paper=1.6e-6,
        printed="±1.6 um",
        band=TRAPEZOID + COUNT,
        reason=A_LAW,
        figure="fig6-error",
        place=_TEXT,
        group=GROUP,
        note="Table 1 says 1.5 um of the same motion; the figure of trapezoid-y once more",
    ),
    accuracy(
        "y-steady-state-staircase",
        "Steady-state error, staircase",
        "stair-y-50mm",
        "y",
        paper=1.6e-6,
        printed="±1.6 um",
        band=STAIRCASE + COUNT,
        reason=A_LAW,
        figure="fig7-error",
        place=_TEXT,
        group=GROUP,
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
    edges(
        "rhombus-all",
        "Following errors, rhombus",
        "rhombus",
        "y",
        paper=18.2e-6,
        printed="±18.2 um",
        place=_TEXT,
        group=GROUP,
        edge=RHOMBUS_Y,
    ),
    edges(
        "pentagram-all",
        "Following errors, pentagram",
        "pentagram",
        "y",
        paper=56.8e-6,
        printed="±56.8 um",
        place=_TEXT,
        group=GROUP,
        edge=PENTAGRAM_Y,
    ),
)
