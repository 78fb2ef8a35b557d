"""What a motion costs: closed forms, and the balance of the mechanical energy."""

from __future__ import annotations

import numpy as np
import pytest

from motionlab.analysis import cost as numbers
from motionlab.analysis.views.cost import cost
from motionlab.simulation.recorded import of_recording
from motionlab.timing import CONTROL_PERIOD as T
from tests.simulated import IDEAL, SHORT, Played, play


def test_sums_are_exact_for_what_settles_between_samples() -> None:
    """A first-order loop that all but settles within a period, while the velocity grows."""
    generator = np.random.default_rng(1)
    fine, tau = 2000, T / 25
    within = numbers.settling(tau, T)
    levels = generator.normal(size=40)
    decay = np.exp(-np.arange(fine) * (T / fine) / tau)
    begun = np.concatenate([[0.0], levels[:-1]])
    i = np.concatenate([(levels + (begun - levels) * decay[:, None]).T.ravel(), levels[-1:]])
    v = np.linspace(-1.0, 2.0, len(i))
    assert numbers.square_integral(i[::fine], T, within) == pytest.approx(
        np.trapezoid(i * i, dx=T / fine), rel=1e-4
    )
    assert numbers.work(i[::fine], v[::fine], T, within) == pytest.approx(
        np.trapezoid(i * v, dx=T / fine), rel=1e-4
    )


def test_straight_lines_and_steps() -> None:
    force, velocity = np.array([1.0, 3.0]), np.array([0.0, 6.0])
    assert numbers.work(force, velocity, 2.0) == pytest.approx(2 * (0 + 3 + 4))
    assert numbers.work(force, velocity, 2.0, numbers.HELD) == pytest.approx(2 * 3)
    assert numbers.square_integral(force, 3.0, numbers.LINEAR) == pytest.approx(13)
    at_once = numbers.settling(0.0, T)
    assert numbers.square_integral(force, 3.0, at_once) == pytest.approx(27)
    assert numbers.settling(1e4 * T, T) == pytest.approx((1, 1 / 2, 1), rel=2e-4)


@pytest.fixture(scope="module")
def circle() -> Played:
    return play("circle", SHORT | {"load.x": 0.5})


def test_thrust_pays_for_friction_load_and_speed(circle: Played) -> None:
    """From rest to full speed, with a load on x."""
    found = cost(of_recording(circle.recording, circle.prepared, 0, 2200))
    for name in "AB":
        for axis in "xy":
            one = found.variants[name][axis]
            parts = one.balance
            assert parts is not None
            total = parts.friction + parts.load + parts.kinetic + parts.residual
            assert total == pytest.approx(parts.thrust, rel=1e-12)
            spent = abs(parts.friction) + abs(parts.load) + abs(parts.kinetic)
            assert abs(parts.residual) < 4e-4 * spent, (name, axis)
            assert one.missing == []
    x = found.variants["A"]["x"].balance
    position = circle.channel("A", "position", "x")
    assert x is not None
    assert x.load == pytest.approx(0.5 * (position[2199] - position[0]), rel=1e-3)


def test_an_ideal_force_leaves_next_to_nothing() -> None:
    played = play("circle", IDEAL | SHORT)
    found = cost(of_recording(played.recording, played.prepared, 0, 2200))
    for axis in "xy":
        parts = found.variants["A"][axis].balance
        assert parts is not None
        assert parts.friction == 0.0
        assert abs(parts.residual) < 1e-6 * abs(parts.kinetic)


def test_figures_are_those_of_the_channels_and_ratios_those_of_the_figures(circle: Played) -> None:
    first, stop = circle.prepared.window
    found = cost(of_recording(circle.recording, circle.prepared, first, stop))
    one, other = found.variants["A"]["y"], found.variants["B"]["y"]
    currents = {p: circle.channel("B", f"current_{p}", "y")[first:stop] for p in "abc"}
    thrust = circle.channel("B", "thrust", "y")[first:stop]
    command = circle.channel("B", "force_command", "y")[first:stop]
    rms = {p: np.sqrt(np.mean(i * i)) for p, i in currents.items()}
    for p, i in currents.items():
        phase = other.phases[p]
        assert phase is not None
        assert phase.peak == np.abs(i).max()
        assert phase.rms == pytest.approx(rms[p], rel=5e-3)
    assert other.copper == pytest.approx(
        T * sum(np.sum(i * i) for i in currents.values()), rel=5e-3
    )
    assert other.worst_phase == max(rms, key=lambda p: rms[p])
    assert other.force_peak == np.abs(thrust).max()
    assert other.force_rms == pytest.approx(np.sqrt(np.mean(thrust**2)))
    assert other.force_rate == pytest.approx(np.sqrt(np.mean(np.diff(command) ** 2)) / T)
    assert other.ratios is not None
    assert one.ratios is None
    assert one.force_rate is not None
    assert other.force_rate is not None
    assert other.ratios.force_rate == other.force_rate / one.force_rate
    assert other.ratios.saturated is None  # nothing is saturated
