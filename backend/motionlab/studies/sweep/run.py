"""A sweep checked, run in batches, and put into its document."""

from __future__ import annotations

import math
from contextlib import nullcontext
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab import __version__
from motionlab.analysis.metrics import DEFINITIONS
from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.config.validation_errors import is_whole, unit_of
from motionlab.errors import ConfigError, FieldError
from motionlab.executors.executor import current
from motionlab.lanes import model_hash
from motionlab.simulation.batch import changed, check_length, naming, run_batch, tasks
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.result import plant_name
from motionlab.studies.study import Progress, Source
from motionlab.studies.sweep.documents import (
    Best,
    PartialSweep,
    SweepDocument,
    SweepRequest,
    SweptAxis,
    SweptField,
    SweptVariant,
)
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.reference import ticks_of

BEST = ("max_abs_following_error", "rms_following_error")
"""Metrics whose best cases are named."""

_DIGITS = 7

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SweepPlan:
    """A sweep that has passed every check without a run.

    Attributes
    ----------
    request : SweepRequest
        As validated.
    base : Prepared
        The scenario without any swept value.
    points : list of list
        Values of each swept field.
    cases : list of dict
        Changes of each case, dotted path to value.
    seconds : float
        Simulated time of all cases and variants, s.
    """

    request: SweepRequest
    base: Prepared
    points: list[list[Any]]
    cases: list[dict[str, Any]]
    seconds: float


def plan(request: SweepRequest, source: Source | None = None) -> SweepPlan:
    """Return the cases of a sweep.

    Of a grid each listed value and both ends of each range are checked without the other fields,
    of a list each row; the motion of each case is planned, but not sampled.

    Raises
    ------
    ConfigError
        Naming the dimension, or the case and its values, and what is wrong.
    Infeasible
        If the scenario's own motor cannot follow its motion.
    """
    scenario = load_scenario(request.scenario if source is None else source, request.set)
    base = prepare(scenario)
    points = [_points(index, scenario, request) for index in range(len(request.grid))]
    cases = request.cases(points)
    document = base.scenario.model_dump(mode="json")
    if request.combine == "grid":
        for index, (dimension, values) in enumerate(zip(request.grid, points, strict=True)):
            listed = values if dimension.values is not None else [values[0], values[-1]]
            for value in {repr(each): each for each in listed}.values():
                with naming(f"grid.{index}"):
                    changed(document, {dimension.path: value}, request.set)
    else:  # of a list only whole rows need be valid
        for number, case in enumerate(cases):
            with naming(f"case {number}", case):
                changed(document, case, request.set)
    ticks = _ticks(base, document, cases, request.set)
    seconds = ticks * CONTROL_PERIOD * len(scenario.variants)
    return SweepPlan(request, base, points, cases, seconds)


def _points(index: int, scenario: Scenario, request: SweepRequest) -> list[Any]:
    dimension = request.grid[index]
    try:
        return dimension.points(whole=is_whole(dimension.path, scenario))
    except ValueError as error:
        raise ConfigError(FieldError(f"grid.{index}: {dimension.path}", str(error))) from None


def _ticks(
    base: Prepared, document: dict[str, Any], cases: list[dict[str, Any]], shared: dict[str, Any]
) -> int:
    """Return the ticks of all cases; raise ConfigError naming one whose motion is too long."""
    known: dict[str, int] = {}
    total = 0
    for number, case in enumerate(cases):
        motion = {path: case[path] for path in case if path.split(".")[0] == "trajectory"}
        key = repr(motion)
        if key not in known:
            with naming(f"case {number}", case) if motion else nullcontext():
                scenario = changed(document, motion, shared) if motion else base.scenario
                known[key] = ticks_of(scenario.trajectory)
                check_length(known[key])
        total += known[key]
    return total


def run(planned: SweepPlan, progress: Progress | None = None) -> SweepDocument:
    """Run every case; cases of one motion run side by side.

    Parameters
    ----------
    planned : SweepPlan
        From `plan`.
    progress : callable, optional
        Takes the share done and the metrics so far; what it raises ends the sweep.

    Returns
    -------
    SweepDocument
        The metrics of each case are those of its run alone, to the last bit before rounding.

    Raises
    ------
    ConfigError
        Naming the case whose values do not go together.
    """
    count, scenario = len(planned.cases), planned.base.scenario
    shape = (count, len(scenario.variants), len(AXES))
    metrics = {name: np.full(shape, np.nan) for name in DEFINITIONS}
    failed, feasible = np.full(shape[:2], -1), np.zeros(count, dtype=bool)
    partial: PartialSweep | None = None

    def tell(now: float) -> None:
        nonlocal partial
        if progress is not None:
            progress(now, partial)
        partial = None

    parts = tasks(scenario, planned.cases, planned.request.set)
    for part, batch in zip(parts, current().map(run_batch, parts, tell), strict=True):
        here = slice(part.first, part.first + len(part.changes))
        failed[here], feasible[here] = batch.failed, batch.feasible
        for name, values in batch.metrics.items():
            metrics[name][here] = values
        partial = PartialSweep(done=here.stop, variants=_variants(planned, metrics, failed))
    return SweepDocument(
        scenario=scenario.name,
        plant=plant_name(scenario.plant),
        seed=scenario.seed,
        version=__version__,
        model=model_hash(),
        fields=[
            SweptField(path=d.path, unit=unit_of(d.path, scenario), values=values)
            for d, values in zip(planned.request.grid, planned.points, strict=True)
        ],
        shape=list(planned.request.shape),
        cases=len(planned.cases),
        infeasible=np.flatnonzero(~feasible).tolist(),
        variants=_variants(planned, metrics, failed),
        best=_best(planned, metrics),
    )


def _variants(
    planned: SweepPlan, metrics: dict[str, Array], failed: NDArray[np.int64]
) -> dict[str, SweptVariant]:
    return {
        name: SweptVariant(
            label=variant.label,
            diverged=np.flatnonzero(failed[:, v] >= 0).tolist(),
            axes=_axes(metrics, v),
        )
        for v, (name, variant) in enumerate(planned.base.scenario.variants.items())
    }


def _axes(metrics: dict[str, Array], v: int) -> dict[str, SweptAxis]:
    """Return the axes that move in some case."""
    return {
        axis: SweptAxis(metrics={name: _short(values[:, v, a]) for name, values in metrics.items()})
        for a, axis in enumerate(AXES)
        if np.isfinite(metrics[BEST[0]][:, v, a]).any()
    }


def _best(planned: SweepPlan, metrics: dict[str, Array]) -> list[Best]:
    best = []
    for v, variant in enumerate(planned.base.scenario.variants):
        for a, axis in enumerate(AXES):
            for name in BEST:
                values = metrics[name][:, v, a]
                if np.isfinite(values).any():
                    case = int(np.nanargmin(values))
                    best.append(
                        Best(
                            variant=variant,
                            axis=axis,
                            metric=name,
                            case=case,
                            value=float(values[case]),
                            set=planned.cases[case],
                        )
                    )
    return best


def _short(values: Array) -> list[float | None]:
    return [
        float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None for value in values.tolist()
    ]
