"""The same scenario gives the same bits, whatever runs beside it and however it is cut."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.kernel.build import initial_state, lane_parameters
from motionlab.kernel.layout import SAMPLE_ROWS, Inputs, state_row
from motionlab.kernel.tick import run_ticks
from motionlab.simulation.inputs import PAGE, page_inputs
from motionlab.simulation.prepare import prepare
from motionlab.simulation.simulation import Simulation
from motionlab.simulation.timeline import Timeline
from motionlab.telemetry.channels import CHANNELS
from motionlab.timing import CONTROL_PERIOD
from tests.simulated import SHORT, Played, play, same_bits

NOISY: dict[str, Any] = SHORT | {
    "plant": "matched",
    "plant.x.encoder.noise": 20e-9,
    "plant.y.encoder.noise": 20e-9,
    "plant.x.amplifiers.noise": 0.02,
    "plant.y.amplifiers.noise": 0.02,
    "plant.x.amplifiers.ripple_amplitude": 0.05,
    "load.noise": 0.5,
}
# Without gains on x the mover stays where it is, and the reference runs away from it.
LIMP = {"x": {"k_p": 0.0, "k_d": 0.0}, "y": {"k_p": 280.5e3, "k_d": 1080.0}}


def controller(played: Played, variant: str) -> Any:
    """Return a variant's resolved controller as tables."""
    return played.prepared.scenario.variants[variant].controller.model_dump(mode="json")


def test_the_same_scenario_gives_the_same_bits() -> None:
    first, second = play("circle", NOISY), play("circle", NOISY)
    for variant in "AB":
        assert same_bits(first.samples(variant), second.samples(variant))
    assert same_bits(first.recording.references, second.recording.references)


def test_another_seed_gives_other_noise() -> None:
    first, second = play("circle", NOISY), play("circle", NOISY | {"seed": 1})
    for variant in "AB":
        assert not same_bits(first.samples(variant), second.samples(variant))


def test_swapping_the_controllers_swaps_the_recordings() -> None:
    straight = play("circle", NOISY)
    A, B = controller(straight, "A"), controller(straight, "B")
    turned = play("circle", NOISY | {"variants.A.controller": B, "variants.B.controller": A})
    assert same_bits(straight.samples("A"), turned.samples("B"))
    assert same_bits(straight.samples("B"), turned.samples("A"))
    assert not same_bits(straight.samples("A"), straight.samples("B"))


def test_more_variants_leave_the_others_alone() -> None:
    # four variants fill one block of lanes, the fifth opens another
    alone = play("circle", NOISY)
    others = ["residual-k", "published-k", "lugre-full", "lugre-observer"]
    for count in (1, 4):
        added = {f"variants.{'CDEF'[i]}.controller": others[i] for i in range(count)}
        together = play("circle", NOISY | added)
        for variant in "AB":
            assert same_bits(alone.samples(variant), together.samples(variant))
    # the same controller in the other block, in another place, gives the same bits there
    moved = NOISY | added | {"variants.F.controller": controller(alone, "B")}
    assert same_bits(alone.samples("B"), play("circle", moved).samples("F"))


def test_noise_does_not_depend_on_the_controller() -> None:
    noise = {"plant.x.encoder.noise": 1e-6, "plant.x.encoder.resolution": 0.0}
    played = play("circle", SHORT | noise)
    seen = [
        played.channel(variant, "position_measured", "x") - played.channel(variant, "position", "x")
        for variant in "AB"
    ]
    assert np.std(seen[0]) == pytest.approx(1e-6, rel=0.05)
    assert seen[0] == pytest.approx(seen[1], abs=4e-9)  # float32 of 15 mm
    assert same_bits(played.recording.references, play("circle", SHORT).recording.references)


SOURCES = {
    "load": {"load.noise": 1.0},
    "encoder_noise": {"plant.x.encoder.noise": 1e-7, "plant.y.encoder.noise": 1e-7},
    "current_a": {"plant.x.amplifiers.noise": 0.1, "plant.y.amplifiers.noise": 0.1},
}


def inputs(changes: dict[str, Any], page: int) -> dict[str, np.ndarray]:
    """Return what acts on the plant over one page, by name, shape (ticks, axes)."""
    prepared = prepare(load_scenario("circle", SHORT | changes))
    rows = page_inputs(prepared.scenario, Timeline(prepared.reference, prepared.load), page)
    return {name: rows[:, i].copy() for i, name in enumerate(Inputs._fields)}


@pytest.mark.parametrize("page", [0, 3])
@pytest.mark.parametrize("source", SOURCES)
def test_a_source_does_not_notice_the_others(source: str, page: int) -> None:
    alone = inputs(SOURCES[source], page)
    together = inputs({k: v for changes in SOURCES.values() for k, v in changes.items()}, page)
    assert np.std(alone[source]) > 0.0
    assert same_bits(alone[source], together[source])
    quiet = inputs({}, page)
    for other in SOURCES.keys() - {source}:
        assert not quiet[other].any()
        assert same_bits(alone[other], quiet[other])


def test_draws_are_independent() -> None:
    changes = {k: v for changes in SOURCES.values() for k, v in changes.items()}
    names = ("load", "encoder_noise", "current_a", "current_b", "current_c")
    draws = np.concatenate(
        [[inputs(changes, page)[name].T for name in names] for page in (0, 1)]
    ).reshape(-1, PAGE)
    draws /= draws.std(axis=1, keepdims=True)
    assert draws.shape[0] == 20  # sources, axes, pages
    correlation = np.abs(draws @ draws.T / PAGE - np.eye(len(draws)))
    assert correlation.max() < 5.0 / np.sqrt(PAGE)


@pytest.mark.parametrize("size", [1, 7, 1000])
def test_the_recording_does_not_depend_on_how_it_is_cut(size: int) -> None:
    changes = NOISY | {
        "schedule": [
            {"time": 0.7775, "set": {"variants.B.controller": "lugre-full", "load.noise": 1.0}}
        ]
    }
    whole = play("circle", changes)
    simulation = Simulation(whole.prepared)
    buffer = np.empty((1, size, SAMPLE_ROWS, 8), dtype=np.float32)
    pieces = []
    while count := simulation.advance(buffer):
        assert count <= size
        pieces.append(buffer[0, :count].copy())
    lanes = np.concatenate(pieces)
    assert simulation.tick == len(lanes) == whole.prepared.reference.ticks
    for index, variant in enumerate("AB"):
        cut = np.ascontiguousarray(lanes[:, :, 2 * index : 2 * index + 2].transpose(1, 2, 0))
        assert same_bits(cut, whole.samples(variant))


def test_a_scheduled_load_is_a_load_step() -> None:
    event = {"time": 1.0, "set": {"load.x": 3.0}}
    scheduled = play("circle", NOISY | {"schedule": [event]})
    stepped = play("circle", NOISY | {"load.steps": [{"time": 1.0, "x": 3.0}]})
    assert scheduled.recording.references[3, 0].max() == 3.0
    for variant in "AB":
        assert same_bits(scheduled.samples(variant), stepped.samples(variant))


# -- divergence -----------------------------------------------------------------------------------


def test_a_variant_that_diverges_ends_alone() -> None:
    healthy = play("circle", NOISY)
    controllers = controller(healthy, "B") | LIMP
    played = play("circle", NOISY | {"variants.B.controller": controllers})
    assert same_bits(healthy.samples("A"), played.samples("A"))
    assert played.recording.variants["A"].diverged is None

    diverged = played.recording.variants["B"].diverged
    assert diverged is not None
    assert diverged.channel == "x.following_error"
    assert diverged.time == diverged.tick * CONTROL_PERIOD
    samples = played.samples("B")
    assert np.isfinite(samples[..., : diverged.tick]).all()
    assert np.isnan(samples[..., diverged.tick :]).all()
    limit = played.prepared.scenario.divergence_error
    error = np.abs(played.channel("B", "following_error", "x")[: diverged.tick])
    assert 0.9 * limit < error.max() <= limit


def test_a_diverged_variant_leaves_its_last_states() -> None:
    played = play("circle", NOISY | {"divergence_error": 10e-6})
    diverged = played.recording.variants["A"].diverged
    assert diverged is not None
    last = diverged.last_states
    assert len(last) == 5
    assert set(last[0]) == {f"{axis}.{channel.name}" for axis in AXES for channel in CHANNELS}
    assert abs(last[-1][diverged.channel]) > 10e-6
    assert max(abs(state[diverged.channel]) for state in last[:-1]) <= 10e-6
    recorded = played.channel("A", "position", "y")[diverged.tick - 4 : diverged.tick]
    assert [state["y.position"] for state in last[:-1]] == list(recorded)


def test_the_place_of_divergence_does_not_depend_on_the_neighbours() -> None:
    alone = play("circle", SHORT | {"variants.A.controller.x": LIMP["x"]})
    crowd = {f"variants.{name}.controller": "residual-k" for name in "CDEFG"}
    together = play("circle", SHORT | {"variants.A.controller.x": LIMP["x"]} | crowd)
    first, second = (run.recording.variants["A"].diverged for run in (alone, together))
    assert first is not None
    assert second is not None
    assert (first.tick, first.channel) == (second.tick, second.channel)


@pytest.mark.parametrize("poison", [np.nan, np.inf])
@pytest.mark.parametrize("where", ["parameters", "state"])
def test_poison_stays_in_its_lane(where: str, poison: float) -> None:
    scenario = load_scenario("circle", NOISY)
    prepared = prepare(scenario)
    start = prepared.reference.position[0]
    rows = page_inputs(scenario, Timeline(prepared.reference, prepared.load), 0)

    def go(lane: int | None) -> tuple[np.ndarray, np.ndarray]:
        parameters = lane_parameters(scenario)[0]
        state = initial_state(1, (float(start[0]), float(start[1])))[0]
        if lane is not None:
            (parameters if where == "parameters" else state)[:2, lane] = poison
        samples = np.empty((len(rows), SAMPLE_ROWS, 8), dtype=np.float32)
        run_ticks(parameters, state, rows, samples)
        return samples, state[state_row("failed")]

    clean, failed = go(None)
    assert (failed == -1.0).all()
    for lane in (0, 3, 7):
        samples, failed = go(lane)
        others = [k for k in range(8) if k != lane]
        assert same_bits(samples[..., others].copy(), clean[..., others].copy())
        assert not np.isfinite(samples[..., lane]).all()
        assert failed[lane] >= 0.0
        assert (failed[others] == -1.0).all()
