"""Section III-C: the claims of the stability proof, along runs with K as published."""

from __future__ import annotations

from functools import partial
from typing import Any

from motionlab.paper.bands import COUNT
from motionlab.paper.experiments import Experiments, Run
from motionlab.paper.lyapunov import Lyapunov, lyapunov
from motionlab.paper.printed_number import (
    PrintedNumber,
    RowResult,
    RowSource,
    by_run,
    from_run,
)

GROUP = "stability"

NOISELESS: dict[str, Any] = {
    f"plant.{axis}.{field}": value
    for axis in "xy"
    for field, value in (("encoder.resolution", 0.0), ("amplifiers.bandwidth", 100e3))
}
"""No quantisation and no noticeable lag: only the control period can be the cause."""

_PRINTED = {"x": 10.4e-6, "y": 11.6e-6}


def terms(run: Run, variant: str, axis: str) -> Lyapunov | None:
    """Return the terms of the proof over a run's main window; None if it diverged."""
    record = run.recording.variants[variant]
    if record.diverged is not None:
        return None
    controller = run.prepared.scenario.variants[variant].controller
    gains = getattr(controller, axis)
    return lyapunov(
        record.cut(*run.prepared.window),
        axis,
        friction=getattr(controller.model, axis).friction,
        k_p=gains.k_p,
        k_d=gains.k_d,
    )


def published(experiments: Experiments, axis: str) -> Lyapunov | None:
    """Return the terms along the circle with K of (25) and a motor without noise or lag."""
    return terms(experiments.run("circle-published-k", NOISELESS), "B", axis)


def _along(axis: str, name: str) -> RowSource:
    """Return one number of the terms along that circle."""

    def compute(experiments: Experiments) -> RowResult:
        found = published(experiments, axis)
        if found is None:
            return RowResult(None, error="it diverged")
        return RowResult(getattr(found, name))

    return RowSource(compute, by_run("circle-published-k", NOISELESS))


def _rows(axis: str) -> tuple[PrintedNumber, ...]:
    find = f"variants.B.axes.{axis}.max_abs_following_error"
    bound = partial(
        PrintedNumber, group=GROUP, comparison="at_most", doing="circle with K as published"
    )
    claim = partial(
        bound,
        kind="claim",
        basis="circle with K of (25), nominal motor without encoder counts or current lag",
        figure=f"lyapunov-{axis}",
    )
    return (
        claim(
            *(f"lyapunov-rate-{axis}", "(32), (38)", f"Share of the time at which V rises, {axis}"),
            *("1", 0.0, "dV/dt <= 0"),
            band=0.01,
            reason="1 %: where V stands still, rounding of the record decides the sign of its "
            "difference",
            source=_along(axis, "rising_share"),
        ),
        claim(
            *(f"lyapunov-bristle-{axis}", "(34)"),
            f"Largest e_z where e passes through zero, {axis}",
            *("m", 0.0, "e_z = 0 if e = 0"),
            band=COUNT,
            reason="what one encoder count would hide, although this motor has none",
            source=_along(axis, "zero_error_bristle"),
        ),
        bound(
            *(f"published-k-{axis}", "(25), Fig. 5"),
            f"Following error of the circle with K of (25), {axis}",
            *("m", _PRINTED[axis], f"±{_PRINTED[axis] * 1e6:.1f} um"),
            band=0.1e-6,
            reason="half of the last printed digit and one encoder count, 50 nm each",
            basis="nominal motor, K exactly as printed",
            note="A chaotic run: its digits depend on the machine, its size does not",
            source=from_run(
                "circle-published-k",
                find,
                others={
                    "without compensation": ("circle-published-k", {}, find.replace(".B.", ".A.")),
                    "with K = 0": ("circle", {}, find),
                    "without encoder counts or lag": ("circle-published-k", NOISELESS, find),
                },
            ),
        ),
    )


QUANTITIES = (*_rows("x"), *_rows("y"))
