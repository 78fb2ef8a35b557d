"""The kernel of batches: a run's tick that accumulates metrics only."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.kernel.accumulator import MEASURED_ROWS, MeasuredChannels, add_ticks
from motionlab.kernel.law_calls import Laws, enter_laws, laws_of, leave_laws, look_ahead
from motionlab.kernel.layout import (
    Inputs,
    PlantState,
    groups,
    read_state,
    reads_tables,
    state_row,
    write_state,
)
from motionlab.kernel.tick import learnt_force, tick
from motionlab.lanes import (
    WIDE,
    WIDTH,
    Lanes,
    axes_at,
    cached,
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
_ERROR = MeasuredChannels._fields.index("following_error")


@compiled
def measured(sample: Sample) -> MeasuredChannels:
    """Return the channels of a tick that enter the metrics."""
    return MeasuredChannels(
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


class Block(NamedTuple):
    """Lanes that move side by side."""

    parameters: Array  # (PARAMETER_ROWS, lanes)
    state: Array  # (STATE_ROWS, lanes); overwritten by the state at the end


class ScoreWindow(NamedTuple):
    """Recorded part of the lanes' motion."""

    target: Array  # position reference over the window, m, (ticks, 1, 2)
    before: int  # ticks from the first input to the window's start; negative inside of it
    tally: Array  # (TALLY_ROWS, lanes); what the window's ticks add to it is added
    errors: NDArray[np.float32]  # following error at every tick, m, (ticks, lanes), or empty


@compiled
def _score(  # noqa: PLR0913, PLR0917 - as the tick
    width: Lanes,
    block: Block,
    inputs: Array,
    window: ScoreWindow,
    tables: Array | None,
    laws: Laws,
) -> None:
    """Advance as many lanes as `width` has; see `score_ticks`."""
    state, (target, before, tally, errors) = block.state, window
    enter_laws(block.parameters, state, laws)
    par = groups(block.parameters, width)
    s = read_state(state, width)
    samples = np.empty((CHUNK, MEASURED_ROWS, state.shape[1]), dtype=np.float32)
    ticks = inputs.shape[0]
    mode = flush_subnormals()
    for begin in range(0, ticks, CHUNK):
        end = min(begin + CHUNK, ticks)
        for k in range(begin, end):
            at = axes_at(Inputs, inputs, k, width)
            look_ahead(laws, inputs, k, width)
            s, sample = tick(par, s, at, tables, laws, learnt_force(par, at))
            record(measured(sample), samples, k - begin)
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
    leave_laws(state, laws)


# One function for each width: numba keeps no compiled function that closes over another.


@cached
def _score_narrow(
    block: Block, inputs: Array, window: ScoreWindow, tables: Array | None, laws: Laws
) -> None:
    _score(unpack(PlantState, block.state, 0, WIDTH).p, block, inputs, window, tables, laws)


@cached
def _score_wide(
    block: Block, inputs: Array, window: ScoreWindow, tables: Array | None, laws: Laws
) -> None:
    _score(unpack(PlantState, block.state, 0, WIDE).p, block, inputs, window, tables, laws)


def score_ticks(block: Block, inputs: Array, window: ScoreWindow) -> None:
    """Advance eight or sixteen lanes by ``len(inputs)`` control periods and tally a window.

    Ends early once every lane has diverged. As in `motionlab.kernel.tick.run_ticks` lanes
    with and without tables each have a kernel of their own.

    Parameters
    ----------
    block : Block
        The lanes.
    inputs : ndarray, shape (ticks, INPUT_ROWS or more, 2)
        As `run_ticks` takes them.
    window : ScoreWindow
        What to keep.
    """
    parameters, state = block
    score = _score_narrow if parameters.shape[1] == WIDTH else _score_wide
    tabled = reads_tables(parameters)
    laws = laws_of(parameters)
    if not any(tabled):
        score(block, inputs, window, None, laws)
        return
    kept = (
        Block(parameters, state.copy()),
        window._replace(tally=window.tally.copy(), errors=np.empty_like(window.errors)),
    )
    score(block, inputs, window, TABLES.values, laws)
    if all(tabled):
        return
    score(kept[0], inputs, kept[1], None, laws)
    plain = [not lane for lane in tabled]
    for own, other in (
        (state, kept[0].state),
        (window.tally, kept[1].tally),
        (window.errors, kept[1].errors),
    ):
        own[:, plain] = other[:, plain]
