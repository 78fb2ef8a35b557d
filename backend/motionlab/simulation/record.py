"""Samples of a simulation in the order of a ring's columns, a page at a time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.simulation.machine import Machine
from motionlab.simulation.simulation import variant_columns
from motionlab.telemetry.channels import CHANNELS, REFERENCES

_SHARED = len(AXES) * len(REFERENCES)


def record(simulation: Machine, page: NDArray[np.float32], columns: NDArray[np.float32]) -> int:
    """Advance a simulation as far as `Simulation.advance` goes at once, and record every channel.

    Parameters
    ----------
    simulation : Machine
        What to advance.
    page : ndarray
        From `sample_page`; overwritten.
    columns : ndarray of float32, shape (columns, ticks)
        Its first ticks are overwritten, in the order of `stream_columns`; a variant that diverged
        is NaN from there on.

    Returns
    -------
    int
        Number of ticks; 0 at the end of the run.
    """
    start = simulation.tick
    count = simulation.advance(page[:, : columns.shape[1]])
    if count == 0:
        return 0
    columns[:_SHARED, :count] = simulation.references(start, start + count)
    own = columns[_SHARED:, :count].reshape(-1, len(AXES), len(CHANNELS), count)
    for variant, failed in enumerate(simulation.failed_ticks):
        rows = own[variant]
        rows[:] = variant_columns(page, variant, count).transpose(1, 0, 2)
        if failed is not None:
            rows[..., max(0, failed - start) :] = np.nan
    return count
