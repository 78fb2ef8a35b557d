"""The compiled step: control periods of many motors under forces from outside, and what is seen.

The machine and its controller are those of `motionlab.kernel.tick`; here each motor has inputs of
its own, since episodes begin and end on their own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.control.position import Last, estimate_motion
from motionlab.kernel.build import LANES_PER_VARIANT
from motionlab.kernel.law_calls import AHEAD_ROW, Laws, enter_laws, leave_laws
from motionlab.kernel.layout import (
    INPUT_ROWS,
    Inputs,
    Parameters,
    PlantState,
    State,
    groups,
    parameter_row,
    read_state,
    state_row,
    write_state,
)
from motionlab.kernel.motion import Ahead
from motionlab.kernel.tick import learnt_force, measured_position, tick
from motionlab.lanes import (
    WIDTH,
    Lanes,
    cached,
    compiled,
    flush_subnormals,
    pack,
    restore_mode,
    select,
    store_vectors,
    unpack,
)
from motionlab.plant.encoder import corrected
from motionlab.simulation.inputs import PAGE

Array = NDArray[np.float64]

MOTORS = WIDTH // LANES_PER_VARIANT
"""Motors in one block of lanes."""

RING = 2 * PAGE
"""Ticks of inputs held of each motor, a power of two: the page that it is on, and the next one."""

ENDED, TURNED = 1, 2
"""Bits of what `advance` returns: some episode has ended; some motor has begun another page."""

_FAILED = state_row("failed")
_ERROR_LIMIT = parameter_row("limits.error")


class Observed(NamedTuple):
    """Observation of an axis: what its controller sees at the same instant."""

    following_error: Lanes  # m
    following_error_rate: Lanes  # m/s
    position_reference: Lanes  # m
    velocity_reference: Lanes  # m/s
    acceleration_reference: Lanes  # m/s^2
    position_measured: Lanes  # m
    velocity_measured: Lanes  # m/s
    force_realised: Lanes  # of the last command, within the limits, N


OBSERVED = len(Observed._fields)


class _PerLane(NamedTuple):
    value: Lanes


class Weights(NamedTuple):
    """Scale of actions, and weights of the reward."""

    action_scale: float  # N
    per_error: float  # 1/m
    effort: float
    divergence: float


@compiled
def _observed(par: Parameters, s: State, at: Inputs) -> Observed:
    """Return the observation of the period that begins now."""
    p_meas = corrected(par.model_subdivision, measured_position(par, s, at))
    memory = s.memory
    last = Last(memory.p_last, memory.v_last, memory.e_last)
    motion = estimate_motion(at.p_ref, p_meas, last, s.age == 0.0)
    return Observed(
        motion.error,
        motion.error_rate,
        at.p_ref,
        at.v_ref,
        at.a_ref,
        p_meas,
        motion.v,
        s.pending.force,
    )


@compiled
def _gather(inputs: Array, clock: NDArray[np.int64], ahead: int, block: int, rows: Array) -> None:
    """Write the inputs of a block's motors at their own ticks into rows of lanes."""
    first = block * MOTORS
    for motor in range(min(MOTORS, clock.shape[0] - first)):
        at = inputs[first + motor, (clock[first + motor] + ahead) & (RING - 1)]
        for row in range(rows.shape[0]):
            rows[row, 2 * motor] = at[row, 0]
            rows[row, 2 * motor + 1] = at[row, 1]


@compiled
def _inputs_of(rows: Array, laws: Laws, width: Lanes) -> Inputs:
    """Return the inputs of a tick; the motion to come goes to laws, as by `look_ahead`."""
    if rows.shape[0] > INPUT_ROWS:
        store_vectors(unpack(Ahead, rows, INPUT_ROWS, width), laws.rows, AHEAD_ROW)
    return unpack(Inputs, rows, 0, width)


@compiled
def _act(
    actions: NDArray[np.float32], weights: Array, block: int, force: Array, reward: Array
) -> None:
    """Write the forces of a block's actions into a row of lanes, and their cost as the reward."""
    first = block * MOTORS
    for motor in range(min(MOTORS, actions.shape[0] - first)):
        squares = 0.0
        for axis in range(2):
            action = np.float64(actions[first + motor, axis])
            if abs(action) > 1.0:  # NaN passes, and makes the motor diverge
                action = 1.0 if action > 0.0 else -1.0
            force[0, 2 * motor + axis] = weights[0] * action
            square = action * action
            squares += square if square <= 1.0 else 1.0
        reward[first + motor] = -weights[2] * squares


@compiled
def _capped(error: Lanes, limit: Lanes) -> Lanes:
    """Return the magnitude of an error, m, no more than its limit where it is not finite either."""
    return select(abs(error) <= limit, abs(error), limit)


@cached
def advance(  # noqa: PLR0913, PLR0917 - a tuple of arrays takes longer to pass
    parameters: Array,
    state: Array,
    inputs: Array,
    clock: NDArray[np.int64],
    end: NDArray[np.int64],
    actions: NDArray[np.float32],
    ticks: int,
    scales: Array,
    weights: Array,
    observation: NDArray[np.float32],
    reward: Array,
    over: NDArray[np.bool_],
    tables: Array | None,
    laws: Laws,
) -> int:
    """Advance every motor by some control periods with its action held.

    Parameters
    ----------
    parameters, state : ndarray, shape (blocks, PARAMETER_ROWS or STATE_ROWS, WIDTH)
        As `motionlab.kernel.tick.run_ticks` takes them, of MOTORS motors a block; the state is
        overwritten.
    inputs : ndarray, shape (motors, RING, INPUT_ROWS or more, 2)
        Fields of `Inputs` of each motor, tick k at k modulo RING, up to one tick beyond the step.
    clock : ndarray of int, shape (motors,)
        The next tick of each motor; overwritten.
    end : ndarray of int, shape (motors,)
        Ticks of its episode.
    actions : ndarray of float32, shape (motors, 2)
        Force added on x and y, of the action scale; clipped to -1 and 1.
    ticks : int
        How many; 0 to observe only.
    scales : ndarray, shape (2, OBSERVED, 2)
        Factor of each field of `Observed` and the largest magnitude of the product, for x and y.
    weights : ndarray, shape (4,)
        Fields of `Weights`.
    observation : ndarray of float32, shape (motors, 2 * OBSERVED)
        Overwritten by fields of `Observed`, those of x, then those of y.
    reward : ndarray, shape (motors,)
        Overwritten.
    over : ndarray of bool, shape (motors, 2)
        Overwritten: whether the episode terminated, and whether it was truncated.
    tables : ndarray or None
        As `motionlab.kernel.tick.tick` takes it.
    laws : Laws
        `laws_of` the parameters.
    """
    width = unpack(PlantState, state[0], 0).p
    rows, seen = np.zeros((inputs.shape[2], WIDTH)), np.empty((OBSERVED, WIDTH))
    force, squares, errors = np.zeros((1, WIDTH)), np.zeros((1, WIDTH)), np.empty((1, WIDTH))
    _, per_error, _, divergence = weights
    events = 0
    mode = flush_subnormals()
    for block in range(parameters.shape[0]):
        enter_laws(parameters[block], state[block], laws)
        par = groups(parameters[block], width)
        s = read_state(state[block], width)
        _act(actions, weights, block, force, reward)
        extra = unpack(_PerLane, force, 0, width).value

        # move
        total_squares = unpack(_PerLane, squares, 0, width).value
        for k in range(ticks):
            _gather(inputs, clock, k, block, rows)
            at = _inputs_of(rows, laws, width)
            s, sample = tick(par, s, at, tables, laws, extra + learnt_force(par, at))
            if k > 0:  # the first error was there before the action
                error = _capped(sample.following_error, par.limits.error)
                total_squares = total_squares + error * error
        write_state(s, state[block])
        leave_laws(state[block], laws)

        # observe
        _gather(inputs, clock, ticks, block, rows)
        now = _observed(par, s, unpack(Inputs, rows, 0, width))
        pack(now, seen)
        error = _capped(now.following_error, par.limits.error)
        pack(_PerLane(total_squares + error * error), errors)
        mean = per_error * per_error / max(ticks, 1)

        first = block * MOTORS
        for motor in range(min(MOTORS, clock.shape[0] - first)):
            number = first + motor
            terminated = False
            for axis in range(2):
                lane = 2 * motor + axis
                reward[number] -= mean * errors[0, lane]
                within = abs(seen[0, lane]) <= parameters[block, _ERROR_LIMIT, lane]
                terminated |= state[block, _FAILED, lane] >= 0.0 or not within
                for row in range(OBSERVED):
                    value, most = seen[row, lane] * scales[0, row, axis], scales[1, row, axis]
                    value = value if value <= most else most  # NaN too
                    value = value if value >= -most else -most
                    observation[number, axis * OBSERVED + row] = value
            before = clock[number]
            after = before + ticks
            clock[number] = after
            truncated = not terminated and after + ticks > end[number]
            over[number, 0], over[number, 1] = terminated, truncated
            if terminated:
                reward[number] -= divergence
            if terminated or truncated:
                events |= ENDED
            if after // PAGE != before // PAGE:
                events |= TURNED
    restore_mode(mode)
    return events
