"""Every number of a scenario changed down and up, in one batch."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab import __version__
from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.config.validation_errors import is_whole, unit_of
from motionlab.errors import ConfigError, FieldError
from motionlab.executors.executor import current
from motionlab.lanes import model_hash
from motionlab.simulation.batch import Batch, changed, check_length, tasks
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.result import plant_name
from motionlab.studies.sensitivity.documents import (
    ChangedField,
    FieldEffect,
    LeftField,
    SensitivityDocument,
    SensitivityRequest,
)
from motionlab.studies.study import Progress, Source
from motionlab.studies.sweep.run import SweepTask, run_task

Array = NDArray[np.float64]

_DIGITS = 7
_NO_MODEL = ("divergence_error", "learnt")  # what ends a run, and a force of its own motion


@dataclass(frozen=True)
class SensitivityPlan:
    """Changes that have passed every check without a run.

    Attributes
    ----------
    request : SensitivityRequest
        As validated.
    base : Prepared
        The scenario without a change.
    fields : list of ChangedField
        What is changed.
    left : list of LeftField
        What is not.
    cases : list of dict
        The base, then each field's low and high value that there is: dotted path to value.
    """

    request: SensitivityRequest
    base: Prepared
    fields: list[ChangedField]
    left: list[LeftField]
    cases: list[dict[str, Any]]

    @property
    def seconds(self) -> float:
        """Simulated time of all cases and variants, s."""
        return self.base.work * len(self.cases)


def plan(request: SensitivityRequest, source: Source | None = None) -> SensitivityPlan:
    """Return the changes of every number, or of those that are named.

    Raises
    ------
    ConfigError
        If the scenario is not valid, or has no such number.
    Infeasible
        If its motor cannot follow its motion.
    """
    scenario = load_scenario(request.scenario if source is None else source, request.set)
    base = prepare(scenario)
    check_length(base.reference.ticks)
    document = base.scenario.model_dump(mode="json")
    numbers = {
        path: value for path, value in _numbers(document) if not is_whole(path, base.scenario)
    }
    chosen = _chosen(request.fields, numbers)
    fields: list[ChangedField] = []
    left: list[LeftField] = []
    cases: list[dict[str, Any]] = [{}]
    for path, value in chosen.items():
        if value == 0.0:
            left.append(LeftField(path=path, why="is zero, of which there is no share"))
            continue
        able: list[float | None] = []
        reason = ""
        for sign in (-1.0, 1.0):
            other = value * (1.0 + sign * request.step)
            try:
                changed(document, {path: other}, request.set)
            except ConfigError as error:
                able.append(None)
                reason = str(error)
                continue
            able.append(other)
            cases.append({path: other})
        low, high = able
        if low is None and high is None:
            left.append(LeftField(path=path, why=reason))
            continue
        unit = unit_of(path, base.scenario)
        fields.append(ChangedField(path=path, unit=unit, value=value, low=low, high=high))
    if not fields:
        message = "has no number that could be changed: " + "; ".join(
            f"{each.path} {each.why}" for each in left[:3]
        )
        raise ConfigError(FieldError("fields", message))
    return SensitivityPlan(request, base, fields, left, cases)


def _numbers(tables: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """Yield dotted path and value of every number but whole ones and switches."""
    items = tables.items() if isinstance(tables, Mapping) else enumerate(tables)
    for key, value in items:
        inner = f"{path}.{key}" if path else str(key)
        if inner in _NO_MODEL:
            continue
        if isinstance(value, Mapping | list):
            yield from _numbers(value, inner)
        elif isinstance(value, float) and math.isfinite(value):
            yield inner, value


def _chosen(named: tuple[str, ...], numbers: dict[str, float]) -> dict[str, float]:
    if not named:
        return numbers
    chosen: dict[str, float] = {}
    for index, name in enumerate(named):
        of = {p: v for p, v in numbers.items() if p == name or p.startswith(f"{name}.")}
        if not of:
            message = "is no number of the scenario, nor a table with any"
            raise ConfigError(FieldError(f"fields.{index}", message, name))
        chosen |= of
    return chosen


def run(planned: SensitivityPlan, progress: Progress | None = None) -> SensitivityDocument:
    """Run all changes side by side.

    Parameters
    ----------
    planned : SensitivityPlan
        From `plan`.
    progress : callable, optional
        Takes the share done; what it raises ends the study.

    Returns
    -------
    SensitivityDocument
        ``slope = (m(x + h) - m(x - h)) / 2h``, with h a share of x.
    """
    scenario, request = planned.base.scenario, planned.request
    loops = tuple((v, a) for v in scenario.variants for a in AXES) if request.margins else ()
    parts = tasks(scenario, planned.cases, request.set)
    todo = [SweepTask(part, loops) for part in parts]

    def tell(share: float) -> None:
        if progress is not None:
            progress(share, None)

    batches: list[Batch] = list(current().map(run_task, todo, tell))
    metrics = {
        name: np.concatenate([batch.metrics[name] for batch in batches])
        for name in batches[0].metrics
    }
    return SensitivityDocument(
        scenario=scenario.name,
        plant=plant_name(scenario.plant),
        seed=scenario.seed,
        version=__version__,
        model=model_hash(),
        step=request.step,
        fields=planned.fields,
        left=planned.left,
        variants={
            name: {
                axis: effects
                for a, axis in enumerate(AXES)
                if (effects := _effects(metrics, planned.fields, v, a))
            }
            for v, name in enumerate(scenario.variants)
        },
    )


def _effects(
    metrics: Mapping[str, Array], fields: list[ChangedField], v: int, a: int
) -> dict[str, FieldEffect]:
    """Return the effects on each metric that the unchanged scenario has."""
    effects: dict[str, FieldEffect] = {}
    for name, values in metrics.items():
        of = iter(values[:, v, a].tolist())
        base = next(of)
        if not math.isfinite(base):
            continue
        low, high, slope = [], [], []
        for field in fields:
            down = next(of) if field.low is not None else math.nan
            up = next(of) if field.high is not None else math.nan
            low.append(_short(down))
            high.append(_short(up))
            slope.append(_short(_slope(field, base, down, up)))
        effects[name] = FieldEffect(base=_short(base), low=low, high=high, slope=slope)
    return effects


def _slope(field: ChangedField, base: float, down: float, up: float) -> float:
    """Return a central difference; one of a side where the other has no value."""
    points = [
        (at, metric)
        for at, metric in ((field.low, down), (field.value, base), (field.high, up))
        if at is not None and math.isfinite(metric)
    ]
    if len(points) == 1:
        return math.nan
    (first, start), (last, end) = points[0], points[-1]
    return (end - start) / (last - first)


def _short(value: float) -> float | None:
    return float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None
