"""Stretches of recordings that views are computed from: of a kept run, or simulated for them."""

from __future__ import annotations

import numpy as np

from motionlab.analysis.contouring import AROUND
from motionlab.analysis.views.recorded import SAMPLES_MAX, Array, Recorded, absent
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.config.timing import CONTROL_PERIOD, to_ticks
from motionlab.errors import ConfigError, FieldError
from motionlab.library.library import library
from motionlab.library.scenario_at import scenario_of
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.run import run as run_simulation
from motionlab.telemetry.channels import REFERENCES
from motionlab.telemetry.parquet import read_ticks
from motionlab.telemetry.recording import Recording

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
    first, stop = _stretch(start, end, run.ticks, run.period)
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


def of_scenario(
    prepared: Prepared, start: float | None, end: float | None, *, window: bool = True
) -> Recorded:
    """Return a stretch of a scenario, which is simulated; parameters as `of_run`."""
    if window and start is None and end is None:
        first, stop = prepared.window
    else:
        first, stop = _stretch(start, end, prepared.reference.ticks, CONTROL_PERIOD)
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


def _stretch(start: float | None, end: float | None, ticks: int, period: float) -> tuple[int, int]:
    """Return samples [first, stop) of times; all, or the latest, where none is given."""
    last = ticks * period
    bounds: dict[str, float] = {"minimum": 0.0, "maximum": last}
    for name, time in (("start", start), ("end", end)):
        if time is not None and not 0.0 <= time <= last * (1 + 1e-9):
            raise ConfigError(FieldError(name, "is not in the recording", time, "", "s", bounds))
    stop = ticks if end is None else min(ticks, round(end / period))
    first = max(0, stop - SAMPLES_MAX) if start is None else round(start / period)
    if not 0 < stop - first <= SAMPLES_MAX:
        ends = {"exclusive_minimum": first * period, "maximum": (first + SAMPLES_MAX) * period}
        raise ConfigError(FieldError("end", "too few or too many samples", end, "", "s", ends))
    return first, stop


def ticks_needed(prepared: Prepared, end: float | None) -> int:
    """Return how many ticks of a scenario a view up to a time takes."""
    return prepared.reference.ticks if end is None else to_ticks(end)
