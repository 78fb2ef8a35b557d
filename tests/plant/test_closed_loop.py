"""The plant in the closed loop: amplifiers, encoder, end stops, symmetries, energy."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.telemetry.channels import CHANNELS
from motionlab.timing import CONTROL_PERIOD
from tests.simulated import FRICTIONLESS, SHORT, Played, play, same_bits

PHASES = ("a", "b", "c")
SINE: dict[str, Any] = {
    "kind": "sine",
    "amplitude": {"x": 0.02, "y": 0.03},
    "phase": {"x": 0.0, "y": 1.0},
    "frequency": 0.5,
    "cycles": 1,
    "lead_in": 0.5,
}


def settled(played: Played, axis: str, phase: str, **amplifier: Any) -> float:
    """Return by how much a recorded current misses the first-order loop's exact response, A."""
    command = played.channel("A", f"current_command_{phase}", axis)
    current = played.channel("A", f"current_{phase}", axis)
    gain, offset = amplifier.get("gain", 1.0), amplifier.get("offset", 0.0)
    limit, bandwidth = amplifier.get("limit", 10.0), amplifier.get("bandwidth", 1000.0)
    rest = 0.0 if bandwidth is None else math.exp(-2.0 * math.pi * bandwidth * CONTROL_PERIOD)
    target = np.clip(gain * command[:-1] + offset, -limit, limit)
    expected = target + rest * (current[:-1] - target)
    return float(np.abs(current[1:] - expected).max())


@pytest.mark.parametrize("bandwidth", [1000.0, 200.0, None])
def test_current_follows_its_command_with_the_bandwidth(bandwidth: float | None) -> None:
    changes = SHORT | {f"plant.{axis}.amplifiers.bandwidth": bandwidth for axis in AXES}
    played = play("circle", changes)
    for axis in AXES:
        for phase in PHASES:
            assert played.channel("A", f"current_{phase}", axis).max() > 1.0
            assert settled(played, axis, phase, bandwidth=bandwidth) < 2e-6


def test_current_has_gain_offset_and_limit() -> None:
    gain, offset, limit = [1.05, 0.9, 1.0], [0.1, -0.2, 0.3], 3.0
    changes = SHORT | {
        "plant.x.amplifiers.gain": gain,
        "plant.x.amplifiers.offset": offset,
        "plant.x.amplifiers.limit": limit,
    }
    played = play("circle", changes)
    for index, phase in enumerate(PHASES):
        amplifier = {"gain": gain[index], "offset": offset[index], "limit": limit}
        assert settled(played, "x", phase, **amplifier) < 2e-6
        assert settled(played, "x", phase) > 0.05
        assert settled(played, "y", phase) < 2e-6


def test_current_ripple() -> None:
    amplitude, frequency = 0.2, 300.0
    changes = SHORT | {
        "plant.x.amplifiers.ripple_amplitude": amplitude,
        "plant.x.amplifiers.ripple_frequency": frequency,
        "plant.x.amplifiers.bandwidth": None,
    }
    played = play("circle", changes)
    for index, phase in enumerate(PHASES):
        command = played.channel("A", f"current_command_{phase}", "x")[:-1]
        ripple = played.channel("A", f"current_{phase}", "x")[1:] - command
        t = np.arange(ripple.size) * CONTROL_PERIOD
        expected = amplitude * np.sin(2.0 * np.pi * (frequency * t - index / 3.0))
        assert ripple == pytest.approx(expected, abs=2e-6)


def test_encoder_counts() -> None:
    resolution = 50e-9
    played = play("circle", SHORT)
    for axis in AXES:
        counts = played.channel("A", "position_measured", axis) / resolution
        assert np.abs(counts - np.rint(counts)).max() < 0.03  # float32 of 15 mm is 1 nm
        missed = played.channel("A", "position_measured", axis) - played.channel(
            "A", "position", axis
        )
        assert np.abs(missed).max() < 0.5 * resolution + 2e-9
        assert np.abs(missed).max() > 0.4 * resolution
        assert np.std(missed) == pytest.approx(resolution / math.sqrt(12.0), rel=0.05)


def test_encoder_sub_divisional_error() -> None:
    amplitude, period = 40e-9, 20e-6
    changes = {
        "trajectory": {"kind": "sine", "amplitude": {"x": 1e-4}, "frequency": 1.0, "cycles": 1},
        "plant.x.encoder": {"resolution": 0.0, "sde_amplitude": amplitude, "sde_period": period},
    }
    played = play("circle", changes)
    position = played.channel("A", "position", "x")
    error = played.channel("A", "position_measured", "x") - position
    assert error == pytest.approx(amplitude * np.sin(2 * np.pi * position / period), abs=1e-10)


def test_an_exact_encoder_reads_the_position() -> None:
    played = play("circle", SHORT | {"plant.x.encoder.resolution": 0.0})
    samples = played.recording.variants["A"]
    assert same_bits(samples.channel("position", "x"), samples.channel("position_measured", "x"))


def test_ideal_force_is_the_command() -> None:
    played = play("circle", SHORT | {"plant.force": "ideal"})
    for axis in AXES:
        samples = played.recording.variants["A"]
        command = samples.channel("force_command", axis)
        assert same_bits(samples.channel("thrust", axis), command)
        assert same_bits(samples.channel("force_realised", axis), command)
        assert not samples.channel("normal_force", axis).any()
        assert not samples.channel("current_saturated", axis).any()


def test_no_friction_without_friction() -> None:
    played = play("circle", SHORT | FRICTIONLESS)
    for axis in AXES:
        assert not played.channel("A", "friction", axis).any()
        # what is left is the inertia of the circle, eq. (42)
        assert played.largest_error("A", axis) < 3.5e-6


IMPERFECTIONS: dict[str, tuple[Any, Any]] = {
    "amplifiers.gain": ([1.1, 0.9, 1.0], [1.0, 1.0, 1.0]),
    "amplifiers.offset": ([0.2, -0.2, 0.1], [0.0, 0.0, 0.0]),
    "amplifiers.ripple_amplitude": (0.1, 0.0),
    "amplifiers.noise": (0.05, 0.0),
    "amplifiers.bandwidth": (300.0, 1000.0),
    "encoder.sde_amplitude": (40e-9, 0.0),
    "encoder.noise": (20e-9, 0.0),
    "encoder.resolution": (1e-6, 50e-9),
    "force_map.h_2": (0.05, 0.0),
    "force_map.h_3": (0.039, 0.0),
    "force_map.offset": (2e-4, 0.0),
    "force_map.F_pk": (38.4, 34.1),
}


@pytest.mark.parametrize("field", IMPERFECTIONS)
def test_each_imperfection_acts_and_can_be_switched_off(field: str) -> None:
    nominal = play("circle", SHORT)
    on, off = IMPERFECTIONS[field]
    with_it = play("circle", SHORT | {f"plant.x.{field}": on})
    without = play("circle", SHORT | {f"plant.x.{field}": off})
    assert same_bits(without.samples("A"), nominal.samples("A"))
    acts = with_it.channel("A", "position", "x") - nominal.channel("A", "position", "x")
    assert np.abs(acts).max() > 1e-9
    assert same_bits(with_it.samples("A")[:, 1], nominal.samples("A")[:, 1])  # y: untouched


def test_end_stops_keep_the_mover_in() -> None:
    load = -60.0  # pushes towards positive positions with more than the motor can hold
    played = play("circle", SHORT | {"load.x": load, "divergence_error": 1.0})
    axis = played.prepared.scenario.plant.x
    stop = axis.stroke + axis.stop_distance
    position = played.channel("A", "position", "x")
    assert stop < position.max() < stop + 1e-3
    thrust = played.channel("A", "thrust", "x")[-1]
    rest = stop + (-load + thrust) / axis.stop_stiffness
    assert position[-1] == pytest.approx(rest, abs=1e-6)
    assert abs(played.channel("A", "velocity", "x")[-1]) < 1e-3


def swapped_axes(tables: Any) -> Any:
    """Return tables with what belongs to x and to y exchanged."""
    if isinstance(tables, dict):
        other = {"x": "y", "y": "x"}
        return {other.get(key, key): swapped_axes(value) for key, value in tables.items()}
    return tables


def test_swapping_the_axes_swaps_the_results() -> None:
    scenario = load_scenario("circle", {"trajectory": SINE, "load.x": 0.5, "load.y": -0.3})
    tables = scenario.model_dump(mode="json")
    straight, turned = play(tables), play(swapped_axes(tables))
    for variant in "AB":
        assert same_bits(straight.samples(variant)[:, 0], turned.samples(variant)[:, 1])
        assert same_bits(straight.samples(variant)[:, 1], turned.samples(variant)[:, 0])
    assert not same_bits(straight.samples("A")[:, 0], turned.samples("A")[:, 0])


EVEN = {"normal_force", "force_saturated", "current_saturated", "current_a", "current_command_a"}
CHANGES_PLACES = {"current_b", "current_c", "current_command_b", "current_command_c"}


def test_mirrored_motion_mirrors_the_result() -> None:
    exact = {f"plant.{axis}.encoder.resolution": 0.0 for axis in AXES}
    mirrored = SINE | {"amplitude": {"x": -0.02, "y": -0.03}}
    one = play("circle", exact | {"trajectory": SINE})
    two = play("circle", exact | {"trajectory": mirrored})
    for axis in AXES:
        for name in (channel.name for channel in CHANNELS):
            if name in CHANGES_PLACES:
                continue
            sign = 1.0 if name in EVEN else -1.0
            first, second = one.channel("B", name, axis), sign * two.channel("B", name, axis)
            assert second == pytest.approx(first, abs=1e-6 * np.abs(first).max()), name
        b = one.channel("B", "current_b", axis)
        assert two.channel("B", "current_c", axis) == pytest.approx(b, abs=1e-5)


def work(force: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Return the work done up to each tick by a force that varies linearly in each period, J."""
    mean = 0.5 * (force[1:] + force[:-1])
    return np.concatenate(([0.0], np.cumsum(mean * np.diff(position))))


@pytest.mark.parametrize("variant", ["A", "B"])
@pytest.mark.parametrize("axis", AXES)
def test_energy_balance(variant: str, axis: str) -> None:
    load = {"load.x": 2.0, "load.y": -3.0}
    played = play("circle", load | {"trajectory": SINE, "plant.force": "ideal"})
    mass = getattr(played.prepared.scenario.plant, axis).mass
    position, velocity = (played.channel(variant, c, axis) for c in ("position", "velocity"))
    # the ideal force is held over each period, so its work is exact
    held = played.channel(variant, "thrust", axis)[:-1] * np.diff(position)
    thrust = np.concatenate(([0.0], np.cumsum(held)))
    friction = work(played.channel(variant, "friction", axis), position)
    against_load = load[f"load.{axis}"] * (position - position[0])
    kinetic = 0.5 * mass * velocity**2
    left = thrust - (kinetic + friction + against_load)
    turned_over = np.abs(held).sum()
    assert turned_over > 0.1
    assert np.abs(left).max() < 2e-3 * turned_over


@pytest.mark.parametrize("axis", AXES)
def test_friction_is_passive(axis: str) -> None:
    played = play("circle", {"trajectory": SINE})
    position, friction = (played.channel("A", c, axis) for c in ("position", "friction"))
    lost = work(friction, position)
    assert lost.min() > -1e-6  # never gives back more than it took
    moving = np.abs(played.channel("A", "velocity", axis)) > 0.01
    power = friction[moving] * played.channel("A", "velocity", axis)[moving]
    assert power.min() > 0.0
    # Coulomb friction alone would take this much over the way travelled
    F_c = getattr(played.prepared.scenario.plant, axis).friction.F_c
    assert lost[-1] > F_c * np.abs(np.diff(position)).sum()
