"""Stretches of recordings that views are computed from, simulated for them."""

from __future__ import annotations

import numpy as np

from motionlab.analysis.contouring import AROUND
from motionlab.analysis.views.recorded import Array, Recorded, stretch
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.run import run as run_simulation
from motionlab.telemetry.channels import REFERENCES
from motionlab.telemetry.recording import Recording
from motionlab.timing import CONTROL_PERIOD, to_ticks


def of_scenario(
    prepared: Prepared, start: float | None, end: float | None, *, window: bool = True
) -> Recorded:
    """Return a stretch of a scenario, which is simulated; times as in `stretch`."""
    if window and start is None and end is None:
        first, stop = prepared.window
    else:
        first, stop = stretch(start, end, prepared.reference.ticks, CONTROL_PERIOD)
    return of_recording(run_simulation(prepared, stop=stop), prepared, first, stop)


def of_recording(recording: Recording, prepared: Prepared, first: int, stop: int) -> Recorded:
    """Return samples [first, stop) of a recording that begins at tick 0."""
    rows = {channel.name: row for row, channel in enumerate(REFERENCES)}
    part = slice(first, stop)

    def column(name: str) -> Array | None:
        *variant, axis, channel = name.split(".")
        if not variant:
            return recording.references[rows[channel], AXES.index(axis), part]
        record = recording.variants.get(variant[0])
        return None if record is None else record.channel(channel, axis)[part].astype(np.float64)

    def path() -> tuple[Array, int]:
        begin = max(0, first - AROUND)
        position = recording.references[rows["position_reference"], :, begin : stop + AROUND]
        return np.ascontiguousarray(position.T), first - begin

    inside = [changed for tick, changed in prepared.epochs if first < tick < stop]
    scenario: Scenario | str = "the schedule changes it within the stretch"
    if not inside:
        now = [changed for tick, changed in prepared.epochs if tick <= first][-1]
        scenario = now.model_copy(update={"schedule": (), "window": None})
    variants = tuple(recording.variants)
    return Recorded(
        variants,
        CONTROL_PERIOD,
        first,
        stop,
        column,
        path,
        scenario,
        simulate=record_simulation,
        simulated=True,
    )


def record_simulation(scenario: Scenario) -> Recorded:
    """Simulate a scenario, and return all of it.

    Raises
    ------
    ConfigError
        If it cannot be simulated.
    """
    prepared = prepare(scenario, checked=True)
    return of_recording(run_simulation(prepared), prepared, 0, prepared.reference.ticks)


def ticks_needed(prepared: Prepared, end: float | None) -> int:
    """Return how many ticks of a scenario a view up to a time takes."""
    return prepared.reference.ticks if end is None else to_ticks(end)
