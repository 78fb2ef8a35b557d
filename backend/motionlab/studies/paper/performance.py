"""Sections III-D and III-E: eqs (39) to (42) against runs of the loop without friction.

The paper states formulas here and no numbers. What they give for the circle's gains stands in the
place of a printed number, and the sampled loop in that of the machine.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.loop.linearise import linearise
from motionlab.loop.margins import margins
from motionlab.loop.steady_state_error import crossover, parabola_error, sine_error
from motionlab.studies.paper.bands import COUNT
from motionlab.studies.paper.experiments import Experiments, Run
from motionlab.studies.paper.printed_number import Compute, Found, Quantity, by_run

GROUP = "performance"
NO_FRICTION: dict[str, Any] = {
    "plant.force": "ideal",
    "plant.x.friction.enabled": False,
    "plant.y.friction.enabled": False,
}
"""What eqs (39) to (42) are about, (19): a mass without friction that gets the force commanded."""

_GAINS = {"x": (5.9, 200.3e3, 1530.0), "y": (13.9, 280.5e3, 1080.0)}
"""Mass, k_p and k_d of the circle, SI."""

_OMEGA = 2.0 * math.pi / 3.0
_RADIUS = 0.015
_SLOPE = 0.5
"""R of R t^2, m/s^2."""

_FORMULA = "the paper prints the formula, not the number"
_BASIS = "nominal mass without friction, any force commanded, PD alone, the circle's gains"


def _parabola(axis: str) -> dict[str, Any]:
    return NO_FRICTION | {
        "trajectory": {
            "kind": "parabola",
            "start": {axis: -0.05},
            "coefficient": {axis: _SLOPE},
            "duration": 0.25,
        }
    }


def _ramp(axis: str) -> dict[str, Any]:
    return NO_FRICTION | {
        "trajectory": {
            "kind": "ramp",
            "start": {axis: -0.03},
            "velocity": {axis: 0.03},
            "lead_in": 0.2,
            "duration": 2.0,
        }
    }


def _step(axis: str) -> dict[str, Any]:
    return NO_FRICTION | {
        "trajectory": {"kind": "step", "height": {axis: 1e-6}, "delay": 0.1, "dwell": 1.0}
    }


def _error(run: Run, axis: str) -> np.ndarray:
    record = run.recording.variants["A"]
    return record.channel("following_error", axis).astype(np.float64)


def _late_mean(axis: str, changes: dict[str, Any]) -> Compute:
    """Return what computes the mean following error over the last fifth of a run."""

    def compute(experiments: Experiments) -> Found:
        error = _error(experiments.run("circle", changes), axis)
        return Found(float(error[-len(error) // 5 :].mean()))

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
    def compute(experiments: Experiments) -> Found:
        found = response(experiments.run("circle", NO_FRICTION), axis)
        return Found(abs(found) * _RADIUS)

    return compute


def _phase(axis: str) -> Compute:
    def compute(experiments: Experiments) -> Found:
        found = response(experiments.run("circle", NO_FRICTION), axis)
        return Found(float(np.angle(found)) % (2.0 * math.pi))

    return compute


def _crossover(axis: str) -> Compute:
    def compute(_: Experiments) -> Found:
        loop = linearise(load_scenario("circle", NO_FRICTION), "A", axis, v=0.02)
        found = margins(loop.open).crossover
        return Found(None if found is None else 2.0 * math.pi * found)

    return compute


def _rows(axis: str) -> tuple[Quantity, ...]:
    M, k_p, k_d = _GAINS[axis]
    w_c = crossover(M, k_p, k_d)
    lag = 0.5 * k_p * k_d * w_c**2 * CONTROL_PERIOD / (k_p**2 + (k_d * w_c) ** 2)
    sine = sine_error(M, k_p, k_d, B=_RADIUS, w=_OMEGA)
    count = "one encoder count, 50 nm"
    return (
        Quantity(
            id=f"crossover-{axis}",
            group=GROUP,
            kind="formula",
            place="(39)",
            quantity=f"Crossover frequency of the open loop, {axis}",
            unit="rad/s",
            paper=w_c,
            printed=_FORMULA,
            comparison="value",
            band=lag * w_c,
            reason=f"{lag:.1%}: the sampled loop differences the error, which lags by half a "
            "control period; that turns k_d w_c by w_c T/2, which adds k_p k_d w_c^2 T to "
            "abs(k_p + j k_d w_c)^2",
            basis="the sampled loop, linearised; without friction",
            compute=_crossover(axis),
            doing="linearised loop",
        ),
        Quantity(
            id=f"step-error-{axis}",
            group=GROUP,
            kind="formula",
            place="(40)",
            quantity=f"Steady-state error of a step, {axis}",
            unit="m",
            paper=0.0,
            printed="0",
            comparison="value",
            band=COUNT,
            reason=count,
            basis=f"{_BASIS}; step of 1 um, last fifth",
            compute=_late_mean(axis, _step(axis)),
            doing="steps, ramps and parabolas without friction",
        ),
        Quantity(
            id=f"ramp-error-{axis}",
            group=GROUP,
            kind="formula",
            place="(40)",
            quantity=f"Steady-state error of a ramp, {axis}",
            unit="m",
            paper=0.0,
            printed="0",
            comparison="value",
            band=COUNT,
            reason=count,
            basis=f"{_BASIS}; 30 mm/s, last fifth",
            compute=_late_mean(axis, _ramp(axis)),
            doing="steps, ramps and parabolas without friction",
        ),
        Quantity(
            id=f"parabola-error-{axis}",
            group=GROUP,
            kind="formula",
            place="(40)",
            quantity=f"Steady-state error of R t^2, R = 0.5 m/s^2, {axis}",
            unit="m",
            paper=parabola_error(M, k_p, _SLOPE),
            printed="2 M R/(k k_p)",
            comparison="value",
            band=COUNT,
            reason=count,
            basis=f"{_BASIS}; last fifth of 0.25 s",
            compute=_late_mean(axis, _parabola(axis)),
            doing="steps, ramps and parabolas without friction",
        ),
        Quantity(
            id=f"sine-amplitude-{axis}",
            group=GROUP,
            kind="formula",
            place="(41), (42)",
            quantity=f"Error amplitude of the circle, {axis}",
            unit="m",
            paper=sine.amplitude,
            printed=_FORMULA,
            comparison="value",
            band=COUNT,
            reason=count,
            basis=f"{_BASIS}; at 1/3 Hz, over two laps",
            compute=_amplitude(axis),
            doing="circle without friction",
            recipe=by_run("circle", NO_FRICTION),
        ),
        Quantity(
            id=f"sine-phase-{axis}",
            group=GROUP,
            kind="formula",
            place="(42)",
            quantity=f"Error phase of the circle, {axis}",
            unit="rad",
            paper=sine.phase % (2.0 * math.pi),
            printed="arctan(...)",
            comparison="value",
            band=COUNT / sine.amplitude,
            reason="one encoder count over the amplitude",
            basis=f"{_BASIS}; at 1/3 Hz, over two laps",
            note="Of the two-argument arc tangent, 0 to 2 pi; as printed it is off by pi: errata",
            compute=_phase(axis),
            doing="circle without friction",
            recipe=by_run("circle", NO_FRICTION),
        ),
    )


QUANTITIES = (*_rows("x"), *_rows("y"))
