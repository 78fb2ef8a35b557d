"""Test vectors of an exported controller: what went into it in a simulation, and what came out."""

from __future__ import annotations

import math
import struct

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.export.controller_step import ReferenceAhead, reference_of
from motionlab.kernel.build import LANES_PER_VARIANT, VARIANTS_PER_BLOCK
from motionlab.kernel.layout import state_row
from motionlab.laws import LAWS
from motionlab.plant.encoder import Subdivision
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.simulation import Simulation, sample_page
from motionlab.simulation.timeline import Timeline
from motionlab.telemetry.channels import Sample
from motionlab.timing import to_ticks

Array = NDArray[np.float64]

_MAGIC = b"PSRMVEC1"

_STATES = (
    "acting.current_a",
    "acting.current_b",
    "acting.current_c",
    "acting.force",
    "pending.estimate",
    "pending.K",
    "memory.d",
    "memory.v_last",
    "memory.e_last",
)
_SAMPLES = (
    "bristle_estimate",
    "pd_force",
    "force_command",
    "force_saturated",
    "current_saturated",
)
"""Signals that the simulation keeps in single precision only."""

_REPETITIONS = 20
SIGNALS = len(_STATES) + len(_SAMPLES)
"""Numbers of one axis in one control period after what goes in."""


def simulated_vectors(prepared: Prepared, variant: str, seconds: float) -> Array:
    """Simulate a scenario and return one variant's inputs and outputs.

    Parameters
    ----------
    prepared : Prepared
        What to run, from its start.
    variant : str
        One of its variants.
    seconds : float
        Longest time, s; the vectors end before if the scenario does, or a scheduled change of the
        controller comes, or the variant diverges.

    Returns
    -------
    ndarray, shape (ticks, 2, columns)
        For each axis the fields of the law's `reference_of`, measured position, then the SIGNALS in
        the order of check.c; SI.
    """
    place = list(prepared.scenario.variants).index(variant)
    block, pair = divmod(place, VARIANTS_PER_BLOCK)
    lanes = slice(pair * LANES_PER_VARIANT, (pair + 1) * LANES_PER_VARIANT)
    measured = state_row("memory.p_last")
    states = [state_row(path) for path in _STATES]
    channels = [Sample._fields.index(name) for name in _SAMPLES]

    model = prepared.scenario.variants[variant].controller.model
    plant = prepared.scenario.plant
    encoders = (plant.x.encoder, plant.y.encoder)
    known = [Subdivision(**each.subdivision.model_dump()) for each in (model.x, model.y)]
    ticks = min(to_ticks(seconds), _unchanged(prepared, variant))
    law = LAWS[prepared.scenario.variants[variant].controller.compensation.law]
    inputs = len(reference_of(law)._fields) + 1
    rows = np.empty((ticks, len(AXES), inputs + SIGNALS))
    rows[:, :, : inputs - 1] = _reference(prepared, ticks)[:, :, : inputs - 1]
    simulation = Simulation(prepared)
    samples = sample_page(len(prepared.scenario.variants))[:, :1].copy()
    for tick in range(ticks):
        simulation.advance(samples)
        state = simulation.snapshot().state[block, :, lanes]
        rows[tick, :, inputs - 1] = [
            reading_of(each, p, encoder.resolution) if each.sine or each.cosine else p
            for each, p, encoder in zip(known, state[measured].tolist(), encoders, strict=True)
        ]
        rows[tick, :, inputs : inputs + len(_STATES)] = state[states].T
        rows[tick, :, inputs + len(_STATES) :] = samples[block, 0, channels, lanes].T
    failed = simulation.failed_ticks[place]
    return rows if failed is None else rows[:failed]


def reading_of(known: Subdivision, position: float, resolution: float) -> float:
    """Return the reading, m, whose correction by what is known of the encoder is a position, m.

    By repetition, which comes closer by ``2 pi A/period`` each time, 0.01 for 40 nm of 20 um; then
    the count that it is, to the last bit.
    """
    reading = position
    for _ in range(_REPETITIONS):
        angle = 2.0 * math.pi * reading / known.period
        reading = position + known.sine * math.sin(angle) + known.cosine * math.cos(angle)
    return resolution * round(reading / resolution) if resolution > 0.0 else reading


def vector_file(vectors: Array) -> bytes:
    """Return the file that check.c reads, of vectors of shape (ticks, 2, columns)."""
    ticks, axes, columns = vectors.shape
    return _MAGIC + struct.pack("2d", ticks, axes * columns) + vectors.tobytes()


def _reference(prepared: Prepared, ticks: int) -> Array:
    """Return the fields of `ReferenceAhead`, shape (ticks, 2, fields)."""
    timeline = Timeline(prepared.reference, prepared.load)
    rows = np.empty((ticks, len(ReferenceAhead._fields), len(AXES)))
    rows[:, :3] = np.stack(timeline.at(0, ticks)[:3], axis=1)
    timeline.ahead(0, ticks, rows[:, 3:])
    return rows.transpose(0, 2, 1)


def _unchanged(prepared: Prepared, variant: str) -> int:
    """Return the tick at which the schedule first changes the controller, or the run ends."""

    def controller(scenario: Scenario) -> tuple[object, ...]:
        parts = (scenario.plant.force, scenario.divergence_error)
        return (scenario.variants[variant].controller, *parts)

    initial = controller(prepared.scenario)
    changed = (tick for tick, now in prepared.epochs if controller(now) != initial)
    return next(changed, prepared.reference.ticks)
