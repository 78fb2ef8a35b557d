"""Drawn paths: limits respected, rest at stops, continuity, closed ones close."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from motionlab.config.trajectory import TrajectoryConfig
from motionlab.timing import CONTROL_PERIOD as T_s
from motionlab.trajectories.motion_profile import jerk_limited, jerk_limited_ticks
from motionlab.trajectories.reference import sample
from motionlab.trajectories.spline import cubics, outline, polyline, spline

ADAPTER = TypeAdapter(TrajectoryConfig)
RHOMBUS = [[0.03, 0.0], [0.0, 0.03], [-0.03, 0.0], [0.0, -0.03]]
STOPPING = ("minimum_jerk", "trapezoid", "jerk_limited")
NEAR = 1e-12
"""Rounding of a position, m."""


def config(**table):
    table = {"kind": "path", "v_max": 0.1, "a_max": 1.0} | table
    if table.get("law") == "jerk_limited" and "lap_time" not in table:
        table = {"j_max": 20.0} | table
    if "lap_time" in table:
        table = {k: v for k, v in table.items() if k not in {"v_max", "a_max", "j_max"}}
    return ADAPTER.validate_python(table)


def reference(**table):
    return sample(config(**table))


coordinate = st.integers(-80, 80).map(lambda mm: mm / 1000)


@st.composite
def points(draw, least=3, most=8):
    """Points of which no two neighbours are the same, and no three turn back on a line."""
    found = [draw(st.tuples(coordinate, coordinate))]
    for _ in range(draw(st.integers(least, most)) - 1):
        angle = draw(st.floats(0.0, 2 * math.pi))
        length = draw(st.floats(0.002, 0.05))
        x, y = found[-1]
        found.append((x + length * math.cos(angle), y + length * math.sin(angle)))
    if math.dist(found[0], found[-1]) < 1e-3:
        found[-1] = (found[-1][0] + 0.01, found[-1][1])
    return found


def speed(ref):
    return np.hypot(*ref.velocity.T)


@settings(max_examples=40)
@given(
    points(),
    st.sampled_from(STOPPING),
    st.sampled_from(["polyline", "spline"]),
    st.booleans(),
    st.floats(0.01, 0.3),
    st.floats(0.05, 5.0),
    st.floats(0.5, 100.0),
)
def test_limits_along_the_path_are_respected(visited, law, geometry, closed, v_max, a_max, j_max):
    extra = {"j_max": j_max} if law == "jerk_limited" else {}
    ref = reference(
        points=visited,
        law=law,
        geometry=geometry,
        closed=closed,
        v_max=v_max,
        a_max=a_max,
        **extra,
    )
    v = speed(ref)
    assert v.max() <= v_max * (1 + 1e-9)
    along = np.diff(v, prepend=0.0) / T_s
    assert np.abs(along).max() <= a_max * (1 + 1e-6) + 1e-9
    if law == "jerk_limited":
        jerk = np.diff(along) / T_s
        assert np.abs(jerk).max() <= j_max * (1 + 1e-6) + 1e-6


@settings(max_examples=25)
@given(points(), st.sampled_from(STOPPING), st.booleans(), st.sampled_from([0.0, 0.01]))
def test_a_polyline_rests_at_each_of_its_points(visited, law, closed, dwell):
    ref = reference(points=visited, law=law, closed=closed, dwell=dwell)
    stops = [*visited, visited[0]] if closed else visited
    begins = [start for start, _ in ref.edges]
    assert len(begins) == len(stops) - 1
    for tick, stop in zip(begins, stops, strict=False):
        assert ref.position[tick] == pytest.approx(stop, abs=NEAR)
        assert speed(ref)[tick] == pytest.approx(0.0, abs=1e-12)
    assert ref.end == pytest.approx(stops[-1], abs=NEAR)
    assert len(ref.holds) == (len(stops) - 1 if dwell else 0)
    for start, stop in ref.holds:
        assert stop - start == round(dwell / T_s)
        assert not ref.velocity[start:stop].any()


@settings(max_examples=25)
@given(points(), st.sampled_from(STOPPING), st.sampled_from(["polyline", "spline"]), st.booleans())
def test_position_and_velocity_are_continuous(visited, law, geometry, closed):
    ref = reference(points=visited, law=law, geometry=geometry, closed=closed)
    ways = np.diff(ref.position, axis=0)
    # Each increment is explained by the velocities at its ends, but for the curvature in between.
    steps = np.hypot(*ways.T)
    top = np.maximum(speed(ref)[1:], speed(ref)[:-1]) * T_s
    assert (steps <= top * 1.05 + 1e-9).all()


@settings(max_examples=25)
@given(points(), st.sampled_from(["polyline", "spline"]), st.integers(2, 4))
def test_closed_laps_repeat_sample_for_sample(visited, geometry, laps):
    ref = reference(points=visited, geometry=geometry, closed=True, laps=laps)
    assert ref.ticks == laps * ref.period
    lap = ref.position[: ref.period]
    for k in range(1, laps):
        assert np.array_equal(ref.position[k * ref.period : (k + 1) * ref.period], lap)
    assert ref.end == pytest.approx(visited[0], abs=NEAR)
    assert ref.window == (ref.period, ref.ticks)


def test_metrics_of_one_lap_leave_out_the_dwell_before_it():
    ref = reference(points=RHOMBUS, closed=True, dwell=0.5)
    assert ref.window == (1000, ref.ticks)


@settings(max_examples=25)
@given(points(least=4), st.booleans())
def test_a_spline_at_constant_speed_has_it_within_a_thousandth(visited, closed):
    ref = reference(
        points=visited,
        geometry="spline",
        law="constant_speed",
        closed=closed,
        v_max=0.05,
        a_max=2.0,
    )
    ramp = next(stop - start for start, stop in ref.edges)
    cruise = slice(ramp, ref.ticks - ramp)
    rate = speed(ref).max()
    assert rate <= 0.05 * (1 + 1e-9)
    assert np.abs(speed(ref)[cruise] / rate - 1).max() < 1e-9
    # The positions themselves: a chord is shorter than its arc by the square of the turn, over 24.
    chords = np.hypot(*np.diff(ref.position[cruise], axis=0).T) / T_s
    ahead = ref.velocity[cruise] / rate
    turn = np.hypot(*np.diff(ahead, axis=0).T)
    gentle = turn < 0.1
    assert gentle.mean() > 0.9
    assert np.abs(chords[gentle] / rate - 1).max() < 1e-3


@settings(max_examples=25)
@given(points(least=4))
def test_laps_at_constant_speed_repeat_within_the_window(visited):
    ref = reference(
        points=visited, geometry="spline", law="constant_speed", closed=True, laps=3, lap_time=1.0
    )
    start, stop = ref.window
    assert (stop - start) % 2000 == 0
    assert stop - start == 4000
    assert np.array_equal(ref.position[start : start + 2000], ref.position[start + 2000 : stop])
    assert not ref.velocity[0].any()
    assert ref.end == pytest.approx(visited[0], abs=NEAR)


@settings(max_examples=25)
@given(points(), st.booleans())
def test_curves_go_through_their_points_with_unit_tangents(visited, closed):
    for build in (polyline, spline):
        curve = build(visited, closed=closed)
        corners = [*visited, visited[0]] if closed else visited
        place, tangent, _ = curve.path(curve.marks)
        assert place == pytest.approx(np.array(corners), abs=1e-9)
        assert np.hypot(*tangent.T) == pytest.approx(1.0, abs=1e-6)


def test_the_spline_through_a_circle_is_one_within_a_thousandth():
    angles = np.arange(12) * 2 * math.pi / 12
    ring = [(0.03 * math.cos(a), 0.03 * math.sin(a)) for a in angles]
    curve = spline(ring, closed=True)
    place, _, bend = curve.path(np.linspace(0, curve.length, 1001))
    assert np.hypot(*place.T) == pytest.approx(0.03, rel=1e-3)
    assert np.hypot(*bend.T) == pytest.approx(1 / 0.03, rel=0.03)
    assert curve.length == pytest.approx(2 * math.pi * 0.03, rel=1e-3)


def test_curvature_of_a_spline_is_continuous_at_its_points():
    for closed in (False, True):
        curve = spline([(0.0, 0.0), (0.01, 0.02), (0.04, 0.01), (0.02, -0.03)], closed=closed)
        inner = curve.marks[1:-1]
        before, after = curve.path(inner - 1e-9), curve.path(inner + 1e-9)
        assert before[1] == pytest.approx(after[1], abs=1e-6)
        assert before[2] == pytest.approx(after[2], rel=1e-4, abs=1e-3)


def test_a_place_on_a_spline_does_not_depend_on_the_places_asked_for_with_it():
    bent = [(0.0, 0.0), (0.01, 0.02), (0.04, 0.01), (0.02, -0.03)]
    curve = spline(bent, closed=True)
    q = np.linspace(0.0, curve.length, 500)
    order = np.random.default_rng(1).permutation(len(q))
    together = curve.path(q)
    mixed = curve.path(q[order])
    for whole, found in zip(together, mixed, strict=True):
        assert np.array_equal(whole[order], found)
    for k in (0, 7, 250, 499):
        for whole, found in zip(together, curve.path(q[k : k + 1]), strict=True):
            assert np.array_equal(whole[k], found[0])


def test_a_spline_that_turns_on_the_spot_stays_finite():
    ref = reference(points=[[0.0, 0.0], [0.02, 0.0], [0.0, 0.0]], geometry="spline")
    for samples in (ref.position, ref.velocity, ref.acceleration):
        assert np.isfinite(samples).all()


@pytest.mark.parametrize("law", STOPPING)
def test_a_lap_takes_the_time_it_is_given(law):
    ref = reference(points=RHOMBUS, closed=True, law=law, lap_time=3.0)
    assert ref.period == 6000
    assert [stop - start for start, stop in ref.edges] == [1500] * 4


def test_edges_share_the_lap_so_that_their_peak_accelerations_are_equal():
    ref = reference(points=[[0.0, 0.0], [0.01, 0.0], [0.01, 0.04]], lap_time=3.0)
    assert ref.ticks == 6000
    peaks = [np.abs(ref.acceleration[a:b]).max() for a, b in ref.edges]
    assert peaks[0] == pytest.approx(peaks[1], rel=2e-3)


@given(st.floats(1e-4, 0.3), st.floats(0.005, 1.0), st.floats(0.05, 10.0), st.floats(0.1, 1e3))
def test_the_jerk_limited_law_keeps_its_limits_and_goes_from_rest_to_rest(length, v, a, j):
    jerk, ramp, travel = jerk_limited_ticks(length, v_max=v, a_max=a, j_max=j)
    assert jerk <= ramp
    assert travel >= ramp + jerk
    total = jerk + ramp + travel
    u = np.arange(total + 1, dtype=np.float64)
    s, rate, second = jerk_limited(u, jerk, ramp, travel)
    assert (s[0], s[-1]) == pytest.approx((0.0, 1.0), abs=1e-12)
    assert (rate[0], rate[-1]) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert length * rate.max() / T_s <= v * (1 + 1e-9)
    assert length * np.abs(second).max() / T_s**2 <= a * (1 + 1e-9)
    assert length * np.abs(np.diff(second)).max() / T_s**3 <= j * (1 + 1e-6)
    assert np.diff(s).min() >= -1e-12


def test_a_long_jerk_limited_move_reaches_all_its_limits():
    jerk, ramp, travel = jerk_limited_ticks(0.2, v_max=0.1, a_max=1.0, j_max=20.0)
    assert (jerk, ramp, travel) == (100, 200, 4000)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"points": [[0, 0]]}, "at least 2 items"),
        ({"points": [[0, 0], [0.01, 0]], "closed": True}, "three points"),
        ({"points": [[0, 0], [0, 0]]}, "point 0 is repeated"),
        ({"points": [[0, 0], [0.01, 0], [0, 0]], "closed": True}, "point 2 is repeated"),
        ({"laps": 2}, "closed path"),
        ({"v_max": None}, "either lap_time"),
        ({"lap_time": 1.0}, "either lap_time"),
        ({"law": "jerk_limited"}, "either lap_time, or v_max, a_max and j_max"),
        ({"j_max": 5.0}, "jerk_limited"),
        ({"law": "sine"}, "minimum_jerk"),
        ({"geometry": "bezier"}, "polyline"),
        ({"points": [[0, 0], [2.0, 0]]}, "less than or equal to 1"),
        ({"points": [[float("nan"), 0], [0, 0]]}, "finite|greater"),
        ({"points": [[i / 9000, 0] for i in range(6001)]}, "at most 6000 items"),
        ({"corners": [1]}, "spline"),
        ({"geometry": "spline", "corners": [1, 0]}, "rising order"),
        ({"geometry": "spline", "corners": [1, 1]}, "rising order"),
        ({"geometry": "spline", "corners": [2]}, "counted from 0 to 1"),
        ({"geometry": "spline", "corners": [-1]}, "greater than or equal to 0"),
    ],
)
def test_refusals_say_why(change, message):
    table = {"kind": "path", "points": [[0, 0], [0.01, 0.0]], "v_max": 0.1, "a_max": 1.0}
    with pytest.raises(ValidationError, match=message):
        ADAPTER.validate_python(table | change)


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("count", [3, 12, 700])
def test_an_outline_lies_on_the_spline_and_names_its_edges(count, closed):
    angles = np.arange(count) * 5.5 / count
    corners = list(zip(0.05 * np.cos(angles), 0.03 * np.sin(2 * angles), strict=True))
    places, edges = outline(corners, closed=closed)
    curve = spline(corners, closed=closed)
    fine, _, _ = curve.path(np.linspace(0.0, curve.length, 20_001))
    away = [np.hypot(*(fine - place).T).min() for place in places]
    assert max(away) < 0.51 * curve.length / 20_000
    begins = np.flatnonzero(np.diff(edges, prepend=-1))
    assert edges[begins] == pytest.approx(np.arange(count if closed else count - 1))
    assert places[begins] == pytest.approx(np.array(corners)[: len(begins)], abs=1e-15)
    assert places[-1] == pytest.approx(corners[0 if closed else -1])


HALF_MOON = [(math.cos(a) * 0.02, math.sin(a) * 0.02) for a in np.linspace(0, math.pi, 9)]


def test_a_spline_stops_at_its_corners_and_is_straight_between_two() -> None:
    ref = reference(points=HALF_MOON, geometry="spline", closed=True, corners=[0, 8], dwell=0.01)
    stops = [HALF_MOON[0], HALF_MOON[8], HALF_MOON[0]]
    begins = [start for start, _ in ref.edges] + [ref.ticks - 1]
    assert len(begins) == 3
    for tick, stop in zip(begins, stops, strict=True):
        assert ref.position[tick] == pytest.approx(stop, abs=NEAR)
    back = ref.position[begins[1] : begins[2]]
    assert np.abs(back[:, 1]).max() < NEAR
    assert len(ref.holds) == 2


def test_the_speed_along_a_spline_is_right_beside_a_corner_of_unequal_edges() -> None:
    corners = [(0.0, 0.0), (1e-4, 0.0), (1e-4, 0.05), (0.03, 0.03), (0.031, 0.03)]
    curve = spline(corners, closed=False, corners=[1, 2, 3])
    arc_lengths = np.linspace(0.0, curve.length, 20_001)
    place, tangent, _ = curve.path(arc_lengths)
    inside = np.abs(arc_lengths[:-1, None] - curve.marks).min(axis=1) > curve.length / 10_000
    steps = np.hypot(*np.diff(place, axis=0).T)[inside]
    assert steps == pytest.approx(curve.length / 20_000, rel=1e-3)
    assert np.hypot(*tangent.T) == pytest.approx(1.0)


def test_a_spline_with_corners_is_the_splines_between_them() -> None:
    whole = spline(HALF_MOON, closed=False, corners=[3, 6])
    parts = [spline(HALF_MOON[a : b + 1], closed=False) for a, b in ((0, 3), (3, 6), (6, 8))]
    assert whole.length == pytest.approx(sum(part.length for part in parts), rel=1e-9)
    for part, start in zip(parts, whole.marks[[0, 3, 6]], strict=True):
        q = np.linspace(0.0, part.length * (1 - 1e-9), 50)
        assert whole.path(start + q)[0] == pytest.approx(part.path(q)[0], abs=1e-9)


@pytest.mark.parametrize(("closed", "corners"), [(False, ()), (True, ()), (True, (0, 5))])
def test_bezier_curves_are_the_spline(closed: bool, corners: tuple[int, ...]) -> None:
    curve = spline(HALF_MOON, closed=closed, corners=corners)
    fine, _, _ = curve.path(np.linspace(0.0, curve.length * (1 - 1e-12), 20_001))
    t = np.linspace(0.0, 1.0, 5)[:, None]
    for a, b, c, d in cubics(HALF_MOON, closed=closed, corners=corners):
        places = (1 - t) ** 3 * a + 3 * t * (1 - t) ** 2 * b + 3 * t**2 * (1 - t) * c + t**3 * d
        for place in places:
            assert np.hypot(*(fine - place).T).min() < curve.length / 20_000
