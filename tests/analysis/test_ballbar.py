"""Circular test: made circles give the figures they were made with."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.analysis import ballbar
from motionlab.analysis.views.ballbar import ballbar as view
from motionlab.errors import ConfigError
from motionlab.simulation.recorded import of_recording
from tests.simulated import IDEAL, SHORT, play

Array = NDArray[np.float64]

R = 0.015  # m
N = 7200  # samples of a lap
PERIOD = 0.5e-3  # s
RATE = 2 * np.pi / (N * PERIOD)


def reference(laps: float, sense: int = 1, start: float = 0.0) -> tuple[Array, Array]:
    phi = start + sense * 2 * np.pi * np.arange(round(laps * N)) / N
    return 0.02 + R * np.cos(phi), -0.05 + R * np.sin(phi)


def lap(made: dict[str, float], sense: int = 1) -> tuple[Array, Array]:
    """Return angle and radial deviation of a lap made with errors to first order of them."""
    x, y = reference(2, sense)
    phi = np.arctan2(y + 0.05, x - 0.02)
    F = (
        made.get("radius", 0.0)
        + made.get("x", 0.0) * np.cos(phi)
        + made.get("y", 0.0) * np.sin(phi)
        + made.get("lobe", 0.0) * np.cos(3 * phi)
        + R * made.get("scale", 0.0) / 2 * np.cos(2 * phi)
        + R * made.get("squareness", 0.0) / 2 * np.sin(2 * phi)
        + sense * R * RATE * made.get("lag", 0.0) / 2 * np.sin(2 * phi)
    )
    circle = ballbar.circle_of(x, y)
    theta, found = ballbar.deviation(circle, x, y, -F * np.cos(phi), -F * np.sin(phi))
    own = ballbar.last_laps(circle, x, y)["ccw" if sense > 0 else "cw"]
    assert own.stop - own.start == N
    return theta[own.start : own.stop], found[own.start : own.stop]


def test_a_lobe_is_out_of_round_by_twice_its_height_and_nothing_else() -> None:
    found = ballbar.figures_of(*lap({"lobe": 5e-6, "radius": 1e-6}), ())
    assert found.G == pytest.approx(10e-6, rel=1e-6)
    assert (found.F_max, found.F_min) == pytest.approx((6e-6, -4e-6), rel=1e-6)
    assert found.harmonics.mean == pytest.approx(1e-6, rel=1e-6)
    for other in ("offset_x", "offset_y", "cos_2", "sin_2"):
        assert getattr(found.harmonics, other) == pytest.approx(0.0, abs=1e-13)


def test_an_offset_is_not_out_of_round() -> None:
    found = ballbar.figures_of(*lap({"x": 3e-6, "y": -4e-6}), ())
    assert found.G < 1e-14
    assert (found.harmonics.offset_x, found.harmonics.offset_y) == pytest.approx((3e-6, -4e-6))
    assert (found.F_max, found.F_min) == pytest.approx((5e-6, -5e-6), rel=1e-5)


def test_both_directions_tell_squareness_from_lag() -> None:
    made = {"squareness": 2e-4, "scale": 3e-4, "lag": 1e-4, "radius": 2e-6, "x": 1e-6, "y": 5e-7}
    found = ballbar.both_figures(R, RATE, lap(made), lap(made, -1))
    assert found.squareness == pytest.approx(2e-4, rel=1e-3)
    assert found.scale_mismatch == pytest.approx(3e-4, rel=1e-3)
    assert found.servo_mismatch == pytest.approx(1e-4, rel=1e-3)
    assert found.radius_error == pytest.approx(2e-6, rel=1e-3)
    assert (found.offset_x, found.offset_y) == pytest.approx((1e-6, 5e-7), rel=1e-3)
    # The two laps differ by twice the term of the lag.
    assert found.H == pytest.approx(R * RATE * 1e-4, rel=3e-3)
    wide = np.hypot(3e-4, 2e-4 + RATE * 1e-4) * R  # the larger of both ovals
    assert found.G == pytest.approx(wide, rel=2e-2)


def test_two_radii_are_out_of_round_only_together() -> None:
    ccw, cw = lap({"radius": 1e-6}), lap({"radius": -1e-6}, -1)
    assert ballbar.figures_of(*ccw, ()).G < 1e-14
    assert ballbar.both_figures(R, RATE, ccw, cw).G == pytest.approx(2e-6, rel=1e-9)


@pytest.mark.parametrize("sense", [1, -1])
def test_a_step_at_a_reversal_is_its_quadrant_height(sense: int) -> None:
    x, y = reference(2.4, sense, start=0.7)
    circle = ballbar.circle_of(x, y)
    phi = np.unwrap(np.arctan2(y - circle.y, x - circle.x))
    heights = [4e-6, 3e-6, -2e-6, 1e-6]
    F = np.zeros_like(phi)
    for k, height in enumerate(heights):
        past = (sense * (phi - k * np.pi / 2)) % (2 * np.pi)
        F += height * np.minimum(past / 0.1, 1.0) * (past < 1.0)
    found = ballbar.last_laps(circle, x, y)
    (own,) = found.values()
    measured = ballbar.quadrant_heights(own, (x, y), F, counts=(0.0, 0.0), period=PERIOD)
    assert measured == pytest.approx(heights, rel=0.01)


def test_what_is_no_circle_is_refused_with_how_far_off() -> None:
    along = np.linspace(0.0, 0.1, 1000)
    with pytest.raises(ConfigError, match=r"is no circle.*a line"):
        ballbar.circle_of(along, 0.5 * along)
    x, y = reference(1.5)
    with pytest.raises(ConfigError, match=r"is no circle.*um off the nearest"):
        ballbar.circle_of(x, y * (1 + 1e-4))
    short = reference(0.9)
    assert ballbar.last_laps(ballbar.circle_of(*short), *short) == {}


def test_a_rounded_reference_is_still_a_circle() -> None:
    x, y = (each.astype(np.float32).astype(np.float64) for each in reference(1.2))
    found = ballbar.circle_of(x, y)
    assert found == pytest.approx((0.02, -0.05, R), abs=1e-9)


def test_an_ideal_motor_is_as_large_as_its_lag_makes_it() -> None:
    """Without friction F is that of eq. (42): gain and phase of each axis at the circle's rate."""
    played = play("circle", IDEAL | SHORT | {"trajectory.laps": 3})
    found = view(
        of_recording(played.recording, played.prepared, 0, played.prepared.reference.ticks)
    )
    both = found.variants["A"].both
    assert both is not None
    w = 2 * np.pi / 3
    # A command that is held acts half a control period late, which takes k_p T/2 off k_d.
    gains = {"x": (5.9, 200300.0, 1530.0 - 50.1), "y": (13.9, 280500.0, 1080.0 - 70.1)}
    left = {
        axis: M * w * w / (k_p - M * w * w + 1j * k_d * w) for axis, (M, k_p, k_d) in gains.items()
    }
    closed = {axis: 1 + value for axis, value in left.items()}
    mean = R * (closed["x"].real + closed["y"].real - 2) / 2
    assert both.radius_error == pytest.approx(mean, rel=2e-2)
    assert both.scale_mismatch == pytest.approx((closed["x"] - closed["y"]).real, rel=2e-2)
    lag = (closed["y"].imag - closed["x"].imag) / w
    assert both.servo_mismatch == pytest.approx(lag, rel=2e-2)
    assert both.squareness == pytest.approx(0.0, abs=1e-9)
