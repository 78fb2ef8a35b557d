"""Fig. 5: the circle, its compensation switched on at 90 s; and the same with K as published."""

from __future__ import annotations

from functools import partial
from typing import Any

from motionlab.paper.bands import COUNT
from motionlab.paper.experiments import Experiments
from motionlab.paper.printed_number import (
    Compute,
    PrintedNumber,
    RowResult,
    RowSource,
    Spread,
    from_run,
    look_up,
    percent,
)

GROUP = "fig5"

NOMINAL: dict[str, Any] = {"plant": "nominal"}
_ROUND = 0.05e-6
PRINTED = {"x": (20.5e-6, 10.4e-6), "y": (17.4e-6, 11.6e-6)}
"""Following error without and with compensation, m."""
_METRIC = "max_abs_following_error"
_fit = partial(PrintedNumber, group=GROUP, kind="fit", doing="fig5, 180 s")


def _path(segment: int, axis: str, variant: str = "A") -> str:
    return f"segments.{segment}.variants.{variant}.axes.{axis}.{_METRIC}"


def _error(axis: str, segment: int) -> PrintedNumber:
    paper = PRINTED[axis][segment]
    off_on = ("without", "with")[segment]
    others = {"nominal motor": ("fig5", NOMINAL, _path(segment, axis))}
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

        return RowResult(gained({}), {"nominal motor": gained(NOMINAL)})

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


QUANTITIES = (
    *(_error(axis, segment) for axis in "xy" for segment in (0, 1)),
    _improvement("x", 0.493),
    _improvement("y", 0.333),
)
