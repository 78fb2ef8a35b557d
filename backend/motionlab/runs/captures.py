"""Stretches of live sessions that are kept as runs of their own."""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.scenario import Scenario
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.runs.description import thumbnail
from motionlab.runs.library import Library
from motionlab.runs.new_run import live_run
from motionlab.runs.run import NOTE_MAX, RunDetail, new_id
from motionlab.simulation.result import metadata
from motionlab.telemetry import recorder
from motionlab.telemetry.recording import as_recording

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
    """

    origin: str
    name: str
    note: str
    drive: str


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
            "ticks": recording.ticks,
            "thumbnail": thumbnail(recording, (first, stop)),
            "scenario_document": None,
        }
    )
    facts = metadata(scenario)
    return library.keep_file(run, lambda part: recorder.write(recording, part, metadata=facts))
