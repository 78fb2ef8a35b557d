"""Splines that turn back on the spot."""

from __future__ import annotations

from typing import Any

import pytest

import motionlab
from motionlab.config.drawn_path import DrawnPath
from motionlab.errors import Infeasible
from motionlab.trajectories.cusps import cusp_note, cusps
from tests.trajectories.random_splines import random_splines

SPLINE = {"kind": "path", "geometry": "spline", "law": "jerk_limited"}
LIMITS = {"v_max": 0.08, "a_max": 0.8, "j_max": 20.0}


def retraced(points: list[tuple[float, float]], **fields: Any) -> dict[str, Any]:
    return SPLINE | LIMITS | {"points": points} | fields


@pytest.mark.parametrize(
    ("points", "place", "corner"),
    [
        ([(0.0, 0.0), (0.02, 0.0), (0.0, 0.0)], "x = 0.02 m, y = 0 m, s = 0.02 m", 1),
        (
            [(0.0, 0.0), (0.01, 0.01), (0.02, 0.0), (0.01, 0.01), (0.0, 0.0)],
            "x = 0.02 m, y = 0 m, s = 0.0296528 m",
            2,
        ),
    ],
)
def test_a_cusp_is_refused_with_the_corner_that_it_needs(
    points: list[tuple[float, float]], place: str, corner: int
) -> None:
    path = retraced(points, v_max=0.04)
    (note,) = motionlab.trajectory(path).check.notes
    assert note == (
        f"the spline turns back on the spot at {place} along the path: add a corner there, "
        f"corners = [{corner}] (points count from 0)"
    )
    with pytest.raises(Infeasible) as refused:
        motionlab.run("circle", set={"trajectory": path})
    assert str(refused.value).endswith(f"; {note}")
    mended = motionlab.trajectory(path | {"corners": [corner]}).check
    assert mended.feasible
    assert mended.notes == []


def test_a_cusp_between_points_needs_a_point_too() -> None:
    path = retraced([(0.0, 0.0), (0.03, 0.0), (0.02, 0.0), (0.05, 0.0), (0.05, 0.03)], corners=[3])
    cusp, _ = cusps(DrawnPath.model_validate(path))
    note = cusp_note(DrawnPath.model_validate(path))
    assert "add a point between points 0 and 1 and a corner there, corners = [1, 4]" in note
    points = [path["points"][0], cusp.place, *path["points"][1:]]
    corrected = DrawnPath.model_validate(path | {"points": points, "corners": [1, 4]})
    assert all(each.way > cusp.way + 1e-4 for each in cusps(corrected))


def test_a_part_of_a_sequence_is_named() -> None:
    path = retraced([(0.0, 0.0), (0.02, 0.0), (0.0, 0.0)])
    parts = [{"kind": "dwell", "duration": 0.1}, path]
    (note,) = motionlab.trajectory({"kind": "sequence", "parts": parts}).check.notes
    assert note.startswith("parts.1: the spline turns back on the spot at x = 0.02 m")


def test_other_bends_are_no_cusps() -> None:
    for path in random_splines(seed=5, count=20):
        table = {"kind": "path", "law": "jerk_limited"} | path
        assert cusps(DrawnPath.model_validate(table)) == []
    corners = DrawnPath.model_validate(retraced([(0.0, 0.0), (0.02, 0.0), (0.0, 0.0)], corners=[1]))
    assert cusps(corners) == []
