"""What the WebAssembly module exports: the kernel on two lanes, x and y of one variant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import float32, float64, int64
from numpy.typing import NDArray

from motionlab.analysis.contouring import write_nearest
from motionlab.config.planar import AXES
from motionlab.kernel.accumulator import TALLY_ROWS, Tally, Target, one_more
from motionlab.kernel.law_calls import adopt_states
from motionlab.kernel.layout import (
    INPUT_ROWS,
    LAW_NUMBER,
    LAW_OF_STATE,
    LAW_STATE,
    PARAMETER_ROWS,
    SAMPLE_ROWS,
    STATE_ROWS,
    Inputs,
    LawState,
    PlantState,
    State,
    groups,
    read_state,
    write_state,
)
from motionlab.kernel.motion import seen
from motionlab.kernel.score import measured
from motionlab.kernel.tick import act, command, measured_position, observe_motion
from motionlab.lanes import Lanes, axes_at, compiled, pack, record, recorded, select, unpack
from motionlab.lanes.bank import NUMBERS_MOST
from motionlab.targets.wasm_laws import estimate_friction
from motionlab.telemetry.channels import Sample
from motionlab.telemetry.decimate import write_extremes
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]
Samples = NDArray[np.float32]

LANES = len(AXES)
_TRACE = 1e-60  # A; its square is far from subnormal


@dataclass(frozen=True)
class Block:
    """An array in the module's memory, C-contiguous unless it has strides.

    Attributes
    ----------
    name : str
        Of the parameter that points to it.
    element : numba type
        Of a number.
    shape : tuple of int or str
        Sizes; a name is a parameter of the exported function.
    strides : tuple of int or str, optional
        Distances of neighbours, in numbers.
    """

    name: str
    element: Any
    shape: tuple[int | str, ...]
    strides: tuple[int | str, ...] | None = None


@dataclass(frozen=True)
class Export:
    """A function of the module: its parameters are blocks, and whole numbers by name."""

    function: Callable[..., None]
    parameters: tuple[Block | str, ...]


@compiled
def _without_traces(s: State) -> State:
    """Return a state in which currents that have decayed are zero.

    Elsewhere a mode of the processor keeps subnormal numbers out; WebAssembly has none, and they
    take several times as long as others.
    """
    p = s.plant
    a, b, c = _current(p.i_a), _current(p.i_b), _current(p.i_c)
    plant = PlantState(p.p, p.v, p.z, p.y, p.y_rate, a, b, c)
    return State(plant, s.memory, s.acting, s.pending, s.age, s.failed)


@compiled
def _current(i: Lanes) -> Lanes:
    return select(abs(i) < _TRACE, 0.0, i)


@compiled
def _advance(
    parameters: Array, state: Array, inputs: Array, samples: Samples, tables: Array | None
) -> None:
    adopt_states(parameters, state)
    width = unpack(PlantState, state, 0, LANES).p
    par = groups(parameters, width)
    s = read_state(state, width)
    number, law_state = int(parameters[LAW_NUMBER, 0]), unpack(LawState, state, LAW_STATE, width)
    for k in range(len(inputs)):
        at = axes_at(Inputs, inputs, k, width)
        motion = observe_motion(par, s, at, measured_position(par, s, at))
        known = seen(par.controller, par.model_friction, motion)
        estimate, law_state = estimate_friction(number, par.law, law_state, known)
        controlled = command(par, s, motion, estimate, tables, None)
        s, sample = act(par, s, at, controlled, tables)
        record(sample, samples, k)
        s = _without_traces(s)
    write_state(s, state)
    pack(law_state, state[LAW_STATE:LAW_OF_STATE])


def run(parameters: Array, state: Array, inputs: Array, samples: Samples) -> None:
    """Advance lanes without tables, as `motionlab.kernel.tick.run_ticks` does."""
    _advance(parameters, state, inputs, samples, None)


def run_tables(
    parameters: Array, state: Array, inputs: Array, samples: Samples, tables: Array
) -> None:
    """Advance lanes of which at least one reads tables."""
    _advance(parameters, state, inputs, samples, tables)


def add_ticks(samples: Samples, inputs: Array, first: int, tally: Array) -> None:
    """Add ticks of a window to its tally, as `motionlab.kernel.accumulator.add_ticks` does."""
    total = unpack(Tally, tally, 0, LANES)
    width = total.error_sum
    for k in range(len(samples)):
        at = measured(recorded(Sample, samples, k, width))
        target = Target(axes_at(Inputs, inputs, k, width).p_ref)
        total = one_more(total, at, target, (first + k) * CONTROL_PERIOD)
    pack(total, tally)


def extremes(values: Samples, size: int, low: Samples, high: Samples) -> None:
    """Write the extremes of each bin of one column."""
    write_extremes(values, size, low, high)


def contour(
    path: Array, start: int, following_error: Samples, kept: NDArray[np.int64], points: Array
) -> None:
    """Write the nearest points of a path."""
    write_nearest(path, start, following_error, kept, points)


_PARAMETERS = Block("parameters", float64, (PARAMETER_ROWS, LANES))
_STATE = Block("state", float64, (STATE_ROWS, LANES))
_INPUTS = Block("inputs", float64, ("ticks", INPUT_ROWS, LANES))
_SAMPLES = Block("samples", float32, ("ticks", SAMPLE_ROWS, LANES))
_ERRORS = Block("following_error", float32, ("ticks", LANES), (SAMPLE_ROWS * LANES, 1))
_TALLY = Block("tally", float64, (TALLY_ROWS, LANES))
_TABLES = Block("tables", float64, (NUMBERS_MOST,))

EXPORTS = (
    Export(run, (_PARAMETERS, _STATE, _INPUTS, _SAMPLES)),
    Export(run_tables, (_PARAMETERS, _STATE, _INPUTS, _SAMPLES, _TABLES)),
    Export(add_ticks, (_SAMPLES, _INPUTS, "first", _TALLY)),
    Export(
        extremes,
        (
            Block("values", float32, ("ticks",), ("stride",)),
            "size",
            Block("low", float32, ("bins",)),
            Block("high", float32, ("bins",)),
        ),
    ),
    Export(
        contour,
        (
            Block("path", float64, ("path_ticks", LANES)),
            "start",
            _ERRORS,
            Block("kept", int64, ("path_ticks",)),
            Block("points", float64, ("ticks", 6)),
        ),
    ),
)
"""Every function; its parameters in the module are these, then the sizes in order of mention."""
