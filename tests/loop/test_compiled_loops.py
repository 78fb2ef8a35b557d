"""Compiled loops against numpy and scipy."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from motionlab.config.load import load_scenario
from motionlab.kernel.layout import (
    MODEL_FRICTION,
    Command,
    ControllerState,
    parameter_row,
    state_row,
)
from motionlab.loop import lane_controller
from motionlab.loop.family import SPEEDS, VELOCITIES, LoopFamily, stability_limits, with_gains
from motionlab.loop.lane_loops import FREQUENCIES
from motionlab.loop.linearise import Loop, linearise, parameters, plant_about
from motionlab.loop.matrices import exponential_less_one, largest_modulus
from motionlab.timing import CONTROL_PERIOD, PLANT_STEP
from tests.loop.drawn_loops import CHANGES

Array = Any


@settings(max_examples=200, deadline=None)
@given(size=st.integers(1, 14), seed=st.integers(0, 2**32 - 1), spread=st.floats(0.0, 4.0))
def test_largest_modulus_is_that_of_the_eigenvalues(size: int, seed: int, spread: float) -> None:
    random = np.random.default_rng(seed)
    scale = 10.0 ** random.uniform(-spread, spread, size)
    A = random.normal(size=(size, size)) * (random.random((size, size)) < 0.6)
    A = A * scale[:, None] / scale
    expected = np.abs(np.linalg.eigvals(A)).max()
    bound = 1e-6 * max(expected, 1e-3)  # eigenvalues that are several hold half the digits
    assert largest_modulus(A.copy(), size) == pytest.approx(expected, abs=bound)


@settings(max_examples=50, deadline=None)
@given(size=st.integers(1, 7), seed=st.integers(0, 2**32 - 1), norm=st.floats(0.0, 30.0))
def test_exponential(size: int, seed: int, norm: float) -> None:
    A = np.random.default_rng(seed).normal(size=(size, size))
    A = A * (norm / np.abs(A).sum())
    E = np.empty_like(A)
    exponential_less_one(A.copy(), size, E, np.empty_like(A))
    expected = expm(A)
    assert E + np.eye(size) == pytest.approx(expected, abs=1e-12 * max(np.abs(expected).max(), 1.0))


@pytest.mark.parametrize("v", [0.0, 0.02, 0.2])
@pytest.mark.parametrize("coupling", [0.0, -1.0])
def test_plant_is_the_exponential_of_its_equations(coupling: float, v: float) -> None:
    scenario = load_scenario("circle", {"plant.x.resonance.coupling": coupling})
    par, axis = parameters(scenario, "A", "x"), scenario.plant.x
    f, mode = par.friction, axis.resonance
    omega_r = 2.0 * math.pi * mode.frequency
    fade = (f.F_s - f.F_c) * math.exp(-((v / f.v_s) ** 2))
    g = (f.F_c + fade) / f.sigma_0
    slope = 1.0 if v == 0.0 else v / g * (-2.0 * v / f.v_s**2 * fade / f.sigma_0)
    rate = 1e-3 if v == 0.0 else v / g
    omega = -math.log(par.amplifiers.half_step) / (0.5 * PLANT_STEP)
    A = np.zeros((7, 7))  # position, velocity, bristle, force, deflection, its rate; command
    A[0, 1] = A[4, 5] = 1.0
    A[1, 1:4] = [-(f.sigma_1 * slope + f.sigma_2), f.sigma_1 * rate - f.sigma_0, 1.0]
    A[1] /= axis.mass
    A[2, 1:3] = slope, -rate
    A[3, 3], A[3, 6] = -omega, omega  # the gain of the nominal map is 1
    A[5, 3:6] = mode.coupling / axis.mass, -(omega_r**2), -2.0 * mode.damping * omega_r
    step = expm(A * CONTROL_PERIOD)
    plant = plant_about(par, v)
    n = len(plant.A)
    assert plant.A == pytest.approx(step[:n, :n], rel=1e-9, abs=1e-9 * np.abs(step).max())
    assert plant.B[:2] == pytest.approx(step[:2, 6], rel=1e-9)
    assert plant.C.tolist() == [1.0, 0.0, 0.0, 0.0, 1.0, 0.0][:n]


def loops_at(scenario: Any, speeds: tuple[float, ...]) -> list[Loop]:
    v_s = scenario.plant.x.friction.v_s
    return [linearise(scenario, "A", "x", v=speed * v_s) for speed in speeds]


@settings(max_examples=25, deadline=None)
@given(changes=CHANGES)
def test_a_family_has_the_poles_and_responses_of_its_loops(changes: dict[str, Any]) -> None:
    scenario = load_scenario("circle", changes)
    family = LoopFamily.of(scenario, "A", "x")
    gains = scenario.variants["A"].controller.x
    loops = loops_at(scenario, VELOCITIES)
    radii = [np.abs(np.linalg.eigvals(loop.closed())).max() for loop in loops]
    assert family.radii(np.array(gains.k_p), np.array(gains.k_d)) == pytest.approx(radii, rel=1e-6)
    frequency = family._loops.frequency[: int(family._loops.sizes[FREQUENCIES, 0])]
    open_loops = np.array([loop.open(frequency) for loop in loops])
    free, p = family._loops.response[..., : len(frequency)]
    z = np.exp(2j * np.pi * frequency * CONTROL_PERIOD)
    L = free + (gains.k_p + gains.k_d * (1.0 - 1.0 / z) / CONTROL_PERIOD) * p
    assert np.abs(L / open_loops - 1.0).max() < 1e-6
    if max(radii) < 1.0:
        expected = worst_by_numpy(family.velocity, open_loops)
        figures = np.array(family.figures(gains.k_p, gains.k_d))
        assert figures[:, 0] == pytest.approx(expected, rel=1e-6)


def worst_by_numpy(velocity: Array, L: Array) -> list[float]:
    """Return gain margin, phase margin and Ms of open loops, (v, f), straight between places."""
    found = []
    for row in L:
        size, phase = np.log(np.abs(row)), np.unwrap(np.angle(-row))
        gain, angle = [math.inf], [math.inf]
        for k in range(len(row) - 1):
            if size[k] * size[k + 1] < 0.0:
                at = phase[k] + (phase[k + 1] - phase[k]) * size[k] / (size[k] - size[k + 1])
                angle.append(abs(math.remainder(at, 2.0 * math.pi)))
            turn = round(phase[k] / (2.0 * math.pi)) * 2.0 * math.pi
            a, b = phase[k] - turn, phase[k + 1] - turn
            if a * b < 0.0:
                gain.append(abs(size[k] + (size[k + 1] - size[k]) * a / (a - b)))
        found.append((min(gain), min(angle), np.abs(1.0 + row).min()))
    least = [_on_parabola(velocity, np.array(values)) for values in zip(*found, strict=True)]
    return [math.exp(least[0]), least[1], 1.0 / max(least[2], 1e-12)]


def _on_parabola(velocity: Array, values: Array) -> float:
    k = int(values.argmin())
    near = values[k - 1 : k + 2]
    if not 1 < k < len(values) - 1 or not np.isfinite(near).all() or np.ptp(near) == 0.0:
        return float(values[k])
    slope, bend = 0.5 * (near[2] - near[0]), near[0] + near[2] - 2.0 * near[1]
    return max(float(near[1] - 0.5 * slope**2 / bend), 0.0)


@settings(max_examples=15, deadline=None)
@given(changes=CHANGES, speed=st.sampled_from([0.0, *SPEEDS]))
def test_stability_changes_at_the_limits(changes: dict[str, Any], speed: float) -> None:
    scenario = load_scenario("circle", changes)
    gains = scenario.variants["A"].controller.x
    limits = stability_limits(scenario, "A", "x", speed)
    for gain, limit in limits.items():
        if limit is not None:
            sides = [
                with_gains(scenario, "A", "x", **{**gains_of(gains), gain: limit * factor})
                for factor in (0.9998, 1.0002)
            ]
            below, above = (loops_at(side, (speed,))[0].stable for side in sides)
            assert below != above, gain


def gains_of(gains: Any) -> dict[str, float]:
    return {"k_p": gains.k_p, "k_d": gains.k_d}


def test_states_of_the_linearised_controller_lie_where_the_kernel_has_them() -> None:
    memory = [f"memory.{name}" for name in ControllerState._fields if name != "e_last"]
    commands = [
        f"{when}.{name}"
        for when in ("acting", "pending")
        for name in Command._fields
        if not name.startswith("current_")
    ]
    names = ["law.s_0", "law.s_1", *memory, *commands]
    assert len(memory) + len(commands) == lane_controller.MEMORY_STATES
    found = [lane_controller._row(state, 2) for state in range(len(names))]
    assert found == [state_row(name) for name in names]
    assert parameter_row("model_friction.v_s") == MODEL_FRICTION + 5
