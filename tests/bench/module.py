"""The WebAssembly module under node: speed beside C, size, agreement with the kernel."""

from __future__ import annotations

import gzip
import statistics
import time
from collections.abc import Iterator

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.config.named_configs import names
from motionlab.kernel.accumulator import new_tally
from motionlab.kernel.build import initial_state, lane_parameters
from motionlab.kernel.layout import SAMPLE_ROWS
from motionlab.lanes.bank import TABLES
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.telemetry.channels import Sample
from tests.bench.scalar_c import ScalarC
from tests.bench.speed import arrays
from tests.bench.table import Row
from tests.targets.module_run import Memory
from tests.targets.module_run import module as compiled_module
from tests.targets.scenario_runs import (
    POINT_COLUMNS,
    Difference,
    differences,
    inputs_of,
    lanes_of,
    run_in_module,
)

_TURNS, _REPETITIONS = 5, 5
_RATIO = 1.4
_KILOBYTES = 40.0
_COUNT = 50e-9
_BINS = 1500
_TABLES = {"plant.force_map": "new-design"}
_LANES = 4
_ONE_VARIANT = ("tally of a variant", "nearest points of a variant", "envelope of a column")


def module(arch: str) -> Iterator[Row]:
    """Measure speed, size and agreement."""
    yield from _speed(arch)
    size = len(gzip.compress(compiled_module(), 9)) / 1e3
    yield Row(
        "module, compressed", f"<= {_KILOBYTES:g} kB", f"{size:.1f} kB", met=size <= _KILOBYTES
    )
    for name in names("scenarios"):
        prepared = prepare(load_scenario(name))
        found = differences(prepared, run_in_module(prepared).recording)
        for variant, difference in found.items():
            yield from _agreement(f"{name} {variant}", prepared, difference)


def _speed(arch: str) -> Iterator[Row]:
    plain, tabled = (prepare(load_scenario("circle", changes)) for changes in ({}, _TABLES))
    ticks = plain.reference.ticks
    try:
        c = ScalarC(arch)
    except FileNotFoundError:
        c = None
    parameters, start, inputs = arrays(plain)
    lanes, states = (np.ascontiguousarray(each.T[:_LANES]) for each in (parameters, start))
    seconds: dict[str, list[float]] = {}
    for _ in range(_TURNS):
        if c is not None:
            before = time.process_time()
            c.run(lanes, states.copy(), inputs)
            seconds.setdefault("C", []).append(time.process_time() - before)
        for what, taken in (_times(plain, "run") | _times(tabled, "run_tables")).items():
            seconds.setdefault(what, []).append(taken)
    nanoseconds = {what: statistics.median(all_) / ticks * 1e9 for what, all_ in seconds.items()}
    reference = nanoseconds.get("C")
    ratio = nanoseconds["run"] / reference if reference else None
    yield Row(
        "module, A and B, x and y",
        f"<= {_RATIO:g} x C",
        f"{nanoseconds['run']:.0f} ns/tick",
        f"C: {reference:.0f} ns/tick" if reference else "no gcc here",
        f"{ratio:.2f}" if ratio else "",
        ratio <= _RATIO if ratio else None,
    )
    others = ("run_tables", "force map by tables"), *((name, name) for name in _ONE_VARIANT)
    for name, what in others:
        yield Row(f"  {what}", "", f"{nanoseconds[name]:.0f} ns/tick")


def _times(prepared: Prepared, function: str) -> dict[str, float]:
    """Return the processor time of a run of A and B, and of what is computed from a variant, s."""
    memory = Memory()
    ticks = prepared.reference.ticks
    blocks = lane_parameters(prepared.scenario)
    inputs, tables = memory.put(inputs_of(prepared)), memory.put(TABLES.values)
    samples = memory.put(np.zeros((ticks, SAMPLE_ROWS, 2), dtype=np.float32))
    path, kept = memory.put(prepared.reference.position), memory.put(np.zeros(ticks))
    points = memory.put(np.zeros((ticks, POINT_COLUMNS)))
    size = -(-ticks // _BINS)
    low, high, tally = memory.put(np.zeros(_BINS)), memory.put(np.zeros(_BINS)), new_tally(2)
    x, y = prepared.reference.position[0]
    state = initial_state(1, (float(x), float(y)), width=2)[0]
    error = samples + 8 * Sample._fields.index("following_error")
    column = (size, low, high, ticks, 2 * SAMPLE_ROWS, -(-ticks // size))
    for _ in range(_REPETITIONS):
        for variant in range(2):
            lanes, at = memory.put(lanes_of(blocks, variant)), memory.put(state)
            places = [tables] if function == "run_tables" else []
            memory.call(function, lanes, at, inputs, samples, *places, ticks)
        memory.call("add_ticks", samples, inputs, 0, memory.put(tally), ticks)
        memory.call("contour", path, 0, error, kept, points, ticks, ticks)
        memory.call("extremes", error, *column)
    taken = np.array(memory.run()).reshape(_REPETITIONS, -1)[1:]  # the first compiles
    run_a, run_b, *others = np.median(taken, axis=0).tolist()
    return {function: run_a + run_b, **dict(zip(_ONE_VARIANT, others, strict=True))}


def _agreement(what: str, prepared: Prepared, difference: Difference) -> Iterator[Row]:
    """Yield the largest differences of the following error, of any channel and of any metric."""
    counts = difference.channels["following_error"] / _COUNT
    share = difference.ticks / prepared.reference.ticks
    metric = max(difference.metrics.values(), default=0.0)
    yield Row(
        what,
        "",
        f"{counts:.0f} counts",
        f"in {100 * share:.1f} % of ticks",
        f"{100 * metric:.2g} %",
    )
    gaps = {
        name: gap / (difference.scales[name] or 1.0) for name, gap in difference.channels.items()
    }
    worst = max(gaps, key=lambda name: gaps[name])
    yield Row("  channel that differs most", "", f"{100 * gaps[worst]:.2g} %", worst)
