"""What is computed for the challenge: a run of each scenario, batches of motors, and margins."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.executors.executor import current
from motionlab.loop.family import VelocityMargin, family_of
from motionlab.loop.linearise import NoLinearisation
from motionlab.simulation.batch import run_batch, tasks
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.studies.challenge.definition import Compensations, Definition
from motionlab.studies.challenge.score import AxisFigures, error_ratio, geometric_mean
from motionlab.studies.montecarlo.documents import DEFAULT
from motionlab.studies.montecarlo.draw import draw, missing
from motionlab.telemetry.decimate import min_max
from motionlab.telemetry.recording import VariantRecord
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]
Progress = Callable[[float], None]

BINS = 160
"""Of a curve of the following error."""


@dataclass(frozen=True)
class ErrorCurves:
    """Following errors of one axis of all laws over the window of the metrics, binned.

    Attributes
    ----------
    start, end : float
        Of the window, s.
    low, high : ndarray, shape (laws, bins)
        Extremes of each bin, m; NaN from where a law diverged.
    """

    start: float
    end: float
    low: NDArray[np.float32]
    high: NDArray[np.float32]


@dataclass(frozen=True)
class ScenarioRun:
    """One scenario under all laws.

    Attributes
    ----------
    figures : list
        Of each law those of each axis that moves; None of a law that diverged.
    curves : dict of str to ErrorCurves
        By axis.
    """

    figures: list[dict[str, AxisFigures] | None]
    curves: dict[str, ErrorCurves]


@dataclass(frozen=True)
class MotorRuns:
    """One scenario on drawn motors under all laws.

    Attributes
    ----------
    ratios : ndarray, shape (laws, motors)
        Error relative to that of the first law on the same motor; NaN where a law diverged.
    diverged : ndarray of int, shape (laws,)
        Motors on which a law diverged.
    left_out : int
        Motors that cannot follow the motion, or on which the first law diverged.
    """

    ratios: Array
    diverged: NDArray[np.int64]
    left_out: int


@dataclass(frozen=True)
class LeastMargin:
    """The least value of a margin, and where it is; infinite where nothing crosses."""

    value: float
    motor: str
    axis: str
    velocity: float  # m/s; 0 at standstill


@dataclass(frozen=True)
class LeastMargins:
    """Least margins of a law over motors, axes and velocities.

    Attributes
    ----------
    gain_margin, phase_margin : LeastMargin
        A factor, and rad.
    unstable : str
        Where its loop is unstable, or why there is none; empty if it is stable everywhere.
    """

    gain_margin: LeastMargin
    phase_margin: LeastMargin
    unstable: str = ""


def run_scenario(definition: Definition, name: str, laws: Compensations) -> ScenarioRun:
    """Run a scenario under all laws at once."""
    prepared = prepare(definition.scenario(name, laws))
    recording, window = run(prepared), prepared.window
    records = [record.cut(*window) for record in recording.variants.values()]
    moving = prepared.reference.moving
    return ScenarioRun(
        [
            None if record.diverged else {axis: _figures(record, axis) for axis in moving}
            for record in records
        ],
        {axis: _curves(records, axis, window) for axis in moving},
    )


def _figures(record: VariantRecord, axis: str) -> AxisFigures:
    error = record.channel("following_error", axis).astype(np.float64)
    force = record.channel("force_command", axis).astype(np.float64)
    return AxisFigures(
        max_error=float(np.abs(error).max()),
        rms_error=_rms(error),
        rms_force=_rms(force),
        rms_force_change=_rms(np.diff(force)),
    )


def _rms(values: Array) -> float:
    return math.sqrt(float(np.mean(values**2)))


def _curves(records: list[VariantRecord], axis: str, window: tuple[int, int]) -> ErrorCurves:
    errors = np.stack([record.channel("following_error", axis) for record in records])
    start, end = (tick * CONTROL_PERIOD for tick in window)
    return ErrorCurves(start, end, *min_max(np.ascontiguousarray(errors), BINS))


def run_motors(
    definition: Definition, name: str, laws: Compensations, seed: int, progress: Progress
) -> MotorRuns:
    """Run a scenario under all laws on motors drawn about its own, as Monte Carlo draws them."""
    scenario = definition.scenario(name, laws)
    plant = scenario.plant.model_dump(mode="json")
    absent = missing(plant, DEFAULT)
    vary = [each for each in DEFAULT if each.path not in absent]
    draws = draw(plant, vary, cases=definition.motors, seed=seed)
    batches = list(current().map(run_batch, tasks(scenario, draws, {}), progress))
    peaks, means = (
        np.concatenate([batch.metrics[metric] for batch in batches])
        for metric in ("max_abs_following_error", "rms_following_error")
    )
    feasible = np.concatenate([batch.feasible for batch in batches])
    failed = np.concatenate([batch.failed for batch in batches]) >= 0
    moving = [AXES.index(axis) for axis in prepare(scenario).reference.moving]
    return motor_runs(peaks[..., moving], means[..., moving], failed, feasible)


def motor_runs(
    peaks: Array, means: Array, failed: NDArray[np.bool_], feasible: NDArray[np.bool_]
) -> MotorRuns:
    """Return the ratios of largest and rms errors to those of the first law.

    Parameters
    ----------
    peaks, means : ndarray, shape (motors, laws, axes)
        Largest and rms following error, m.
    failed : ndarray, shape (motors, laws)
        Whether a law diverged on a motor.
    feasible : ndarray, shape (motors,)
        Whether a motor can follow the motion.
    """
    used = feasible & ~failed[:, 0]
    ratios = np.full(failed.T.shape, np.nan)
    for motor, law in np.argwhere(used[:, None] & ~failed):
        ratios[law, motor] = geometric_mean(
            error_ratio(peak, mean, (peak_off, mean_off))
            for peak, mean, peak_off, mean_off in zip(
                peaks[motor, law],
                means[motor, law],
                peaks[motor, 0],
                means[motor, 0],
                strict=True,
            )
        )
    return MotorRuns(ratios, failed[feasible].sum(axis=0), int((~used).sum()))


def least_margins(definition: Definition, laws: Compensations) -> list[LeastMargins]:
    """Return the least margins of each law."""
    scenarios = {name: definition.on_motor(name, laws) for name in definition.margins}
    letters = list(next(iter(scenarios.values())).variants)
    return [_of_law(scenarios, letter) for letter in letters]


def _of_law(scenarios: dict[str, Scenario], variant: str) -> LeastMargins:
    nothing = LeastMargin(math.inf, "", "", 0.0)
    gain = phase = nothing
    unstable = ""
    for (motor, scenario), axis in product(scenarios.items(), AXES):
        try:
            family = family_of(scenario, variant, axis)
        except NoLinearisation as error:
            return LeastMargins(nothing, nothing, error.errors[0].message)
        gains = getattr(scenario.variants[variant].controller, axis)
        if family.radius(np.array(gains.k_p), np.array(gains.k_d)) >= 1.0:
            unstable = unstable or f"linearised loop unstable on {axis} of {motor}"
            continue
        figures = family.figures(gains.k_p, gains.k_d)
        gain = _less(gain, figures.gain_margin, motor, axis)
        phase = _less(phase, figures.phase_margin, motor, axis)
    return LeastMargins(gain, phase, unstable)


def _less(least: LeastMargin, margin: VelocityMargin, motor: str, axis: str) -> LeastMargin:
    if margin.value >= least.value:
        return least
    return LeastMargin(margin.value, motor, axis, margin.velocity)
