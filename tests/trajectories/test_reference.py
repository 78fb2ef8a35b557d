"""Sampled references: geometry, integer ticks, continuity, windows and holds."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from motionlab.config.trajectory import TrajectoryConfig
from motionlab.errors import ConfigError
from motionlab.timing import CONTROL_PERIOD as T_s
from motionlab.trajectories.reference import sample

ADAPTER = TypeAdapter(TrajectoryConfig)
RHOMBUS = [[0.03, 0.0], [0.0, 0.03], [-0.03, 0.0], [0.0, -0.03]]


def reference(**table):
    return sample(ADAPTER.validate_python(table))


def assert_integrates(ref):
    """Velocity explains every increment of position, acceleration every one of velocity."""
    for samples, derivative in (
        (ref.position, ref.velocity),
        (ref.velocity, ref.acceleration),
    ):
        change = np.diff(samples, axis=0)
        mean = (derivative[1:] + derivative[:-1]) / 2
        # A corner of the derivative that lies on a tick costs half its jump.
        slack = np.abs(np.diff(derivative, axis=0)) / 2 + 1e-3 * np.abs(derivative).max()
        assert np.all(np.abs(change - T_s * mean) <= T_s * slack + 1e-15)


lengths = st.floats(0.005, 0.08)
laps = st.integers(1, 4)
periodic = st.one_of(
    st.fixed_dictionaries(
        {
            "kind": st.just("circle"),
            "radius": lengths,
            "frequency": st.floats(0.2, 2.0),
            "laps": laps,
            "direction": st.sampled_from(["ccw", "cw"]),
            "start_angle": st.floats(-3, 3),
        }
    ),
    st.fixed_dictionaries(
        {
            "kind": st.just("star"),
            "circumradius": lengths,
            "frequency": st.floats(0.2, 1.0),
            "points": st.sampled_from([5, 7, 9]),
            "laps": laps,
        }
    ),
)
motions = st.one_of(
    periodic,
    st.fixed_dictionaries(
        {
            "kind": st.just("sine"),
            "amplitude": st.fixed_dictionaries({"x": lengths, "y": lengths}),
            "frequency": st.floats(0.2, 2.0),
            "phase": st.fixed_dictionaries({"y": st.floats(-3, 3)}),
        }
    ),
    st.fixed_dictionaries(
        {
            "kind": st.just("trapezoid"),
            "end": st.fixed_dictionaries({"x": lengths, "y": lengths}),
            "v_max": st.floats(0.02, 0.3),
            "a_max": st.floats(0.2, 3.0),
            "dwell": st.floats(0.0, 0.2),
        }
    ),
    st.fixed_dictionaries(
        {
            "kind": st.just("waypoints"),
            "points": st.just(RHOMBUS),
            "v_max": st.floats(0.02, 0.3),
            "a_max": st.floats(0.2, 3.0),
            "dwell": st.floats(0.0, 0.2),
        }
    ),
    st.fixed_dictionaries(
        {
            "kind": st.just("ramp"),
            "velocity": st.fixed_dictionaries({"x": st.floats(-0.1, 0.1)}),
            "lead_in": st.floats(0.05, 0.5),
        }
    ),
    st.fixed_dictionaries(
        {
            "kind": st.just("parabola"),
            "coefficient": st.fixed_dictionaries({"y": st.floats(-0.5, 0.5)}),
        }
    ),
)


@given(motions)
def test_a_motion_is_continuous_and_its_derivatives_are_true(table):
    ref = reference(**table)
    assert ref.velocity.shape == ref.acceleration.shape == (ref.ticks, 2)
    assert_integrates(ref)


@given(motions)
def test_a_motion_starts_from_rest(table):
    assert np.allclose(reference(**table).velocity[0], 0, atol=1e-15)


@given(periodic)
def test_laps_of_circle_and_star_repeat_after_whole_ticks(table):
    ref = reference(**table)
    first_lap = ref.ticks - table["laps"] * ref.period
    laps = ref.position[first_lap:].reshape(table["laps"], ref.period, 2)
    assert np.allclose(laps, laps[0], rtol=0, atol=1e-13)
    assert np.allclose(ref.end, laps[0, 0], rtol=0, atol=1e-13)


def test_circle_lead_in_then_laps_at_constant_speed():
    ref = reference(kind="circle", radius=0.015, frequency=1 / 3)
    assert ref.ticks == 3000 + 3 * 6000
    assert ref.window == (9000, 21000)
    assert ref.period == 6000
    assert ref.moving == ("x", "y")
    assert ref.holds == ()
    assert np.allclose(ref.position[0], [0.015, 0], atol=1e-17)
    assert np.allclose(np.hypot(*ref.position.T), 0.015, rtol=1e-12)
    speed = np.hypot(*ref.velocity[3000:].T)
    assert np.allclose(speed, 2 * math.pi / 3 * 0.015, rtol=1e-12)
    normal = np.hypot(*ref.acceleration[3000:].T)
    assert np.allclose(normal, (2 * math.pi / 3) ** 2 * 0.015, rtol=1e-12)
    # The clock stays half a lead-in behind: a quarter of a lap.
    assert np.allclose(ref.position[3000], [0, 0.015], atol=1e-15)


@pytest.mark.parametrize(("direction", "sign"), [("ccw", 1), ("cw", -1)])
def test_circle_direction_start_and_centre(direction, sign):
    ref = reference(
        kind="circle",
        radius=0.01,
        frequency=1.0,
        direction=direction,
        start_angle=math.pi / 2,
        center={"x": 0.02, "y": -0.03},
        lead_in=0.0,
        laps=1,
    )
    assert np.allclose(ref.position[0], [0.02, -0.02], atol=1e-15)
    assert np.sign(ref.velocity[0, 0]) == -sign
    assert ref.window == (0, 2000)


@pytest.mark.parametrize(("laps", "measured"), [(1, 1), (2, 1), (3, 2), (7, 2)])
def test_circle_window_is_the_last_two_laps_but_not_the_first(laps, measured):
    ref = reference(kind="circle", radius=0.01, frequency=1.0, laps=laps)
    assert ref.window == (ref.ticks - measured * 2000, ref.ticks)


def test_sine_keeps_its_exact_frequency():
    ref = reference(kind="sine", amplitude={"y": 0.001}, frequency=7.0, cycles=30, lead_in=0.5)
    t = np.arange(1000, ref.ticks) * T_s - 0.25
    assert ref.ticks == 1000 + round(30 / 7 / T_s)
    assert ref.moving == ("y",)
    assert np.allclose(ref.position[1000:, 1], 1e-3 * np.sin(2 * math.pi * 7 * t), atol=1e-14)
    assert np.array_equal(ref.position[:, 0], np.zeros(ref.ticks))


def test_ramp_and_parabola_closed_forms():
    t = np.arange(2000) * T_s
    ramp = reference(kind="ramp", start={"x": 0.01}, velocity={"x": 0.02, "y": -0.03}, lead_in=0.0)
    assert np.allclose(ramp.position[:, 0], 0.01 + 0.02 * t, atol=1e-15)
    assert np.allclose(ramp.position[:, 1], -0.03 * t, atol=1e-15)
    assert np.array_equal(ramp.acceleration, np.zeros((2000, 2)))
    eased = reference(kind="ramp", velocity={"x": 0.02}, lead_in=0.1)
    assert np.allclose(eased.position[200:, 0], 0.02 * (t[200:] - 0.05), atol=1e-15)
    parabola = reference(kind="parabola", coefficient={"x": 0.1, "y": 0.2}, duration=0.5)
    assert np.allclose(parabola.position[:, 1], 0.2 * t[:1000] ** 2, atol=1e-15)
    assert np.allclose(parabola.acceleration, [0.2, 0.4], rtol=1e-12)
    assert ramp.window == (0, 2000)


def test_step_is_a_jump_between_two_ticks():
    ref = reference(kind="step", height={"x": 5e-6, "y": -2e-6}, delay=0.1, dwell=0.4)
    assert ref.ticks == 1000
    assert np.array_equal(ref.position[199], [0, 0])
    assert np.array_equal(ref.position[200], [5e-6, -2e-6])
    assert not ref.velocity.any()
    assert not ref.acceleration.any()
    assert ref.holds == ((200, 1000),)
    assert ref.edges == ()


def test_rhombus_stops_at_corners_with_equal_time_per_edge():
    ref = reference(kind="polygon", vertices=RHOMBUS, frequency=1 / 3)
    assert ref.period == 6000
    assert ref.window == (6000, 18000)
    assert ref.edges == tuple((k, k + 1500) for k in range(0, 18000, 1500))
    corners = ref.position[::1500]
    assert np.array_equal(corners, np.array(RHOMBUS * 3))
    assert not ref.velocity[::1500].any()
    assert not ref.acceleration[::1500].any()
    assert ref.end == pytest.approx(RHOMBUS[0], abs=1e-16)
    assert np.ptp(ref.position, axis=0) == pytest.approx([0.06, 0.06])


def test_pentagram_has_the_papers_chord():
    ref = reference(kind="star", circumradius=0.03, frequency=1 / 3)
    corners = ref.position[: ref.period : 1200]
    chords = np.hypot(*(np.roll(corners, -1, axis=0) - corners).T)
    assert ref.period == 6000
    assert np.allclose(chords, 57.06e-3, atol=5e-6)
    assert np.allclose(corners[0], [0, 0.03], atol=1e-17)
    assert len(np.unique(corners.round(9), axis=0)) == 5


@given(st.floats(0.05, 90.0), st.integers(1, 4))
def test_time_of_a_polygon_does_not_drift(frequency, laps):
    ref = reference(kind="polygon", vertices=RHOMBUS, frequency=frequency, laps=laps)
    edge = max(1, round(1 / (4 * frequency) / T_s))
    assert ref.ticks == 4 * edge * laps
    assert np.array_equal(ref.position[:: 4 * edge], np.array([RHOMBUS[0]] * laps))


def test_trapezoid_there_and_back_with_dwells():
    ref = reference(
        kind="trapezoid", start={"y": -0.145}, end={"y": 0.145}, v_max=0.15, a_max=1.6, dwell=1.0
    )
    move = 188 + 3679 + 188
    assert ref.ticks == 3 * 2000 + 2 * move
    assert ref.moving == ("y",)
    assert ref.holds == ((2000 + move, 4000 + move), (4000 + 2 * move, 6000 + 2 * move))
    assert ref.edges == ((2000, 2000 + move), (4000 + move, 4000 + 2 * move))
    assert ref.position[:, 1].min() == -0.145
    assert ref.position[:, 1].max() == 0.145
    assert 0.1499 < np.abs(ref.velocity).max() <= 0.15
    assert 1.59 < np.abs(ref.acceleration).max() <= 1.6
    assert ref.window == (0, ref.ticks)


def test_trapezoid_cycles_and_one_way():
    once = reference(kind="trapezoid", end={"x": 0.05}, there_and_back=False)
    thrice = reference(kind="trapezoid", end={"x": 0.05}, cycles=3)
    assert len(once.holds) == 1
    assert once.end == (0.05, 0.0)
    assert len(thrice.holds) == 6
    assert thrice.end == (0.0, 0.0)


def test_staircase_of_true_steps():
    ref = reference(kind="staircase", step={"x": 5e-7}, count=3, dwell=0.5)
    levels = np.array([0, 1, 2, 3, 2, 1, 0]) * 5e-7
    assert np.allclose(ref.position[::1000, 0], levels, rtol=1e-12)
    assert ref.ticks == 7000
    assert ref.holds == tuple((k, k + 1000) for k in range(1000, 7000, 1000))
    assert not ref.velocity.any()


def test_staircase_of_moves():
    ref = reference(
        kind="staircase",
        start={"y": -0.125},
        step={"y": 0.05},
        dwell=0.5,
        v_max=0.14,
        a_max=1.2,
    )
    assert len(ref.edges) == len(ref.holds) == 10
    levels = [ref.position[start, 1] for start, _ in ref.holds]
    up = [-0.075, -0.025, 0.025, 0.075, 0.125]
    assert np.allclose(levels, up + up[-2::-1] + [-0.125], atol=1e-15)
    assert np.abs(ref.velocity).max() <= 0.14
    assert np.abs(ref.acceleration).max() <= 1.2
    assert_integrates(ref)


def test_line_and_waypoints_with_explicit_edge_time():
    line = reference(kind="line", end={"x": 0.05, "y": 0.02}, edge_time=1.0, dwell=0.25)
    assert line.edges == ((500, 2500),)
    assert line.holds == ((2500, 3000),)
    assert line.end == pytest.approx((0.05, 0.02))
    route = reference(kind="waypoints", points=RHOMBUS, edge_time=0.2, dwell=0.0)
    assert route.edges == ((0, 400), (400, 800), (800, 1200))
    assert route.holds == ()
    assert np.array_equal(route.position[::400], np.array(RHOMBUS[:3]))


def test_point_and_dwell_stand_still():
    ref = reference(kind="point", position={"x": 0.01, "y": -0.02}, duration=0.5)
    assert ref.ticks == 1000
    assert np.array_equal(ref.position, np.tile([0.01, -0.02], (1000, 1)))
    assert ref.moving == ref.holds == ref.edges == ()
    assert reference(kind="dwell", duration=0.5).end == (0.0, 0.0)


def test_the_shortest_duration_is_one_tick():
    assert reference(kind="dwell", duration=1e-9).ticks == 1


def test_sequence_starts_each_part_where_the_one_before_ended():
    line = {"kind": "line", "edge_time": 0.5, "dwell": 0.1}
    ref = reference(
        kind="sequence",
        parts=[
            line | {"start": {"x": 0.01}, "end": {"x": 0.03}},
            {"kind": "dwell", "duration": 0.2},
            line | {"start": {"x": 0.07}, "end": {"x": 0.07, "y": 0.04}},
            {"kind": "step", "height": {"y": 1e-6}, "delay": 0.1, "dwell": 0.1},
        ],
    )
    assert ref.ticks == 1400 + 400 + 1400 + 400
    assert ref.end == pytest.approx((0.03, 0.04 + 1e-6), abs=1e-15)
    # Dwells that follow one another at the same place are one.
    assert ref.holds == ((1200, 2000), (3000, 3400), (3400, 3600))
    assert ref.window == (0, ref.ticks)
    assert np.abs(np.diff(ref.position, axis=0)).max() < 1e-4


def test_samples_are_read_only():
    ref = reference(kind="point")
    for samples in (ref.position, ref.velocity, ref.acceleration):
        with pytest.raises(ValueError, match="read-only"):
            samples[0, 0] = 1.0


@given(motions)
def test_the_same_config_gives_the_same_bits(table):
    one, two = reference(**table), reference(**table)
    assert one.position.tobytes() == two.position.tobytes()
    assert one.acceleration.tobytes() == two.acceleration.tobytes()


@pytest.mark.parametrize(
    "table",
    [
        {"kind": "circle", "radius": 0.01, "frequency": 0.01, "laps": 36},
        {"kind": "polygon", "vertices": RHOMBUS, "frequency": 1e-4, "laps": 1000},
        {"kind": "line", "end": {"x": 0.1}, "v_max": 1e-6, "a_max": 1e-6},
        {"kind": "sequence", "parts": [{"kind": "point", "duration": 3600.0}, {"kind": "dwell"}]},
    ],
    ids=lambda table: table["kind"],
)
def test_more_than_an_hour_is_refused(table):
    with pytest.raises(ConfigError, match=r"trajectory: lasts too long; .* <= 3600 s"):
        reference(**table)


def test_a_minute_less_than_an_hour_is_planned():
    assert reference(kind="point", duration=60.0).ticks == 120_000


# -- once, n times, for ever -----------------------------------------------------------------------


@pytest.mark.parametrize(
    "table",
    [
        {"kind": "circle", "radius": 0.015, "frequency": 1.0, "direction": "cw"},
        {"kind": "sine", "amplitude": {"x": 0.01}, "frequency": 0.7, "cycles": 3},
    ],
)
def test_what_is_not_for_ever_eases_to_rest_after_its_laps(table) -> None:
    endless, ending = reference(**table), reference(**table, for_ever=False)
    whole = endless.ticks
    assert np.array_equal(ending.position[:whole], endless.position)
    assert ending.window == endless.window
    assert np.abs(ending.velocity[-1]).max() < 1e-3 * np.abs(ending.velocity).max()
    assert_integrates(ending)
    lead = ending.ticks - whole
    assert lead == round(0.5 / table["frequency"] / T_s)


def there_and_back(**more):
    points = [[0.0, 0.0], [0.01, 0.0], [0.01, 0.01], [0.0, 0.0]]
    return {"kind": "waypoints", "points": points, "edge_time": 0.1, "dwell": 0.05} | more


@pytest.mark.parametrize(
    "table",
    [
        there_and_back(),
        {"kind": "staircase", "step": {"x": 0.001}, "count": 2, "dwell": 0.1},
        {"kind": "sequence", "parts": [there_and_back(), {"kind": "dwell", "duration": 0.2}]},
    ],
)
def test_laps_repeat_sample_for_sample_and_leave_the_first_out(table) -> None:
    once, thrice = reference(**table), reference(**table, laps=3)
    lap = thrice.period
    assert thrice.ticks == once.ticks + 2 * lap
    assert np.array_equal(thrice.position[: once.ticks], once.position)
    assert np.array_equal(thrice.position[once.ticks - lap : once.ticks], thrice.position[-lap:])
    assert thrice.window == (thrice.ticks - 2 * lap, thrice.ticks)
    assert once.period == 0


def test_the_dwell_of_a_polygon_is_at_each_corner() -> None:
    table = {"kind": "polygon", "vertices": RHOMBUS, "frequency": 0.5, "laps": 2}
    without, dwelling = reference(**table), reference(**table, dwell=0.2)
    assert dwelling.period == without.period + 4 * 400
    assert dwelling.ticks == 400 + 2 * dwelling.period
    assert np.abs(np.diff(dwelling.holds, axis=1)).tolist() == [[400]] * 8


def test_laps_need_an_end_where_the_motion_starts() -> None:
    parts = [{"kind": "line", "end": {"x": 0.01}, "edge_time": 0.1}]
    with pytest.raises(ConfigError, match="ends elsewhere"):
        reference(kind="sequence", parts=parts, laps=2)
    with pytest.raises(ValidationError, match="last point equal to the first"):
        reference(**there_and_back(points=[[0.0, 0.0], [0.01, 0.0]], laps=2))
    endless = {"kind": "circle", "radius": 0.01, "frequency": 1.0, "for_ever": False}
    with pytest.raises(ValidationError, match="not to its parts"):
        reference(kind="sequence", parts=[endless])
    with pytest.raises(ConfigError, match="lasts too long"):
        reference(**there_and_back(laps=1000, dwell=5.0))
