"""Candidates of a search as documents."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motionlab.loop.document import WorstMargin
from motionlab.loop.family import LoopFamily, VelocityMargin
from motionlab.studies.tune.documents import (
    Candidate,
    GainMargins,
    GainMetrics,
    TunedAxis,
)
from motionlab.studies.tune.evaluation import Group, Tried, Verdict
from motionlab.studies.tune.problem import Outcome

Array = NDArray[np.float64]


def candidate(  # noqa: PLR0913, PLR0917 - a set of gains and what is known of it
    group: Group,
    values: dict[str, float],
    tried: Tried,
    verdict: Verdict,
    origin: Literal["present", "paper", "start"],
    start: int | None = None,
) -> Candidate:
    """Return a set of gains with its metrics and margins on each motor and the verdict on it."""
    problem = group.problem
    return Candidate(
        origin=origin,
        start=start,
        axes={
            axis: TunedAxis(
                k_p=values[f"{axis}.k_p"],
                k_d=values[f"{axis}.k_d"],
                metrics={name: _metrics(tried[name, axis]) for name in problem.setups},
                margins={
                    motor: _margins(family, *group.gains(values, axis))
                    for (motor, of), family in group.families(values).items()
                    if of == axis
                },
            )
            for axis in group.axes
        },
        also={path: values[path] for path in group.request.also},
        **vars(verdict.document()),
        set={problem.path(path): value for path, value in values.items()},
    )


def _metrics(outcome: Outcome) -> GainMetrics:
    figures = {name: getattr(outcome, name) for name in GainMetrics.model_fields}
    return GainMetrics(**(dict.fromkeys(figures) if outcome.diverged else figures))


def _margins(family: LoopFamily, k_p: Array, k_d: Array) -> GainMargins:
    if family.radius(k_p, k_d) >= 1.0:
        return GainMargins(stable=False, gain_margin=None, phase_margin=None, Ms=None)
    figures = family.figures(float(k_p), float(k_d))._asdict()
    return GainMargins(stable=True, **{name: _worst(margins) for name, margins in figures.items()})


def _worst(margin: VelocityMargin) -> WorstMargin | None:
    return WorstMargin(**margin._asdict()) if math.isfinite(margin.value) else None
