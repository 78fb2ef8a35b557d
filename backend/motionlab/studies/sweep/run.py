"""A sweep checked, run in batches, and put into its document."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab import __version__
from motionlab.analysis.metrics import DEFINITIONS
from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.config.validation_errors import is_whole, unit_of
from motionlab.errors import ConfigError, FieldError
from motionlab.executors.executor import current
from motionlab.executors.kept import Arrays, Form, kept_map
from motionlab.lanes import model_hash
from motionlab.simulation.batch import (
    Batch,
    CaseTask,
    at_case,
    changed,
    check_length,
    naming,
    run_batch,
    tasks,
)
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.result import plant_name
from motionlab.studies.study import Progress, Source
from motionlab.studies.sweep.documents import (
    Best,
    PartialSweep,
    SweepDocument,
    SweptAxis,
    SweptField,
    SweptFigure,
    SweptLimit,
    SweptVariant,
)
from motionlab.studies.sweep.figures import (
    MARGIN_UNITS,
    Criteria,
    Figure,
    front_of,
    margins_of_case,
)
from motionlab.studies.sweep.request import SweepRequest
from motionlab.studies.sweep.sampling import draw
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.reference import ticks_of

BEST = ("max_abs_following_error", "rms_following_error")
"""Metrics whose best cases are named."""

KEPT_SECONDS = 3000.0
"""Simulated time, s, from which on parts of a sweep are kept: about a second of two cores."""

_DIGITS = 7
_CORNERS_MAX = 1000

Array = NDArray[np.float64]
Case = dict[str, Any]


@dataclass(frozen=True)
class SweepPlan:
    """A sweep that has passed every check without a run.

    Attributes
    ----------
    request : SweepRequest
        As validated.
    base : Prepared
        The scenario without any swept value.
    whole : list of bool
        Whether each swept field takes whole numbers alone.
    points : list of list
        Values of each swept field; empty of a search, which chooses them as it goes.
    cases : list of dict
        Changes of each case, dotted path to value; none of a search.
    criteria : Criteria
        Objectives and limits.
    seconds : float
        Simulated time of all cases and variants, s.
    """

    request: SweepRequest
    base: Prepared
    whole: list[bool]
    points: list[list[Any]]
    cases: list[Case]
    criteria: Criteria
    seconds: float


def plan(request: SweepRequest, source: Source | None = None) -> SweepPlan:
    """Return the cases of a sweep.

    Of a grid each listed value and both ends of each range are checked without the other fields, as
    they are where cases are drawn or searched; of a list each row. The motion of each case is
    planned, but not sampled.

    Raises
    ------
    ConfigError
        Naming the dimension, or the case and its values, and what is wrong.
    Infeasible
        If the scenario's own motor cannot follow its motion.
    """
    scenario = load_scenario(request.scenario if source is None else source, request.set)
    base = prepare(scenario)
    criteria = Criteria.of(request, base.scenario)
    whole = [is_whole(dimension.path, scenario) for dimension in request.grid]
    ends = [_ends(index, request, of) for index, of in enumerate(whole)]
    document = base.scenario.model_dump(mode="json")
    if request.combine != "list":
        for index, (dimension, listed) in enumerate(zip(request.grid, ends, strict=True)):
            for value in {repr(each): each for each in listed}.values():
                with naming(f"grid.{index}.{dimension.place(value)}".removesuffix(".")):
                    changed(document, {dimension.path: value}, request.set)
    if request.combine == "search":
        # Optuna is an extra.
        from motionlab.studies.sweep.search import check_searcher  # noqa: PLC0415

        check_searcher(request)
        points, cases = [[] for _ in request.grid], []
        ticks = _most_ticks(base, document, request, ends) * (request.samples or 0)
    else:
        points = draw(request, whole) if request.drawn else _grid(request, whole)
        cases = request.cases(points)
        ticks = _ticks(base, document, cases, request)
    if request.combine == "list":  # of a list only whole rows need be valid
        for number, case in enumerate(cases):
            with _of_case(request, number, case):
                changed(document, case, request.set)
    seconds = ticks * CONTROL_PERIOD * len(scenario.variants)
    return SweepPlan(request, base, whole, points, cases, criteria, seconds)


def _grid(request: SweepRequest, whole: list[bool]) -> list[list[Any]]:
    return [d.points(whole=of) for d, of in zip(request.grid, whole, strict=True)]


def _ends(index: int, request: SweepRequest, whole: bool) -> list[Any]:
    """Return listed values, or both ends of a range, of a field."""
    dimension = request.grid[index]
    try:
        if dimension.values is not None:
            return list(dimension.values)
        if request.drawn:
            return [dimension.at(0.0, whole=whole), dimension.at(1.0, whole=whole)]
        points = dimension.points(whole=whole)
    except ValueError as error:
        message = f"{dimension.path}: {error}"
        raise ConfigError(FieldError(f"grid.{index}", message)) from None
    return [points[0], points[-1]]


@contextmanager
def _of_case(request: SweepRequest, number: int, case: Case) -> Iterator[None]:
    """Have errors be of the value of the request that a case has them from, and name the case."""
    try:
        yield
    except ConfigError as error:
        places = [(request.place_of(e.loc, case), e) for e in error.errors]
        named = [(place, replace(e, loc=f"case {number}: {e.loc}")) for place, e in places]
        raise ConfigError(*(at_case(place, case, e) for place, e in named)) from None


def _ticks(
    base: Prepared, document: dict[str, Any], cases: list[Case], request: SweepRequest
) -> int:
    """Return the ticks of all cases; raise ConfigError naming one whose motion is too long."""
    known: dict[str, int] = {}
    total = 0
    for number, case in enumerate(cases):
        motion = {path: case[path] for path in case if path.split(".")[0] == "trajectory"}
        key = repr(motion)
        if key not in known:
            with _of_case(request, number, case) if motion else nullcontext():
                scenario = changed(document, motion, request.set) if motion else base.scenario
                known[key] = ticks_of(scenario.trajectory)
                check_length(known[key])
        total += known[key]
    return total


def _most_ticks(
    base: Prepared, document: dict[str, Any], request: SweepRequest, ends: list[list[Any]]
) -> int:
    """Return the ticks of the longest motion between the ends of all fields."""
    fields = [
        (dimension.path, values)
        for dimension, values in zip(request.grid, ends, strict=True)
        if dimension.path.split(".")[0] == "trajectory"
    ]
    if math.prod(len(values) for _, values in fields) > _CORNERS_MAX:
        message = "has too many values of the motion for a search: sweep them"
        raise ConfigError(FieldError("grid", message))
    paths = [path for path, _ in fields]
    corners = product(*(values for _, values in fields))
    motions = [dict(zip(paths, corner, strict=True)) for corner in corners]
    return max(_ticks(base, document, [motion], request) for motion in motions)


class SweepTask(NamedTuple):
    """Some cases, and the controllers and axes whose margins are needed."""

    cases: CaseTask
    loops: tuple[tuple[str, str], ...]


def run_task(task: SweepTask, progress: Callable[[float], None]) -> Batch:
    """Run some cases, and find their margins, which are metrics among the others."""
    cases, loops = task
    batch = run_batch(cases, progress)
    if not loops:
        return batch
    margins = [
        margins_of_case(changed(cases.scenario, each, cases.shared), loops)
        for each in cases.changes
    ]
    for name in MARGIN_UNITS:
        batch.metrics[name] = np.array([each[name] for each in margins])
    return batch


def _content(task: SweepTask) -> list[Any]:
    cases = task.cases
    return [cases.scenario, cases.changes, cases.shared, sorted(cases.maps), task.loops]


def _arrays(batch: Batch) -> Arrays:
    return {"failed": batch.failed, "feasible": batch.feasible, **batch.metrics}


def _batch(arrays: Arrays, task: SweepTask) -> Batch:
    metrics = {name: arrays[name] for name in (*DEFINITIONS, *(MARGIN_UNITS if task.loops else ()))}
    variants = tuple(task.cases.scenario["variants"])
    return Batch(variants, metrics, arrays["failed"], arrays["feasible"])


_FORM = Form[SweepTask, Batch](_content, _arrays, _batch)


class Results:
    """Metrics of the cases that have run.

    Attributes
    ----------
    cases : list of dict
        Changes of each.
    metrics : dict of str to ndarray, shape (cases, variants, axes)
        NaN where a case has none.
    failed : ndarray of int, shape (cases, variants)
        Tick at which a variant diverged; -1 where it has not.
    feasible : ndarray of bool, shape (cases,)
        Whether the motor can follow the motion.
    """

    def __init__(self, planned: SweepPlan, size: int) -> None:
        self.variants = list(planned.base.scenario.variants)
        shape = (size, len(self.variants), len(AXES))
        names = (*DEFINITIONS, *(MARGIN_UNITS if planned.criteria.loops else ()))
        self.cases: list[Case] = []
        self.metrics = {name: np.full(shape, np.nan) for name in names}
        self.failed, self.feasible = np.full(shape[:2], -1), np.zeros(size, dtype=bool)
        self._plan = planned

    def run(self, cases: Sequence[Case], tell: Callable[[float], None]) -> Iterator[None]:
        """Run further cases side by side; yield after each part of them."""
        planned = self._plan
        parts = tasks(planned.base.scenario, cases, planned.request.set)
        todo = [SweepTask(part, planned.criteria.loops) for part in parts]
        kept = planned.seconds >= KEPT_SECONDS
        batches = (
            kept_map(run_task, todo, _FORM, tell) if kept else current().map(run_task, todo, tell)
        )
        for part, batch in zip(parts, batches, strict=True):
            here = slice(len(self.cases), len(self.cases) + len(part.changes))
            self.cases += [dict(each) for each in part.changes]
            self.failed[here], self.feasible[here] = batch.failed, batch.feasible
            for name, values in batch.metrics.items():
                self.metrics[name][here] = values
            yield

    def of(self, figure: Figure) -> Array:
        """Return a figure of each case."""
        return figure.of(self.metrics, self.variants)

    def excess(self) -> Array:
        """Return by how much each case exceeds each limit; see `Criteria.excess`."""
        return self._plan.criteria.excess(self.metrics, self.variants)

    def costs(self) -> Array:
        """Return the objectives of each case; see `Criteria.costs`."""
        return self._plan.criteria.costs(self.metrics, self.variants)


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
    request = planned.request
    size = request.samples or 0 if request.combine == "search" else len(planned.cases)
    results = Results(planned, size)
    partial: PartialSweep | None = None

    def tell(now: float) -> None:
        nonlocal partial
        if progress is not None:
            progress(now, partial)
        partial = None

    if request.combine == "search":
        # An extra, which brings Optuna.
        from motionlab.studies.sweep.search import search  # noqa: PLC0415

        parts = search(planned, results, tell)
    else:
        parts = results.run(planned.cases, tell)
    for _ in parts:
        partial = PartialSweep(done=len(results.cases), variants=_variants(planned, results))
    return _document(planned, results)


def _document(planned: SweepPlan, results: Results) -> SweepDocument:
    request, criteria, scenario = planned.request, planned.criteria, planned.base.scenario
    paths = [dimension.path for dimension in request.grid]
    points = planned.points
    if request.combine == "search":
        points = [[case[path] for case in results.cases] for path in paths]
    excess = results.excess()
    met = np.asarray((excess <= 0.0).all(axis=1))
    return SweepDocument(
        scenario=scenario.name,
        plant=plant_name(scenario.plant),
        seed=scenario.seed,
        version=__version__,
        model=model_hash(),
        fields=[
            SweptField(path=path, unit=unit_of(path, scenario), values=values)
            for path, values in zip(paths, points, strict=True)
        ],
        shape=list(request.shape),
        cases=len(results.cases),
        infeasible=np.flatnonzero(~results.feasible).tolist(),
        variants=_variants(planned, results),
        best=_best(results, met),
        objectives=[
            SweptFigure(of=each.name, unit=each.unit, falls=each.falls, values=_short(values))
            for each, values in ((each, results.of(each)) for each in criteria.objectives)
        ],
        limits=[
            SweptLimit(
                of=each.name,
                unit=each.unit,
                at_least=limit.at_least,
                at_most=limit.at_most,
                exceeded=np.flatnonzero(over > 0.0).tolist(),
            )
            for (each, limit), over in zip(criteria.limits, excess.T, strict=True)
        ],
        front=front_of(results.costs(), met),
    )


def _variants(planned: SweepPlan, results: Results) -> dict[str, SweptVariant]:
    return {
        name: SweptVariant(
            label=variant.label,
            diverged=np.flatnonzero(results.failed[:, v] >= 0).tolist(),
            axes=_axes(results.metrics, v),
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


def _best(results: Results, met: NDArray[np.bool_]) -> list[Best]:
    """Return the best cases of those that meet all limits."""
    best = []
    for v, variant in enumerate(results.variants):
        for a, axis in enumerate(AXES):
            for name in BEST:
                values = np.where(met, results.metrics[name][:, v, a], np.nan)
                if np.isfinite(values).any():
                    case = int(np.nanargmin(values))
                    best.append(
                        Best(
                            variant=variant,
                            axis=axis,
                            metric=name,
                            case=case,
                            value=float(values[case]),
                            set=results.cases[case],
                        )
                    )
    return best


def _short(values: Array) -> list[float | None]:
    return [
        float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None for value in values.tolist()
    ]
