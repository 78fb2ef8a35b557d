"""Friction anatomy: made loops and curves give what they were made with; a run, its samples'."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.analysis import friction_anatomy as numbers
from motionlab.analysis.views.friction import POINTS, friction
from motionlab.analysis.views.recorded import Recorded
from motionlab.errors import ConfigError
from motionlab.plant.friction import LuGre
from motionlab.simulation.recorded import of_recording
from tests.simulated import SHORT, Played, play

Array = NDArray[np.float64]

LUGRE = LuGre(sigma_0=1.2e5, sigma_1=1000.0, sigma_2=10.0, F_c=0.25, F_s=3.6, v_s=0.04)
PERIOD = 0.5e-3  # s


@pytest.fixture(scope="module")
def played() -> Played:
    return play("circle", SHORT)


def recorded(played: Played) -> Recorded:
    return of_recording(played.recording, played.prepared, 0, played.prepared.reference.ticks)


def test_the_stribeck_curve_is_the_closed_form() -> None:
    v = numbers.stribeck_velocities(0.03, [0.04])
    assert len(v) == 2 * numbers.VELOCITIES
    assert v[-1] == pytest.approx(2.2 * 0.04)
    assert v == pytest.approx(-v[::-1])
    assert numbers.stribeck_velocities(0.2, [0.04])[-1] == pytest.approx(0.22)
    level = 0.25 + 3.35 * np.exp(-((v / 0.04) ** 2))
    assert numbers.stribeck_curve(LUGRE, v) == pytest.approx(np.sign(v) * level + 10.0 * v)


def slow_loop(shift: float = 0.0) -> tuple[Array, Array, Array]:
    """Return reference velocity, position and friction of bristles alone in a slow sine.

    ``dz/dx = 1 - sgn(v) sigma_0 z/F_s``, in closed form from each turn on.
    """
    t = np.arange(8000) / 4000
    position = 3e-4 * np.sin(2 * np.pi * t)
    velocity = np.cos(2 * np.pi * t)
    way = np.sign(velocity)
    force = np.zeros_like(t)
    turn, start = 0.0, -3.6
    for k in range(1, len(t)):
        if way[k] != way[k - 1] and way[k] != 0:
            turn, start = position[k - 1], force[k - 1]
        away = position[k] - turn
        last = way[k] * 3.6
        force[k] = last + (start - last) * np.exp(-abs(away) * LUGRE.sigma_0 / 3.6)
    return velocity, position + shift, force


def test_a_slow_loop_is_as_stiff_as_its_bristles_and_breaks_away_at_stiction() -> None:
    velocity, position, force = slow_loop(shift=0.02)
    found = numbers.branches(velocity, position)
    assert [branch.direction for branch in found] == [-1, 1, -1, 1]
    assert found[0].turn == pytest.approx(0.0203, abs=1e-9)
    length = numbers.PRESLIDING * 3.6 / LUGRE.sigma_0
    loop = numbers.presliding(found, position, force, length)
    assert loop.breakaway == pytest.approx(3.6, rel=0.02)
    assert loop.stiffness == pytest.approx(LUGRE.sigma_0, rel=0.02)
    away = numbers.displacement(found, position)
    assert np.isnan(away[: found[0].start]).all()
    assert away[found[1].start :].min() >= 0.0
    # A motion that stays within presliding breaks nothing away.
    within = numbers.presliding(found, position, force, 1e-3)
    assert within == (None, None)


def test_points_are_dense_where_a_curve_is_quick() -> None:
    step = np.tanh((np.arange(10_000) - 5000) / 20.0)
    picked = numbers.spread_evenly([step], 200)
    assert len(picked) <= 200
    assert (picked[0], picked[-1]) == (0, 9999)
    assert np.count_nonzero(np.abs(picked - 5000) < 100) > 50
    assert numbers.spread_evenly([step], 10_000).tolist() == list(range(10_000))


def test_the_figures_of_a_circle_are_those_of_its_samples(played: Played) -> None:
    found = friction(recorded(played))
    assert (set(found.axes), found.note) == ({"x", "y"}, "")
    for axis in "xy":
        one = found.axes[axis]
        assert one.motor is not None
        assert len(one.time) <= POINTS // 2
        for name, share in (("A", 0.0), ("B", 1.0)):
            true, estimate, velocity = (
                played.channel(name, channel, axis)
                for channel in ("friction", "friction_estimate", "velocity")
            )
            variant = one.variants[name]
            assert variant.figures is not None
            assert variant.curves is not None
            error = estimate - true
            figures = variant.figures
            assert figures.mismatch_rms == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-9)
            assert figures.mismatch_max == pytest.approx(np.abs(error).max(), rel=1e-9)
            left = np.sqrt(np.mean((true - share * estimate) ** 2) / np.mean(true**2))
            assert figures.compensated == pytest.approx(1 - left, rel=1e-9, abs=1e-12)
            ticks = np.rint(np.array(one.time) / PERIOD).astype(int)
            assert variant.curves.friction == pytest.approx(true[ticks], abs=1e-5)
            assert variant.curves.velocity == pytest.approx(velocity[ticks], abs=1e-7)
            assert variant.curves.compensation == pytest.approx(share * estimate[ticks], abs=1e-5)
            # Sliding along the curve: the quarter around the middle of each stroke.
            v = velocity[-1500:]
            level = one.motor.F_c + (one.motor.F_s - one.motor.F_c) * np.exp(
                -((v / one.motor.v_s) ** 2)
            )
            fast = np.abs(v) > 0.5 * np.abs(v).max()
            steady = np.sign(v) * level + one.motor.sigma_2 * v
            assert true[-1500:][fast] == pytest.approx(steady[fast], abs=0.25)
            assert figures.breakaway == pytest.approx(one.motor.F_s, rel=0.15)
    curve = np.array(found.axes["x"].stribeck)
    assert curve == pytest.approx(np.array(found.axes["x"].variants["B"].stribeck))


def test_without_friction_or_motion_there_is_nothing_to_see(played: Played) -> None:
    off = {"plant.x.friction.enabled": False}
    x = friction(recorded(play("circle", SHORT | off))).axes["x"]
    assert (x.motor, x.stribeck) == (None, None)
    assert x.variants["B"].figures is not None
    assert x.variants["B"].figures.compensated is None
    with pytest.raises(ConfigError, match="no axis moves"):
        friction(recorded(play("circle", {"trajectory": {"kind": "point", "duration": 0.2}})))
