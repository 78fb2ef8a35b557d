"""Motion profiles: limits, rest at the ends, derivatives."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.motion_profile import (
    minimum_jerk,
    minimum_jerk_ticks,
    smooth_start,
    trapezoidal,
    trapezoidal_ticks,
)

durations = st.floats(0.1, 1e4)
lengths = st.floats(1e-6, 0.3)
speeds = st.floats(1e-3, 2.0)
accelerations = st.floats(1e-2, 20.0)


def fraction(n=201):
    return np.linspace(0.0, 1.0, n)


def assert_derivatives(law, u, scale, *, size=1.0):
    """Compare the analytic derivatives with central differences between the grid points."""
    middle = (u[1:] + u[:-1]) / 2
    h = scale * 1e-5
    s_left, rate_left, _ = law(middle - h)
    s_right, rate_right, _ = law(middle + h)
    _, rate, second = law(middle)
    assert np.allclose((s_right - s_left) / (2 * h), rate, rtol=1e-6, atol=1e-8 * size / scale)
    assert np.allclose(
        (rate_right - rate_left) / (2 * h), second, rtol=1e-5, atol=1e-6 * size / scale**2
    )


@given(durations)
def test_minimum_jerk_goes_from_rest_to_rest(duration):
    s, rate, second = minimum_jerk(np.array([0.0, duration]), duration)
    assert np.allclose(s, [0, 1], atol=1e-12)
    assert np.allclose(rate * duration, 0, atol=1e-12)
    assert np.allclose(second * duration**2, 0, atol=1e-12)


@given(durations)
def test_minimum_jerk_derivatives_and_peaks(duration):
    u = fraction() * duration
    assert_derivatives(lambda t: minimum_jerk(t, duration), u, duration)
    _, rate, second = minimum_jerk(fraction(20_001) * duration, duration)
    assert rate.max() * duration == pytest.approx(15 / 8, rel=1e-6)
    assert np.abs(second).max() * duration**2 == pytest.approx(10 / math.sqrt(3), rel=1e-6)


@given(st.integers(1, 500), st.integers(0, 500))
def test_trapezoidal_ends_at_rest_and_holds_its_peaks(ramp, cruise):
    total = 2 * ramp + cruise
    s, rate, second = trapezoidal(np.arange(total + 1.0), ramp, cruise)
    assert np.allclose([s[0], s[-1], rate[0], rate[-1]], [0, 1, 0, 0], rtol=0, atol=1e-15)
    assert rate.max() == pytest.approx(1 / (ramp + cruise))
    assert np.abs(second).max() == pytest.approx(1 / (ramp * (ramp + cruise)))
    # Corners lie on ticks, so both integrals by sums over ticks are exact.
    assert np.allclose(np.diff(s), (rate[1:] + rate[:-1]) / 2, rtol=0, atol=1e-14)
    assert np.allclose(np.diff(rate), second[:-1], rtol=0, atol=1e-14)


@given(st.floats(0.5, 1e4))
def test_smooth_start_starts_from_rest_and_runs_at_full_rate(lead_in):
    u = fraction() * 2 * lead_in
    assert_derivatives(lambda t: smooth_start(t, lead_in), u, lead_in, size=lead_in)
    w, rate, second = smooth_start(np.array([0.0, lead_in, 1.7 * lead_in]), lead_in)
    assert np.allclose(w / lead_in, [0, 0.5, 1.2], atol=1e-12)
    assert np.allclose(rate, [0, 1, 1], atol=1e-12)
    assert np.allclose(second * lead_in, 0, atol=1e-12)


def test_smooth_start_without_lead_in_is_the_clock_itself():
    u = np.arange(5.0)
    w, rate, second = smooth_start(u, 0)
    assert np.array_equal(w, u)
    assert np.array_equal(rate, np.ones(5))
    assert np.array_equal(second, np.zeros(5))


@given(lengths, speeds, accelerations)
def test_trapezoidal_move_respects_its_limits_and_wastes_little(length, v_max, a_max):
    ramp, cruise = trapezoidal_ticks(length, v_max=v_max, a_max=a_max)
    velocity = length / (ramp + cruise) / CONTROL_PERIOD
    assert velocity <= v_max * (1 + 1e-8)
    assert velocity / (ramp * CONTROL_PERIOD) <= a_max * (1 + 1e-8)
    full_speed = length >= v_max**2 / a_max
    ideal = length / v_max + v_max / a_max if full_speed else 2 * math.sqrt(length / a_max)
    assert (2 * ramp + cruise) * CONTROL_PERIOD <= ideal + 3 * CONTROL_PERIOD


@given(lengths, speeds, accelerations)
def test_minimum_jerk_move_respects_its_limits_and_wastes_little(length, v_max, a_max):
    ticks = minimum_jerk_ticks(length, v_max=v_max, a_max=a_max)
    _, rate, second = minimum_jerk(fraction(2001) * ticks, ticks)
    velocity = length * rate.max() / CONTROL_PERIOD
    acceleration = length * second.max() / CONTROL_PERIOD**2
    assert velocity <= v_max * (1 + 1e-8)
    assert acceleration <= a_max * (1 + 1e-8)
    stretch = ticks / max(ticks - 1, 1)
    assert (
        ticks == 1
        or velocity * stretch >= v_max * (1 - 1e-6)
        or acceleration * stretch**2 >= a_max * (1 - 1e-4)
    )


def test_a_duration_that_is_whole_up_to_rounding_gains_no_tick():
    assert trapezoidal_ticks(0.3, v_max=0.3, a_max=3.0) == (200, 1800)
