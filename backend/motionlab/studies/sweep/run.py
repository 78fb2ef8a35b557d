"""A sweep checked, run in batches, and put into its document."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab import __version__
from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.config.validation_errors import unit_of
from motionlab.executors.executor import current
from motionlab.lanes import model_hash
from motionlab.results.metrics import DEFINITIONS
from motionlab.simulation.batch import changed, run_batch, tasks
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.result import plant_name
from motionlab.studies.study import Progress, Source
from motionlab.studies.sweep.document import (
    Best,
    PartialSweep,
    SweepDocument,
    SweptAxis,
    SweptField,
    SweptVariant,
)
from motionlab.studies.sweep.request import SweepRequest

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
    cases : list of dict
        Changes of each case, dotted path to value.
    """

    request: SweepRequest
    base: Prepared
    cases: list[dict[str, Any]]

    @property
    def seconds(self) -> float:
        """Simulated time of all cases and variants, s, if each takes as long as the scenario."""
        return self.base.work * len(self.cases)


def plan(request: SweepRequest, source: Source | None = None) -> SweepPlan:
    """Return the cases of a sweep; each value is checked by itself, without the others.

    Parameters
    ----------
    request : SweepRequest
        As validated.
    source : str, Path or dict, optional
        The scenario in place of the request's.

    Raises
    ------
    ConfigError
        Naming the dimension and what is wrong with its value.
    Infeasible
        If the scenario's own motor cannot follow its motion.
    """
    scenario = load_scenario(request.scenario if source is None else source, request.set)
    base = prepare(scenario)
    cases = request.cases()
    if request.combine == "grid":  # of a list only whole rows need be valid
        document = scenario.model_dump(mode="json")
        for index, dimension in enumerate(request.grid):
            points = dimension.points()
            for value in {str(point): point for point in (points[0], points[-1])}.values():
                changed(document, {dimension.path: value}, f"grid.{index}")
    return SweepPlan(request, base, cases)


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
    said: PartialSweep | None = None

    def tell(now: float) -> None:
        nonlocal said
        if progress is not None:
            progress(now, said)
        said = None

    parts = tasks(scenario, planned.cases)
    for part, found in zip(parts, current().map(run_batch, parts, tell), strict=True):
        here = slice(part.first, part.first + len(part.changes))
        failed[here], feasible[here] = found.failed, found.feasible
        for name, values in found.metrics.items():
            metrics[name][here] = values
        said = PartialSweep(done=here.stop, variants=_variants(planned, metrics, failed))
    return SweepDocument(
        scenario=scenario.name,
        plant=plant_name(scenario.plant),
        seed=scenario.seed,
        version=__version__,
        model=model_hash(),
        fields=[
            SweptField(path=d.path, unit=unit_of(d.path, scenario), values=d.points())
            for d in planned.request.grid
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
    found = []
    for v, variant in enumerate(planned.base.scenario.variants):
        for a, axis in enumerate(AXES):
            for name in BEST:
                values = metrics[name][:, v, a]
                if np.isfinite(values).any():
                    case = int(np.nanargmin(values))
                    found.append(
                        Best(
                            variant=variant,
                            axis=axis,
                            metric=name,
                            case=case,
                            value=float(values[case]),
                            set=planned.cases[case],
                        )
                    )
    return found


def _short(values: Array) -> list[float | None]:
    return [
        float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None for value in values.tolist()
    ]
