"""The distance to the path: exact on lines, round corners, never on another branch."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionlab.analysis.contouring import REACH, contour_error


def distance(path, measured, window=None):
    """Return the contouring error of measured positions, shape (n, 2)."""
    path = np.asarray(path, dtype=float)
    window = window or (0, len(path))
    return contour_error(path, window, path[slice(*window)] - np.asarray(measured, dtype=float))


def to_polyline(path, point):
    """Return the distance from a point to a whole polyline, one segment at a time."""
    best = min(math.dist(point, corner) for corner in path)
    for a, b in itertools.pairwise(path):
        along = b - a
        length = math.hypot(*along)
        if length > 1e-9:
            share = min(max(np.dot(point - a, along) / length**2, 0.0), 1.0)
            best = min(best, math.dist(point, a + share * along))
    return best


def edges(corners, per_edge):
    """Return points that go from corner to corner at constant speed."""
    share = np.linspace(0, 1, per_edge, endpoint=False)[:, None]
    parts = [a + share * (b - a) for a, b in itertools.pairwise(corners)]
    return np.concatenate([*parts, corners[-1:]])


def test_lag_along_a_line_is_no_contouring_error():
    line = np.linspace([0.0, 0.0], [0.03, 0.04], 200)
    lagging = line - 0.9 * (line[7] - line[0])
    assert distance(line, lagging)[10:] == pytest.approx(0.0, abs=1e-15)


def test_offset_across_a_line():
    line = np.linspace([0.0, 0.0], [0.03, 0.04], 200)
    across = np.array([-0.8, 0.6]) * 5e-6
    lag = 3.3 * (line[1] - line[0])
    assert distance(line, line - lag + across)[10:] == pytest.approx(5e-6, rel=1e-12)


def test_beyond_the_ends_the_end_is_nearest():
    line = np.linspace([0.0, 0.0], [1e-3, 0.0], 11)
    ahead = line + np.array([3e-3, 4e-3])
    assert distance(line, ahead)[-1] == pytest.approx(5e-3)


def test_circle_of_smaller_radius_with_lag():
    angle = np.linspace(0, 2 * np.pi, 6001)
    circle = 0.015 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    late = angle - 2.7 * angle[1]
    measured = 0.014_99 * np.stack([np.cos(late), np.sin(late)], axis=1)
    sagitta = 0.015 * (1 - math.cos(angle[1] / 2))
    assert distance(circle, measured)[10:] == pytest.approx(1e-5, abs=1.01 * sagitta)


def test_a_window_of_a_longer_path_sees_what_lies_before_it():
    line = np.linspace([0.0, 0.0], [1e-2, 0.0], 101)
    lagging = line[50:60] - [7e-4, 0.0]
    assert distance(line, lagging, (50, 60)) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("hold", [0, 1000])
def test_lag_round_a_sharp_corner(hold):
    """A pentagram's corner: the reference is on the next edge already, perhaps after a rest."""
    tip, half = np.zeros(2), math.radians(18)
    arrive = 1e-3 * np.array([math.sin(half), math.cos(half)])
    leave = 1e-3 * np.array([-math.sin(half), math.cos(half)])
    path = edges(np.stack([arrive, tip, leave]), 100)
    path = np.concatenate([path[:100], np.repeat(path[100:101], hold, axis=0), path[100:]])
    now = len(path) - 101 + 30
    on_first_edge = path[100 - 30]
    assert distance(path, on_first_edge[None], (now, now + 1)) == pytest.approx(0.0, abs=1e-15)


def test_another_branch_is_not_the_path_being_followed():
    """A mover driven off its branch onto a crossing one is off its path all the same."""
    corners = np.array([[-1, 0], [1, 0], [1, 1], [0, 1], [0, -1]]) * 0.01
    path = edges(corners, 1000)  # crosses itself at the origin, 30 mm later
    now = 1000 - 500 + 2  # 40 um past the crossing, on the way along x
    assert path[now] == pytest.approx([4e-5, 0.0])
    on_other_branch = np.array([[0.0, 3e-5]])
    assert to_polyline(path, on_other_branch[0]) == pytest.approx(0.0, abs=1e-12)
    assert distance(path, on_other_branch, (now, now + 1)) == pytest.approx(3e-5)


def test_nanometres_far_from_the_origin():
    line = np.linspace([0.08, 0.140], [0.08, 0.145], 500)
    error = np.zeros_like(line, dtype=np.float32)
    error[:, 0] = 1e-9
    found = contour_error(line, (0, 500), error.astype(float))
    assert found == pytest.approx(1e-9, rel=1e-6)


def test_standstill_and_vanishing_moves():
    away = np.array([3.0, 4.0])
    still = np.zeros((5, 2))
    assert distance(still, still + away) == pytest.approx(5.0)
    tiny = np.cumsum(np.full((5, 2), 1e-200), axis=0)
    assert distance(tiny, tiny + away) == pytest.approx(5.0)


coordinate = st.integers(-20, 20).map(lambda n: n * 1e-4)
points = st.lists(st.tuples(coordinate, coordinate), min_size=2, max_size=12)


@given(points, st.data())
def test_between_the_nearest_point_of_all_and_the_following_error(corners, data):
    path = np.array(corners)
    shape = st.lists(
        st.tuples(coordinate, coordinate), min_size=len(corners), max_size=len(corners)
    )
    measured = np.array(data.draw(shape))
    error = np.hypot(*(path - measured).T)
    found = distance(path, measured)
    nearest = np.array([to_polyline(path, point) for point in measured])
    assert np.all(found <= error * (1 + 1e-12))
    assert np.all(found >= nearest - 1e-12)
    length = np.hypot(*np.diff(path, axis=0).T).sum()
    within = REACH * error > length  # the whole path lies within reach
    assert found[within] == pytest.approx(nearest[within], abs=1e-12)
