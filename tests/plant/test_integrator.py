"""The integrator against an independent stiff solver: order of convergence and closed loop."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from tests.kernel import lane_runs
from tests.nominal_motor import Y_TRAPEZOID, Axis, X, Y
from tests.plant.pushed_movers import Array, pushed, steady_bristle
from tests.plant.stiff_cases import CASES, Case, compare, overload
from tests.plant.stiff_reference import hold

AXES = pytest.mark.parametrize("axis", [X, Y], ids=["x", "y"])

DURATION = 0.02
VELOCITY = np.array([0.15, -0.15, 0.65, -0.4, 0.03, 2e-4, 0.0, -0.02])
FORCE = np.array([6.0, -12.0, 10.0, 5.0, -3.0, 2.5, 8.0, 9.0])
REVERSES = 7  # the lane that comes to rest and turns round, where abs(v) has its kink


def start(axis: Axis) -> Array:
    """Return eight movers: sliding fast and slow, held by the bristles, breaking away, turning."""
    bristle = steady_bristle(axis, VELOCITY)
    bristle[5] = 1e-6
    return np.array([np.zeros(8), VELOCITY, bristle])


@functools.cache
def truth(axis: Axis, method: str) -> Array:
    """Return where the movers are after DURATION, shape (3, 8)."""
    ends = [
        hold(axis, tuple(state), force, duration=DURATION, method=method, tolerance=1e-12)
        for state, force in zip(start(axis).T.tolist(), FORCE.tolist(), strict=True)
    ]
    return np.array(ends).T


def decay_rate(axis: Axis, v: Array) -> Array:
    return np.abs(v / steady_bristle(axis, v))


@AXES
def test_two_stiff_solvers_agree(axis: Axis) -> None:
    """The reference can be trusted to a thousandth of what the integrator is measured at."""
    difference = np.abs(truth(axis, "LSODA") - truth(axis, "Radau"))
    assert difference[0].max() < 1e-14  # m
    assert difference[1].max() < 1e-12  # m/s
    assert difference[2].max() < 1e-13  # m


@AXES
def test_error_falls_with_the_square_of_the_step(axis: Axis) -> None:
    exact = truth(axis, "LSODA")
    counts = [50, 100, 200, 400, 800, 1600]
    # An explicit method is stable up to h lambda = 2 only.
    assert (decay_rate(axis, VELOCITY[:4]) * DURATION / counts[1] > 2.0).all()

    ends = [pushed(axis, start(axis), np.tile(FORCE, (n, 1)), DURATION / n)[-1] for n in counts]
    errors = np.array([np.abs(end - exact)[:2] for end in ends])  # of p and v
    assert errors[2, 0].max() < 4e-9  # m, at the 100 us of the kernel
    halved = errors[:-1] / errors[1:]
    smooth = np.delete(halved[:, 0], REVERSES, axis=1)
    assert smooth == pytest.approx(4.0, rel=0.05)
    # Velocities reach rounding, and the kink falls at another place of a step each time: there
    # only the trend tells.
    trend = np.log2(errors[0] / errors[-1]) / (len(counts) - 1)
    assert trend == pytest.approx(2.0, abs=0.4)
    assert trend[:, REVERSES] == pytest.approx(2.0, abs=0.1)


CIRCLE = lane_runs.circle(4700)  # both axes have turned round
TRAPEZOID = lane_runs.trapezoid(1800)  # break-away and 0.15 m/s


@pytest.mark.parametrize("law", ["off", "observer"])
@pytest.mark.parametrize(
    ("motion", "y", "axis"),
    [(CIRCLE, Y, 0), (CIRCLE, Y, 1), (TRAPEZOID, Y_TRAPEZOID, 1)],
    ids=["circle x", "circle y", "trapezoid y"],
)
def test_closed_loop_follows_the_stiff_solver_within_5_nm(
    motion: Array, y: Axis, axis: int, law: str
) -> None:
    found = compare(Case(law, y=y), motion, axis)
    assert found.error.max() > 1e-6  # it was a task
    assert found.difference.max() < 5e-9


@pytest.mark.parametrize("name", ["residual-k", "reversed-k", "delay", "resonance", "matched"])
def test_laws_delay_resonance_and_currents_follow_it_too(name: str) -> None:
    found = compare(CASES[name], CIRCLE[:3300], 1)  # y has turned round
    assert found.error.max() > 1e-6
    assert found.difference.max() < 5e-9


def test_where_currents_jump_to_their_limit_the_error_stays_below_a_thousandth() -> None:
    rest, load = overload(800)
    found = compare(Case("off", phases=True), rest, 1, load)
    assert found.error.max() > 5e-3
    assert 1e-7 < found.difference.max() < 1e-3 * found.error.max()
