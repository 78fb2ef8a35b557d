"""The loop's controller is that of the simulation, bit for bit on the same positions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.drive.link.commanding import UNKNOWN
from motionlab.drive.motion import held_parameters, on_drives
from motionlab.kernel.layout import INPUT_ROWS, STATE_ROWS, state_row
from motionlab.kernel.tick import run_lanes
from motionlab.lanes import WIDTH
from motionlab.telemetry.channels import CHANNELS, Sample
from tests.simulated import SHORT, play

LAWS = ("off", "lugre-observer", "published-k", "residual-k", "canudas-de-wit", "reversed-k")
MACHINE = {
    "current_a",
    "current_b",
    "current_c",
    "load_force",
} | {CHANNELS[row].name for row in UNKNOWN}
"""Channels of the machine: the drives' own currents, and what nothing measures."""


@pytest.mark.parametrize("law", LAWS)
def test_a_recording_gives_the_same_bits_in_the_loop(law: str) -> None:
    changes: dict[str, Any] = SHORT | {
        "variants.B.controller.compensation.law": law,
        "variants.B.controller.delay": 1,
        "variants.B.controller.disturbance_observer.enabled": True,
    }
    simulated = play("circle", changes)
    samples = simulated.samples("B")
    reference = simulated.prepared.reference
    resolution = simulated.prepared.scenario.plant.x.encoder.resolution
    parameters = held_parameters(on_drives(load_scenario("circle", changes), "B"))
    state = np.zeros((STATE_ROWS, WIDTH))
    state[state_row("failed")] = -1.0
    inputs, out = np.zeros((1, INPUT_ROWS, 2)), np.zeros((1, len(CHANNELS), WIDTH), np.float32)
    measured = samples[Sample._fields.index("position_measured")]
    ticks = round(0.5 / CONTROL_PERIOD)
    replayed = np.empty((len(CHANNELS), 2, ticks), np.float32)
    for k in range(ticks):
        counts = np.rint(measured[:, k].astype(np.float64) / resolution)
        state[state_row("plant.p")] = np.tile(resolution * counts, WIDTH // 2)
        for row, values in enumerate(
            (reference.position, reference.velocity, reference.acceleration)
        ):
            inputs[0, row] = values[k]
        run_lanes(parameters, state, inputs, out, None)
        replayed[:, :, k] = out[0, :, :2]
    assert np.abs(replayed[Sample._fields.index("force_command")]).max() > 1.0
    for row, channel in enumerate(CHANNELS):
        if channel.name not in MACHINE:
            np.testing.assert_array_equal(replayed[row], samples[row, :, :ticks], channel.name)
