"""The structural resonance: closed forms, energy, and the loop with it against the simulation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.kernel.layout import state_row
from motionlab.loop.family import stability_limits
from motionlab.loop.linearise import linearise
from motionlab.loop.margins import margins
from motionlab.plant.resonance import Resonance, natural, ring, sampled
from motionlab.studies.loop.frequency_sweep import frequency_sweep
from motionlab.timing import PLANT_STEP as H
from tests.kernel.lane_runs import IDEAL, at_rest, changed, channel, inputs, lane, rows, run
from tests.nominal_motor import CONTROL_PERIOD, X, Y
from tests.simulated import IDEAL as IDEAL_MOTOR
from tests.simulated import SHORT, play, same_bits

FREQUENCY, DAMPING, COUPLING = 137.0, 0.03, -0.4
OMEGA = 2.0 * math.pi * FREQUENCY


def resonant(coupling: float = COUPLING, damping: float = DAMPING) -> dict[str, Any]:
    """Changes to a scenario: both axes ring."""
    mode = {"frequency": FREQUENCY, "damping": damping, "coupling": coupling}
    return {f"plant.{axis}.resonance.{key}": value for axis in "xy" for key, value in mode.items()}


def ringing(**changes: float) -> Resonance:
    mode = {"frequency": FREQUENCY, "damping": DAMPING, "coupling": 1.0, "mass": X.M, "h": H}
    return sampled(**(mode | changes))


def test_free_decay_has_the_frequency_and_the_damping_of_the_closed_form() -> None:
    mode = {f"resonance.{key}": value for key, value in ringing()._asdict().items()}
    loose = {"controller.k_p": 0.0, "controller.k_d": 0.0}
    lanes = rows([changed(lane(axis), IDEAL | mode | loose) for axis in (X, Y)] * 4)
    state = at_rest((0.0, 0.0))
    y_0 = 1e-5
    state[state_row("plant.y")] = y_0
    seen = channel(run(lanes, state, inputs(np.zeros((400, 3, 2)))), "position_measured")
    t = np.arange(400) * CONTROL_PERIOD
    damped = OMEGA * math.sqrt(1.0 - DAMPING**2)
    tilt = DAMPING / math.sqrt(1.0 - DAMPING**2)
    expected = y_0 * np.exp(-DAMPING * OMEGA * t) * (np.cos(damped * t) + tilt * np.sin(damped * t))
    assert np.abs(seen[:, :] - expected[:, None]).max() < 1e-6 * y_0  # recorded as float32


def test_a_constant_thrust_deflects_by_its_compliance() -> None:
    mode = ringing(coupling=COUPLING)
    y, rate = 0.0, 0.0
    for _ in range(20_000):
        y, rate = ring(mode, y, rate, 12.0)
    assert y == pytest.approx(COUPLING * 12.0 / (X.M * OMEGA**2), rel=1e-12)
    assert rate == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("damping", [0.0, 0.02, 0.9])
@pytest.mark.parametrize("frequency", [1.0, 137.0, 2000.0])
def test_the_sampled_mode_still_tells_what_it_was(frequency: float, damping: float) -> None:
    omega = 2.0 * math.pi * frequency
    found = natural(ringing(frequency=frequency, damping=damping), H)
    assert found == pytest.approx((omega**2, 2.0 * damping * omega), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("frequency", [20.0, 137.0, 2000.0])
def test_energy_is_the_work_of_the_thrust(frequency: float) -> None:
    """Undamped, (dw/dt^2 + omega^2 w^2) M/2 grows by F (w_n - w) in every step."""
    omega = 2.0 * math.pi * frequency
    mode = ringing(frequency=frequency, damping=0.0)
    thrust = np.random.Generator(np.random.Philox(3)).standard_normal(5000)
    w, rate, work, largest = 1e-8, 0.0, 0.0, 0.0

    def energy() -> float:
        return 0.5 * X.M * (rate**2 + omega**2 * w**2)

    start = energy()
    for force in thrust:
        before = w
        w, rate = ring(mode, w, rate, float(force))
        work += float(force) * (w - before)
        largest = max(largest, energy())
        assert energy() == pytest.approx(start + work, rel=1e-9, abs=1e-12 * largest)
    assert largest > 2.0 * start  # the thrust did something


def test_a_damped_mode_only_loses_energy() -> None:
    mode = ringing()
    w, rate = 1e-6, 0.0
    last = math.inf
    for _ in range(3000):
        energy = rate**2 + OMEGA**2 * w**2
        assert energy < last
        last = energy
        w, rate = ring(mode, w, rate, 0.0)


def test_without_coupling_nothing_changes() -> None:
    elsewhere = resonant(coupling=0.0, damping=0.3)
    plain, idle = play("circle-matched", SHORT), play("circle-matched", SHORT | elsewhere)
    for variant in "AB":
        assert same_bits(plain.samples(variant), idle.samples(variant))


def test_the_encoder_sees_the_deflection_and_the_guides_do_not() -> None:
    """Driven slowly, the mode follows the thrust: y = kappa F/(M omega^2)."""
    soft = {"variants.A.controller.x.k_d": 600.0, "plant.x.encoder.resolution": 0.0}
    played = play("circle", SHORT | resonant() | soft)
    seen = played.channel("A", "position_measured", "x") - played.channel("A", "position", "x")
    slow = COUPLING * played.channel("A", "thrust", "x") / (X.M * OMEGA**2)
    rounding = 2e-9  # positions of 15 mm in single precision
    assert np.abs(seen - slow).max() < 0.3 * np.abs(slow).max() + rounding
    assert np.abs(seen).max() > 0.2e-6


@pytest.mark.parametrize("controller", ["pd", "lugre-full"])
@pytest.mark.parametrize(("axis", "coupling"), [("x", -0.03), ("x", 0.3), ("y", -0.05)])
def test_margins_of_the_linearised_loop_are_those_of_a_sweep(
    controller: str, axis: str, coupling: float
) -> None:
    """The sweep's L where the linearised loop has its crossing and its turn, and at the mode."""
    v = 0.02
    changes = resonant(coupling) | {"variants.B.controller": controller}
    changes["variants.B.controller.y.k_d"] = 2000.0
    scenario = load_scenario("circle", changes)
    loop = linearise(scenario, "B", axis, v=v)
    found = margins(loop.open)
    assert found.crossover is not None and loop.stable
    places = [found.crossover, 0.9 * FREQUENCY, FREQUENCY, 1.1 * FREQUENCY]
    measured = frequency_sweep(scenario, "B", axis, places, v=v)
    ratio = measured.open / loop.open(measured.frequency)
    assert np.abs(ratio) == pytest.approx(1.0, abs=0.03)
    assert np.angle(ratio) == pytest.approx(0.0, abs=0.06)
    rigid = linearise(load_scenario("circle", changes | resonant(0.0)), "B", axis, v=v)
    assert np.abs(measured.open / rigid.open(measured.frequency) - 1.0).max() > 0.4


@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_stiff_loop_goes_unstable_where_the_poles_leave_the_circle(axis: str) -> None:
    own = f"variants.A.controller.{axis}"
    soft = IDEAL_MOTOR | {f"{own}.k_p": 2e4, f"{own}.k_d": 400.0}
    limit = stability_limits(load_scenario("circle", soft | resonant()), "A", axis)["k_d"]
    rigid = stability_limits(load_scenario("circle", soft), "A", axis)["k_d"]
    assert limit is not None and rigid is not None
    assert limit < 0.1 * rigid
    kick = {"kind": "step", "height": {axis: 1e-6}, "dwell": 3.0}
    for factor, grows in ((0.98, False), (1.02, True)):
        changes = soft | resonant() | {"trajectory": kick, f"{own}.k_d": factor * limit}
        error = np.abs(play("circle", changes).channel("A", "following_error", axis))
        late, early = np.nanmax(error[-200:]), np.nanmax(error[400:1000])
        assert (late > early or not np.isfinite(error[-1])) == grows


def test_margins_find_a_mode_narrower_than_the_grid() -> None:
    """A mode of damping 1e-5 on a loop of gain 1/100: its peak is 500 times that."""

    def response(frequency: Any) -> NDArray[np.complex128]:
        s = 1j * frequency / 123.456
        return np.asarray(0.01 / (s**2 + 2e-5 * s + 1.0), dtype=np.complex128)

    found = margins(response)
    assert found.crossover == pytest.approx(123.456 * math.sqrt(1.01), rel=1e-6)
    assert found.phase_margin is not None
    assert found.phase_margin == pytest.approx(2e-3, rel=0.02)
