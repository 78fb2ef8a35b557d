"""Metrics of the latest part of a motion do not depend on where its window begins and ends."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import pytest

from motionlab.analysis.latest_metrics import ReferencePath, latest_metrics
from motionlab.telemetry.recording import Recording
from tests.simulated import Played, play

TICKS = 6000
"""A lap of the circle: the last of three."""
REVERSALS = [12_000 + quarter * 1500 for quarter in range(4)]

circle = functools.cache(lambda: play("circle"))


def cut(recording: Recording, start: int, stop: int) -> Recording:
    """Return ticks [start, stop) as a recording of their own."""
    return dataclasses.replace(
        recording,
        references=recording.references[..., start:stop],
        variants={name: each.cut(start, stop) for name, each in recording.variants.items()},
        first_tick=start,
    )


def contour(played: Played, start: int, around: int) -> dict[str, float]:
    """Return the largest contour error of each variant over a lap from `start` on."""
    recording = cut(played.recording, start, start + TICKS)
    position = played.prepared.reference.position
    begin = max(0, start - around)
    path = ReferencePath(position[begin : start + TICKS + around], start - begin)
    band = played.prepared.scenario.settling_band
    measured = latest_metrics(recording, played.prepared.reference, path, settling_band=band)
    return {name: each["contour"]["max"] for name, each in measured["variants"].items()}


@pytest.mark.parametrize("around", [0, 2000])
def test_a_lap_of_a_steady_circle_has_one_contour_error(around: int) -> None:
    """Wherever it begins, also just after a reversal, where the tracking error is 25 um."""
    played = circle()
    # The same samples in the same laps: what is left are the ends of the window.
    starts = [reversal + after for reversal in REVERSALS for after in (0, 30, 100, 200, 400)]
    found = [contour(played, start, around) for start in starts if start + TICKS <= 21_000]
    assert len(found) > 10
    for name in "AB":
        values = np.array([each[name] for each in found])
        assert np.ptp(values) < 0.01 * values.min(), values
    assert found[0]["A"] == pytest.approx(20.5e-6, abs=0.05e-6)
