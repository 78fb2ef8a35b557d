"""No controller that a scenario may hold is unstable by itself, whatever the loop about it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.kernel.build import lane
from motionlab.kernel.law_calls import law_parameters
from motionlab.laws.residual_k import gain_limit
from motionlab.loop.linearise import controller_about

B = "variants.B.controller"
ROUNDING = 1e-6
"""Of a modulus: the kernel's control half is differenced."""
SPEEDS = (0.0, *np.geomspace(0.003, 4.0, 40).tolist())
"""In Stribeck velocities: at rest, and where D passes through every value below zero."""


def largest_modulus(changes: dict[str, Any], axis: str) -> float:
    """Return the largest modulus of the controller's own poles at any of the velocities."""
    scenario = load_scenario("circle-matched", changes)
    par = lane(scenario, scenario.variants["B"].controller, axis)
    v_s = par.model_friction.v_s
    return max(
        float(np.abs(np.linalg.eigvals(controller_about(par, speed * v_s).A)).max())
        for speed in SPEEDS
    )


def residual_k(share: float, c: float, **friction: float) -> tuple[dict[str, Any], float]:
    """Return the changes that set a share of the limit of the gain of residual-k, and the gain."""
    changes: dict[str, Any] = {
        f"{B}.compensation.law": "residual-k",
        f"{B}.compensation.regularisation": c,
    }
    for name, value in friction.items():
        changes |= {f"{B}.model.{axis}.friction.{name}": value for axis in "xy"}
    controller = load_scenario("circle-matched", changes).variants["B"].controller
    gain = share * min(
        gain_limit(getattr(controller.model, axis).friction.parameters(), c) for axis in "xy"
    )
    return changes | {f"{B}.compensation.gain": gain}, gain


@given(
    law=st.sampled_from(["off", "lugre-observer", "canudas-de-wit", "reversed-k"]),
    bandwidth=st.floats(0.1, 500.0),
    filtered=st.floats(0.1, 1000.0),
    frequency=st.floats(1.0, 900.0),
    damping=st.floats(0.01, 2.0),
    depth=st.floats(0.0, 1.0),
    delay=st.integers(0, 1),
    velocity=st.sampled_from(["measured", "reference"]),
)
def test_every_other_law_with_observer_and_notch(
    law: str,
    bandwidth: float,
    filtered: float,
    frequency: float,
    damping: float,
    depth: float,
    delay: int,
    velocity: str,
) -> None:
    changes = {
        f"{B}.compensation.law": law,
        f"{B}.compensation.velocity": velocity,
        f"{B}.compensation.residual_bandwidth": filtered,
        f"{B}.disturbance_observer": {"enabled": True, "bandwidth": bandwidth},
        f"{B}.y.notch": {"frequency": frequency, "damping": damping, "gain": depth},
        f"{B}.delay": delay,
    }
    assert largest_modulus(changes, "y") <= 1.0 + ROUNDING


@given(c=st.floats(0.02, 5.0), sigma_1=st.floats(100.0, 1e4), delay=st.integers(0, 1))
def test_residual_k_up_to_the_limit_of_its_gain(c: float, sigma_1: float, delay: int) -> None:
    changes, _ = residual_k(0.999, c, sigma_1=sigma_1)
    for axis in "xy":
        assert largest_modulus(changes | {f"{B}.delay": delay}, axis) <= 1.0 + ROUNDING


@pytest.mark.parametrize("c", [0.2, 0.4, 1.0, 3.0])
def test_the_limit_is_where_the_residual_begins_to_feed_itself(
    c: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    changes, gain = residual_k(1.1, c)
    with pytest.raises(ConfigError, match="residual feeds itself") as refusal:
        load_scenario("circle-matched", changes)
    (error,) = refusal.value.errors
    assert (error.loc, error.value, error.unit) == (f"{B}.compensation.gain", gain, "1/s")
    assert error.bounds["exclusive_maximum"] == pytest.approx(gain / 1.1)
    assert "on y" in error.message and "lower the gain or raise c" in error.message
    monkeypatch.setattr("motionlab.config.load._unstable_gains", lambda _: [])
    assert largest_modulus(changes, "y") > 1.0 + ROUNDING


@pytest.mark.parametrize("sigma_1", [0.0, 1493.5, 2e4])
def test_the_gain_that_is_left_out_is_within_its_limit(sigma_1: float) -> None:
    changes, _ = residual_k(1.0, 0.4, sigma_1=sigma_1)
    changes[f"{B}.compensation.gain"] = None
    scenario = load_scenario("circle-matched", changes)
    gain = law_parameters(lane(scenario, scenario.variants["B"].controller, "y")).gain
    assert gain == pytest.approx(40.0 if sigma_1 < 2e4 else 0.9 * 0.8 * 84737.0 / 2e4)
    assert largest_modulus(changes, "y") <= 1.0 + ROUNDING
