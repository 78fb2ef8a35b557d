"""Quadrant glitches: made errors are measured as they were made, and noise is called noise."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.analysis.glitches import AVERAGED, glitches, reversals
from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]

COUNT = 50e-9  # m
TICKS = 6000
PERIOD = 2000  # ticks of a reference that turns every half of them
TIME = CONTROL_PERIOD * np.arange(TICKS)
VELOCITY = np.sin(2 * np.pi * np.arange(TICKS) / PERIOD + 1e-9)
TURNS = [1000, 2000, 3000, 4000, 5000]


def made(shape: NDArray[Any], *, noise: float = 0.0, base: float = 2e-6) -> Array:
    """Return an error that follows a shape from each turn on, with the sign of the motion."""
    error = np.full(TICKS, base)
    sign = 1.0
    for turn in [0, *TURNS]:
        error[turn : turn + 1000] += sign * shape[: len(error) - turn]
        sign = -sign
    error += noise * np.random.default_rng(7).standard_normal(TICKS)
    return COUNT * np.rint(error / COUNT)


def spike(height: float, rise: float, fall: float) -> Array:
    """Return an error that rises evenly, falls evenly and is over, s."""
    t = TIME[:1000]
    return height * np.clip(np.minimum(t / rise, 1 - (t - rise) / fall), 0.0, None)


def test_it_turns_where_the_sign_of_the_velocity_changes() -> None:
    turns = reversals(VELOCITY)
    assert [turn.tick for turn in turns] == TURNS
    assert [turn.direction for turn in turns] == [-1, 1, -1, 1, -1]
    assert [turn.end for turn in turns] == [*TURNS[1:], TICKS]


def test_a_rest_between_is_no_reversal_of_its_own() -> None:
    velocity = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, -1.0, -1.0, 0.0])
    assert reversals(velocity) == [(7, -1, 10)]
    assert reversals(np.zeros(5)) == []
    assert reversals(np.ones(5)) == []


@pytest.mark.parametrize("noise", [0.0, 40e-9])
def test_a_spike_has_the_height_and_the_times_it_was_made_with(noise: float) -> None:
    found = glitches(
        VELOCITY, made(spike(3e-6, 0.02, 0.06), noise=noise), count=COUNT, period=CONTROL_PERIOD
    )
    assert len(found) == len(TURNS)
    for glitch in found:
        assert np.sign(glitch.height) == glitch.direction
        # The average over 5 ms takes the tip off: a quarter of its length, of both slopes.
        tip = 3e-6 * AVERAGED / 4 * (1 / 0.02 + 1 / 0.06) / 2
        assert abs(glitch.height) == pytest.approx(3e-6 - tip, abs=2 * COUNT)
        assert glitch.delay == pytest.approx(0.002, abs=0.0015)
        assert glitch.rise == pytest.approx(0.016, abs=0.003)
        # Within a tenth of its height of nothing: at 90 % of the fall.
        assert glitch.duration == pytest.approx(0.02 + 0.9 * 0.06, abs=0.008)


def test_a_step_that_stays_is_settled_where_it_stays() -> None:
    shape = np.clip(TIME[:1000] / 0.05, 0.0, 1.0) * 2e-6 - 1e-6
    found = glitches(VELOCITY, made(shape), count=COUNT, period=CONTROL_PERIOD)
    for glitch in found[1:]:
        # It leaves what the turn before left it at, -1 um of the new direction.
        assert abs(glitch.height) == pytest.approx(2e-6, abs=2 * COUNT)
        assert glitch.duration == pytest.approx(0.05, abs=0.01)


def test_one_count_has_a_height_and_no_duration() -> None:
    for shape in (spike(0.6 * COUNT, 0.02, 0.06), np.zeros(1000)):
        found = glitches(VELOCITY, made(shape), count=COUNT, period=CONTROL_PERIOD)
        assert len(found) == len(TURNS)
        for glitch in found:
            assert abs(glitch.height) <= 1.01 * COUNT
            assert (glitch.delay, glitch.rise, glitch.duration) == (None, None, None)


def test_what_was_not_measured_is_left_out() -> None:
    error = made(spike(3e-6, 0.02, 0.06))
    error[2500] = np.nan
    found = glitches(VELOCITY, error, count=COUNT, period=CONTROL_PERIOD)
    assert [glitch.tick for glitch in found] == [1000, 3000, 4000, 5000]
    assert glitches(VELOCITY[995:], error[995:], count=COUNT, period=CONTROL_PERIOD)[0].tick == 2005


def test_an_error_that_goes_on_growing_has_no_duration() -> None:
    ramp = 3e-6 * TIME[:1000] / 0.5
    found = glitches(VELOCITY, made(ramp), count=COUNT, period=CONTROL_PERIOD)
    assert [(one.duration, one.rise is None) for one in found] == 5 * [(None, False)]


def test_compensation_of_the_circle_takes_nearly_all_of_it() -> None:
    """Under A the error turns from one peak to the other; B leaves less than a twentieth."""
    prepared = prepare(load_scenario("circle", {"trajectory.laps": 2}))
    recording = run(prepared)
    for index, axis in enumerate("xy"):
        found = {
            name: glitches(
                prepared.reference.velocity[:, index],
                record.channel("following_error", axis).astype(float),
                count=COUNT,
                period=CONTROL_PERIOD,
            )
            for name, record in recording.variants.items()
        }
        error = recording.variants["A"].channel("following_error", axis)[-3000:]
        heights = {name: [abs(one.height) for one in each] for name, each in found.items()}
        assert max(heights["A"]) == pytest.approx(float(error.max() - error.min()), rel=0.2)
        assert max(heights["B"]) < min(heights["A"]) / 20
