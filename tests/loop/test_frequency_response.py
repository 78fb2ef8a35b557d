"""The linearised loop against closed forms, the kernel's stability boundary, and a sweep."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError, Infeasible
from motionlab.kernel.build import lane
from motionlab.kernel.force_gain import force_gain
from motionlab.loop.linearise import linearise
from motionlab.loop.margins import Margins, margins
from motionlab.loop.steady_state_error import crossover, parabola_error, sine_error
from motionlab.studies.loop.frequency_sweep import frequency_sweep
from motionlab.timing import CONTROL_PERIOD
from tests.simulated import IDEAL, play

MASS = {"x": 5.9, "y": 13.9}


def gains(axis: str, k_p: float, k_d: float) -> dict[str, Any]:
    return {
        f"variants.A.controller.{axis}.k_p": k_p,
        f"variants.A.controller.{axis}.k_d": k_d,
    }


@pytest.mark.parametrize("axis", ["x", "y"])
def test_the_crossover_of_slow_loops_is_that_of_eq_39(axis: str) -> None:
    k_p, k_d = 2000.0, 150.0
    loop = linearise(load_scenario("circle", IDEAL | gains(axis, k_p, k_d)), "A", axis, v=0.0)
    expected = crossover(MASS[axis], k_p, k_d) / (2 * math.pi)
    assert margins(loop.open).crossover == pytest.approx(expected, rel=5e-3)


def test_crossover_is_where_the_open_loop_has_gain_one() -> None:
    M, k_p, k_d = 5.9, 200300.0, 1530.0
    w = crossover(M, k_p, k_d)
    assert abs(complex(k_p, w * k_d)) / (M * w**2) == pytest.approx(1.0, rel=1e-12)


def test_the_sine_error_has_the_quadrant_that_the_printed_phase_lacks() -> None:
    M, k_p, k_d, B, w = 5.9, 200300.0, 1530.0, 0.015, 2 * math.pi / 3
    error = sine_error(M, k_p, k_d, B=B, w=w)
    s = 1j * w
    exact = B * M * s**2 / (M * s**2 + k_d * s + k_p)
    assert error.amplitude == pytest.approx(abs(exact), rel=1e-12)
    assert error.phase == pytest.approx(np.angle(exact), rel=1e-12)
    assert error.phase > math.pi / 2  # arctan as printed stays below
    assert parabola_error(M, k_p, 0.5) == pytest.approx(5.9 / 200300.0)


@pytest.mark.parametrize("delay", [0, 1])
@pytest.mark.parametrize(("axis", "k_d"), [("x", 1500.0), ("y", 3000.0)])
def test_the_kernel_loses_stability_where_the_poles_leave_the_circle(
    axis: str, k_d: float, delay: int
) -> None:
    changes = IDEAL | {"variants.A.controller.delay": delay, "trajectory": "stair-x-500nm"}

    def stable(k_p: float) -> bool:
        scenario = load_scenario("circle", changes | gains(axis, k_p, k_d))
        return linearise(scenario, "A", axis, v=0.0).stable

    low, high = 1e4, 1e8
    assert stable(low)
    assert not stable(high)
    for _ in range(40):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    kick = {"kind": "step", "height": {axis: 1e-6}, "dwell": 3.0}
    for factor, grows in ((0.98, False), (1.02, True)):
        changed = changes | {"trajectory": kick} | gains(axis, factor * low, k_d)
        error = np.abs(play("circle", changed).channel("A", "following_error", axis))
        late, early = np.nanmax(error[-200:]), np.nanmax(error[400:1000])
        assert (late > early or not np.isfinite(error[-1])) == grows


CONTROLLERS = ["pd", "lugre-observer", "lugre-full", "canudas-de-wit", "residual-k", "reversed-k"]


@pytest.mark.parametrize("controller", CONTROLLERS)
@pytest.mark.parametrize(("axis", "delay"), [("x", 0), ("y", 1)])
def test_a_sweep_of_the_simulation_finds_the_linearised_loop(
    controller: str, axis: str, delay: int
) -> None:
    v = 0.02
    changes = {
        "variants.B.controller": controller,
        "variants.B.controller.delay": delay,
        "variants.B.controller.y.k_d": 2000.0,  # the published gains hardly bear a delay on y
    }
    scenario = load_scenario("circle", changes)
    measured = frequency_sweep(scenario, "B", axis, [5.0, 12.0, 30.0, 70.0, 160.0], v=v)
    expected = linearise(scenario, "B", axis, v=v).open(measured.frequency)
    ratio = measured.open / expected
    assert np.abs(ratio) == pytest.approx(1.0, abs=0.03)
    assert np.angle(ratio) == pytest.approx(0.0, abs=0.06)


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize("plant", ["as-measured", "matched", "table"])
def test_a_motor_other_than_its_model_has_the_gain_that_a_sweep_finds(
    plant: str, axis: str
) -> None:
    """Peaks, harmonics and current offsets all count; over whole pitches they average out."""
    table = {f"plant.{axis}.force_map": {"kind": "table", "name": "new-design"}}
    scenario = load_scenario("circle", table if plant == "table" else {"plant": plant})
    measured = frequency_sweep(scenario, "A", axis, [5.0, 12.0, 30.0, 70.0], v=0.02)
    expected = linearise(scenario, "A", axis, v=0.02).open(measured.frequency)
    ratio = measured.open / expected
    assert np.abs(ratio) == pytest.approx(1.0, abs=0.02)
    assert np.angle(ratio) == pytest.approx(0.0, abs=0.02)


def test_the_gain_of_an_axis_is_not_the_ratio_of_peaks() -> None:
    def gain(plant: str, force: float = 3.0) -> float:
        scenario = load_scenario("circle", {"plant": plant})
        par = lane(scenario, scenario.variants["A"].controller, "x")
        return float(force_gain(par, np.array([force]))[0])

    assert gain("nominal") == pytest.approx(1.0, rel=1e-12)
    assert gain("nominal", 0.0) == gain("nominal", 0.5)
    assert gain("nominal", 1e3) == pytest.approx(1.0, rel=1e-12)  # limits have no place in it
    assert gain("as-measured") == pytest.approx(1.1829, rel=1e-3)  # 38.4/34.1 is 1.126
    assert gain("matched", 0.5) > gain("matched", 5.0) > gain("as-measured")


def test_a_motor_without_current_has_no_margins() -> None:
    scenario = load_scenario("circle", {"plant.x.amplifiers.gain": (0.0, 0.0, 0.0)})
    found = margins(linearise(scenario, "A", "x", v=0.02).open)
    assert found == Margins(None, None, None, None, 1.0, None)


def test_the_published_law_has_no_linearisation() -> None:
    scenario = load_scenario("circle-published-k")
    with pytest.raises(ConfigError, match="no linearisation"):
        linearise(scenario, "B", "x", v=0.02)


def test_a_sweep_that_would_leave_the_stroke_is_refused() -> None:
    with pytest.raises(Infeasible, match="position on x"):
        frequency_sweep(load_scenario("circle"), "A", "x", [5.0], v=0.1)


def test_margins_of_an_integrator_with_a_period_of_delay() -> None:
    """L = w_0/(s) e^-sT: crossover w_0, phase margin pi/2 - w_0 T, gain margin pi/(2 w_0 T)."""
    w_0, T = 300.0, CONTROL_PERIOD

    def response(frequency: Any) -> Any:
        s = 2j * np.pi * frequency
        return w_0 / s * np.exp(-s * T)

    found = margins(response)
    assert found.crossover == pytest.approx(w_0 / (2 * math.pi), rel=1e-9)
    assert found.phase_margin == pytest.approx(math.pi / 2 - w_0 * T, rel=1e-9)
    assert found.gain_margin == pytest.approx(math.pi / (2 * w_0 * T), rel=1e-9)
    assert found.gain_reduction is None
    assert found.Ms > 1.0


def test_a_loop_that_never_reaches_gain_one_has_no_crossover() -> None:
    found = margins(lambda frequency: np.full(len(frequency), 0.1 + 0.0j))
    assert found == Margins(None, None, None, None, found.Ms, None)
    assert found.Ms == pytest.approx(1 / 1.1)
