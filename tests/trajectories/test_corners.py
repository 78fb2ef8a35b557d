"""Motions as drawn paths: the same corners, about the same time."""

from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.trajectories.corners import drawn
from motionlab.trajectories.reference import sample

ADAPTER: TypeAdapter[TrajectoryConfig] = TypeAdapter(TrajectoryConfig)
THERE: dict[str, Any] = {"start": {"x": 0.01, "y": 0.0}, "end": {"x": 0.01, "y": 0.03}}
TRIANGLE = [[0.03, 0.0], [0.0, 0.03], [-0.03, 0.0]]


def path_of(**table: Any) -> DrawnPath:
    path = drawn(ADAPTER.validate_python(table))
    assert path is not None
    return path


def closest(positions: np.ndarray, points: tuple[tuple[float, float], ...]) -> np.ndarray:
    """Return how near a motion comes to each point, m."""
    return np.array([np.hypot(*(positions - point).T).min() for point in points])


@pytest.mark.parametrize(
    "table",
    [
        {"kind": "polygon", "vertices": TRIANGLE, "frequency": 0.5, "laps": 2},
        {"kind": "star", "circumradius": 0.03, "frequency": 0.25, "laps": 2},
        {"kind": "line", "v_max": 0.1, "a_max": 1.0} | THERE,
        {"kind": "line", "edge_time": 0.7, "dwell": 0.1} | THERE,
        {"kind": "waypoints", "points": [*TRIANGLE, [0.0, 0.01]], "v_max": 0.1, "a_max": 1.0},
        {"kind": "trapezoid", "cycles": 2} | THERE,
        {"kind": "staircase", "step": {"x": 1e-3}, "v_max": 0.1, "a_max": 1.0},
    ],
    ids=lambda table: table["kind"],
)
def test_corners_and_time_stay(table: dict[str, Any]) -> None:
    figure = sample(ADAPTER.validate_python(table))
    path = path_of(**table)
    assert closest(figure.position, path.points).max() < 1e-8
    run = sample(path)
    assert run.ticks == pytest.approx(figure.ticks, rel=0.01)
    assert run.end == pytest.approx(figure.end, abs=1e-9)


@pytest.mark.parametrize("direction", ["ccw", "cw"])
def test_a_circle_becomes_a_spline_the_same_way_round(direction: str) -> None:
    table = {
        "kind": "circle",
        "radius": 0.02,
        "center": {"x": 0.01},
        "start_angle": 1.0,
        "frequency": 0.5,
        "direction": direction,
    }
    path = path_of(**table)
    figure, run = sample(ADAPTER.validate_python(table)), sample(path)
    radii = np.hypot(*(run.position - (0.01, 0.0)).T)
    assert np.abs(radii - 0.02).max() < 1e-5
    assert path.laps == 3
    turned = [each.position[0, 0] - each.position[1000, 0] for each in (figure, run)]
    assert np.sign(turned[0]) == np.sign(turned[1])


@pytest.mark.parametrize(
    "table",
    [
        {"kind": "sine", "amplitude": {"x": 0.01}, "frequency": 1.0},
        {"kind": "staircase", "step": {"x": 1e-6}},
        {
            "kind": "waypoints",
            "points": [[i * 1e-5, 0.0] for i in range(6001)],
            "v_max": 0.1,
            "a_max": 1.0,
        },
        {"kind": "circle", "radius": 0.01, "frequency": 1e-4},
        {"kind": "sequence", "parts": [{"kind": "dwell"}]},
    ],
    ids=["no corners", "true steps", "too many points", "too long a lap", "sequence"],
)
def test_some_motions_have_no_drawn_path(table: dict[str, Any]) -> None:
    assert drawn(ADAPTER.validate_python(table)) is None
