"""Inputs common to all variants: reference, load, and the draws of every noise source.

Time is cut into pages of PAGE ticks. Each noise source of each axis draws every page from a
generator of its own, keyed by (seed, source, axis, page): draws never depend on what a controller
does, on another source being switched on, or on how a run is cut into pieces.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import Epochs
from motionlab.config.plant import AmplifierConfig
from motionlab.config.scenario import LoadConfig, Scenario
from motionlab.kernel.layout import INPUT_ROWS, Inputs
from motionlab.kernel.motion import Ahead
from motionlab.laws import OWN
from motionlab.simulation.timeline import Timeline
from motionlab.timing import CONTROL_PERIOD, to_ticks

PAGE = 1024
"""Ticks in one page."""

_ROW = {name: row for row, name in enumerate(Inputs._fields)}
_ENCODER, _LOAD, _CURRENT = 0, 1, 2  # noise sources; phase k of the currents is _CURRENT + k
_JITTER = _CURRENT + 3
_PHASES = ("current_a", "current_b", "current_c")


def load_force(load: LoadConfig, stop: int, start: int = 0) -> NDArray[np.float64]:
    """Return the external load force without its noise over [start, stop), N, shape (n, 2)."""
    force = np.tile((load.x, load.y), (stop - start, 1)).astype(np.float64)
    for step in load.steps:
        force[max(to_ticks(step.time) - start, 0) :] += (step.x, step.y)
    return force


def input_rows() -> int:
    """Return the rows of inputs: laws that ship do not look ahead, those of one's own may."""
    return INPUT_ROWS + (len(Ahead._fields) if OWN else 0)


def page_inputs(scenario: Scenario, timeline: Timeline, page: int) -> NDArray[np.float64]:
    """Return the kernel's inputs over one page.

    Parameters
    ----------
    scenario : Scenario
        Parameters that hold over the page.
    timeline : Timeline
        Reference and load; the load's noise is added here.
    page : int
        Which page; the last one of a run may be shorter than PAGE.

    Returns
    -------
    ndarray, shape (ticks in the page, input_rows(), 2)
        Fields of `Inputs` for x and y, then those of `Ahead` where there are laws that may use it.
    """
    start = page * PAGE
    stop = start + PAGE if timeline.end is None else min(start + PAGE, timeline.end)
    count = stop - start
    inputs = np.zeros((count, input_rows(), 2))
    for name, values in zip(
        ("p_ref", "v_ref", "a_ref", "load"), timeline.at(start, stop), strict=True
    ):
        inputs[:, _ROW[name]] = values
    if scenario.learnt is not None:
        inputs[:, _ROW["learnt"]] = timeline.learnt(scenario.learnt, start, stop)
    if inputs.shape[1] > INPUT_ROWS:
        timeline.ahead(start, stop, inputs[:, INPUT_ROWS:])
    for axis, config in enumerate((scenario.plant.x, scenario.plant.y)):

        def draw(source: int, rms: float, axis: int = axis) -> NDArray[np.float64] | float:
            if rms == 0.0:
                return 0.0
            key = (source, axis, page)
            generator = np.random.Generator(
                np.random.Philox(np.random.SeedSequence(scenario.seed, spawn_key=key))
            )
            return rms * generator.standard_normal(PAGE)[:count]

        inputs[:, _ROW["load"], axis] += draw(_LOAD, scenario.load.noise)
        inputs[:, _ROW["encoder_noise"], axis] = draw(_ENCODER, config.encoder.noise)
        inputs[:, _ROW["encoder_jitter"], axis] = draw(_JITTER, config.encoder.jitter)
        for phase, name in enumerate(_PHASES):
            noise = draw(_CURRENT + phase, config.amplifiers.noise)
            if config.amplifiers.ripple_amplitude > 0.0:
                noise += _ripple(config.amplifiers, start, phase)[:count]
            inputs[:, _ROW[name], axis] = noise
    return inputs


def inputs_over(epochs: Epochs, timeline: Timeline, start: int, stop: int) -> NDArray[np.float64]:
    """Return the kernel's inputs over ticks [start, stop), shape (stop - start, INPUT_ROWS, 2)."""
    ends = [*(tick for tick, _ in epochs[1:]), stop]
    parts = []
    for (begin, scenario), end in zip(epochs, ends, strict=True):
        first, last = max(begin, start), min(end, stop)
        for page in range(first // PAGE, -(-last // PAGE) if first < last else 0):
            offset = page * PAGE
            inputs = page_inputs(scenario, timeline, page)
            parts.append(inputs[max(first - offset, 0) : last - offset])
    return np.concatenate(parts)


def _ripple(config: AmplifierConfig, start: int, phase: int) -> NDArray[np.float64]:
    """Return one page of ripple current of one phase, A; always a whole page, for equal bits."""
    turns = config.ripple_frequency * (start + np.arange(PAGE)) * CONTROL_PERIOD - phase / 3.0
    return config.ripple_amplitude * np.sin(2.0 * np.pi * turns)
