"""A sweep checked, run in batches, and put into its document."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab import __version__
from motionlab.config.changes import apply_changes
from motionlab.config.load import load_scenario, validate
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.config.validation_errors import unit_of
from motionlab.errors import ConfigError, FieldError, Infeasible
from motionlab.lanes import model_hash
from motionlab.results.metrics import DEFINITIONS
from motionlab.simulation.batch import run_prepared
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.result import plant_name
from motionlab.studies.study import Source
from motionlab.studies.sweep.document import (
    Best,
    SweepDocument,
    SweptAxis,
    SweptField,
    SweptVariant,
)
from motionlab.studies.sweep.request import SweepRequest

BEST = ("max_abs_following_error", "rms_following_error")
"""Metrics whose best cases are named."""

_TOGETHER = 1000  # cases that are prepared and run side by side, at most
_MOTION_SIZE = 100_000_000  # bytes of references and loads that they may hold
_DIGITS = 7

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sweep:
    """A sweep that has passed every check which takes no run.

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


def plan(request: SweepRequest, source: Source | None = None) -> Sweep:
    """Return the cases of a sweep; each value is checked by itself, beside no other.

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
                _changed(document, {dimension.path: value}, f"grid.{index}")
    return Sweep(request, base, cases)


def run(planned: Sweep, progress: Callable[[float], None] | None = None) -> SweepDocument:
    """Run every case; cases of one motion run side by side.

    Parameters
    ----------
    planned : Sweep
        From `plan`.
    progress : callable, optional
        Takes the share done; what it raises ends the sweep.

    Returns
    -------
    SweepDocument
        The metrics of each case are those of its run alone, to the last bit before rounding.

    Raises
    ------
    ConfigError
        Naming the case whose values do not go together.
    """
    variants = tuple(planned.base.scenario.variants)
    shape = (len(planned.cases), len(variants), len(AXES))
    metrics = {name: np.full(shape, np.nan) for name in DEFINITIONS}
    diverged = np.zeros(shape[:2], dtype=bool)
    infeasible: list[int] = []
    done = 0
    for numbers, prepared in _parcels(planned, infeasible):

        def tell(share: float, done: int = done, size: int = len(numbers)) -> None:
            if progress is not None:
                progress((done + share * size) / len(planned.cases))

        batch = run_prepared(prepared, progress=tell)
        diverged[numbers] = batch.failed >= 0
        for name, values in batch.metrics.items():
            metrics[name][numbers] = values
        done = numbers[-1] + 1
    scenario = planned.base.scenario
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
        infeasible=infeasible,
        variants={
            name: SweptVariant(
                label=variant.label,
                diverged=np.flatnonzero(diverged[:, v]).tolist(),
                axes=_axes(metrics, v),
            )
            for v, (name, variant) in enumerate(scenario.variants.items())
        },
        best=_best(planned, metrics),
    )


def _parcels(planned: Sweep, infeasible: list[int]) -> Iterator[tuple[list[int], list[Prepared]]]:
    """Yield numbers of cases with the cases, prepared; as many at once as memory may hold."""
    document = planned.base.scenario.model_dump(mode="json")
    numbers: list[int] = []
    prepared: list[Prepared] = []
    motions: dict[int, int] = {}
    for number, changes in enumerate(planned.cases):
        try:
            case = prepare(_changed(document, changes, f"case {number}"))
        except Infeasible:
            infeasible.append(number)
            continue
        numbers.append(number)
        prepared.append(case)
        motions[id(case.reference)] = case.motion_size
        if len(numbers) == _TOGETHER or sum(motions.values()) > _MOTION_SIZE:
            yield numbers, prepared
            numbers, prepared, motions = [], [], {}
    if numbers:
        yield numbers, prepared


def _changed(document: dict[str, Any], changes: Mapping[str, Any], where: str) -> Scenario:
    try:
        scenario = validate(apply_changes(document, changes))
    except ConfigError as error:
        raise ConfigError(*(replace(e, loc=f"{where}: {e.loc}") for e in error.errors)) from None
    if list(scenario.variants) != list(document["variants"]):
        message = "a sweep cannot add or remove a variant"
        raise ConfigError(FieldError(where, message, list(scenario.variants)))
    return scenario


def _axes(metrics: dict[str, Array], v: int) -> dict[str, SweptAxis]:
    """Return the axes that move in some case."""
    return {
        axis: SweptAxis(metrics={name: _short(values[:, v, a]) for name, values in metrics.items()})
        for a, axis in enumerate(AXES)
        if np.isfinite(metrics[BEST[0]][:, v, a]).any()
    }


def _best(planned: Sweep, metrics: dict[str, Array]) -> list[Best]:
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
