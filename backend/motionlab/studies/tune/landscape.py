"""The cost over the plane of gains, coarse then refined, with the stability boundary."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab import __version__
from motionlab.config.controller import ControllerConfig, GainsConfig
from motionlab.config.planar import AXES
from motionlab.executors.executor import current
from motionlab.lanes import model_hash
from motionlab.loop.family import Figures, LoopFamily
from motionlab.loop.linearise import SLIDING, NoLinearisation
from motionlab.loop.stability_boundary import stability_edge
from motionlab.motor_design.fem.force_map import ForceMap
from motionlab.motor_design.kept_maps import kept_in, lent
from motionlab.simulation.result import plant_name
from motionlab.studies.tune.documents import (
    AxisLandscape,
    LandscapeDocument,
    LandscapeRequest,
    PartialLandscape,
)
from motionlab.studies.tune.evaluation import cost
from motionlab.studies.tune.problem import TrialSetup, TuningProblem, unstable_warnings
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]
Progress = Callable[[float, PartialLandscape | None], None]
"""Takes the share done, 0 to 1, and the map so far when that has changed."""

_COARSEST = 8
"""Stride of the first reported map."""
_AT_ONCE = 1024
"""Trials of a task, at most."""
_TRIED = ("saturated", "force")
"""What a search limits of the trials."""
_MOST = {"gain_margin": 1000.0, "phase_margin": math.pi}
"""Told where nothing crosses."""


def landscape(problem: TuningProblem, progress: Progress | None = None) -> LandscapeDocument:
    """Return cost, margins and what else a search can limit of each axis over its gains.

    Both axes are tried side by side. Every point is simulated on every motor, also where the
    linearised loop is unstable.

    Parameters
    ----------
    problem : TuningProblem
        Of a `LandscapeRequest`, from `motionlab.studies.tune.problem.plan`.
    progress : callable, optional
        Called with the share done and, after each level, the map so far.
    """
    request = problem.request
    assert isinstance(request, LandscapeRequest)
    report = progress or (lambda _share, _partial: None)
    n = request.points
    k_p, k_d = (np.geomspace(*ends, n) for ends in (request.bounds.k_p, request.bounds.k_d))
    families = {axis: _families(problem, axis) for axis in problem.axes}
    grids = {axis: _unknown(n, linear=bool(families[axis])) for axis in problem.axes}
    edges = {axis: _edge(problem, axis, k_p, k_d) for axis in problem.axes}
    tried = 0
    executor, maps = current(), kept_in(problem.scenario.model_dump(mode="json"))

    def drawn(stride: int) -> dict[str, AxisLandscape]:
        return {
            axis: AxisLandscape(
                stride=stride,
                k_p=_figures(k_p[::stride]),
                k_d=_figures(k_d[::stride]),
                cost=_rows(grids[axis]["cost"], stride),
                limits={
                    name: _rows(values, stride)
                    for name, values in grids[axis].items()
                    if name != "cost"
                },
                edge=edges[axis],
                present=_place(getattr(problem.controller, axis)),
                paper=_place(problem.published(axis)),
            )
            for axis in problem.axes
        }

    stride = _COARSEST
    while stride:
        level = [
            (i, j)
            for i in range(0, n, stride)
            for j in range(0, n, stride)
            if np.isnan(grids[problem.axes[0]]["cost"][i, j])
        ]
        i, j = np.array(level).T
        for axis in problem.axes:
            for name, values in _margins(families[axis], k_p[j], k_d[i]).items():
                grids[axis][name][i, j] = values
        parts = executor.parts(len(level), _AT_ONCE)
        controller, threads = problem.controller, executor.threads
        places = [(part, trials) for trials in problem.setups.values() for part in parts]
        tasks = [_Gains(t, controller, k_p[j[p]], k_d[i[p]], threads, maps) for p, t in places]

        def tell(share: float, before: int = tried, size: int = len(level)) -> None:
            report((before + share * size) / n**2, None)

        for (part, _), metrics in zip(places, executor.map(_try, tasks, tell), strict=True):
            at = i[part], j[part]
            for axis in problem.axes:
                of_axis = {name: values[:, AXES.index(axis)] for name, values in metrics.items()}
                of_axis["cost"] = cost(request.objective, of_axis)
                for name in ("cost", *_TRIED):
                    grid = grids[axis][name]
                    grid[at] = np.fmax(grid[at], of_axis[name])
        tried += len(level)
        report(tried / n**2, PartialLandscape(axes=drawn(stride)) if stride > 1 else None)
        stride //= 2
    scenario, window = problem.scenario, problem.own.window
    return LandscapeDocument(
        axes=drawn(1),
        scenario=scenario.name,
        seed=scenario.seed,
        plant=plant_name(scenario.plant),
        plants=list(problem.setups),
        version=__version__,
        model=model_hash(),
        variant=problem.variant,
        objective={**request.objective},
        window=[tick * CONTROL_PERIOD for tick in window],
        warnings=unstable_warnings(problem),
    )


class _Gains(NamedTuple):
    """Some points of the plane: a task."""

    trials: TrialSetup
    controller: ControllerConfig
    k_p: Array
    k_d: Array
    threads: int | None
    maps: dict[str, ForceMap]


def _try(gains: _Gains, progress: Callable[[float], None]) -> dict[str, Array]:
    """Return metrics of some points, see `TrialSetup.over_gains`."""
    with lent(gains.maps):
        return gains.trials.over_gains(
            gains.controller, gains.k_p, gains.k_d, progress, threads=gains.threads
        )


def _unknown(n: int, *, linear: bool) -> dict[str, Array]:
    """Return empty maps of the cost and of each quantity that a search can limit."""
    margins = Figures._fields if linear else ()
    return {name: np.full((n, n), np.nan) for name in ("cost", *margins, *_TRIED)}


def _edge(
    problem: TuningProblem, axis: str, k_p: Array, k_d: Array
) -> list[list[tuple[float, float]]]:
    try:
        family = LoopFamily.of(problem.scenario, problem.variant, axis, (0.0, SLIDING))
    except NoLinearisation:
        return []
    return [
        [(float(f"{p:.6g}"), float(f"{d:.6g}")) for p, d in line]
        for line in stability_edge(family, k_p, k_d)
    ]


def _families(problem: TuningProblem, axis: str) -> list[LoopFamily]:
    """Return the loops of an axis on each motor; none where the law has no linearisation."""
    try:
        return [
            LoopFamily.of(trials.scenario, problem.variant, axis)
            for trials in problem.setups.values()
        ]
    except NoLinearisation:
        return []


def _margins(families: list[LoopFamily], k_p: Array, k_d: Array) -> dict[str, Array]:
    """Return the worst margins over some motors, NaN where one of them is unstable."""
    every = [family.margins_over(k_p, k_d) for family in families]
    if not every:
        return {}
    least = {name: np.min([one[name] for one in every], axis=0) for name in _MOST}
    most = {name: np.minimum(values, _MOST[name]) for name, values in least.items()}
    return most | {"Ms": np.max([one["Ms"] for one in every], axis=0)}


def _rows(grid: Array, stride: int) -> list[list[float | None]]:
    """Return every which row and column, to five digits."""
    return [
        [float(f"{value:.5g}") if np.isfinite(value) else None for value in row]
        for row in grid[::stride, ::stride].tolist()
    ]


def _place(gains: GainsConfig) -> tuple[float, float]:
    return gains.k_p, gains.k_d


def _figures(values: Array) -> list[float]:
    return [float(f"{value:.6g}") for value in values]
