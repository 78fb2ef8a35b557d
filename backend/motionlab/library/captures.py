"""Stretches of live sessions and simulations that are kept as runs of their own."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.glitches import glitches
from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import StoreError
from motionlab.library.description import thumbnail
from motionlab.library.library import Library
from motionlab.library.new_run import live_run, new_run
from motionlab.library.recorded import scenario_of
from motionlab.library.run import NAME_MAX, NOTE_MAX, Capture, RunDetail, new_id
from motionlab.library.stability_margins import stability_margins
from motionlab.simulation.result import metadata
from motionlab.telemetry import recorder
from motionlab.telemetry.channels import Channel
from motionlab.telemetry.expressions.columns import compile_columns, values_of
from motionlab.telemetry.law_channels import kept_states
from motionlab.telemetry.parquet import read_ticks
from motionlab.telemetry.recording import Recording
from motionlab.timing import CONTROL_PERIOD

TAG = "capture"
"""The tag of captures."""


class About(NamedTuple):
    """What is said of a capture.

    Attributes
    ----------
    origin : str
        Identifier of the run that the session is recorded as; empty if it is not.
    name, note : str
        What it is called, and what is said of it besides where it comes from.
    drive : str
        Title of the drive link that moves; empty for a simulated session.
    automatic : bool
        Whether a program kept it as it came; then it may be evicted.
    simulated : bool
        Whether it is of a simulation, and not of a session.
    trigger : int or None
        Tick at which it was triggered; its first one when left out.
    columns : sequence of str
        Channels of the trigger, also math channels.
    """

    origin: str
    name: str
    note: str
    drive: str
    automatic: bool = False
    simulated: bool = False
    trigger: int | None = None
    columns: Sequence[str] = ()


def recorded_stretch(
    library: Library, run_id: str, start: int, stop: int
) -> tuple[Scenario, NDArray[np.float32], list[tuple[str, Channel]]] | None:
    """Return ticks [start, stop) of what is or was recorded, and the scenario in effect there.

    Returns
    -------
    Scenario, ndarray of float32, shape (columns, ticks), and the last columns, of laws; or None
        None where the recording does not hold all of them.

    Raises
    ------
    StoreError
        If it cannot be read.
    """
    from motionlab.library import spool  # noqa: PLC0415 - slow to load: a server starts without it

    run, data = None, spool.samples(library.spools, run_id, start, stop)
    if data is not None:
        with contextlib.suppress(StoreError):  # it has just been made a run
            run, events = spool.begun(library.spools, run_id)
            run = run.model_copy(update={"events": events})
    if run is None or data is None:
        run = library.index.get(run_id)
        if run is None or run.state == "recording":
            return None
        first, names = run.first_tick, [column["name"] for column in run.columns]
        with library.files.open(run_id) as file:
            if start < first or stop - first > file.metadata.num_rows:
                return None
            data = read_ticks(file, names, start - first, stop - first)
    at = start - run.first_tick
    scenario = scenario_of(run, at, at + 1, lambda _: False)
    if isinstance(scenario, str):  # a motor or map that is gone
        scenario = load_scenario(run.scenario_document or {})
    return scenario, data, kept_states(run.columns)


def keep_capture(
    library: Library,
    scenario: Scenario,
    recording: Recording,
    about: About,
) -> RunDetail:
    """Keep a stretch of a session or a simulation as a run, tagged as a capture.

    It has every channel and no scenario to simulate again: it did not begin at rest.

    Parameters
    ----------
    library : Library
        Where it is kept.
    scenario : Scenario
        What is in effect in the session.
    recording : Recording
        The stretch.
    about : About
        What is said of it.

    Raises
    ------
    ConfigError
        If a channel of the trigger is not there.
    StoreError
        If it cannot be kept; `StoreFull` where there is no room. Nothing is kept then.
    """
    first, stop = recording.first_tick, recording.first_tick + recording.ticks
    tick = first if about.trigger is None else about.trigger
    times = f"{first * CONTROL_PERIOD:.8g} to {stop * CONTROL_PERIOD:.8g} s"
    where = f"{times} of {about.origin or scenario.name}."
    if about.simulated:
        run = new_run("simulation", scenario, {})
    else:
        run = live_run(scenario, new_id(), time.time(), drive=about.drive)
    run = run.model_copy(
        update={
            "state": "complete",
            "name": about.name
            or f"capture at {tick * CONTROL_PERIOD:.8g} s, {run.name}"[:NAME_MAX],
            "named": bool(about.name),
            "note": f"{about.note}\n{where}".strip()[:NOTE_MAX],
            "tags": [TAG],
            "kept": not about.automatic,
            "capture": capture_figures(recording, scenario, about),
            "metrics": {} if about.drive else stability_margins(scenario),
            "ticks": recording.ticks,
            "thumbnail": thumbnail(recording, (first, stop)),
            "scenario_document": None,
        }
    )
    facts = metadata(scenario)
    return library.keep_file(run, lambda part: recorder.write(recording, part, metadata=facts))


def capture_figures(recording: Recording, scenario: Scenario, about: About) -> Capture:
    """Return what a list shows of a capture.

    Parameters
    ----------
    recording : Recording
        Of the capture.
    scenario : Scenario
        What is in effect in it.
    about : About
        What triggered it, and when.

    Raises
    ------
    ConfigError
        If a channel of the trigger is not there, or cannot be computed.
    """
    columns = {name: (channel, values) for name, channel, values in recorder.columns(recording)}
    units = {name: channel.unit for name, (channel, _) in columns.items()}
    math = compile_columns(about.columns, units, CONTROL_PERIOD)
    first = recording.first_tick
    trigger = first if about.trigger is None else about.trigger
    heights: dict[str, float] = {}
    for axis, velocity in zip(AXES, recording.references[1], strict=True):
        count = getattr(scenario.plant, axis).encoder.resolution
        for variant, record in recording.variants.items():
            error = record.channel("following_error", axis).astype(np.float64)
            turns = glitches(velocity, error, count=count, period=CONTROL_PERIOD)
            nearest = min(turns, key=lambda turn: abs(first + turn.tick - trigger), default=None)
            if nearest is not None:
                heights[f"{variant}.{axis}.following_error"] = nearest.height
    errors = [f"{name}.{axis}.following_error" for name in scenario.variants for axis in AXES]
    peaks: dict[str, float] = {}
    for name in dict.fromkeys([*errors, *about.columns]):
        if name in math:
            values = values_of(math[name], lambda source: columns[source][1])
        else:
            values = columns[name][1]
        finite = values[np.isfinite(values)]
        if finite.size:
            peaks[name] = float(finite[np.argmax(np.abs(finite))])
    return Capture(
        origin=about.origin,
        from_tick=first,
        trigger_tick=trigger,
        peaks=peaks,
        glitches=heights,
    )
