"""Offline runs that a live session has to agree with, to the last bit."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from motionlab.server.live.history import RING_SECONDS
from motionlab.telemetry import recorder
from motionlab.telemetry.channels import CHANNELS, REFERENCES
from motionlab.timing import CONTROL_PERIOD
from tests.server.live import Live
from tests.simulated import Played, play

COLUMNS = 2 * len(REFERENCES) + 2 * 2 * len(CHANNELS)
RING = round(RING_SECONDS / CONTROL_PERIOD)

offline = functools.cache(play)


def expected(played: Played, start: int, end: int) -> dict[str, NDArray[np.float32]]:
    """Return every column of an offline run over ticks [start, end)."""
    return {name: values[start:end] for name, _, values in recorder.columns(played.recording)}


def assert_offline(live: Live, played: Played, start: int = 0) -> None:
    """Fail unless every bit that the session holds from `start` on is that of the offline run.

    A circle goes on live where the offline run has ended; those ticks are not compared.
    """
    columns = live.columns()
    ticks = columns.pop("tick")
    times = columns.pop("time")
    assert len(columns) == COLUMNS
    assert ticks[0] == max(0, live.tick - RING)
    assert ticks[-1] == live.tick - 1
    np.testing.assert_array_equal(np.diff(ticks), 1)
    np.testing.assert_array_equal(times, ticks * CONTROL_PERIOD)
    skip = max(0, start - int(ticks[0]))
    wanted = expected(played, int(ticks[skip]), int(ticks[-1]) + 1)
    assert list(columns) == list(wanted)
    for name, values in wanted.items():
        assert len(values) > 0
        assert values.tobytes() == columns[name][skip : skip + len(values)].tobytes(), name


def wanted(name: str, start: int, end: int) -> bytes:
    """Return the bytes of a column of the circle over ticks [start, end)."""
    return expected(offline("circle"), start, end)[name].tobytes()
