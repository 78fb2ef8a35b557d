"""Stretches of live sessions that are kept as runs of their own."""

from __future__ import annotations

import contextlib
import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.errors import StoreError
from motionlab.library.description import thumbnail
from motionlab.library.library import Library
from motionlab.library.new_run import live_run
from motionlab.library.recorded import scenario_of
from motionlab.library.run import NOTE_MAX, RunDetail, new_id
from motionlab.simulation.result import metadata
from motionlab.telemetry import recorder
from motionlab.telemetry.parquet import read_ticks
from motionlab.telemetry.recording import as_recording
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
    """

    origin: str
    name: str
    note: str
    drive: str
    automatic: bool = False


def recorded_stretch(
    library: Library, run_id: str, start: int, stop: int
) -> tuple[Scenario, NDArray[np.float32]] | None:
    """Return ticks [start, stop) of what is or was recorded, and the scenario in effect there.

    Returns
    -------
    Scenario and ndarray of float32, shape (columns, ticks), or None
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
    return scenario, data


def keep_capture(
    library: Library,
    scenario: Scenario,
    samples: tuple[int, NDArray[np.float32]],
    about: About,
) -> RunDetail:
    """Keep a stretch of a session as a run, tagged as a capture.

    It has every channel and no scenario to simulate again: it did not begin at rest.

    Parameters
    ----------
    library : Library
        Where it is kept.
    scenario : Scenario
        What is in effect in the session.
    samples : tuple of int and ndarray of float32, shape (columns, ticks)
        First tick, and all columns as `stream_columns` orders them.
    about : About
        What is said of it.

    Raises
    ------
    StoreError
        If it cannot be kept; `StoreFull` where there is no room. Nothing is kept then.
    """
    first, data = samples
    stop = first + data.shape[1]
    recording = as_recording(first, data, dict.fromkeys(scenario.variants))
    times = f"{first * CONTROL_PERIOD:.8g} to {stop * CONTROL_PERIOD:.8g} s"
    where = f"{times} of {about.origin or scenario.name}."
    run = live_run(scenario, new_id(), time.time(), drive=about.drive)
    run = run.model_copy(
        update={
            "state": "complete",
            "name": about.name or f"{scenario.name} at {first * CONTROL_PERIOD:.8g} s",
            "note": f"{about.note}\n{where}".strip()[:NOTE_MAX],
            "tags": [TAG],
            "kept": not about.automatic,
            "ticks": recording.ticks,
            "thumbnail": thumbnail(recording, (first, stop)),
            "scenario_document": None,
        }
    )
    facts = metadata(scenario)
    return library.keep_file(run, lambda part: recorder.write(recording, part, metadata=facts))
