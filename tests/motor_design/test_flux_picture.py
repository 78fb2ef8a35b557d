"""Contours of triangles, and triangles sampled on a grid."""

from __future__ import annotations

import numpy as np
import pytest
from skfem import MeshTri

from motionlab.motor_design.fem.contour import Triangles, contour, thinned
from motionlab.motor_design.fem.picture import FieldRequest, picture, sampled


def mesh(count: int = 32) -> MeshTri:
    ends = np.linspace(-1, 1, count + 1)
    return MeshTri.init_tensor(ends, ends)


def triangles(of: MeshTri, values: np.ndarray) -> Triangles:
    return Triangles(of.p[:, of.t], of.t, values[of.t])


def test_a_circle_is_one_closed_line_on_its_radius() -> None:
    m = mesh()
    (line,) = contour(triangles(m, m.p[0] ** 2 + m.p[1] ** 2), 0.25, tolerance=0.0)
    assert np.array_equal(line[0], line[-1])
    assert np.hypot(*line.T) == pytest.approx(0.5, abs=2e-3)
    steps = np.hypot(*np.diff(line, axis=0).T)
    assert steps.max() < 2 / 32 * 1.5
    assert steps.sum() == pytest.approx(np.pi, rel=0.01)


def test_lines_that_leave_the_mesh_are_open_and_apart() -> None:
    m = mesh()
    lines = contour(triangles(m, np.abs(m.p[0])), 0.51, tolerance=1e-9)
    assert sorted(round(float(line[0, 0]), 2) for line in lines) == [-0.51, 0.51]
    for line in lines:
        assert len(line) == 2  # straight: nothing on the way is kept
        assert sorted(line[:, 1]) == [-1, 1]


def test_a_line_ends_where_neighbours_lie_apart() -> None:
    m = mesh(8)
    moved = m.p[:, m.t].copy()
    moved[0, :, moved[0].mean(axis=0) > 0] += 5.0
    values = m.p[1][m.t]
    lines = contour(Triangles(moved, m.t, values), 0.1, tolerance=0.0)
    assert len(lines) == 2
    assert max(np.ptp(line[:, 0]) for line in lines) == pytest.approx(1.0)


def test_thinning_keeps_within_its_tolerance() -> None:
    angle = np.linspace(0, np.pi, 400)
    arc = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    kept = thinned(arc, 1e-3)
    assert 10 < len(kept) < 80
    middles = (kept[1:] + kept[:-1]) / 2
    assert 1 - np.hypot(*middles.T) == pytest.approx(0, abs=1e-3)


def test_a_grid_takes_the_triangle_at_each_point() -> None:
    m = mesh(10)
    middle = m.p[:, m.t].mean(axis=1)
    x = y = np.linspace(-0.97, 0.97, 41)
    for axis, expected in ((0, np.broadcast_to(x, (41, 41))), (1, np.broadcast_to(y, (41, 41)).T)):
        found = sampled(m.p[:, m.t], middle[axis], x, y)
        assert np.max(np.abs(found - expected)) <= 2 / 10 * 2 / 3 + 1e-9


def test_flux_is_kept_between_neighbouring_lines() -> None:
    found = picture(FieldRequest(position=0.0, current=2.0, lines=9, columns=64))
    # aligned: the picture is its own mirror image
    density = np.array(found.flux_density)
    assert density == pytest.approx(density[:, ::-1], abs=2e-3)
    assert found.thrust == pytest.approx(0, abs=0.02)
    # all lines of the core pass through the yoke, x = 0, with even spacing of flux
    crossings = [line for line in found.lines if max(y for _, y in line.points) > 28e-3]
    assert len(crossings) >= 7


def test_without_current_there_is_no_line() -> None:
    found = picture(FieldRequest(current=0.0, columns=32))
    assert found.lines == []
    assert found.flux_density_max == 0
