"""Learning planned: a scenario, who learns, and the filters; refused where it would diverge."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.simulation.learnt import Lap, checked_lap
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.studies.learn.documents import LearnRequest
from motionlab.studies.learn.learning_filter import (
    SPEEDS,
    LearningFilter,
    bandwidth_of,
    thinned,
    to_error,
)
from motionlab.studies.learn.lessons import LAPS, MEAN_LAPS, SIMULATED_LAPS
from motionlab.studies.study import Source
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]

_FREQUENCIES = 160
_LESSONS_MOST = 100.0
"""Laps of other motions that are fitted at once, s."""


@dataclass(frozen=True)
class LearnPlan:
    """Learning that has passed every check.

    Attributes
    ----------
    request : LearnRequest
        As validated.
    prepared : Prepared
        The scenario.
    variant : str
        Which controller learns.
    lap : Lap
        Of the motion.
    filters : dict of str to LearningFilter
        Of the axes that move.
    bandwidths : dict of str to float
        Hz.
    after : tuple of LearnPlan
        Motions that are learnt first.
    """

    request: LearnRequest
    prepared: Prepared
    variant: str
    lap: Lap
    filters: dict[str, LearningFilter]
    bandwidths: dict[str, float]
    after: tuple[LearnPlan, ...] = ()

    @property
    def seconds(self) -> float:
        """Simulated time, s."""
        laps = self.request.laps + 1
        if self.after:
            laps += SIMULATED_LAPS + 3
        own = (self.lap.first + laps * self.lap.ticks) * CONTROL_PERIOD
        return own + sum(each.seconds + MEAN_LAPS * each.lap_seconds for each in self.after)

    @property
    def lap_seconds(self) -> float:
        """Duration of a lap, s."""
        return self.lap.ticks * CONTROL_PERIOD

    @property
    def scenario(self) -> Scenario:
        """The scenario."""
        return self.prepared.scenario


def plan(request: LearnRequest, source: Source | None = None) -> LearnPlan:
    """Return the checked plan of a request.

    Raises
    ------
    ConfigError
        Naming every field that is wrong; where the controller has no linearisation; and where
        learning would diverge, unless it is to go on anyway.
    """
    scenario = load_scenario(request.scenario if source is None else source, request.set)
    prepared = prepare(scenario)
    scenario = prepared.scenario
    lap = checked_lap(prepared.reference)
    variant = request.variant or list(scenario.variants)[-1]
    if variant not in scenario.variants:
        choices = ", ".join(scenario.variants)
        raise ConfigError(FieldError("variant", "is not in the scenario", variant, choices))
    controller = scenario.variants[variant].controller
    bandwidths = {
        axis: getattr(request.bandwidth, axis) or bandwidth_of(getattr(controller, axis).notch)
        for axis in prepared.reference.moving
    }
    filters = {
        axis: LearningFilter.of(scenario, variant, axis, lap.ticks, bandwidth)
        for axis, bandwidth in bandwidths.items()
    }
    after = tuple(_lesson(request, source, motion, k) for k, motion in enumerate(request.after))
    if (seconds := sum(each.lap_seconds for each in after)) > _LESSONS_MOST:
        allowed = f"<= {_LESSONS_MOST:g}"
        message = "laps are too long to be fitted together"
        raise ConfigError(FieldError("after", message, seconds, allowed, "s"))
    planned = LearnPlan(request, prepared, variant, lap, filters, bandwidths, after)
    if not request.anyway:
        _refuse_divergence(planned)
    return planned


def _lesson(
    request: LearnRequest, source: Source | None, motion: str | dict[str, Any], number: int
) -> LearnPlan:
    """Return the plan of a motion that is learnt first."""
    changes = {
        "set": request.set | {"trajectory": motion, "learnt": None},
        "after": (),
        "laps": LAPS,
    }
    try:
        return plan(request.model_copy(update=changes), source)
    except ConfigError as error:
        raise ConfigError(
            *(
                replace(each, loc=f"after.{number}{each.loc.removeprefix('trajectory')}")
                for each in error.errors
            )
        ) from None


def _refuse_divergence(planned: LearnPlan) -> None:
    errors = []
    for axis, each in planned.filters.items():
        rho = factors(planned, axis, planned.scenario, band(each))
        worst = int(rho.argmax())
        if rho[worst] >= 1.0:
            at = each.frequency[band(each)][worst]
            errors.append(
                FieldError(
                    f"bandwidth.{axis}",
                    f"learning would diverge: an error at {at:.4g} Hz would grow by "
                    f"{rho[worst]:.3g} from lap to lap; a lower bandwidth or gain converges",
                    planned.bandwidths[axis],
                    unit="Hz",
                )
            )
    if errors:
        raise ConfigError(*errors)


def band(each: LearningFilter) -> NDArray[np.intp]:
    """Return indices of frequencies at which something is learnt, at most some."""
    last = int(np.flatnonzero(each.band)[-1])
    return thinned(each.frequency[: last + 1], _FREQUENCIES)


def factors(planned: LearnPlan, axis: str, scenario: Scenario, at: NDArray[np.intp]) -> Array:
    """Return the largest rho over velocities of the motor of a scenario, (n,).

    Parameters
    ----------
    planned : LearnPlan
        Whose filter learns.
    axis : str
        ``x`` or ``y``.
    scenario : Scenario
        Motor, under the same controller.
    at : ndarray of int, shape (n,)
        Indices of frequencies.
    """
    each, gain = planned.filters[axis], planned.request.gain
    part = LearningFilter(each.frequency[at], each.response[at], each.q[at])
    return np.max(
        [
            part.factor(to_error(scenario, planned.variant, axis, speed, part.frequency), gain)
            for speed in SPEEDS
        ],
        axis=0,
    )
