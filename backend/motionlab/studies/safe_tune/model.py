"""What the scenario's motor, and plausible ones about it, say of gains."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.changes import apply_changes
from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.loop.family import LoopFamily
from motionlab.simulation.prepare import prepare
from motionlab.studies.montecarlo.draw import draw, missing
from motionlab.studies.response.margins import measured_margins, refined
from motionlab.studies.response.measure import ResponsePlan, measure
from motionlab.studies.response.recorded import RecordedPlan
from motionlab.studies.safe_tune.documents import VARY, SafeTuneRequest
from motionlab.studies.shape.controllers import Controllers, present
from motionlab.studies.shape.search import Limits, Search
from motionlab.studies.shape.shaping import sure_lines
from motionlab.studies.tune.problem import TrialSetup

Array = NDArray[np.float64]

_DISTANCE = 0.35
"""Least distance of the measured loop from -1, between its margins."""


@dataclass(frozen=True)
class Margins:
    """Worst margins for n pairs of gains, NaN where a loop is unstable.

    Attributes
    ----------
    gain, phase : ndarray, shape (n,)
        Of the measured loop, or else of the scenario's motor: a factor, and rad.
    least_gain, least_phase : ndarray, shape (n,)
        Of the worst plausible motor.
    hold : ndarray of bool, shape (n,)
        Whether the first keep what is requested, and every plausible motor is stable; without a
        measured loop it keeps half of what is requested.
    """

    gain: Array
    phase: Array
    least_gain: Array
    least_phase: Array
    hold: NDArray[np.bool_]


class MeasuredLoop:
    """The loop of any gains on a machine's measured plant.

    Parameters
    ----------
    planned : ResponsePlan or RecordedPlan
        Of the measurement, with the controller that ran in it.
    request : SafeTuneRequest
        Its margins are kept at the worse end of the plant's 95 % intervals.

    Raises
    ------
    ConfigError
        As a measurement does, or if too few of its frequencies are sure.
    """

    def __init__(self, planned: ResponsePlan | RecordedPlan, request: SafeTuneRequest) -> None:
        measured = measure(planned, lambda *_: None)
        lines = sure_lines(measured, "response")
        frequency, plant, deviation = refined(*lines, measured.fitted)
        controllers = Controllers(
            planned.scenario, planned.variant, request.axis, measured.velocity, frequency
        )
        self._frequency = frequency
        self._before = present(controllers.config, request.axis)
        limits = Limits(
            request.phase_margin, request.gain_margin, step=math.inf, filters=0, distance=_DISTANCE
        )
        self._search = Search(
            controllers, plant, deviation, self._before, limits, progress=lambda _: None
        )

    def margins(self, k_p: Array, k_d: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Return gain margin, phase margin and whether both hold, of n pairs of gains."""
        gain, phase = np.full((2, len(k_p)), math.nan)
        hold = np.zeros(len(k_p), dtype=bool)
        for n, (p, d) in enumerate(zip(k_p.tolist(), k_d.tolist(), strict=True)):
            shape = dataclasses.replace(self._before, k_p=p, k_d=d)
            here = measured_margins(self._frequency, self._search.open(shape))
            factors = here["gain_margin"], here["gain_reduction"]
            gain[n] = min((max(f, 1.0 / f) for f in factors if f), default=math.inf)
            phase[n] = math.inf if here["phase_margin"] is None else here["phase_margin"]
            hold[n] = self._search.keeps(shape)
        return gain, phase, hold


class Bench:
    """One motion on one motor for any gains of an axis: what a motion on it measures.

    Parameters
    ----------
    scenario : Scenario
        Motor, motion, load and noise.
    variant, axis : str
        Whose gains.
    metric : {"peak", "rms"}
        Of the following error over the metrics window; the other outputs are of the whole motion.
    """

    def __init__(self, scenario: Scenario, variant: str, axis: str, metric: str) -> None:
        alone = scenario.model_copy(
            update={"variants": {variant: scenario.variants[variant]}, "schedule": ()}
        )
        prepared = prepare(alone)
        start, end = prepared.window
        if scenario.window is None and prepared.reference.period:
            end = min(end, start + prepared.reference.period)
        prepared = dataclasses.replace(prepared, scenario=alone)
        self._controller = alone.variants[variant].controller
        self._metric, self._axis = metric, "xy".index(axis)
        self._inside = TrialSetup(prepared, (start, end))
        self._whole = self._inside if start == 0 else TrialSetup(prepared, (0, end))
        self.window = start, end
        self.moving = axis in prepared.reference.moving

    def measure(self, k_p: Array, k_d: Array) -> Array:
        """Return metric, largest error and largest thrust, shape (3, n); infinite if diverged."""
        inside = self._inside.over_gains(self._controller, k_p, k_d)
        whole = inside
        if self._whole is not self._inside:
            whole = self._whole.over_gains(self._controller, k_p, k_d)
        chosen = inside[self._metric], whole["peak"], whole["force"]
        return np.array([each[:, self._axis] for each in chosen])


class MotorModel(Bench):
    """The scenario's motor: motions predicted by simulation, margins by linearised loops."""

    def __init__(
        self,
        scenario: Scenario,
        variant: str,
        request: SafeTuneRequest,
        plausible: Sequence[Scenario],
        *,
        loop: MeasuredLoop | None = None,
    ) -> None:
        super().__init__(scenario, variant, request.axis, request.metric)
        self._request, self._loop = request, loop
        self._own, *self._plausible = (
            LoopFamily.of(each, variant, request.axis) for each in (scenario, *plausible)
        )

    def margins(self, k_p: Array, k_d: Array) -> Margins:
        """Return the worst margins of n pairs of gains."""
        own = self._own.margins_over(k_p, k_d)
        others = [each.margins_over(k_p, k_d) for each in self._plausible]
        least = {
            name: np.min([each[name] for each in others], axis=0)
            for name in ("gain_margin", "phase_margin")
        }
        request = self._request
        gain, phase = own["gain_margin"], own["phase_margin"]
        if self._loop is None:
            hold = (gain >= request.gain_margin) & (phase >= request.phase_margin)
            hold &= least["gain_margin"] >= math.sqrt(request.gain_margin)
            hold &= least["phase_margin"] >= 0.5 * request.phase_margin
        else:
            gain, phase, hold = self._loop.margins(k_p, k_d)
            hold &= ~np.isnan(least["gain_margin"])
        return Margins(gain, phase, least["gain_margin"], least["phase_margin"], hold)


def plausible_motors(scenario: Scenario, request: SafeTuneRequest) -> tuple[Scenario, ...]:
    """Return the scenario with each of the motors that are drawn about its own.

    Raises
    ------
    ConfigError
        If `vary` names what the motor has not, or draws a value out of its range.
    """
    tables = scenario.model_dump(mode="json")
    vary = request.vary
    if vary == VARY:  # the motor may lack some of these, as in Monte Carlo
        absent = missing(tables["plant"], vary)
        vary = tuple(each for each in vary if each.path not in absent)
    draws = draw(tables["plant"], vary, cases=request.motors, seed=request.seed)
    return tuple(load_scenario(apply_changes(tables, each)) for each in draws)


def gains_of(scenario: Scenario, variant: str, axis: str) -> tuple[float, float]:
    """Return k_p and k_d of an axis."""
    gains: Any = getattr(scenario.variants[variant].controller, axis)
    return gains.k_p, gains.k_d
