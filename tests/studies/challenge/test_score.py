"""The score on made-up figures, worked out by hand, and the order of laws."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from motionlab.studies.challenge.runs import motor_runs
from motionlab.studies.challenge.score import (
    WEIGHTS,
    AxisFigures,
    effort_of,
    error_of,
    geometric_mean,
    place,
    score_of,
    verdict_of,
)

OFF = {"x": AxisFigures(8e-6, 4e-6, 2.0, 0.1), "y": AxisFigures(4e-6, 2e-6, 1.0, 0.2)}
LAW = {"x": AxisFigures(2e-6, 1e-6, 2.0, 0.4), "y": AxisFigures(4e-6, 2e-6, 4.0, 0.2)}


def test_the_error_is_the_mean_of_largest_and_rms_and_of_the_axes() -> None:
    # x: sqrt(1/4 1/4) = 1/4, y: 1; their geometric mean is 1/2.
    assert error_of(LAW, OFF) == pytest.approx(0.5)
    assert error_of({"x": LAW["x"]}, OFF) == pytest.approx(0.25)


def test_the_effort_is_that_of_the_force_and_of_its_change() -> None:
    # x: sqrt(1 4) = 2, y: sqrt(4 1) = 2.
    assert effort_of(LAW, OFF) == pytest.approx(2.0)


def test_off_has_one_throughout() -> None:
    assert error_of(OFF, OFF) == effort_of(OFF, OFF) == 1.0
    assert score_of(dict.fromkeys(WEIGHTS, 1.0)) == 1.0


def test_the_score_is_the_weighted_mean_of_three_parts() -> None:
    assert sum(WEIGHTS.values()) == 1.0
    # (1/4)^(1/2) (1/16)^(1/4) 16^(1/4) = 1/2 1/2 2
    assert score_of({"error": 0.25, "motors": 0.0625, "effort": 16.0}) == pytest.approx(0.5)


def test_an_error_of_nothing_counts_as_a_nanometre() -> None:
    nothing = {"x": AxisFigures(0.0, 0.0, 2.0, 0.1)}
    assert error_of(nothing, OFF) == pytest.approx(math.sqrt(1e-9 / 8e-6 * 1e-9 / 4e-6))


def test_a_mean_of_nothing_is_none() -> None:
    assert math.isnan(geometric_mean([]))


def verdict(**changes: Any) -> str:
    held: dict[str, Any] = {"diverged": 0, "stable": True, "gain_margin": 2.0, "phase_margin": 0.6}
    return verdict_of(**held | changes)


def test_a_verdict_is_the_worst_that_holds_of_a_law() -> None:
    assert verdict() == "holds"
    assert verdict(gain_margin=1.99) == "short of margins"
    assert verdict(phase_margin=math.radians(29.9)) == "short of margins"
    assert verdict(gain_margin=math.inf, phase_margin=math.inf) == "holds"
    assert verdict(stable=False, gain_margin=1.0) == "without margins"
    assert verdict(diverged=1, stable=False) == "diverges"


def test_a_law_that_holds_ranks_above_any_that_does_not() -> None:
    places = [
        place("holds", 0.9, "b"),
        place("holds", 0.9, "c"),
        place("holds", 1.0, "a"),
        place("short of margins", 0.1, "a"),
        place("without margins", 0.01, "a"),
        place("diverges", 0.001, "a"),
        place("diverges", None, "a"),
    ]
    assert places == sorted(places[::-1])


def test_motors_on_which_a_law_diverges_are_counted_and_others_compared_with_off() -> None:
    """Four motors, the law off and another, one axis: errors in um."""
    peaks = np.array([[8, 2], [8, 8], [8, np.nan], [np.nan, 2]])[..., None] * 1e-6
    failed = np.isnan(peaks[..., 0])
    feasible = np.array([True, False, True, True])
    runs = motor_runs(peaks, peaks, failed, feasible)
    assert runs.ratios[0, 0] == 1.0
    assert runs.ratios[1, 0] == pytest.approx(0.25)
    assert np.isnan(runs.ratios[:, [1, 3]]).all(), "not feasible; nothing to compare with"
    assert math.isnan(runs.ratios[1, 2])
    assert runs.diverged.tolist() == [1, 1]
    assert runs.left_out == 2
