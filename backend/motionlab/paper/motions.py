"""What the text of section IV-A says of the motions of Figs 6 to 8."""

from __future__ import annotations

import numpy as np

from motionlab.config.timing import CONTROL_PERIOD
from motionlab.paper.bands import COUNT, STAIRCASE, TRAPEZOID
from motionlab.paper.experiments import Experiments
from motionlab.paper.quantity import Compute, Found, Quantity, by_run, from_run, not_comparable
from motionlab.paper.tracking import (
    A_LAW,
    BASIS,
    MATCHED,
    PENTAGRAM_Y,
    RHOMBUS_Y,
    TEXT,
    accuracy,
    edges,
)
from motionlab.simulation.result import main_window

GROUP = TEXT

_TEXT = "IV-A"
_SECOND = 2.0 * COUNT / CONTROL_PERIOD**2
_SECOND_REASON = (
    "readings are off by half a count each, their second difference over 0.5 ms by two counts: "
    "0.4 m/s^2"
)


def _measured(scenario: str, axis: str, order: int) -> Compute:
    """Return what differences the encoder's reading, as the paper does, over the main window."""

    def compute(experiments: Experiments) -> Found:
        run = experiments.run(scenario, MATCHED)
        start, stop = main_window(run.prepared)
        record = run.recording.variants["B"]
        values = record.channel("velocity_measured", axis).astype(np.float64)[start:stop]
        if order == 2:
            values = np.diff(values) / CONTROL_PERIOD
        return Found(float(np.abs(values).max()))

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
            _SECOND,
            _SECOND_REASON,
        ),
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
            basis=f"encoder differenced; {BASIS}",
            compute=_measured(scenario, axis, order),
            doing=scenario,
            figure=figure,
        )
        for order, (what, unit, limit, band, reason) in enumerate(kinds, start=1)
    )
    return first, second


def _accelerations(experiments: Experiments) -> Found:
    ends: list[float] = []
    for scenario in ("trapezoid-y", "stair-y-50mm"):
        run = experiments.run(scenario, MATCHED)
        velocity = run.recording.variants["B"].channel("velocity_measured", "y")
        acceleration = np.diff(velocity.astype(np.float64)) / CONTROL_PERIOD
        ends += [float(acceleration.min()), float(acceleration.max())]
    return Found((min(ends), max(ends)))


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
        band=_SECOND,
        reason=_SECOND_REASON,
        basis=f"encoder differenced twice; {BASIS}; time law ours",
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
        note="Table 1 says 1.5 um of the same motion",
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
    ),
    Quantity(
        id="current-limit",
        group=GROUP,
        kind="claim",
        place=_TEXT,
        quantity="Largest phase current of the trapezoid",
        unit="A",
        paper=10.0,
        printed="limited to 10 A",
        comparison="at_most",
        band=0.0,
        reason="a limit: kept or not",
        basis=BASIS,
        compute=from_run("trapezoid-y", "variants.B.axes.y.max_current", changes=MATCHED),
        doing="trapezoid-y",
        recipe=by_run("trapezoid-y", MATCHED, ["variants.B.axes.y.max_current"]),
        figure="fig6-currents",
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
