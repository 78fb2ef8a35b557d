"""What the motor cannot follow is refused with time and place."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter

from motionlab.config.trajectory import TrajectoryConfig
from motionlab.errors import Infeasible
from motionlab.trajectories.feasibility import check, count_rate_warning
from motionlab.trajectories.motion_limits import MotionLimits
from motionlab.trajectories.reference import sample

ADAPTER = TypeAdapter(TrajectoryConfig)


def reference(**table):
    return sample(ADAPTER.validate_python(table))


def friction(axis, velocity):
    """Steady friction of the paper's identified LuGre model, eqs (43) to (48)."""
    F_c, F_s, v_s, sigma_2 = ((0.2399, 3.5908, 0.0436, 10.3128), (0.8179, 4.3917, 0.0222, 25.8778))[
        axis
    ]
    stribeck = F_c + (F_s - F_c) * np.exp(-((velocity / v_s) ** 2))
    return np.sign(velocity) * stribeck + sigma_2 * velocity


LIMITS = MotionLimits(
    stroke=(0.085, 0.145),
    v_max=(1.0, 1.0),
    a_max=(7.31, 3.1),
    mass=(5.9, 13.9),
    friction=friction,
    available_thrust=lambda axis, position, sign: np.full(position.shape, 28.1),
)

SHIPPED = {
    "circle": {"kind": "circle", "radius": 0.015, "frequency": 1 / 3},
    "stair-x-500nm": {"kind": "staircase", "step": {"x": 5e-7}},
    "stair-y-500nm": {"kind": "staircase", "step": {"y": 5e-7}},
    "stair-y-50mm": {
        "kind": "staircase",
        "start": {"y": -0.125},
        "step": {"y": 0.05},
        "v_max": 0.14,
        "a_max": 1.2,
    },
    "trapezoid-y": {
        "kind": "trapezoid",
        "start": {"y": -0.145},
        "end": {"y": 0.145},
        "v_max": 0.15,
        "a_max": 1.6,
    },
    "rhombus": {
        "kind": "polygon",
        "vertices": [[0.03, 0.0], [0.0, 0.03], [-0.03, 0.0], [0.0, -0.03]],
        "frequency": 1 / 3,
    },
    "pentagram": {"kind": "star", "circumradius": 0.03, "frequency": 1 / 3},
}


@pytest.mark.parametrize("table", SHIPPED.values(), ids=SHIPPED)
def test_the_papers_trajectories_are_feasible_without_a_warning(table):
    ref = reference(**table)
    check(ref, LIMITS)
    assert count_rate_warning(ref, "x", resolution=50e-9, rate=1.25e6) is None


def refusal(*, limits: MotionLimits = LIMITS, **table: object) -> Infeasible:
    with pytest.raises(Infeasible) as caught:
        check(reference(**table), limits)
    return caught.value


def test_leaving_the_stroke_gives_first_time_and_place():
    error = refusal(kind="ramp", start={"x": 0.08, "y": 0.01}, velocity={"x": 0.1})
    assert (error.quantity, error.axis, error.unit) == ("position", "x", "m")
    assert error.limit == (-0.085, 0.085)
    # 5 mm at 0.1 m/s, half a lead-in of 0.1 s late: on the limit at 0.1 s, outside a tick later.
    assert error.time == pytest.approx(0.1005)
    assert error.place == pytest.approx((0.08505, 0.01))
    assert "x is 0.08505 m at t = 0.1005 s" in str(error)
    assert "allowed -0.085 to 0.085 m" in str(error)


@pytest.mark.parametrize("excess", [0.0, 1e-13])
def test_the_limit_of_the_stroke_is_inclusive(excess):
    check(reference(kind="point", position={"x": 0.085 + excess, "y": -0.145 - excess}), LIMITS)


def test_just_outside_the_stroke_is_refused_at_the_start():
    error = refusal(kind="point", position={"y": -0.145 - 1e-11})
    assert (error.quantity, error.axis, error.time) == ("position", "y", 0.0)


def test_the_very_end_belongs_to_the_motion():
    ref = reference(
        kind="ramp", start={"x": 0.0849}, velocity={"x": 2e-4}, lead_in=0.0, duration=0.5005
    )
    assert ref.position.max() <= 0.085
    with pytest.raises(Infeasible, match="position on x"):
        check(ref, LIMITS)


def test_too_fast():
    error = refusal(
        limits=replace(LIMITS, v_max=(0.1, 0.1)),
        kind="trapezoid",
        end={"x": 0.08},
        v_max=0.12,
        a_max=1.0,
        dwell=0.0,
    )
    assert (error.quantity, error.axis, error.unit) == ("velocity", "x", "m/s")
    assert error.time == pytest.approx(0.1, abs=2e-3)


def test_too_much_acceleration():
    error = refusal(kind="trapezoid", end={"y": -0.1}, v_max=0.2, a_max=4.0, dwell=0.25)
    assert (error.quantity, error.axis, error.unit) == ("acceleration", "y", "m/s^2")
    assert error.time == 0.25
    assert error.value == pytest.approx(-4.0, rel=0.02)
    assert error.limit == (-3.1, 3.1)


def test_too_much_thrust_counts_mass_and_friction():
    fits = {"kind": "trapezoid", "end": {"y": 0.1}, "v_max": 0.14, "a_max": 1.6}
    check(reference(**fits), LIMITS)
    error = refusal(**{**fits, "a_max": 1.9})
    assert (error.quantity, error.axis, error.unit) == ("thrust", "y", "N")
    # Standing, 13.9 kg x 1.9 m/s^2 = 26.4 N would do; static friction on top is too much.
    assert 28.1 < error.value < 13.9 * 1.9 + 4.4 + 0.5
    check(reference(**fits | {"a_max": 1.9}), replace(LIMITS, mass=(5.9, 11.0)))


def test_thrust_is_asked_for_at_the_place_and_in_the_direction():
    def one_sided(axis, position, sign):
        return np.where((sign < 0) & (position > 0.02), 1.0, 40.0)

    limits = replace(LIMITS, available_thrust=one_sided)
    error = refusal(limits=limits, kind="trapezoid", end={"x": 0.05}, dwell=0.0)
    assert error.quantity == "thrust"
    assert error.value < -1.0
    assert error.place[0] > 0.02
    check(reference(kind="trapezoid", end={"x": -0.05}, there_and_back=False), limits)


@pytest.mark.parametrize("height", [10e-6, -10e-6, 5e-7])
def test_true_steps_up_to_ten_micrometres_are_allowed(height):
    check(reference(kind="step", start={"x": 0.03}, height={"x": height}), LIMITS)


def test_a_larger_true_step_is_refused():
    error = refusal(kind="step", height={"y": -10.1e-6}, delay=0.2)
    assert (error.quantity, error.axis, error.unit) == ("step", "y", "m")
    assert error.time == pytest.approx(0.2)
    assert error.value == pytest.approx(-10.1e-6)
    assert error.limit == (-10e-6, 10e-6)


def test_a_move_too_short_to_be_sampled_is_a_step():
    assert refusal(kind="line", end={"x": 0.01}, edge_time=0.0005).quantity == "step"


@pytest.mark.parametrize(
    "table",
    [
        {"kind": "ramp", "velocity": {"y": 0.02}, "lead_in": 0.0},
        {"kind": "circle", "radius": 0.015, "frequency": 1 / 3, "lead_in": 0.0},
        {"kind": "sine", "amplitude": {"y": 0.01}, "frequency": 1.0, "lead_in": 0.0},
    ],
    ids=lambda table: table["kind"],
)
def test_a_jump_of_velocity_counts_as_acceleration(table):
    error = refusal(**table)
    assert (error.quantity, error.axis, error.time) == ("acceleration", "y", 0.0)
    check(reference(**table | {"lead_in": 0.5}), LIMITS)


def test_stopping_dead_inside_a_sequence_is_refused():
    ramp = {"kind": "ramp", "velocity": {"x": 0.05}, "duration": 0.5}
    error = refusal(kind="sequence", parts=[ramp, {"kind": "dwell"}])
    assert (error.quantity, error.axis, error.time) == ("acceleration", "x", 0.5)


def test_the_earliest_refusal_wins():
    error = refusal(
        kind="sequence",
        parts=[
            {"kind": "step", "height": {"x": 50e-6}},
            {"kind": "trapezoid", "end": {"x": 0.2}, "a_max": 50.0},
        ],
    )
    assert error.quantity == "step"


@given(
    st.floats(0.001, 0.08),
    st.floats(0.02, 0.25),
    st.floats(0.2, 7.3),
    st.sampled_from(["trapezoid", "line"]),
)
def test_moves_within_limits_are_never_refused(length, v_max, a_max, kind):
    limits = replace(
        LIMITS,
        v_max=(v_max, v_max),
        a_max=(a_max, a_max),
        available_thrust=lambda axis, position, sign: np.full(position.shape, math.inf),
    )
    ref = reference(kind=kind, end={"x": length}, v_max=v_max, a_max=a_max, dwell=0.01)
    check(ref, limits)


@given(st.floats(1.001, 3.0))
def test_acceleration_beyond_the_limit_is_always_refused(excess):
    limits = replace(LIMITS, a_max=(1.0, 1.0))
    with pytest.raises(Infeasible, match="acceleration on x"):
        check(reference(kind="parabola", coefficient={"x": excess / 2}, duration=0.1), limits)


def test_count_rate_warning_above_a_quarter_metre_per_second():
    fast = reference(kind="trapezoid", end={"x": 0.08}, v_max=0.3, a_max=2.0, dwell=0.0)
    note = count_rate_warning(fast, "x", resolution=50e-9, rate=1.25e6)
    assert note is not None
    assert "velocity on x exceeds 0.25 m/s from t = 0.12" in note
    assert "1.25 MHz" in note
    at_limit = reference(kind="trapezoid", end={"x": 0.08}, v_max=0.25, a_max=2.0)
    assert count_rate_warning(at_limit, "x", resolution=50e-9, rate=1.25e6) is None
