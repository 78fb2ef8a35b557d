"""Speed of the search for gains and of the gain landscape, against the scalar C reference.

The best of several turns of each: on a machine that does much else the others tell of it alone.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import prepare
from motionlab.studies.tune.documents import LandscapeRequest, TuneRequest, read_request
from motionlab.studies.tune.landscape import landscape
from motionlab.studies.tune.problem import plan
from motionlab.studies.tune.search import tune
from motionlab.timing import CONTROL_PERIOD
from tests.bench.scalar_c import ScalarC
from tests.bench.speed import arrays
from tests.bench.table import Row

_WINDOW = {"start": 1.0, "end": 3.0}
_EVALUATIONS, _POINTS = 200, 64
_REPETITIONS = 7
_SEARCH_TARGET, _MAP_TARGET = 1.5, 2.0  # s


def tuning(arch: str) -> Iterator[Row]:
    """Measure the search, one start for each axis and several, and the map of both axes."""
    lane_tick = _scalar_c(arch)
    for starts in (1, 4):
        request = {"window": _WINDOW, "starts": starts, "evaluations": _EVALUATIONS}
        problem = plan(read_request(TuneRequest, request))
        tune(problem)
        taken = []
        for _ in range(_REPETITIONS):
            before = time.perf_counter()
            found = tune(problem)
            seconds = time.perf_counter() - before
            # a simplex that has converged asks no more: told for as many as the target counts
            rounds = max(len(start.cost) for group in found.groups for start in group.starts)
            taken.append(seconds * _EVALUATIONS / rounds)
        yield _row(
            f"simplex, {_EVALUATIONS} evaluations of 3 s, {starts} start" + "s" * (starts > 1),
            _SEARCH_TARGET,
            min(taken),
            lane_tick * 2 * starts * _EVALUATIONS * _WINDOW["end"] / CONTROL_PERIOD,
        )

    problem = plan(read_request(LandscapeRequest, {"window": _WINDOW, "points": _POINTS}))
    landscape(problem)
    taken, first = [], []
    for _ in range(_REPETITIONS):
        before = time.perf_counter()
        told: list[float] = []

        def watch(_share: float, partial: Any, told: list[float] = told, t: float = before) -> None:
            if partial is not None:
                told.append(time.perf_counter() - t)

        landscape(problem, watch)
        taken.append(time.perf_counter() - before)
        first.append(told[0])
    yield _row(
        f"landscape {_POINTS} x {_POINTS} of 3 s, x and y",
        _MAP_TARGET,
        min(taken),
        lane_tick * 2 * _POINTS**2 * _WINDOW["end"] / CONTROL_PERIOD,
    )
    yield Row("first, coarse map of it", "", f"{min(first):.2f} s")


def _row(what: str, target: float, taken: float, c: float | None) -> Row:
    return Row(
        what,
        f"< {target:g} s",
        f"{taken:.2f} s",
        f"C, scalar: {c:.1f} s" if c else "no gcc here",
        f"{c / taken:.1f}" if c else "",
        taken < target,
    )


def _scalar_c(arch: str) -> float:
    """Return the time of the C reference for one lane and tick, s; 0 without a compiler."""
    try:
        c = ScalarC(arch)
    except FileNotFoundError:
        return 0.0
    parameters, state, inputs = arrays(prepare(load_scenario("circle")))
    lanes = np.ascontiguousarray(parameters.T[:4])
    taken = []
    for _ in range(_REPETITIONS):
        states = np.ascontiguousarray(state.T[:4])
        before = time.perf_counter()
        c.run(lanes, states, inputs)
        taken.append(time.perf_counter() - before)
    return min(taken) / (len(lanes) * len(inputs))
