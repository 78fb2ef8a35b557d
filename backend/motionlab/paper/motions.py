"""Table 1 and Figs 5 to 8: circle, staircases, trapezoid, rhombus and pentagram."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.moves import Staircase, Trapezoid
from motionlab.paper.documents import Number
from motionlab.paper.experiments import Experiments, Run
from motionlab.paper.printed_number import (
    COUNT,
    STAIRCASE,
    TRAPEZOID,
    Compute,
    PrintedNumber,
    RowResult,
    RowSource,
    Spread,
    edge_law,
    from_run,
    look_up,
    percent,
)
from motionlab.timing import CONTROL_PERIOD

TABLE, MOTIONS = "table1", "motions"
"""Identifiers of the groups."""

MATCHED: dict[str, Any] = {"plant": "matched"}
NOMINAL: dict[str, Any] = {}

BASIS = "matched motor, LuGre observer (K = 0), the printed gains"
_PEAK = "max_abs_following_error"
_ROUND = 0.05e-6
"""Half of the last printed digit, m."""

LIKE_PD = "The nominal motor without compensation is closest to the printed value"

A_LAW = (
    "half of what accelerations of 1.0 to 1.66 m/s^2, all allowed by the text, make of the steady "
    "state without compensation, and one encoder count"
)


def _find(axis: str, metric: str | tuple[str, str], variant: str) -> str | tuple[str, str]:
    path = f"variants.{variant}.axes.{axis}."
    if isinstance(metric, str):
        return path + metric
    return (path + metric[0], path + metric[1])


def accuracy(
    row_id: str, quantity: str, paper: Number, *, run: tuple[str, str] | None = None, **more: Any
) -> PrintedNumber:
    """Return a row on the error of the matched, compensated motor, with the other three as values.

    Parameters
    ----------
    row_id, quantity, paper
        See `motionlab.paper.printed_number.PrintedNumber`; two numbers for `paper` are a
        range.
    run : tuple of str, optional
        Scenario and axis, where they are not those of the identifier.
    **more
        Further fields of the row.
    """
    scenario, axis = run or (row_id, "x" if "-x" in row_id else "y")
    metric: str | tuple[str, str] = "steady_state_error"
    if ranged := isinstance(paper, tuple):
        metric = ("min_following_error", "max_following_error")
        printed = "[{:.1f}, {:.1f}] um".format(*(1e6 * end for end in paper))
    else:
        printed = f"±{1e6 * paper:.1f} um"
    if not ranged and scenario in {"rhombus", "pentagram"}:
        metric = _PEAK
    source = from_run(
        scenario,
        _find(axis, metric, "B"),
        changes=MATCHED,
        others={
            f"{motor}, {'LuGre observer' if variant == 'B' else 'no compensation'}": (
                scenario,
                changes,
                _find(axis, metric, variant),
            )
            for motor, changes, variant in (
                ("matched", MATCHED, "A"),
                ("nominal", NOMINAL, "B"),
                ("nominal", NOMINAL, "A"),
            )
        },
    )
    fields: dict[str, Any] = {"place": "Table 1", "group": TABLE} | more
    return PrintedNumber(
        id=row_id,
        quantity=quantity,
        unit="m",
        paper=paper,
        printed=printed,
        comparison="within" if ranged else "at_most",
        basis=BASIS,
        source=source,
        doing=scenario,
        spread=Spread(scenario, axis, metric if isinstance(metric, str) else _PEAK),
        **fields,
    )


def edges(row_id: str, paper: Number, axis: str, **more: Any) -> PrintedNumber:
    """Return a row on the following error along edges of unprinted motion profile.

    Parameters
    ----------
    row_id, paper
        See `motionlab.paper.printed_number.PrintedNumber`.
    axis : str
        ``x`` or ``y``.
    **more
        Further fields of the row.
    """
    scenario = row_id.split("-", maxsplit=1)[0]
    law = edge_law(scenario, axis)
    fields = {"quantity": f"Following error, {scenario}, {axis}"} | more
    return accuracy(
        row_id,
        paper=paper,
        run=(scenario, axis),
        band=law + COUNT + _ROUND,
        reason="the motion profile of the edges is not printed: "
        f"31 % of M a/k_p, {law * 1e6:.1f} um, between the least acceleration that stops at the "
        "corners and ours; one encoder count; half of the last printed digit",
        figure=f"fig8-{scenario}-{axis}",
        note=LIKE_PD,
        **fields,
    )


CIRCLE = "fig5"

FIG5: dict[str, Any] = {"plant": "nominal"}
PRINTED = {"x": (20.5e-6, 10.4e-6), "y": (17.4e-6, 11.6e-6)}
"""Following error without and with compensation, m."""
_METRIC = "max_abs_following_error"
_fit = partial(PrintedNumber, group=CIRCLE, kind="fit", doing="fig5, 180 s")


def _path(segment: int, axis: str, variant: str = "A") -> str:
    return f"segments.{segment}.variants.{variant}.axes.{axis}.{_METRIC}"


def _error(axis: str, segment: int) -> PrintedNumber:
    paper = PRINTED[axis][segment]
    off_on = ("without", "with")[segment]
    others = {"nominal motor": ("fig5", FIG5, _path(segment, axis))}
    if segment == 1:
        others["matched, with feedforward and disturbance observer too"] = (
            "fig5",
            {},
            _path(segment, axis, "B"),
        )
    return _fit(
        *(f"fig5-{('off', 'on')[segment]}-{axis}", "Fig. 5"),
        *(f"Following error {off_on} compensation, {axis}", "m", paper),
        f"±{paper * 1e6:.1f} um",
        comparison="at_most",
        band=_ROUND + COUNT,
        reason="half of the last printed digit and one encoder count, 50 nm each",
        basis=f"matched motor, {('PD alone', 'LuGre observer (K = 0)')[segment]}; last two laps",
        note="The matched motor's friction was fitted to this number: a fit, not a validation",
        source=from_run("fig5", _path(segment, axis), others=others),
        spread=Spread("circle", axis, _METRIC, ("A", "B")[segment]),
        figure=f"fig5-{axis}",
    )


def _gain(axis: str) -> Compute:
    def compute(experiments: Experiments) -> RowResult:
        def gained(plant: dict[str, Any]) -> float | None:
            document = experiments.run("fig5", plant).document
            off, on = (look_up(document, _path(segment, axis)) for segment in (0, 1))
            return None if off is None or on is None else 1.0 - on / off

        return RowResult(gained({}), {"nominal motor": gained(FIG5)})

    return compute


def _improvement(axis: str, paper: float) -> PrintedNumber:
    off, on = PRINTED[axis]
    band = (_ROUND + COUNT) * (1.0 / off + on / off**2)
    return _fit(
        *(f"fig5-improvement-{axis}", "IV-A", f"Reduction by compensation, {axis}"),
        *("1", paper, percent(paper)),
        comparison="at_least",
        band=band,
        reason=f"the bands of both errors together, {band:.1%}",
        basis="matched motor, LuGre observer (K = 0)",
        note="Follows from the two errors, to which the matched motor was fitted",
        source=RowSource(_gain(axis)),
        spread=Spread("circle", axis, _METRIC, None),
        figure=f"fig5-{axis}",
    )


CIRCLE_ROWS = (
    *(_error(axis, segment) for axis in "xy" for segment in (0, 1)),
    _improvement("x", 0.493),
    _improvement("y", 0.333),
)


TABLE_ROWS = (
    *(
        accuracy(
            f"stair-{axis}-500nm",
            f"Steady-state error, {axis} staircase of 0.5 um",
            0.4e-6,
            band=COUNT,
            reason="one encoder count, 50 nm",
            figure=f"stair-{axis}-500nm",
        )
        for axis in "xy"
    ),
    accuracy(
        *("stair-y-50mm", "Steady-state error, y staircase of 50 mm", 1.6e-6),
        band=STAIRCASE + COUNT,
        reason=A_LAW,
        figure="fig7-error",
        note=LIKE_PD,
    ),
    accuracy(
        *("trapezoid-y", "Steady-state error, y trapezoid of 290 mm", 1.5e-6),
        band=TRAPEZOID + COUNT,
        reason=A_LAW,
        figure="fig6-error",
        note="Section IV-A says 1.6 um of the same motion",
    ),
    edges("rhombus-x", (-14.2e-6, 14.3e-6), "x"),
    edges("rhombus-y", (-18.2e-6, 16.9e-6), "y"),
    edges("pentagram-x", (-31.5e-6, 38.6e-6), "x"),
    edges("pentagram-y", (-52.7e-6, 56.8e-6), "y"),
)


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
            group=MOTIONS,
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


_text_claim = partial(accuracy, paper=1.6e-6, place=_TEXT, group=MOTIONS, reason=A_LAW)

MOTION_ROWS = (
    PrintedNumber(
        *("y-velocity-range", _TEXT, "Velocities of both y motions"),
        *("m/s", (-0.14, 0.15), "[-0.14, 0.15] m/s"),
        group=MOTIONS,
        kind="input",
        reason="the paper prints no motion profile; ours takes its velocity from this very range",
    ),
    PrintedNumber(
        *("y-acceleration-range", _TEXT, "Accelerations of both y motions"),
        *("m/s^2", (-3.06, 1.66), "[-3.06, 1.66] m/s^2"),
        group=MOTIONS,
        comparison="within",
        band=0.0,
        reason=_TRUE,
        basis=f"true acceleration; {BASIS}; motion profile ours",
        source=RowSource(_accelerations),
        doing="trapezoid-y",
        figure="fig6-acceleration",
    ),
    _text_claim(
        *("y-steady-state-trapezoid", "Steady-state error, trapezoid"),
        run=("trapezoid-y", "y"),
        band=TRAPEZOID + COUNT,
        figure="fig6-error",
        note="Table 1 says 1.5 um of the same motion; the figure of trapezoid-y once more",
    ),
    _text_claim(
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
            group=MOTIONS,
        )
        for name, paper in (("rhombus", 18.2e-6), ("pentagram", 56.8e-6))
    ),
)
