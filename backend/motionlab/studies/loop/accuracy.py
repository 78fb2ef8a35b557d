"""Eqs (39) to (42) for a loop, and its simulation."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.changes import apply_changes
from motionlab.config.load import validate
from motionlab.config.planar import AXES
from motionlab.config.quantity import si
from motionlab.config.scenario import Scenario
from motionlab.loop.steady_state_error import crossover, parabola_error, sine_error
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.run import run
from motionlab.studies.tune.documents import AxisRequest
from motionlab.timing import CONTROL_PERIOD


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class SineAccuracy(_Document):
    """Following error at the fundamental of a motion that repeats."""

    frequency: float = si("Of the fundamental", "Hz")
    amplitude: float = si("Of the reference at the fundamental", "m")
    predicted: float = si("Amplitude of the error, eq. (41)", "m")
    predicted_phase: float = si("Against the reference, eq. (42) with its quadrant", "rad")
    ideal: float | None = si("The same, simulated: PD alone, without friction", "m")
    ideal_phase: float | None = si("The same, simulated: PD alone, without friction", "rad")
    simulated: float | None = si("The same, simulated as the scenario is", "m")
    simulated_phase: float | None = si("The same, simulated as the scenario is", "rad")


class AccuracyDocument(_Document):
    """Eqs (39) to (42) for one axis, PD control of a mass without friction, and the simulation."""

    variant: str
    axis: str
    crossover: float = si("Of eq. (39)", "Hz")
    acceleration: float = si("Largest of the reference in the window", "m/s^2")
    parabola: float = si("Steady-state error at that acceleration, eq. (40) with 2 R = a", "m")
    sine: SineAccuracy | None = Field(description="null for a motion that does not repeat")
    ideal_peak: float | None = si(
        "Largest error, simulated: PD alone, without friction; null where it diverges", "m"
    )
    simulated_peak: float | None = si(
        "Largest error, simulated as the scenario is; null where it diverges", "m"
    )


def accuracy(request: AxisRequest, scenario: Scenario) -> AccuracyDocument:
    """Return eqs (39) to (42) for one axis, and simulated errors.

    Raises
    ------
    ConfigError, Infeasible
        As `motionlab.simulation.prepare.prepare`.
    """
    variant, axis = request.chosen(scenario), request.axis
    document: dict[str, Any] = {**scenario.model_dump(mode="json"), "schedule": []}
    document["variants"] = {variant: document["variants"][variant]}
    own = prepare(validate(document))
    bare = {
        f"plant.{axis}.friction.enabled": False,
        f"variants.{variant}.controller.compensation": {"law": "off"},
        f"variants.{variant}.controller.feedforward": False,
        f"variants.{variant}.controller.disturbance_observer.enabled": False,
    }
    ideal = prepare(validate(apply_changes(document, bare)))
    errors = {"simulated": _error(own, axis), "ideal": _error(ideal, axis)}

    gains = getattr(scenario.variants[variant].controller, axis)
    M = getattr(scenario.plant, axis).mass
    start, stop = own.window
    a = float(np.abs(own.reference.acceleration[start:stop, AXES.index(axis)]).max())
    return AccuracyDocument(
        variant=variant,
        axis=axis,
        crossover=crossover(M, gains.k_p, gains.k_d) / (2.0 * math.pi),
        acceleration=a,
        parabola=parabola_error(M, gains.k_p, 0.5 * a),
        sine=_sine(own, axis, M, gains, errors),
        ideal_peak=_peak(errors["ideal"]),
        simulated_peak=_peak(errors["simulated"]),
    )


def _error(prepared: Prepared, axis: str) -> np.ndarray | None:
    """Return the following error over the window, m, or None if the axis diverged."""
    (record,) = run(prepared).variants.values()
    if record.diverged is not None:
        return None
    start, stop = prepared.window
    return record.channel("following_error", axis)[start:stop].astype(np.float64)


def _peak(error: np.ndarray | None) -> float | None:
    return None if error is None else float(np.abs(error).max())


def _sine(
    own: Prepared, axis: str, M: float, gains: Any, errors: dict[str, np.ndarray | None]
) -> SineAccuracy | None:
    """Compare at the fundamental, over as many whole laps as the window has."""
    period = own.reference.period
    start, stop = own.window
    laps = (stop - start) // period if period else 0
    if laps == 0 or axis not in own.reference.moving:
        return None
    ticks = laps * period
    w = 2.0 * math.pi / (period * CONTROL_PERIOD)
    turning = np.exp(-1j * w * CONTROL_PERIOD * np.arange(ticks)) * (2.0 / ticks)
    position = own.reference.position[start : start + ticks, AXES.index(axis)]
    reference = complex((position * turning).sum())
    promised = sine_error(M, gains.k_p, gains.k_d, B=abs(reference), w=w)
    figures: dict[str, float | None] = {}
    for name, error in errors.items():
        at = None if error is None else complex((error[:ticks] * turning).sum()) / reference
        figures[name] = None if at is None else abs(at * reference)
        figures[f"{name}_phase"] = None if at is None else cmath.phase(at)
    return SineAccuracy(
        frequency=w / (2.0 * math.pi),
        amplitude=abs(reference),
        predicted=promised.amplitude,
        predicted_phase=promised.phase,
        **figures,
    )
