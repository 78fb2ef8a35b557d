"""The compensation laws on the circle, each within bounds on both sides, and how they switch."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.kernel.build import initial_state, lane_parameters
from motionlab.kernel.layout import SAMPLE_ROWS
from motionlab.kernel.tick import run_ticks
from motionlab.simulation.inputs import PAGE, page_inputs
from motionlab.simulation.prepare import prepare
from motionlab.simulation.timeline import Timeline
from motionlab.timing import CONTROL_PERIOD
from tests.simulated import SHORT, Played, play, same_bits

LUGRE = {"compensation.law": "lugre-observer"}
RESIDUAL = {"compensation.law": "residual-k"}
CANUDAS = {"compensation.law": "canudas-de-wit"}
FEEDFORWARD = {"feedforward": True}
OBSERVER = {"disturbance_observer.enabled": True}
BOTH = FEEDFORWARD | OBSERVER
REFERENCE = LUGRE | BOTH | {"compensation.velocity": "reference"}

# Largest following error, um: x with 200.3/1.53, y with 350/1.3 and 280.5/1.08 N/mm, N s/mm.
TABLE: dict[str, tuple[dict[str, Any], float, float, float]] = {
    "off": ({}, 20.53, 17.54, 22.40),
    "observer": (LUGRE, 2.57, 3.22, 4.02),
    "residual": (RESIDUAL, 2.32, 2.91, 3.61),
    "canudas-de-wit": (CANUDAS, 1.33, 2.01, 2.39),
    "disturbance observer": (OBSERVER, 8.29, 7.66, 9.62),
    "feedforward": (FEEDFORWARD, 18.61, 14.94, 19.18),
    "observer, feedforward": (LUGRE | FEEDFORWARD, 0.66, 0.61, 0.76),
    "observer, both": (LUGRE | BOTH, 0.25, 0.22, 0.27),
    "residual, both": (RESIDUAL | BOTH, 0.19, 0.165, 0.195),
    "canudas-de-wit, both": (CANUDAS | BOTH, 0.17, 0.16, 0.18),
    "reference, both at 80 Hz": (
        REFERENCE | {"disturbance_observer.bandwidth": 80.0},
        0.081,
        0.081,
        0.089,
    ),
}
LAWS = ["lugre-observer", "residual-k", "canudas-de-wit", "reversed-k", "published-k"]
ENCODER_COUNT = 0.05  # um


def controlled(law: dict[str, Any], variant: str, k_p: float, k_d: float) -> dict[str, Any]:
    """Return the changes that put PD with a law into a variant, with these gains on y."""
    controller = f"variants.{variant}.controller"
    changes: dict[str, Any] = {controller: "pd"}
    changes |= {f"{controller}.{key}": value for key, value in law.items()}
    changes |= {f"{controller}.x.k_p": 200.3e3, f"{controller}.x.k_d": 1530.0}
    return changes | {f"{controller}.y.k_p": k_p, f"{controller}.y.k_d": k_d}


def circle(law: dict[str, Any], **more: Any) -> Played:
    """Run a law on the nominal circle: A with 350/1.3 on y, B with 280.5/1.08."""
    changes = controlled(law, "A", 350e3, 1300.0) | controlled(law, "B", 280.5e3, 1080.0)
    return play("circle", changes | more)


@pytest.mark.parametrize("name", TABLE)
def test_largest_error_of_each_law(name: str) -> None:
    law, x, y, y_softer = TABLE[name]
    played = circle(law)
    found = [played.largest_error(*which) * 1e6 for which in (("A", "x"), ("A", "y"), ("B", "y"))]
    # a count for where the counts happen to fall, a hundredth for the model
    assert found == pytest.approx([x, y, y_softer], rel=0.01, abs=ENCODER_COUNT)


def test_order_of_the_laws() -> None:
    errors = {
        name: circle(TABLE[name][0]).largest_error("A", "x")
        for name in ("off", "disturbance observer", "observer", "residual", "canudas-de-wit")
    }
    assert list(errors.values()) == sorted(errors.values(), reverse=True)


def test_k_as_published_makes_it_worse() -> None:
    played = circle({"compensation.law": "published-k"})
    off = circle({})
    for variant, axis, low, high in (("A", "x", 50, 5000), ("A", "y", 300, 15000)):
        error = played.largest_error(variant, axis)
        assert low * 1e-6 < error < high * 1e-6  # chaotic: its order of magnitude only
        assert error > 3.0 * off.largest_error(variant, axis)
        assert np.isfinite(played.samples(variant)).all()


def test_k_as_published_is_tamer_with_its_state_clipped() -> None:
    law = {"compensation.law": "published-k", "compensation.bristle_limit": 1.0}
    played = circle(law)
    assert 35e-6 < played.largest_error("A", "x") < 60e-6
    assert 60e-6 < played.largest_error("A", "y") < 100e-6
    z_hat = np.abs(played.channel("A", "bristle_estimate", "x"))
    friction = played.prepared.scenario.variants["A"].controller.model.x.friction
    assert z_hat.max() == pytest.approx(friction.F_s / friction.sigma_0, rel=1e-5)


@pytest.mark.parametrize("resolution", [50e-9, 0.0])
def test_k_as_published_at_rest_is_a_number(resolution: float) -> None:
    # eq. (25) is 0/0 with the mover at rest on its reference
    changes: dict[str, Any] = {"trajectory": {"kind": "dwell", "duration": 0.5}}
    changes |= {f"plant.{axis}.encoder.resolution": resolution for axis in AXES}
    played = play("circle-published-k", changes)
    assert played.recording.variants["B"].diverged is None
    assert np.isfinite(played.samples("B")).all()
    assert not played.channel("B", "position", "x").any()


@pytest.mark.parametrize("law", LAWS)
def test_a_law_that_is_switched_off_runs_but_adds_nothing(law: str) -> None:
    played = play(
        "circle",
        SHORT
        | {
            "variants.B.controller.compensation.law": law,
            "variants.B.controller.compensation.enabled": False,
        },
    )
    motion = slice(0, 8)  # position ... friction: everything but the estimates
    assert same_bits(played.samples("A")[motion], played.samples("B")[motion])
    for axis in AXES:
        assert played.channel("B", "friction_estimate", axis).any()
        force = [played.recording.variants[v].channel("force_command", axis) for v in "AB"]
        assert same_bits(*force)


def test_an_observer_switched_on_has_the_state_of_one_that_always_ran() -> None:
    tick = 1500
    off = {"variants.B.controller.compensation.enabled": False}
    on = {"variants.B.controller.compensation.enabled": True}
    event = {"time": tick * CONTROL_PERIOD, "set": on}
    never = play("circle", SHORT | off)
    later = play("circle", SHORT | off | {"schedule": [event]})
    before, after = later.samples("B"), never.samples("B")
    assert same_bits(before[..., :tick].copy(), after[..., :tick].copy())
    for axis in AXES:
        estimate = later.channel("B", "friction_estimate", axis)
        assert estimate[tick] == never.channel("B", "friction_estimate", axis)[tick]
        # friction is known from the first tick on: no transient from z* = 0
        friction = later.channel("B", "friction", axis)[tick]
        assert estimate[tick] == pytest.approx(friction, abs=0.05 * abs(friction))
        jump = [run.channel("B", "force_command", axis)[tick] for run in (later, never)]
        assert jump[0] - jump[1] == pytest.approx(estimate[tick], abs=1e-5)


def test_a_schedule_is_a_run_cut_in_two() -> None:
    tick = 1200
    changes = {
        "variants.A.controller.y.k_p": 350e3,
        "variants.B.controller.feedforward": True,
        "plant.x.mass": 7.0,
    }
    event = {"time": tick * CONTROL_PERIOD, "set": changes}
    scheduled = play("circle", SHORT | {"schedule": [event]})

    first = load_scenario("circle", SHORT)
    prepared = prepare(first)
    reference = prepared.reference
    inputs = np.concatenate(
        [
            page_inputs(first, Timeline(reference, prepared.load), page)
            for page in range(-(-reference.ticks // PAGE))
        ]
    )
    start = reference.position[0]
    state = initial_state(1, (float(start[0]), float(start[1])))[0]
    samples = np.empty((reference.ticks, SAMPLE_ROWS, 8), dtype=np.float32)
    run_ticks(lane_parameters(first)[0], state, inputs[:tick], samples[:tick])
    second = load_scenario("circle", SHORT | changes)
    run_ticks(lane_parameters(second)[0], state, inputs[tick:], samples[tick:])

    for index, variant in enumerate("AB"):
        lanes = np.ascontiguousarray(samples[:, :, 2 * index : 2 * index + 2].transpose(1, 2, 0))
        assert same_bits(scheduled.samples(variant), lanes)


def test_loop_delay_of_one_tick() -> None:
    delayed = {f"variants.{variant}.controller.delay": 1 for variant in "AB"}
    at_once, late = play("circle", SHORT), play("circle", SHORT | delayed)
    for axis in AXES:
        command = at_once.channel("B", "force_command", axis)
        assert at_once.channel("B", "force_realised", axis) == pytest.approx(command, rel=1e-6)
        command = late.channel("B", "force_command", axis)
        realised = late.channel("B", "force_realised", axis)
        assert realised[0] == 0.0
        assert realised[1:] == pytest.approx(command[:-1], rel=1e-6)


def test_one_tick_of_delay_upsets_the_stiffest_gains() -> None:
    # the gains of the 0.5 um staircase sit at the stability boundary without any delay
    delayed = {"variants.A.controller.delay": 1, "trajectory.count": 1, "trajectory.dwell": 0.5}
    played = play("stair-x-500nm", delayed)
    assert 5e-6 < played.largest_error("A", "x") < 20e-6
    prompt = play("stair-x-500nm", delayed | {"variants.A.controller.delay": 0})
    assert prompt.largest_error("A", "x") < 0.7e-6


def test_the_observer_follows_the_reference_where_told() -> None:
    law = LUGRE | {"compensation.velocity": "reference"}
    changes = controlled(law, "A", 350e3, 1300.0) | controlled(LUGRE, "B", 350e3, 1300.0)
    played = play("circle", SHORT | changes)
    for axis in AXES:
        smooth, noisy = (
            np.abs(np.diff(played.channel(v, "friction_estimate", axis), n=2)).max() for v in "AB"
        )
        assert smooth < 0.5 * noisy


def test_k_of_each_law() -> None:
    laws = {"A": "lugre-observer", "B": "canudas-de-wit", "C": "residual-k"}
    played = play("circle", SHORT | {f"variants.{v}.controller": law for v, law in laws.items()})
    for axis in AXES:
        assert not played.channel("A", "K", axis).any()
        error = played.channel("B", "following_error", axis)
        assert played.channel("B", "K", axis) == pytest.approx(300.0 * error, rel=1e-6)
        friction = getattr(played.prepared.scenario.variants["C"].controller.model, axis).friction
        v = np.abs(played.channel("C", "velocity_measured", axis))
        level = friction.F_c + (friction.F_s - friction.F_c) * np.exp(-((v / friction.v_s) ** 2))
        D = friction.sigma_0 * (friction.sigma_1 * v / level - 1.0)
        K = played.channel("C", "K", axis)
        assert K[D < -1.0].any()
        assert not K[D > 1.0].any()


def test_the_realised_force_is_fed_back() -> None:
    # A load that the limited currents cannot hold: the command stays at its limit, the observer
    # hears of what the currents gave, and finds the load, not the command.
    load = 25.0
    changes = SHORT | {
        "variants.B.controller": "lugre-full",
        "variants.B.controller.current_limit": 5.0,
        "load.steps": [{"time": 1.0, "x": load}, {"time": 1.05, "x": -load}],
    }
    played = play("circle", changes)
    assert played.channel("B", "current_saturated", "x").any()
    assert np.abs(played.channel("B", "force_command", "x")).max() == 40.0
    realised = np.abs(played.channel("B", "force_realised", "x"))
    thrust = np.abs(played.channel("B", "thrust", "x"))
    assert realised.max() == pytest.approx(thrust.max(), rel=0.02)
    assert realised.max() < 21.0
    estimate = played.channel("B", "disturbance_estimate", "x")
    assert 0.9 * load < np.abs(estimate).max() < 1.2 * load
    assert np.abs(played.channel("B", "following_error", "x")[3000:]).max() < 2e-6
