"""The references that a motion on drives adds to its trajectory."""

from __future__ import annotations

import numpy as np
import pytest

from motionlab.drive.link.bounds import check_reference
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.link.shared import RUN_TICKS_MAX
from motionlab.drive.motion import braking, minimum_jerk
from motionlab.drive.virtual.segment import default_drive
from motionlab.timing import CONTROL_PERIOD


def test_the_approach_goes_from_rest_to_rest_within_limits() -> None:
    start, end = np.array([0.0, 0.02]), np.array([0.01, -0.03])
    velocity, acceleration = np.array([0.05, 0.04]), np.array([2.0, 1.0])
    reference = minimum_jerk(start, end, velocity=velocity, acceleration=acceleration)
    np.testing.assert_array_equal(reference[0, 0], start)
    assert np.abs(reference[-1, 0] - end).max() < 1e-6
    assert (np.abs(reference[:, 1]).max(axis=0) <= velocity * (1 + 1e-9)).all()
    assert (np.abs(reference[:, 2]).max(axis=0) <= acceleration * (1 + 1e-9)).all()


def test_a_way_that_takes_too_long_is_refused_before_it_is_computed() -> None:
    slow = np.full(2, 1e-9)
    with pytest.raises(LinkError, match=r"the way to the start takes \d+ s; at most 300 s"):
        minimum_jerk(np.zeros(2), np.full(2, 0.02), velocity=slow, acceleration=np.ones(2))


@pytest.mark.parametrize("velocity", [(0.1, -0.05), (0.0, 0.2), (0.0, 0.0)])
def test_a_motion_that_ends_at_speed_brakes(velocity: tuple[float, float]) -> None:
    last = np.array([[0.01, 0.02], velocity, [0.0, 0.0]])
    deceleration = np.array([3.0, 1.5])
    reference = braking(last, deceleration)
    np.testing.assert_allclose(reference[-1, 1], 0.0, atol=1e-15)
    way = np.sign(velocity) * np.square(velocity) / (2 * deceleration)
    np.testing.assert_allclose(reference[-1, 0] - last[0], way, atol=1e-12)
    steps = np.diff(np.vstack((last[1], reference[:, 1])), axis=0)
    assert (np.abs(steps) <= deceleration * CONTROL_PERIOD * (1 + 1e-9)).all()


def test_a_motion_beyond_a_limit_is_refused_before_it_begins() -> None:
    config = default_drive()
    reference = np.zeros((100, 3, 2))
    check_reference(reference, config)
    for row, axis, value, message in (
        (0, 0, config.x.position_max + 1e-3, "goes from 0.00 to .* mm in x; allowed"),
        (0, 1, config.y.position_min - 1e-3, "mm in y; allowed"),
        (1, 1, -config.y.velocity_max - 1e-3, "mm/s fast in y; at most"),
        (0, 0, np.nan, "not a number"),
    ):
        wrong = reference.copy()
        wrong[50, row, axis] = value
        with pytest.raises(LinkError, match=message):
            check_reference(wrong, config)
    with pytest.raises(LinkError, match="at most 300 s"):
        check_reference(np.zeros((RUN_TICKS_MAX + 1, 3, 2)), config)
