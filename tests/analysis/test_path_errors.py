"""Contour error beside tracking error: made paths with known offsets give them back."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.analysis import path_errors as numbers
from motionlab.analysis.metrics import variant_metrics
from motionlab.analysis.views.contouring import contouring
from motionlab.errors import ConfigError
from motionlab.simulation.recorded import of_recording
from tests.simulated import SHORT, play

Array = NDArray[np.float64]

PERIOD = 0.5e-3  # s


def errors_of(path: Array, measured: Array) -> numbers.PathErrors:
    tangent = numbers.tangents(np.gradient(path, axis=0))
    return numbers.path_errors(path, (0, len(path)), tangent, path - measured)


def line(count: int = 4001) -> Array:
    """Return a path of 50 mm that speeds up and slows down."""
    share = (1 - np.cos(np.linspace(0, np.pi, count))) / 2
    return share[:, None] * np.array([0.03, 0.04])


def test_a_lag_on_a_line_is_all_tracking_error() -> None:
    path, late = line(), 8
    measured = np.concatenate([np.repeat(path[:1], late, axis=0), path[:-late]])
    found = errors_of(path, measured)
    assert np.abs(found.contour).max() < 1e-15  # from the very first sample on
    assert found.along == pytest.approx(found.tracking, abs=1e-15)
    assert found.lag == pytest.approx(found.tracking, abs=1e-12)
    figures = numbers.figures_of(found, PERIOD)
    assert figures.across_max < 1e-15
    # Late by so many samples at any speed, but for the ends.
    assert figures.lag_time == pytest.approx(late * PERIOD, rel=1e-3)
    assert figures.lag_distance == pytest.approx(0.05 * late / len(path), rel=2e-3)


def test_an_offset_to_the_left_is_positive() -> None:
    path = line()
    found = errors_of(path, path + 5e-6 * np.array([-0.8, 0.6]))
    assert found.contour == pytest.approx(5e-6, rel=1e-9)
    assert found.across == pytest.approx(5e-6, rel=1e-9)
    assert found.along == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("sense", [1, -1])
def test_a_circle_of_larger_radius_with_lag(sense: int) -> None:
    """Outside is right of a counter-clockwise circle; the lag alone leaves its tangent."""
    R, dR, angle = 0.015, 1e-5, sense * np.linspace(0, 4 * np.pi, 12001)
    around = lambda phi: np.stack([np.cos(phi), np.sin(phi)], axis=1)  # noqa: E731
    late = 3e-3  # rad
    found = errors_of(R * around(angle), (R + dR) * around(angle - sense * late))
    inside = slice(20, -1)
    sagitta = R * (1 - np.cos((angle[1] - angle[0]) / 2))
    assert found.contour[inside] == pytest.approx(-sense * dR, abs=1.01 * sagitta)
    assert found.lag[inside] == pytest.approx(R * late, rel=1e-3)
    assert found.tracking[inside] == pytest.approx(
        np.sqrt(dR**2 + 4 * R * (R + dR) * np.sin(late / 2) ** 2), rel=1e-9
    )
    across = sense * (R - (R + dR) * np.cos(late))
    assert found.across[inside] == pytest.approx(across, rel=1e-3)
    assert found.arc[-1] == pytest.approx(4 * np.pi * R, rel=1e-6)


def test_a_corner_is_nearest_from_its_outside_only() -> None:
    """A path along x that turns left by 90 degrees: outside of the corner is right of it."""
    share = np.linspace(0, 1, 501)[:, None]
    before = np.array([-0.01, 0.0]) * (1 - share)
    path = np.concatenate([before, np.array([0.0, 0.01]) * share[1:]])
    measured = path.copy()
    measured[500] = [3e-6, -4e-6]  # beyond the corner, which is nearest
    measured[520] = [-2e-6, path[500 + 18, 1]]  # inside, left of the second edge
    measured[510] = [path[495, 0], 1e-6]  # still left of the first edge, behind the corner
    found = errors_of(path, measured)
    assert found.contour[[500, 520, 510]] == pytest.approx([-5e-6, 2e-6, 1e-6], rel=1e-9)
    assert found.lag[510] == pytest.approx(15 * 2e-5, rel=1e-9)
    assert np.hypot(*found.foot[500]) == pytest.approx(0.0, abs=1e-15)
    top = numbers.peaks_of(found)[0]
    assert (top.sample, top.contour) == (500, pytest.approx(-5e-6))


def test_at_a_crossing_the_branch_that_is_followed_counts() -> None:
    """A figure of eight crosses itself at its middle; 1 um off its own branch stays 1 um."""
    phi = np.linspace(0.3, 0.3 + 2 * np.pi, 20_001)
    path = 0.02 * np.stack([np.sin(phi), np.sin(phi) * np.cos(phi)], axis=1)
    tangent = numbers.tangents(np.gradient(path, axis=0))
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    size = 1e-6 * np.cos(5 * phi)
    found = errors_of(path, path + size[:, None] * normal)
    assert found.contour == pytest.approx(size, abs=2e-9)
    # Its other branch is much nearer there than the whole path is wide.
    crossing = np.hypot(*path.T).argmin()
    assert np.hypot(*path[crossing]) < 5e-6


def test_a_rest_keeps_the_direction() -> None:
    velocity = np.array([[0.0, 0.0], [0.0, 2.0], [0.0, 0.0], [-3.0, 0.0], [0.0, 0.0]])
    expected = [[0, 1], [0, 1], [0, 1], [-1, 0], [-1, 0]]
    assert numbers.tangents(velocity) == pytest.approx(np.array(expected))


def test_the_view_has_the_figures_of_the_metrics_and_draws_every_extreme() -> None:
    played = play("circle", SHORT)
    window = played.prepared.window
    found = contouring(of_recording(played.recording, played.prepared, *window))
    for name in "AB":
        variant = found.variants[name]
        assert variant is not None
        metrics = variant_metrics(
            played.recording, name, played.prepared.reference, window, settling_band=1e-6
        )["contour"]
        figures = asdict(numbers.PathFigures(**variant.figures.model_dump()))
        assert figures["contour_max"] == pytest.approx(metrics["max"], rel=1e-9)
        assert figures["contour_rms"] == pytest.approx(metrics["rms"], rel=1e-9)
        points = variant.points
        assert max(map(abs, points.contour)) == pytest.approx(figures["contour_max"], abs=1e-12)
        assert max(points.tracking) == pytest.approx(figures["tracking_max"], abs=1e-12)
        off = np.hypot(points.off_x, points.off_y)
        assert off == pytest.approx(np.abs(points.contour), abs=2e-12)
        assert np.square(points.along) + np.square(points.across) == pytest.approx(
            np.square(points.tracking), rel=1e-5, abs=1e-17
        )
        assert abs(variant.peaks[0].contour) == figures["contour_max"]


def test_a_stretch_sees_the_path_before_it() -> None:
    """The first sample of a stretch lags behind the stretch, but not beside the path."""
    played = play("circle", SHORT)
    start = played.prepared.window[0] + 1000
    whole = contouring(of_recording(played.recording, played.prepared, 0, start + 500))
    part = contouring(of_recording(played.recording, played.prepared, start, start + 500))
    assert whole.variants["A"] is not None
    assert part.variants["A"] is not None
    at = whole.variants["A"].points.time.index(part.variants["A"].points.time[0])
    assert part.variants["A"].points.contour[0] == pytest.approx(
        whole.variants["A"].points.contour[at], abs=5e-9
    )


def test_one_axis_alone_has_no_contour() -> None:
    played = play("stair-y-500nm", {"trajectory.count": 1})
    recorded = of_recording(played.recording, played.prepared, 0, played.prepared.reference.ticks)
    with pytest.raises(ConfigError, match=r"one axis only.*x at rest"):
        contouring(recorded)
    with pytest.raises(ConfigError, match="rests over the whole stretch"):
        contouring(of_recording(played.recording, played.prepared, 0, 10))
