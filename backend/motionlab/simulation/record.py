"""Samples of a simulation in the order of a ring's columns, a page at a time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.simulation.machine import Machine
from motionlab.simulation.simulation import variant_columns
from motionlab.telemetry.channels import CHANNELS, REFERENCES
from motionlab.telemetry.law_channels import StateColumn

_SHARED = len(AXES) * len(REFERENCES)


def record(
    simulation: Machine,
    page: NDArray[np.float32],
    columns: NDArray[np.float32],
    states: Sequence[StateColumn] = (),
) -> int:
    """Advance a simulation as far as `Simulation.advance` goes at once, and record every channel.

    Parameters
    ----------
    simulation : Machine
        What to advance.
    page : ndarray
        From `sample_page`; overwritten.
    columns : ndarray of float32, shape (columns, ticks)
        Its first ticks are overwritten, in the order of `stream_columns`, then that of `states`; a
        variant that diverged is NaN from there on.
    states : sequence of StateColumn
        States of laws to be recorded; the page has rows for them.

    Returns
    -------
    int
        Number of ticks; 0 at the end of the run.
    """
    start, scenario = simulation.tick, simulation.scenario
    count = simulation.advance(page[:, : columns.shape[1]])
    if count == 0:
        return 0
    columns[:_SHARED, :count] = simulation.references(start, start + count)
    end = len(columns) - len(states)
    own = columns[_SHARED:end, :count].reshape(-1, len(AXES), len(CHANNELS), count)
    for variant, failed in enumerate(simulation.failed_ticks):
        rows = own[variant]
        rows[:] = variant_columns(page, variant, count)[: len(CHANNELS)].transpose(1, 0, 2)
        if failed is not None:
            rows[..., max(0, failed - start) :] = np.nan
    if states:
        failed_ticks = simulation.failed_ticks
        write_states(scenario, states, page, columns[end:, :count])
        for row, each in enumerate(states, end):
            failed = failed_ticks[list(scenario.variants).index(each.variant)]
            if failed is not None:
                columns[row, max(0, failed - start) : count] = np.nan
    return count


def write_states(
    scenario: Scenario,
    states: Sequence[StateColumn],
    page: NDArray[np.float32],
    columns: NDArray[np.float32],
) -> None:
    """Write the states of the laws in effect into columns, (states, ticks); NaN of other laws."""
    count = columns.shape[1]
    variants = list(scenario.variants)
    for column, each in zip(columns, states, strict=True):
        law = scenario.variants[each.variant].controller.compensation.law
        if (row := each.rows.get(law)) is None:
            column[:] = np.nan
        else:
            samples = variant_columns(page, variants.index(each.variant), count)
            column[:] = samples[len(CHANNELS) + row, each.axis]
