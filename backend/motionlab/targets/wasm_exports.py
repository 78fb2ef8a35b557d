"""What the WebAssembly module exports: the kernel on two lanes, x and y of one variant."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import complex128, float32, float64, int64
from numpy.typing import NDArray

from motionlab.analysis.contouring import write_nearest
from motionlab.kernel.accumulator import TALLY_ROWS, Tally, Target, one_more
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
from motionlab.kernel.motion import none_ahead, seen
from motionlab.kernel.score import measured
from motionlab.kernel.tick import act, command, learnt_force, measured_position, observe_motion
from motionlab.lanes import Lanes, axes_at, compiled, pack, record, recorded, select, unpack
from motionlab.lanes.bank import NUMBERS_MOST
from motionlab.loop.family import VELOCITIES
from motionlab.loop.lane_controller import CONTROLLER_SIZE
from motionlab.loop.lane_loops import MOST_FREQUENCIES, MOST_VELOCITIES, ROWS_OF_SIZES, STATES
from motionlab.loop.lane_plant import PLANT_SIZE
from motionlab.targets.wasm_laws import adopt_states, estimate_friction
from motionlab.targets.wasm_loops import LANES, linearise, margins
from motionlab.telemetry.channels import Sample
from motionlab.telemetry.decimate import write_extremes
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]
Samples = NDArray[np.float32]

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
    """A function of the module: its parameters are blocks, and whole numbers by name.

    One that is `small` is optimised for its size.
    """

    function: Callable[..., None]
    parameters: tuple[Block | str, ...]
    small: bool = False


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
        known = seen(par.controller, par.model_friction, motion, none_ahead(motion))
        estimate, law_state = estimate_friction(number, par.law, law_state, known)
        controlled = command(par, s, motion, estimate, tables, learnt_force(par, at))
        s, sample = act(par, s, at, controlled, tables, None)
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
_SPEEDS = len(VELOCITIES)
_LOOPS = (
    Block("velocity", float64, (_SPEEDS,)),
    Block("plant", float64, (_SPEEDS, PLANT_SIZE, PLANT_SIZE)),
    Block("controller", float64, (3, _SPEEDS, CONTROLLER_SIZE, CONTROLLER_SIZE)),
    Block("matrix", float64, (3, _SPEEDS, STATES, STATES)),
    Block("fixed", float64, (_SPEEDS,)),
    Block("frequency", float64, (MOST_FREQUENCIES,)),
    Block("response", complex128, (2, _SPEEDS, MOST_FREQUENCIES)),
    Block("sizes", float64, (ROWS_OF_SIZES, MOST_VELOCITIES)),
    Block("work", float64, (2, STATES + 1, STATES + 1)),
    Block("upper", complex128, (STATES, STATES + 1)),
)
_LINEARISE = (
    Block("numbers", float64, (PARAMETER_ROWS, LANES)),
    Block("probes", float64, (STATE_ROWS, LANES)),
    Block("reference", float64, (1, INPUT_ROWS, LANES)),
    Block("measured", float64, (1, LANES)),
    Block("sliding", float64, (len(LawState._fields),)),
    Block("forces", float64, (-(-_SPEEDS // LANES), 1, LANES)),
)
_MARGINS = (
    Block("gains", float64, (2, 1)),
    Block("radii", float64, (1, _SPEEDS)),
    Block("limits", float64, (2, 2)),
    Block("worst", float64, (3, 2)),
)

_SPEED = Block("speeds", float64, (_SPEEDS,))
LOOP_BYTES = {
    block.name: block.element.bitwidth // 8 * math.prod(block.shape)
    for block in (_SPEED, *_LOOPS, *_LINEARISE, *_MARGINS)
}
"""Bytes of the arrays of one loop, by name."""

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
    Export(
        linearise,
        (_PARAMETERS, "axis", _TABLES, _SPEED, *_LOOPS, *_LINEARISE),
        small=True,
    ),
    Export(margins, (_PARAMETERS, "axis", *_LOOPS, *_MARGINS), small=True),
)
"""Every function; its parameters in the module are these, then the sizes in order of mention."""
