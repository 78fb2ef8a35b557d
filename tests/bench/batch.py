"""Batches against C, in lanes and scalar; a gain landscape; the overhead of a small call."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.executors.executor import cores
from motionlab.kernel.build import initial_state
from motionlab.kernel.layout import parameter_row
from motionlab.simulation.batch import lanes_of
from motionlab.simulation.batch_runner import BatchRunner
from motionlab.simulation.inputs import PAGE, page_inputs
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.timeline import Timeline
from tests.bench.machine import vector_unit
from tests.bench.scalar_c import Array, LanesC, ScalarC
from tests.bench.table import Row

_MOVERS = 8  # of both axes: a block of sixteen lanes
_SCALAR = 1  # movers that scalar C takes in the same turn
_TURNS = 40
_SIDE = 64
_TARGETS = {"AVX-512": 6.0, "AVX2": 3.0}
_THREE_SECONDS = {"trajectory.frequency": 1.0, "trajectory.laps": 2, "trajectory.lead_in": 1.0}
_FAR = 1e-11  # m, exact encoder: nothing but rounding


def batch(arch: str) -> Iterator[Row]:
    """Measure a batch on one core against both C references, then a landscape on all cores."""
    prepared = _exact()
    runner, lanes = BatchRunner(prepared), _gains(prepared, np.geomspace(1e5, 4e5, _MOVERS))
    ticks, inputs = prepared.reference.ticks, _inputs(prepared)
    columns = lanes[0].transpose(1, 0, 2).reshape(lanes.shape[2], -1)
    x, y = prepared.reference.position[0]
    start = initial_state(1, (float(x), float(y)), width=columns.shape[1])[0]

    contenders: dict[str, Callable[[], object]] = {"ours": lambda: runner.score(lanes, threads=1)}
    try:
        c, scalar = LanesC(arch), ScalarC(arch)
    except FileNotFoundError:
        c = None
    else:
        few = np.ascontiguousarray(columns.T[: 2 * _SCALAR])
        at_rest = np.ascontiguousarray(start.T[: 2 * _SCALAR])
        contenders["lanes"] = lambda: c.run(columns, start.copy(), inputs)
        contenders["scalar"] = lambda: scalar.run(few, at_rest.copy(), inputs)
    times = _best(contenders)
    each = {
        name: taken / (ticks * 2 * (_SCALAR if name == "scalar" else _MOVERS)) * 1e9
        for name, taken in times.items()
    }
    sizes = (("lanes", "in lanes", 0.9), ("scalar", "scalar", _TARGETS.get(vector_unit(), 3.0)))
    for name, what, target in sizes:
        ratio = each[name] / each["ours"] if c else None
        yield Row(
            f"batch and metrics, one core, to C {what}",
            f">= {target:g} x C",
            f"{each['ours']:.0f} ns/lane",
            f"C: {each[name]:.0f} ns/lane" if c else "no gcc here",
            f"{ratio:.2f}" if ratio else "",
            ratio >= target if ratio else None,
        )
    if c:
        worst = np.abs(c.run(columns, start.copy(), inputs) - _peaks(runner, lanes)).max()
        yield Row(
            "  C in lanes agrees, exact encoder",
            f"<= {_FAR * 1e9:g} nm",
            f"{worst * 1e9:.1g} nm",
            "max |e| of 16 lanes",
            "",
            bool(worst <= _FAR),
        )
    yield from _landscape()


def _landscape() -> Iterator[Row]:
    """Score 64 by 64 gains of a run of about 3 s, both axes side by side; then a few gains."""
    prepared = prepare(load_scenario("circle", _THREE_SECONDS))
    k_p, k_d = np.meshgrid(np.geomspace(2e4, 6e6, _SIDE), np.geomspace(2e2, 2e4, _SIDE))
    runner, lanes = BatchRunner(prepared), _gains(prepared, k_p.ravel(), k_d.ravel())
    seconds = prepared.duration
    taken = min(_time(lambda: runner.score(lanes)) for _ in range(3))
    yield Row(
        f"landscape 64 x 64 of {seconds:.2g} s, x and y, {cores()} cores",
        "<= 2 s",
        f"{taken:.2f} s",
        f"{2 * len(k_p.ravel()) * seconds / taken:.0f} x real",
        "",
        taken <= 2.0,
    )
    one = min(_time(lambda: runner.score(lanes[:, :1])) for _ in range(9))
    eight = min(_time(lambda: runner.score(lanes[:, :8])) for _ in range(9))
    yield Row(
        f"one gain set of {seconds:.2g} s, x and y",
        "",
        f"{one * 1e3:.1f} ms",
        f"eight: {eight * 1e3:.1f} ms",
    )


def _peaks(runner: BatchRunner, lanes: Array) -> Array:
    """Return the largest error of each lane over the whole run, m."""
    peaks = np.zeros((lanes.shape[1], 2))

    def watch(first: int, errors: np.ndarray) -> None:  # pyright: ignore[reportMissingTypeArgument]
        peaks[first : first + len(errors)] = np.abs(errors).max(axis=2)

    runner.score(lanes, watch=watch)
    return peaks.ravel()


def _exact() -> Prepared:
    exact = {"plant.x.encoder.resolution": 0.0, "plant.y.encoder.resolution": 0.0}
    return prepare(load_scenario("circle", exact))


def _gains(prepared: Prepared, k_p: Array, k_d: Array | None = None) -> Array:
    """Return lanes of variant B under as many gain sets, the same on both axes."""
    lanes = np.repeat(lanes_of(prepared.epochs)[:, 1:], len(k_p), axis=1)
    lanes[:, :, parameter_row("controller.k_p")] = k_p[:, None]
    if k_d is not None:
        lanes[:, :, parameter_row("controller.k_d")] = k_d[:, None]
    return lanes


def _inputs(prepared: Prepared) -> Array:
    timeline = Timeline(prepared.reference, prepared.load)
    pages = range(-(-prepared.reference.ticks // PAGE))
    return np.concatenate([page_inputs(prepared.scenario, timeline, page) for page in pages])


def _best(contenders: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Return the least time of each contender, all in turns: what else runs only adds to it."""
    best = dict.fromkeys(contenders, float("inf"))
    for _ in range(_TURNS):
        for name, call in contenders.items():
            best[name] = min(best[name], _time(call))
    return best


def _time(call: Callable[[], object]) -> float:
    before = time.perf_counter()
    call()
    return time.perf_counter() - before
