"""Each effect that ships against equations written anew, at a step of a hundredth."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.effects.free_mover import M, loads, pushed, simulated, stepped

Array = NDArray[np.float64]

F_C, F_S, V_S, S_0, S_1, S_2 = 1.0, 2.5, 0.01, 1e5, 300.0, 12.0
CURVE = {"F_c": F_C, "F_s": F_S, "v_s": V_S}
SHARES = np.full(4, 0.25)
K = S_0 * -np.diff(np.exp(-np.array([0.0, 0.96127876, 1.67834699, 2.69263453, np.inf])))


def curve(v: float) -> float:
    return float(F_C + (F_S - F_C) * np.exp(-((v / V_S) ** 2)))


def static(v: float, _p: float, s: Array) -> tuple[float, Array]:
    return curve(v) * np.tanh(v / 2e-4) + S_2 * v, s


def lugre(v: float, p: float, s: Array) -> tuple[float, Array]:
    rate = v - S_0 * abs(v) / curve(v) * s
    along = 1.0 + 0.3 * np.sin(2.0 * np.pi * p / 1e-3)
    return float(along * (S_0 * s[0] + S_1 * rate[0]) + S_2 * v), rate


def dahl(v: float, _p: float, s: Array) -> tuple[float, Array]:
    return float(S_0 * s[0] + S_2 * v), v - S_0 * abs(v) / F_C * s


def cogging(_v: float, p: float, s: Array) -> tuple[float, Array]:
    x = 2.0 * np.pi * p / 1e-3
    return float(2.0 * np.sin(x) + 0.5 * np.sin(3.0 * x + 1.0)), s


class Maxwell:
    """Elements that stick or slip; the switch is between steps."""

    C = 1000.0

    def __init__(self) -> None:
        self.slips = np.zeros(4, dtype=bool)
        self.side = 0.0

    def __call__(self, v: float, _p: float, s: Array) -> tuple[float, Array]:
        level, side = curve(v), float(np.sign(v))
        if side and side != self.side:
            self.slips[:], self.side = False, side
        self.slips |= side * s >= SHARES * level
        slip = side * self.C * (SHARES - np.abs(s) / level)
        return float(s.sum() + S_2 * v), np.where(self.slips, slip, K * v)


MODELS: dict[str, tuple[dict[str, Any], Callable[[], Any], int]] = {
    "static-stribeck": (CURVE | {"sigma_2": S_2}, lambda: static, 1),
    "lugre": (
        CURVE
        | {"sigma_0": S_0, "sigma_1": S_1, "sigma_2": S_2}
        | {"position_amplitude": 0.3, "position_period": 1e-3},
        lambda: lugre,
        1,
    ),
    "dahl": ({"F_c": F_C, "sigma_0": S_0, "sigma_2": S_2}, lambda: dahl, 1),
    "gms": (CURVE | {"sigma_0": S_0, "sigma_2": S_2}, Maxwell, 4),
    "cogging": (
        {"pitch": 1e-3, "amplitude_1": 2.0, "amplitude_3": 0.5, "phase_3": 1.0},
        lambda: cogging,
        1,
    ),
}

TOLERANCES = {
    "static-stribeck": 2e-4,
    "lugre": 2e-5,
    "dahl": 1e-5,
    "gms": 4e-4,
    "cogging": 5e-6,
}
"""Errors as shares of the largest position and velocity; the lab's step is 0.1 ms."""


@pytest.mark.parametrize("name", MODELS)
def test_it_moves_a_mover_as_its_equations_do(name: str) -> None:
    values, model, states = MODELS[name]
    load = loads(12.0)
    lab = simulated([{"effect": name, **values}], load)
    p, v = stepped(load, model(), states, 2e-6).T
    assert np.abs(p).max() > 2e-4
    tolerance = TOLERANCES[name]
    assert np.abs(lab["position"] - p).max() < tolerance * np.abs(p).max()
    assert np.abs(lab["velocity"] - v).max() < tolerance * np.abs(v).max()


def test_samples_have_the_force_of_their_instant() -> None:
    values, load = MODELS["static-stribeck"][0], loads(12.0)
    lab = simulated([{"effect": "static-stribeck", **values}], load)
    force = np.array([static(v, 0.0, np.zeros(1))[0] for v in lab["velocity"]])
    np.testing.assert_allclose(lab["friction"], force, atol=1e-4)
    held = np.repeat(load, 10)
    np.testing.assert_allclose(
        M * lab["acceleration"], lab["thrust"] - held - lab["friction"], atol=1e-5
    )


def test_cogging_is_in_the_acceleration_and_not_in_the_friction() -> None:
    load = loads(12.0)
    lab = simulated([{"effect": "cogging", **MODELS["cogging"][0]}], load)
    force = np.array([cogging(0.0, p, np.zeros(1))[0] for p in lab["position"]])
    assert not lab["friction"].any()
    np.testing.assert_allclose(M * lab["acceleration"], -np.repeat(load, 10) - force, atol=2e-4)


def test_effects_add_up() -> None:
    load = loads(12.0)
    half = CURVE | {"F_c": 0.5 * F_C, "F_s": 0.5 * F_S, "sigma_2": 0.5 * S_2}
    two = simulated([{"effect": "static-stribeck", **half}] * 2, load)
    one = simulated([{"effect": "static-stribeck", **MODELS["static-stribeck"][0]}], load)
    for name in one:
        np.testing.assert_allclose(two[name], one[name], rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("name", ["static-stribeck", "lugre", "dahl", "gms"])
def test_friction_grows_with_the_normal_force_and_follows_the_position(name: str) -> None:
    v, h = np.full(4000, 0.02), 1e-3
    own = {"F_c": F_C, "sigma_2": 0.0} | ({} if name == "dahl" else {"F_s": F_C})
    own |= {"sigma_1": 0.0} if name == "lugre" else {}
    plain, _ = pushed(name, own, v, h)
    heavy, _ = pushed(name, own | {"mu": 0.02}, v, h, normal=100.0)
    np.testing.assert_allclose(heavy[500:] - plain[500:], 2.0, rtol=1e-6)
    wavy, p = pushed(name, own | {"position_amplitude": 0.2, "position_period": 0.06}, v, h)
    along = 1.0 + 0.2 * np.sin(2.0 * np.pi * p / 0.06)
    lag = 0.02 if name == "gms" else 1e-3  # elements follow with C
    np.testing.assert_allclose(wavy[500:], F_C * along[500:], rtol=lag)
