"""K of eq. (25) with its sign reversed: stable where the printed one is not, and better than K = 0.

Stuck, ``M a - u = s_1 K - s_0 e_z`` and ``de_z/dt = -K``, with ``e_z = z - z*``: the printed sign
makes ``s_1 K`` follow ``M a - u``, the reversed one opposes it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.kernel.layout import INPUT_ROWS, state_row
from motionlab.loop.linearise import linearise
from tests.kernel.lane_runs import IDEAL, Array, at_rest, channel, lane, rows, run
from tests.nominal_motor import CONTROL_PERIOD, POLE_PITCH, Axis, X, Y
from tests.simulated import SHORT, Played, play

AXES = pytest.mark.parametrize("axis", [X, Y], ids=["x", "y"])
RAW = {"law.alpha": 1.0}
RHOMBUS = {"x.k_p": 400e3, "x.k_d": 1480.0, "y.k_p": 501.6e3, "y.k_d": 1570.0}
TABLE_NUMBER = {"compensation.k_d_share": 1e-3, "compensation.bristle_limit": 1000.0}
"""k_d in N s/mm taken as N s/m, and no bound on the estimate."""


def bristle_error(axis: Axis, law: str, changes: dict[str, float] | None = None) -> Array:
    """Return abs(e_z), m, of a mover at rest whose estimate starts 1e-15 m off: it stays linear."""
    lanes = rows([lane(axis, law, IDEAL | (changes or {}))] * 8)
    state = at_rest((0.0, 0.0))
    state[state_row("law.s_0")] = 1e-15
    samples = run(lanes, state, np.zeros((140, INPUT_ROWS, 2)))
    e_z = channel(samples, "bristle") - channel(samples, "bristle_estimate")
    return np.abs(e_z[:, 0])


def growth(error: Array) -> float:
    """Return the rate of an exponential through the later part of `error`, 1/s."""
    ticks = np.arange(60, 120)
    return float(np.polyfit(ticks * CONTROL_PERIOD, np.log(error[ticks]), 1)[0])


def printed_growth(axis: Axis) -> float:
    """Return the rate of the fastest mode of the printed sign, sampled, while stuck, 1/s.

    The acceleration is that of the encoder, differenced twice: a mean over two periods, in each of
    which K is held and e_z runs straight.
    """
    stiffness = axis.sigma_0 / axis.sigma_1
    # of e_n, e_(n-1), e_(n-2), K_(n-1), K_(n-2)
    K = np.array([-stiffness / 6, -4 * stiffness / 6, -stiffness / 6, 0.5, 0.5])
    step = np.zeros((5, 5))
    step[0] = -CONTROL_PERIOD * K
    step[0, 0] += 1.0
    step[1, 0] = step[2, 1] = step[4, 3] = 1.0
    step[3] = K
    return float(np.log(np.abs(np.linalg.eigvals(step)).max()) / CONTROL_PERIOD)


@AXES
def test_the_printed_sign_grows_while_stuck(axis: Axis) -> None:
    # without k_d, eq. (25) is K = (M a - u)/sigma_1
    found = growth(bristle_error(axis, "published-k", {"controller.k_d": 0.0}))
    assert found == pytest.approx(printed_growth(axis), rel=0.05)  # u moves a little meanwhile
    at_once = np.sqrt(axis.sigma_0 / (axis.sigma_1 * CONTROL_PERIOD))
    assert 0.7 * at_once < found < at_once  # faster still if the acceleration came at once


@AXES
def test_the_reversed_sign_decays_while_stuck(axis: Axis) -> None:
    rate = axis.sigma_0 / (2.0 * axis.sigma_1)
    assert growth(bristle_error(axis, "reversed-k", RAW)) == pytest.approx(-rate, rel=0.02)
    assert -1.3 * rate < growth(bristle_error(axis, "reversed-k")) < -rate  # filtered, at 30 Hz
    assert growth(bristle_error(axis, "lugre-observer")) == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize("v", [0.0, 1e-4, 1e-3, 0.01, 0.1, 1.0])
def test_the_reversed_sign_is_stable_at_every_speed(v: float, axis: str) -> None:
    scenario = load_scenario("circle", {"variants.B.controller": "reversed-k"})
    assert linearise(scenario, "B", axis, v=v).stable


def compared(plant: str, changes: dict[str, Any], gains: dict[str, float]) -> Played:
    """Run the circle without compensation, with K = 0, with `reversed-k`, and with e k_d/1000."""
    controllers = {
        "A": {},
        "B": {"compensation.law": "lugre-observer"},
        "C": {"compensation.law": "reversed-k"},
        "D": {"compensation.law": "reversed-k"} | TABLE_NUMBER,
    }
    more: dict[str, Any] = {}
    for name, law in controllers.items():
        more[f"variants.{name}.controller"] = "pd"
        more |= {f"variants.{name}.controller.{key}": v for key, v in (law | gains).items()}
    return play("circle", {"plant": plant} | changes | more)


PLACES = [{f"trajectory.center.{a}": k * POLE_PITCH / 8 for a in "xy"} for k in range(8)]
SLOW, FAST = ({"trajectory.frequency": hertz} for hertz in (0.1, 0.5))


@pytest.mark.parametrize("plant", ["nominal", "matched"])
@pytest.mark.parametrize(
    ("changes", "gains"),
    [*((place, {}) for place in PLACES), (SLOW, {}), (FAST, {}), ({}, RHOMBUS), (SLOW, RHOMBUS)],
    ids=[*(f"place {k}" for k in range(8)), "0.1 Hz", "0.5 Hz", "stiff", "stiff, 0.1 Hz"],
)
def test_it_is_better_than_no_k_and_than_no_compensation(
    plant: str, changes: dict[str, Any], gains: dict[str, float]
) -> None:
    played = compared(plant, changes, gains)
    for axis in "xy":
        off, without, with_K, table_number = (played.largest_error(v, axis) for v in "ABCD")
        assert with_K < min(0.99 * without, off)
        pole = (plant, changes, gains, axis) == ("nominal", SLOW, RHOMBUS, "x")
        assert (table_number < 0.99 * without) != pole  # its denominator still has a zero


def test_its_size_on_the_circle() -> None:
    """With e k_d/1000 in the denominator or without it: the same within a count."""
    expected = {"nominal": (2.22, 3.62), "matched": (9.60, 10.03)}  # um
    for plant, errors in expected.items():
        played = compared(plant, {}, {})
        for variant in "CD":
            found = [played.largest_error(variant, axis) * 1e6 for axis in "xy"]
            assert found == pytest.approx(errors, abs=0.06)


def test_with_feedforward_and_disturbance_observer_it_halves_the_error_of_lugre_full() -> None:
    changes = {"plant": "matched", "variants.A.controller": "lugre-full"}
    changes |= {"variants.B.controller": "lugre-full"}
    played = play("circle", changes | {"variants.B.controller.compensation.law": "reversed-k"})
    for axis in "xy":
        assert played.largest_error("B", axis) < 0.5 * played.largest_error("A", axis)


def test_k_is_the_filtered_force_balance_over_sigma_1() -> None:
    played = play("circle", SHORT | {"variants.B.controller": "reversed-k"})
    alpha = 1.0 - np.exp(-2.0 * np.pi * 30.0 * CONTROL_PERIOD)
    for axis, numbers in (("x", X), ("y", Y)):
        a = np.diff(played.channel("B", "velocity_measured", axis)) / CONTROL_PERIOD
        known = played.channel("B", "force_realised", axis)
        known = known - played.channel("B", "friction_estimate", axis)
        K = played.channel("B", "K", axis)
        expected = np.zeros_like(K)
        for k in range(1, len(K)):
            balance = numbers.M * a[k - 1] - known[k - 1]
            expected[k] = expected[k - 1] + alpha * (-balance / numbers.sigma_1 - expected[k - 1])
        assert pytest.approx(expected, abs=1e-4 * np.abs(K).max()) == K


@pytest.mark.parametrize("share", [0.0, 1e-3])
def test_a_model_without_bristle_damping_has_no_k(share: float) -> None:
    changes: dict[str, Any] = SHORT | {"variants.B.controller": "reversed-k"}
    changes |= {"variants.B.controller.compensation.k_d_share": share}
    model = "variants.B.controller.model.x.friction"
    for without in ({f"{model}.sigma_1": 0.0}, {f"{model}.enabled": False}):
        played = play("circle", changes | without)
        assert np.isfinite(played.samples("B")).all()
        if share == 0.0:
            assert not played.channel("B", "K", "x").any()


def test_a_share_of_k_d_has_no_linearisation() -> None:
    share = {"variants.B.controller.compensation.k_d_share": 1e-3}
    scenario = load_scenario("circle-reversed-k", share)
    with pytest.raises(ConfigError, match=r"k_d_share: has no linearisation"):
        linearise(scenario, "B", "x", v=0.02)
