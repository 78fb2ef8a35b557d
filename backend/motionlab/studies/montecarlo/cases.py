"""Plants drawn, every controller run on each, and the statistics of their metrics."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab import __version__
from motionlab.analysis.metrics import DEFINITIONS
from motionlab.analysis.variant_comparison import RATIOS
from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.errors import ConfigError, FieldError
from motionlab.executors.executor import current
from motionlab.lanes import model_hash
from motionlab.simulation.batch import Batch, CaseTask, check_length, run_batch, tasks
from motionlab.simulation.prepare import Prepared, needs_plan, prepare
from motionlab.simulation.result import plant_name
from motionlab.studies.montecarlo.documents import (
    DEFAULT,
    Band,
    DrawnParameter,
    Histogram,
    MonteCarloAxis,
    MonteCarloDocument,
    MonteCarloRequest,
    MonteCarloVariant,
    Probability,
    Quantiles,
    WorstCase,
)
from motionlab.studies.montecarlo.draw import draw, missing
from motionlab.studies.montecarlo.statistics import (
    Bands,
    drawn_parameters,
    histogram,
    rank_correlations,
    threshold,
)
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]
Source = str | Path | dict[str, Any]

Correlations = dict[str, list[dict[str, list[float | None]]]]
"""By axis, variant and metric: rho with each drawn parameter of the axis."""

PEAK = "max_abs_following_error"
_WORST = 3
_DIGITS = 5
_Z = 1.959964  # of a 95 % interval


@dataclass(frozen=True)
class MonteCarloPlan:
    """Plants drawn for a Monte Carlo study that has passed every check.

    Attributes
    ----------
    request : MonteCarloRequest
        As validated.
    base : Prepared
        The scenario itself, which its motor can follow.
    draws : list of dict
        Changes that make the plant of each case: dotted path to value.
    notes : list of str
        Default variations left out, and why.
    seed : int
        Of the draws.
    motion : dict
        What a time-optimal path is planned for, where the scenario leaves that out, as a change:
        else a case run alone would plan it for its own plant.
    """

    request: MonteCarloRequest
    base: Prepared
    draws: list[dict[str, Any]]
    notes: list[str]
    seed: int
    motion: dict[str, Any]

    def changes(self, case: int) -> dict[str, Any]:
        """Return the changes that make a case of the request's scenario."""
        return self.draws[case] | self.motion

    @property
    def seconds(self) -> float:
        """Simulated time of all cases and variants, s."""
        return self.base.work * len(self.draws)


def plan(request: MonteCarloRequest, source: Source | None = None) -> MonteCarloPlan:
    """Return the checked plan of a request.

    Raises
    ------
    ConfigError
        Naming every number that is wrong.
    Infeasible
        If the scenario's own plant cannot follow its motion.
    """
    scenario = load_scenario(request.scenario if source is None else source, request.set)
    base = prepare(scenario)
    check_length(base.reference.ticks)
    plant = scenario.plant.model_dump(mode="json")
    vary, notes = request.vary, []
    if vary == DEFAULT:
        absent = missing(plant, vary)
        notes = [f"not varied, because this plant has none: {path}" for path in absent]
        vary = tuple(variation for variation in vary if variation.path not in absent)
    seed = scenario.seed if request.seed is None else request.seed
    draws = draw(plant, vary, cases=request.cases, seed=seed)
    motion: dict[str, Any] = {}
    if needs_plan(scenario.trajectory):
        trajectory = base.scenario.trajectory.model_dump(mode="json")
        motion = {"trajectory.planned_for": trajectory["planned_for"]}
    varied = request.model_copy(update={"vary": vary})
    return MonteCarloPlan(varied, base, draws, notes, seed, motion)


def run_cases(
    planned: MonteCarloPlan,
    progress: Callable[[float], None] | None = None,
) -> MonteCarloDocument:
    """Run every controller of a scenario on every plant.

    Parameters
    ----------
    planned : MonteCarloPlan
        From `plan`.
    progress : callable, optional
        Takes the share done; what it raises ends the study.

    Raises
    ------
    ConfigError
        If a draw lies outside of what a plant may be, naming the case.
    """
    count, scenario, window = len(planned.draws), planned.base.scenario, planned.base.window
    bands = Bands(count, len(scenario.variants), window)
    parts = tasks(scenario, planned.draws, {})
    parts_done = list(current().map(_run, [(part, window) for part in parts], progress))
    bands.join(part for _, part in parts_done)
    batches = [batch for batch, _ in parts_done]
    metrics = {name: np.concatenate([b.metrics[name] for b in batches]) for name in DEFINITIONS}
    failed = np.concatenate([batch.failed for batch in batches])
    feasible = np.flatnonzero(np.concatenate([batch.feasible for batch in batches]))
    if not len(feasible):
        raise ConfigError(FieldError("vary", "no plant that it gives can follow the motion", count))
    moving = planned.base.reference.moving
    plant = scenario.plant.model_dump(mode="json")
    vary = planned.request.vary
    drawn = {axis: drawn_parameters(planned.draws, vary, plant, axis) for axis in moving}
    return MonteCarloDocument(
        scenario=planned.base.scenario.name,
        plant=plant_name(planned.base.scenario.plant),
        version=__version__,
        model=model_hash(),
        cases=count,
        seed=planned.seed,
        vary=list(planned.request.vary),
        notes=planned.notes,
        infeasible=count - len(feasible),
        window={"start": window[0] * CONTROL_PERIOD, "end": window[1] * CONTROL_PERIOD},
        time=[round(tick * CONTROL_PERIOD, 7) for tick in bands.ticks.tolist()],
        spec=planned.request.spec,
        variants=_variants(
            planned, failed, metrics, bands, _correlations(drawn, metrics, feasible)
        ),
        histograms={axis: _histograms(planned, metrics, AXES.index(axis)) for axis in moving},
        parameters={axis: parameters for axis, (parameters, _) in drawn.items()},
        significant=threshold(
            len(feasible), max((len(parameters) for parameters, _ in drawn.values()), default=0)
        ),
        improvement={axis: _improvement(metrics, AXES.index(axis)) for axis in moving}
        if len(scenario.variants) > 1
        else {},
        table=_table(planned, metrics) if planned.request.table else None,
        worst=_worst(planned, metrics[PEAK], feasible),
    )


def case_changes(planned: MonteCarloPlan, case: int) -> dict[str, Any]:
    """Return the changes that make the plant of one case.

    Raises
    ------
    ConfigError
        If there is no such case.
    """
    if not 0 <= case < len(planned.draws):
        allowed = f"0 <= case < {len(planned.draws)}"
        raise ConfigError(FieldError("case", "there is no such case", case, allowed, "1"))
    return planned.changes(case)


def _run(
    task: tuple[CaseTask, tuple[int, int]], progress: Callable[[float], None]
) -> tuple[Batch, Bands]:
    """Run some cases; return their metrics and bands."""
    cases, window = task
    bands = Bands(len(cases.changes), len(cases.scenario["variants"]), window)
    try:
        return run_batch(cases, progress, bands.watch), bands
    except ConfigError as error:
        errors = (replace(e, message=f"{e.message}: vary it less") for e in error.errors)
        raise ConfigError(*errors) from None


def _variants(
    planned: MonteCarloPlan,
    failed: NDArray[np.int64],
    metrics: dict[str, Array],
    bands: Bands,
    correlations: Correlations,
) -> dict[str, MonteCarloVariant]:
    variants = {}
    spec = planned.request.spec
    limits = {axis: limit for axis in AXES if (limit := getattr(spec, axis)) is not None}
    for v, (name, variant) in enumerate(planned.base.scenario.variants.items()):
        axes = {}
        for axis in planned.base.reference.moving:
            a = AXES.index(axis)
            band = bands.of(v, a)
            axes[axis] = MonteCarloAxis(
                metrics={metric: _quantiles(metrics[metric][:, v, a]) for metric in DEFINITIONS},
                band=None if band is None else Band(**{k: _short(row) for k, row in band.items()}),
                peaks=[_number(value) for value in metrics[PEAK][:, v, a].tolist()],
                correlations=correlations[axis][v],
            )
        within = np.ones(len(planned.draws), dtype=bool)
        for axis, limit in limits.items():
            if axis in axes:
                within &= metrics[PEAK][:, v, AXES.index(axis)] <= limit  # never so for NaN
        variants[name] = MonteCarloVariant(
            label=variant.label,
            law=variant.controller.compensation.law,
            enabled=variant.controller.compensation.enabled,
            diverged=int((failed[:, v] >= 0).sum()),
            axes=axes,
            meets=probability(int(within.sum()), len(within)) if limits else None,
        )
    return variants


def _correlations(
    drawn: dict[str, tuple[list[DrawnParameter], Array]],
    metrics: dict[str, Array],
    feasible: NDArray[np.intp],
) -> Correlations:
    """Return rho of every metric with every parameter over the feasible cases."""
    correlations: Correlations = {}
    for axis, (_, values) in drawn.items():
        a = AXES.index(axis)
        of_all = np.stack([metrics[name][feasible, :, a] for name in DEFINITIONS])
        correlations[axis] = []
        for v in range(of_all.shape[2]):
            rho = rank_correlations(values[feasible], of_all[:, :, v].T)
            correlations[axis].append(dict(zip(DEFINITIONS, rho, strict=True)))
    return correlations


def _histograms(
    planned: MonteCarloPlan, metrics: dict[str, Array], axis: int
) -> dict[str, Histogram | None]:
    names = list(planned.base.scenario.variants)
    return {
        metric: histogram({name: metrics[metric][:, v, axis] for v, name in enumerate(names)})
        for metric in DEFINITIONS
    }


def probability(hits: int, cases: int) -> Probability:
    """Return a share with its 95 % interval after Wilson, J. Am. Stat. Assoc. 22, 1927.

    ``(p + z^2/(2 n) +- z sqrt(p (1 - p)/n + z^2/(4 n^2)))/(1 + z^2/n)``
    """
    p, scale = hits / cases, 1.0 + _Z**2 / cases
    middle = (p + _Z**2 / (2 * cases)) / scale
    half = _Z * math.sqrt(p * (1.0 - p) / cases + _Z**2 / (4 * cases**2)) / scale
    # At the ends rounding would leave them.
    low = 0.0 if hits == 0 else middle - half
    high = 1.0 if hits == cases else middle + half
    return Probability(share=p, low=low, high=high)


def _improvement(metrics: dict[str, Array], axis: int) -> dict[str, Quantiles | None]:
    improvement = {}
    for name in RATIOS:
        a, b = metrics[name][:, 0, axis], metrics[name][:, 1, axis]
        with np.errstate(divide="ignore", invalid="ignore"):
            improvement[name] = _quantiles(np.where(a == 0.0, np.nan, 1.0 - b / a))
    return improvement


def _table(planned: MonteCarloPlan, metrics: dict[str, Array]) -> dict[str, list[float | None]]:
    """Return every number that differs from case to case, and every metric, by case."""
    columns: dict[str, list[float | None]] = {}
    constant = {variation.path for variation in planned.request.vary if variation.kind == "value"}
    for path in planned.draws[0]:
        if path.split(".", 2)[2] in constant:
            continue
        values = np.array([case[path] for case in planned.draws], dtype=float)
        if values.ndim == 1:
            columns[path] = values.tolist()
        else:
            columns |= {f"{path}.{k}": item.tolist() for k, item in enumerate(values.T)}
    for v, name in enumerate(planned.base.scenario.variants):
        for axis in planned.base.reference.moving:
            for metric in DEFINITIONS:
                values = metrics[metric][:, v, AXES.index(axis)].tolist()
                columns[f"{name}.{axis}.{metric}"] = list(map(_number, values))
    return columns


def _worst(planned: MonteCarloPlan, peaks: Array, feasible: NDArray[np.int64]) -> list[WorstCase]:
    worst = []
    for v, name in enumerate(planned.base.scenario.variants):
        for axis in planned.base.reference.moving:
            values = peaks[feasible, v, AXES.index(axis)]
            order = np.argsort(-np.where(np.isnan(values), np.inf, values), kind="stable")
            worst += [
                WorstCase(
                    variant=name,
                    axis=axis,
                    case=case,
                    value=_number(float(peaks[case, v, AXES.index(axis)])),
                    set=planned.changes(case),
                )
                for case in feasible[order[:_WORST]].tolist()
            ]
    return worst


def _quantiles(values: Array) -> Quantiles | None:
    values = values[np.isfinite(values)]
    if not len(values):
        return None
    least, low, middle, high, most = np.quantile(values, (0.0, 0.05, 0.5, 0.95, 1.0)).tolist()
    return Quantiles(min=least, q05=low, q50=middle, q95=high, max=most, cases=len(values))


def _short(row: NDArray[np.float32]) -> list[float]:
    """Return numbers with as many digits as a picture can use."""
    return [float(f"{value:.{_DIGITS}g}") for value in row.tolist()]


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
