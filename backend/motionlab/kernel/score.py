"""The kernel of batches: the same tick as a run's, keeping only what metrics are made of."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from motionlab.kernel.accumulator import MEASURED_ROWS, Measured, add_ticks
from motionlab.kernel.layout import (
    Inputs,
    PlantState,
    groups,
    read_state,
    reads_tables,
    state_row,
    write_state,
)
from motionlab.kernel.tick import tick
from motionlab.lanes import (
    WIDE,
    WIDTH,
    Lanes,
    axes_at,
    compiled,
    flush_subnormals,
    record,
    restore_mode,
    select,
    unpack,
)
from motionlab.lanes.bank import TABLES
from motionlab.telemetry.channels import Sample

Array = NDArray[np.float64]

CHUNK = 256
"""Ticks whose samples are kept at once: they stay in the processor's cache."""

_FAILED = state_row("failed")
_ERROR = Measured._fields.index("following_error")


@compiled
def _measured(sample: Sample) -> Measured:
    return Measured(
        following_error=sample.following_error,
        position=sample.position,
        velocity=sample.velocity,
        thrust=sample.thrust,
        current_a=sample.current_a,
        current_b=sample.current_b,
        current_c=sample.current_c,
        saturated=select(
            sample.force_saturated > sample.current_saturated,
            sample.force_saturated,
            sample.current_saturated,
        ),
    )


@compiled
def _score(  # noqa: PLR0913, PLR0917 - the kernel's arguments, and where samples go
    width: Lanes,
    parameters: Array,
    state: Array,
    inputs: Array,
    target: Array,
    before: int,
    tally: Array,
    errors: NDArray[np.float32],
    tables: Array | None,
) -> None:
    """Advance as many lanes as `width` has; see `score_ticks`."""
    par = groups(parameters, width)
    s = read_state(state, width)
    samples = np.empty((CHUNK, MEASURED_ROWS, state.shape[1]), dtype=np.float32)
    ticks = inputs.shape[0]
    mode = flush_subnormals()
    for begin in range(0, ticks, CHUNK):
        end = min(begin + CHUNK, ticks)
        for k in range(begin, end):
            s, sample = tick(par, s, axes_at(Inputs, inputs, k, width), tables)
            record(_measured(sample), samples, k - begin)
        start = max(begin, before)
        stop = min(end, before + target.shape[0])
        if start < stop:
            part = target[start - before : stop - before]
            add_ticks(samples[start - begin : stop - begin], part, start - before, tally, width)
        if errors.shape[0] > 0:
            errors[begin:end] = samples[: end - begin, _ERROR]
        write_state(s, state)
        if np.all(state[_FAILED] >= 0.0):
            break
    restore_mode(mode)
    write_state(s, state)


# One function for each width: numba keeps no compiled function that closes over another.


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _score_narrow(  # noqa: PLR0913, PLR0917 - as _score
    parameters: Array,
    state: Array,
    inputs: Array,
    target: Array,
    before: int,
    tally: Array,
    errors: NDArray[np.float32],
    tables: Array | None,
) -> None:
    _score(
        unpack(PlantState, state, 0, WIDTH).p,
        parameters,
        state,
        inputs,
        target,
        before,
        tally,
        errors,
        tables,
    )


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _score_wide(  # noqa: PLR0913, PLR0917 - as _score
    parameters: Array,
    state: Array,
    inputs: Array,
    target: Array,
    before: int,
    tally: Array,
    errors: NDArray[np.float32],
    tables: Array | None,
) -> None:
    _score(
        unpack(PlantState, state, 0, WIDE).p,
        parameters,
        state,
        inputs,
        target,
        before,
        tally,
        errors,
        tables,
    )


def score_ticks(  # noqa: PLR0913, PLR0917 - the kernel's arguments, and where samples go
    parameters: Array,
    state: Array,
    inputs: Array,
    target: Array,
    before: int,
    tally: Array,
    errors: NDArray[np.float32],
) -> None:
    """Advance eight or sixteen lanes by ``len(inputs)`` control periods and tally a window.

    Ends early once every lane has diverged. As in `motionlab.kernel.tick.run_ticks` lanes
    with and without tables each have a kernel of their own.

    Parameters
    ----------
    parameters, state, inputs : ndarray
        As `run_ticks` takes them.
    target : ndarray, shape (ticks, 1, 2)
        Position reference over the window, m.
    before : int
        Ticks from the first input to the window's start; negative inside of the window.
    tally : ndarray, shape (TALLY_ROWS, lanes)
        Overwritten with what the window's ticks add to it.
    errors : ndarray of float32, shape (ticks or 0, lanes)
        Overwritten with the following error at every tick, m; empty where it is not wanted.
    """
    score = _score_narrow if parameters.shape[1] == WIDTH else _score_wide
    tabled = reads_tables(parameters)
    if not any(tabled):
        score(parameters, state, inputs, target, before, tally, errors, None)
        return
    kept = state.copy(), tally.copy(), np.empty_like(errors)
    score(parameters, state, inputs, target, before, tally, errors, TABLES.values)
    if all(tabled):
        return
    score(parameters, kept[0], inputs, target, before, kept[1], kept[2], None)
    plain = [not lane for lane in tabled]
    for own, other in zip((state, tally, errors), kept, strict=True):
        own[:, plain] = other[:, plain]
