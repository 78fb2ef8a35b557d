"""What is computed from kept runs: a stretch of one, its scenario there, its glitches."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from motionlab.analysis.contouring import AROUND
from motionlab.analysis.glitch_document import RunGlitches, glitches_of
from motionlab.analysis.views.recorded import Array, Recorded, absent, stretch
from motionlab.config.changes import apply_changes
from motionlab.config.load import validate
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError
from motionlab.library.library import library
from motionlab.library.run import RunDetail
from motionlab.simulation.recorded import record_simulation
from motionlab.telemetry.parquet import read_ticks

_POSITIONS = [f"{axis}.position_reference" for axis in AXES]


def of_run(run_id: str, start: float | None, end: float | None, *, window: bool = True) -> Recorded:
    """Return a stretch of a kept run.

    Parameters
    ----------
    run_id : str
        The run.
    start, end : float or None
        Of the stretch, s; where neither is given it is the window of the run's metrics, or the
        latest `SAMPLES_MAX` samples if there is none or `window` is not wanted.
    window : bool
        Whether the window of the metrics is what is wanted.

    Raises
    ------
    Unknown
        If there is no such run.
    Busy
        If it is being recorded.
    ConfigError
        If the stretch is not in the run, or too long.
    """
    run = library().complete(run_id)
    if window and start is None and end is None and (measured := run.measured()):
        start, end = measured
    first, stop = stretch(start, end, run.ticks, run.period)
    with library().files.open(run_id) as file:
        known = set(file.schema_arrow.names)

    def column(name: str) -> Array | None:
        if name not in known:
            return None
        with library().files.open(run_id) as file:
            return read_ticks(file, [name], first, stop)[0].astype(np.float64)

    def path() -> tuple[Array, int]:
        begin = max(0, first - AROUND)
        for name in _POSITIONS:
            if name not in known:
                raise absent(name)
        with library().files.open(run_id) as file:
            return read_ticks(file, _POSITIONS, begin, stop + AROUND).T.astype(np.float64), (
                first - begin
            )

    scenario = scenario_of(
        run, first, stop, lambda path: path.startswith(("variants.", "plant", "trajectory"))
    )
    simulate = record_simulation if run.kind in {"simulation", "live"} else None
    variants = tuple(run.variants)
    return Recorded(variants, run.period, first, stop, column, path, scenario, simulate)


def scenario_of(
    run: RunDetail, start: int, stop: int, matters: Callable[[str], bool]
) -> Scenario | str:
    """Return the scenario of a run at a sample, without schedule, or why there is none.

    Parameters
    ----------
    run : RunDetail
        The run.
    start, stop : int
        Samples [start, stop).
    matters : callable
        Of a dotted path: whether its change within the stretch leaves no scenario for all of it.
    """
    if run.scenario_document is None:
        return "the run has no scenario"
    document = dict(run.scenario_document)
    changes = [(round(one["time"] / run.period), one["set"]) for one in document["schedule"]]
    changes += [(event.tick, event.set) for event in run.events if event.kind == "change"]
    start, stop = start + run.first_tick, stop + run.first_tick
    for tick, paths in sorted(changes, key=lambda change: change[0]):
        if tick <= start:
            document = apply_changes(document, paths)
        elif tick < stop and any(matters(path) for path in paths):
            return f"motor or controller change at {tick * run.period:g} s, within the stretch"
    document["schedule"] = []
    try:
        return validate(document)
    except ConfigError as problem:  # a motor or a map of one's own that is gone
        return str(problem)


def run_glitches(run_id: str) -> RunGlitches:
    """Return what the following error of a run does at its reversals; docs/glitches.md.

    Raises
    ------
    Unknown
        If there is no such run.
    Busy
        If it is being recorded.
    """
    run = library().complete(run_id)
    plant = (run.scenario_document or {}).get("plant") or {}
    counts = {
        axis: float(plant.get(axis, {}).get("encoder", {}).get("resolution", 0.0)) for axis in AXES
    }
    with library().files.open(run_id) as file:
        known = set(file.schema_arrow.names)

        def column(name: str) -> Array | None:
            if name not in known:
                return None
            return read_ticks(file, [name], 0, run.ticks)[0].astype(np.float64)

        return glitches_of(run.variants, column, counts=counts, period=run.period)
