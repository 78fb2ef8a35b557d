"""Scenarios run by the module under node, as recordings, and how far they are from the kernel's."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.metrics import DEFINITIONS
from motionlab.kernel.accumulator import new_tally
from motionlab.kernel.build import LANES_PER_VARIANT, initial_state, lane_parameters
from motionlab.kernel.layout import SAMPLE_ROWS, reads_tables, state_row
from motionlab.lanes.bank import TABLES
from motionlab.simulation.inputs import PAGE, page_inputs
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from motionlab.simulation.timeline import Timeline
from motionlab.telemetry.channels import CHANNELS
from motionlab.telemetry.recording import Divergence, Recording, VariantRecord
from tests.targets.module_run import Memory

Array = NDArray[np.float64]
Engine = Callable[[Memory], list[float]]

POINT_COLUMNS = 6


class ModuleRun(NamedTuple):
    """What the module computes of a scenario.

    Attributes
    ----------
    recording : Recording
        Of its samples.
    tallies : dict of str to ndarray, shape (TALLY_ROWS, 2)
        Of each variant over the window.
    nearest : dict of str to ndarray, shape (ticks of the window, 6)
        Nearest points of the reference path, not prolonged.
    seconds : dict of str to float
        Processor time of each variant's ticks.
    """

    recording: Recording
    tallies: dict[str, Array]
    nearest: dict[str, Array]
    seconds: dict[str, float]


class Difference(NamedTuple):
    """Largest differences of two runs of a variant.

    Attributes
    ----------
    channels : dict of str to float
        Largest difference of each channel, in its unit.
    scales : dict of str to float
        Largest magnitude of each channel.
    metrics : dict of str to float
        Largest difference of each metric, of either axis and of the contour: of errors in the
        largest following error, of others in the metric itself.
    ticks : int
        Ticks with another following error.
    """

    channels: dict[str, float]
    scales: dict[str, float]
    metrics: dict[str, float]
    ticks: int


def inputs_of(prepared: Prepared) -> Array:
    """Return the kernel's inputs over a whole scenario, shape (ticks, INPUT_ROWS, 2)."""
    timeline = Timeline(prepared.reference, prepared.load, endless=False)
    pages = []
    for first in range(0, prepared.reference.ticks, PAGE):
        in_effect = [scenario for tick, scenario in prepared.epochs if tick <= first][-1]
        pages.append(page_inputs(in_effect, timeline, first // PAGE))
    return np.concatenate(pages)


def run_in_module(prepared: Prepared, engine: Engine = Memory.run) -> ModuleRun:
    """Run every variant of a scenario by the module, one after another in one memory.

    Parameters
    ----------
    prepared : Prepared
        What to run.
    engine : callable
        Makes the calls on a memory; returns the time of each, s. Under node when left out.
    """
    memory = Memory()
    ticks = prepared.reference.ticks
    names = list(prepared.scenario.variants)
    inputs = inputs_of(prepared)
    per_tick = inputs[0].nbytes
    inputs_at = memory.put(inputs)
    epochs = [(tick, lane_parameters(scenario)) for tick, scenario in prepared.epochs]
    tables_at = memory.put(TABLES.values)
    start, end = prepared.window
    path_at = memory.put(prepared.reference.position)
    kept_at = memory.put(np.empty(ticks, dtype=np.int64))
    samples = {name: np.zeros((ticks, SAMPLE_ROWS, 2), dtype=np.float32) for name in names}
    states, tallies, nearest, runs = {}, {}, {}, {}
    calls = 0
    for number, name in enumerate(names):
        sample_size = samples[name][0].nbytes
        samples_at = memory.result(samples[name])
        x, y = prepared.reference.position[0]
        states[name] = initial_state(1, (float(x), float(y)), width=LANES_PER_VARIANT)[0]
        state_at = memory.result(states[name])
        runs[name] = range(calls, calls + len(epochs))
        ends = [tick for tick, _ in epochs[1:]] + [ticks]
        for (first, blocks), last in zip(epochs, ends, strict=True):
            parameters = lanes_of(blocks, number)
            at = (inputs_at + first * per_tick, samples_at + first * sample_size)
            tables = [tables_at] if any(reads_tables(parameters)) else []
            function = "run_tables" if tables else "run"
            memory.call(function, memory.put(parameters), state_at, *at, *tables, last - first)
        window_at = samples_at + start * sample_size
        tallies[name] = new_tally(LANES_PER_VARIANT)
        tally_at = memory.result(tallies[name])
        memory.call("add_ticks", window_at, inputs_at + start * per_tick, 0, tally_at, end - start)
        nearest[name] = np.zeros((end - start, POINT_COLUMNS))
        error_at = window_at + samples[name][0, : _row("following_error")].nbytes
        points_at = memory.result(nearest[name])
        memory.call("contour", path_at, start, error_at, kept_at, points_at, ticks, end - start)
        calls += len(epochs) + 2
    seconds = engine(memory)
    reference = prepared.reference
    shared = (reference.position, reference.velocity, reference.acceleration, prepared.load)
    records = {name: _record(samples[name], states[name]) for name in names}
    return ModuleRun(
        Recording(np.stack([column.T for column in shared]), records),
        tallies,
        nearest,
        {name: sum(seconds[i] for i in runs[name]) for name in names},
    )


def differences(prepared: Prepared, other: Recording) -> dict[str, Difference]:
    """Return of each variant how far a recording is from the kernel's."""
    kernel = run(prepared)
    mine, theirs = document(prepared, other), document(prepared, kernel)
    found = {}
    for name, record in kernel.variants.items():
        assert _divergence(record) == _divergence(other.variants[name])
        gap = np.abs(other.variants[name].samples.astype(np.float64) - record.samples)
        largest = np.nanmax(gap, axis=(1, 2))
        scale = np.nanmax(np.abs(record.samples), axis=(1, 2))
        channels = [channel.name for channel in CHANNELS]
        found[name] = Difference(
            dict(zip(channels, largest.tolist(), strict=True)),
            dict(zip(channels, scale.tolist(), strict=True)),
            _metrics(mine["variants"][name], theirs["variants"][name]),
            int((gap[_row("following_error")] > 0.0).any(axis=0).sum()),
        )
    return found


def _metrics(mine: dict[str, Any], theirs: dict[str, Any]) -> dict[str, float]:
    axes = theirs["axes"]
    largest = max(each["max_abs_following_error"] or 0.0 for each in axes.values())
    pairs = [
        (name, mine["axes"][axis][name], axes[axis][name]) for axis in axes for name in axes[axis]
    ]
    pairs += [
        (f"contour_{name}", mine["contour"][name], v) for name, v in theirs["contour"].items()
    ]
    gaps: dict[str, float] = {}
    for name, value, exact in pairs:
        assert (value is None) == (exact is None), name
        if exact is not None:
            is_error = name.startswith("contour") or DEFINITIONS[name].unit == "m"
            scale = largest if is_error else abs(exact)
            gaps[name] = max(gaps.get(name, 0.0), abs(value - exact) / (scale or 1.0))
    return gaps


def _divergence(record: VariantRecord) -> int | None:
    return None if record.diverged is None else record.diverged.tick


def _record(samples: NDArray[np.float32], state: Array) -> VariantRecord:
    columns = samples.transpose(1, 2, 0).copy()
    failed = [int(tick) for tick in state[state_row("failed")] if tick >= 0.0]
    if not failed:
        return VariantRecord(columns)
    columns[:, :, min(failed) :] = np.nan
    return VariantRecord(columns, Divergence(min(failed), "", ()))


def lanes_of(blocks: Array, variant: int) -> Array:
    """Return the parameters of one variant, shape (PARAMETER_ROWS, 2)."""
    lanes = np.concatenate(list(blocks), axis=1)
    first = variant * LANES_PER_VARIANT
    return np.ascontiguousarray(lanes[:, first : first + LANES_PER_VARIANT])


def _row(channel: str) -> int:
    return [each.name for each in CHANNELS].index(channel)
