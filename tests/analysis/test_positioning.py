"""Positioning: figures of ISO 230-2 computed by hand, and how they are read off a recording."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from motionlab.analysis import positioning as numbers
from motionlab.analysis.views.positioning import (
    OVERRUN,
    PositioningCycle,
    measured_scenario,
    positioning,
)
from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.simulation.prepare import prepare
from motionlab.simulation.recorded import of_recording
from motionlab.simulation.run import run

PERIOD = 0.5e-3  # s
UM = 1e-6

TARGETS = [
    numbers.Target(0.00, UM * np.array([1.0, 2.0, 3.0]), UM * np.array([-1.0, -1.0, -1.0])),
    numbers.Target(0.05, UM * np.array([4.0, 4.0, 7.0]), UM * np.array([6.0, 4.0, 2.0])),
]
"""Means 2 and -1, 5 and 4 um; standard deviations 1 and 0, sqrt(3) and 2 um."""


def test_the_figures_are_those_computed_by_hand() -> None:
    found = numbers.figures_of(TARGETS)
    by_hand = {
        "B": 3.0,  # 2 - -1
        "B_mean": (3.0 + 1.0) / 2,
        "R_up": 4 * math.sqrt(3.0),
        "R_down": 8.0,
        "R": 2 * math.sqrt(3.0) + 4.0 + 1.0,  # of the second target; the first has 5
        "M": 4.5 - 0.5,
        "E": 5.0 - -1.0,
        "E_up": 5.0 - 2.0,
        "E_down": 4.0 - -1.0,
        "A": 5.0 + 2 * math.sqrt(3.0) - -1.0,
        "A_up": 5.0 + 2 * math.sqrt(3.0) - 0.0,
        "A_down": 8.0 - -1.0,
    }
    for name, value in by_hand.items():
        assert getattr(found, name) == pytest.approx(UM * value, rel=1e-12), name
    assert TARGETS[0].repeatability == pytest.approx(UM * (2 * 1 + 0 + 3), rel=1e-12)
    # One direction alone may be the worst of a target.
    lone = numbers.Target(0.0, UM * np.array([-4.0, 4.0]), UM * np.array([0.0, 0.0]))
    assert lone.repeatability == pytest.approx(4 * lone.s_up, rel=1e-12)


def test_rests_are_read_at_their_end_and_sorted_by_direction() -> None:
    """Two targets, twice each way; the drift of a rest ends where its mean is taken."""
    hold, move = 400, 200  # samples
    stops = numbers.cycle([0.0, 0.01], 0.002, 2)
    pieces: list[np.ndarray] = [np.full(hold, stops[0])]
    for start, end in itertools.pairwise(stops):
        pieces += [np.linspace(start, end, move + 2)[1:-1], np.full(hold, end)]
    reference = np.concatenate(pieces)
    found = numbers.rests(reference, PERIOD)
    assert [rest.place for rest in found] == pytest.approx(stops[1:])
    assert all(rest.stop - rest.start == hold for rest in found)
    groups = numbers.grouped(found)
    # Where the axis turns it is approached from one side only.
    assert [place for place, _, _ in groups] == pytest.approx([0.0, 0.01])
    for _, up, down in groups:
        assert [rest.direction for rest in up] == [numbers.UP] * 2
        assert [rest.direction for rest in down] == [numbers.DOWN] * 2
    last = round(numbers.READ / PERIOD)
    values = np.zeros_like(reference)
    rest = groups[1][1][0]
    values[rest.start : rest.stop - last] = 1.0
    values[rest.stop - last : rest.stop] = 5e-6
    assert numbers.read(rest, values, PERIOD) == pytest.approx(5e-6, rel=1e-12)


def test_targets_rise_from_end_to_end_at_uneven_distances() -> None:
    targets = numbers.targets_in(-0.08, 0.08, 9)
    assert (targets[0], targets[-1]) == (-0.08, 0.08)
    assert np.diff(targets).min() > 0.0
    shifts = np.array(targets)[1:-1] - np.linspace(-0.08, 0.08, 9)[1:-1]
    assert len(set(np.round(shifts, 6))) == 7  # no two at the same phase of a period of 20 mm
    assert np.abs(shifts).max() <= 0.3 * 0.02


def test_a_cycle_under_friction_equals_its_samples() -> None:
    """A stops short by its friction over k_p: a reversal value; the laser sees what it does."""
    asked = PositioningCycle(axis="x", targets=3, runs=2, dwell=0.3, low=-0.01, high=0.01)
    scenario = load_scenario("circle", {"plant.x.encoder.sde_amplitude": 1e-6})
    prepared = prepare(measured_scenario(scenario, asked))
    recording = run(prepared)
    recorded = of_recording(recording, prepared, 0, prepared.reference.ticks)
    found = positioning(recorded, asked)
    assert (found.axis, found.instrument, found.simulated) == ("x", "true", True)
    assert found.resolution == pytest.approx(2.0**-30)  # single precision at 10 mm

    reference = recorded.needed("x.position_reference")
    inner = found.variants["B"].targets[1].place
    there = np.flatnonzero(np.diff(np.abs(reference - inner) < 1e-12)) + 1
    ends = there[1::2]  # where each rest ends: up, down, up, down
    position = recorded.needed("B.x.position")
    means = [position[end - 200 : end].mean() - inner for end in ends]
    shown = found.variants["B"].targets[1]
    assert [shown.up[0], shown.down[0], shown.up[1], shown.down[1]] == pytest.approx(
        means, abs=1e-12
    )
    a, b = (found.variants[name].figures for name in "AB")
    assert a is not None
    assert b is not None
    assert a.B > 20e-6 > 10 * b.B

    encoder = asked.model_copy(update={"instrument": "encoder"})
    other = positioning(recorded, encoder).variants["B"].targets[1]
    error = recorded.needed("B.x.following_error")
    assert other.up[0] == pytest.approx(-error[ends[0] - 200 : ends[0]].mean(), abs=1e-12)
    assert abs(other.mean_up - shown.mean_up) > 50e-9  # it does not see its own error


@pytest.mark.parametrize(
    ("change", "named"),
    [({"high": 0.084}, "high"), ({"low": 0.05, "high": 0.04}, "high"), ({"low": -0.2}, "low")],
)
def test_a_cycle_that_does_not_fit_is_refused_by_name(change: dict[str, float], named: str) -> None:
    with pytest.raises(ConfigError) as caught:
        measured_scenario(load_scenario("circle", {}), PositioningCycle().model_copy(update=change))
    assert [error.loc for error in caught.value.errors] == [named]
    assert OVERRUN == 2e-3
