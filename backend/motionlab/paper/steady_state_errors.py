"""Sections III-D and III-E: eqs (39) to (42) against runs of the loop without friction.

The paper states formulas here and no numbers. Their values for the circle's gains are used as the
printed numbers, and the sampled loop as the machine.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.loop.linearise import linearise
from motionlab.loop.margins import margins
from motionlab.loop.steady_state_error import crossover, parabola_error, sine_error
from motionlab.paper.bands import COUNT, gains
from motionlab.paper.experiments import Experiments, Run
from motionlab.paper.printed_number import (
    Compute,
    PrintedNumber,
    RowResult,
    RowSource,
    by_run,
)

GROUP = "performance"
NO_FRICTION: dict[str, Any] = {
    "plant.force": "ideal",
    "plant.x.friction.enabled": False,
    "plant.y.friction.enabled": False,
}
"""Plant of eqs (39) to (42), (19): a mass without friction under the commanded force."""

_OMEGA = 2.0 * math.pi / 3.0
_RADIUS = 0.015
_SLOPE = 0.5
"""R of R t^2, m/s^2."""

_FORMULA = "the paper prints the formula, not the number"
_BASIS = "nominal mass without friction, any force commanded, PD alone, the circle's gains"


def _motion(kind: str, **fields: Any) -> dict[str, Any]:
    return NO_FRICTION | {"trajectory": {"kind": kind} | fields}


def _parabola(axis: str) -> dict[str, Any]:
    start, slope = {axis: -0.05}, {axis: _SLOPE}
    return _motion("parabola", start=start, coefficient=slope, duration=0.25)


def _ramp(axis: str) -> dict[str, Any]:
    start, velocity = {axis: -0.03}, {axis: 0.03}
    return _motion("ramp", start=start, velocity=velocity, lead_in=0.2, duration=2.0)


def _step(axis: str) -> dict[str, Any]:
    return _motion("step", height={axis: 1e-6}, delay=0.1, dwell=1.0)


def _error(run: Run, axis: str) -> np.ndarray:
    record = run.recording.variants["A"]
    return record.channel("following_error", axis).astype(np.float64)


def _late_mean(axis: str, changes: dict[str, Any]) -> Compute:
    """Return a computation of the mean following error over the last fifth of a run."""

    def compute(experiments: Experiments) -> RowResult:
        error = _error(experiments.run("circle", changes), axis)
        return RowResult(float(error[-len(error) // 5 :].mean()))

    return compute


def response(run: Run, axis: str) -> complex:
    """Return error over reference at the circle's frequency, amplitude and phase."""
    start, stop = run.prepared.window
    time = np.arange(start, stop) * CONTROL_PERIOD
    turning = np.exp(-1j * _OMEGA * time)
    reference = run.prepared.reference.position[start:stop, "xy".index(axis)]
    error = _error(run, axis)[start:stop]
    return complex((error * turning).sum() / (reference * turning).sum())


def _amplitude(axis: str) -> Compute:
    def compute(experiments: Experiments) -> RowResult:
        found = response(experiments.run("circle", NO_FRICTION), axis)
        return RowResult(abs(found) * _RADIUS)

    return compute


def _phase(axis: str) -> Compute:
    def compute(experiments: Experiments) -> RowResult:
        found = response(experiments.run("circle", NO_FRICTION), axis)
        return RowResult(float(np.angle(found)) % (2.0 * math.pi))

    return compute


def _crossover(axis: str) -> Compute:
    def compute(_: Experiments) -> RowResult:
        loop = linearise(load_scenario("circle", NO_FRICTION), "A", axis, v=0.02)
        found = margins(loop.open).crossover
        return RowResult(None if found is None else 2.0 * math.pi * found)

    return compute


def _rows(axis: str) -> tuple[PrintedNumber, ...]:
    M, k_p, k_d = gains("circle", axis)
    w_c = crossover(M, k_p, k_d)
    lag = 0.5 * k_p * k_d * w_c**2 * CONTROL_PERIOD / (k_p**2 + (k_d * w_c) ** 2)
    sine = sine_error(M, k_p, k_d, B=_RADIUS, w=_OMEGA)
    row = partial(PrintedNumber, group=GROUP, kind="formula", comparison="value")
    counted = partial(row, band=COUNT, reason="one encoder count, 50 nm")
    settled = partial(counted, doing="steps, ramps and parabolas without friction")
    basis, doing = f"{_BASIS}; at 1/3 Hz, over two laps", "circle without friction"
    recipe = by_run("circle", NO_FRICTION)
    return (
        row(
            *(f"crossover-{axis}", "(39)", f"Crossover frequency of the open loop, {axis}"),
            *("rad/s", w_c, _FORMULA),
            band=lag * w_c,
            reason=f"{lag:.1%}: the sampled loop differences the error, which lags by half a "
            "control period; that turns k_d w_c by w_c T/2, which adds k_p k_d w_c^2 T to "
            "abs(k_p + j k_d w_c)^2",
            basis="the sampled loop, linearised; without friction",
            source=RowSource(_crossover(axis)),
            doing="linearised loop",
        ),
        settled(
            *(f"step-error-{axis}", "(40)", f"Steady-state error of a step, {axis}", "m", 0.0, "0"),
            basis=f"{_BASIS}; step of 1 um, last fifth",
            source=RowSource(_late_mean(axis, _step(axis))),
        ),
        settled(
            *(f"ramp-error-{axis}", "(40)", f"Steady-state error of a ramp, {axis}", "m", 0.0, "0"),
            basis=f"{_BASIS}; 30 mm/s, last fifth",
            source=RowSource(_late_mean(axis, _ramp(axis))),
        ),
        settled(
            *(f"parabola-error-{axis}", "(40)"),
            f"Steady-state error of R t^2, R = 0.5 m/s^2, {axis}",
            *("m", parabola_error(M, k_p, _SLOPE), "2 M R/(k k_p)"),
            basis=f"{_BASIS}; last fifth of 0.25 s",
            source=RowSource(_late_mean(axis, _parabola(axis))),
        ),
        counted(
            *(f"sine-amplitude-{axis}", "(41), (42)", f"Error amplitude of the circle, {axis}"),
            *("m", sine.amplitude, _FORMULA),
            source=RowSource(_amplitude(axis), recipe),
            basis=basis,
            doing=doing,
        ),
        row(
            *(f"sine-phase-{axis}", "(42)", f"Error phase of the circle, {axis}"),
            *("rad", sine.phase % (2.0 * math.pi), "arctan(...)"),
            band=COUNT / sine.amplitude,
            reason="one encoder count over the amplitude",
            note="Of the two-argument arc tangent, 0 to 2 pi; as printed it is off by pi: errata",
            source=RowSource(_phase(axis), recipe),
            basis=basis,
            doing=doing,
        ),
    )


QUANTITIES = (*_rows("x"), *_rows("y"))
