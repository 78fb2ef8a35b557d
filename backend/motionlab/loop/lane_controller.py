"""The controller of one lane about a velocity: differences of the kernel's own control half.

Each number that the controller remembers, and the measured position, is moved up in one lane and
down in the next: `write_probes`, a control period, `read_probes`. Compiled for this machine and
for WebAssembly, whose lanes differ in number.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.force_sharing.functions import CLOSED_FORM
from motionlab.kernel.law_calls import SHIPPED_BY_NUMBER
from motionlab.kernel.layout import (
    LAW_NUMBER,
    LAW_OF_STATE,
    LAW_PARAMETERS,
    LAW_STATE,
    MODEL_FRICTION,
    Inputs,
    LawState,
    parameter_row,
    state_row,
)
from motionlab.lanes import compiled
from motionlab.loop.lane_plant import CREEP, friction_of, sliding_force
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]
Sliding = Callable[[int, Any, float, Array], int]

_FEEDBACK_STATES = 9
"""Of the disturbance observer and the filters, one after another."""
MEMORY_STATES = 19
"""States of the linearised controller beside those of its law. Its force needs no currents; the
reference is zero, so the last error is a position."""
CONTROLLER_SIZE = len(LawState._fields) + MEMORY_STATES + 1
"""Rows of the system at most."""

_STEP, _SHARE = 1e-5, 1e-4
_STEP_AT_REST = 1e-10
"""Steps of a velocity, of a law's state and of a velocity at rest by which the controller is
differenced, as shares of their scale."""
_K_P, _K_D = parameter_row("controller.k_p"), parameter_row("controller.k_d")
_LIMIT, _IDEAL = parameter_row("controller.force_limit"), parameter_row("controller.ideal_force")
_SHARING, _ENABLED = parameter_row("force_model.sharing.law"), parameter_row("compensation.enabled")
_SINE, _COSINE = (parameter_row(f"model_subdivision.{name}") for name in ("sine", "cosine"))
_P_LAST, _V_LAST, _E_LAST = (state_row(f"memory.{name}") for name in ("p_last", "v_last", "e_last"))
_D = state_row("memory.d")
_ACTING, _PENDING = state_row("acting.force"), state_row("pending.force")
_ESTIMATE, _ADDED = 1, 2
"""Places of the estimate and of its added part after the force."""
COMMAND_STATES = 4
"""Numbers of a command before its currents, of which the force is the first. The last states are
those of the acting command and of the pending one."""
_AGE, _FAILED = state_row("age"), state_row("failed")
_V_REF = Inputs._fields.index("v_ref")


def _sliding() -> Sliding:
    """Return the function that calls `Law.sliding` by the number of a law in the kernel."""
    scope: dict[str, Any] = {}
    lines = ["def sliding(number, friction, v, state):"]
    for number, law in enumerate(SHIPPED_BY_NUMBER):
        rows = len(law.State._fields)
        lines.append(f"    if number == {number}:")
        if law.sliding is not None:
            scope[f"of_{number}"] = compiled(law.sliding)
            lines.append(f"        at = of_{number}(friction, v)")
        lines += [
            f"        state[{row}] = {'0.0' if law.sliding is None else f'at[{row}]'}"
            for row in range(rows)
        ]
        lines.append(f"        return {rows}")
    exec("\n".join([*lines, "    return 0"]), scope)
    return scope["sliding"]


def _unbounded() -> Callable[[int, Array, int], None]:
    """Return the function that removes the limits of a law by its number in the kernel."""
    lines = ["def unbounded(number, numbers, lane):"]
    for number, law in enumerate(SHIPPED_BY_NUMBER):
        lines += [f"    if number == {number}:"] + [
            f"        numbers[{LAW_PARAMETERS + law.Parameters._fields.index(name)}, lane] = inf"
            for name in law.limits
        ]
        lines += ["        return"]
    scope: dict[str, Any] = {"inf": math.inf}
    exec("\n".join([*lines, "    return"]), scope)
    return scope["unbounded"]


_sliding_state: Sliding = compiled(_sliding())
_without_limits: Callable[[int, Array, int], None] = compiled(_unbounded())


@compiled
def linear_numbers(numbers: Array, k_p: float, k_d: float) -> None:
    """Set gains, N/m and N s/m, and remove what no linear loop has: limits, sharing and tables.

    A correction of the encoder changes the gain by 1 % along its period, and goes, too.
    """
    for lane in range(numbers.shape[1]):
        numbers[_K_P, lane], numbers[_K_D, lane] = k_p, k_d
        numbers[_LIMIT, lane], numbers[_IDEAL, lane] = math.inf, 1.0
        numbers[_SHARING, lane] = CLOSED_FORM
        numbers[_SINE, lane] = numbers[_COSINE, lane] = 0.0
        _without_limits(int(numbers[LAW_NUMBER, lane]), numbers, lane)


@compiled
def _row(state: int, law_states: int) -> int:
    """Return the row of a state of the linearised controller in an array of states."""
    k = state - law_states
    if k < 0:
        return LAW_STATE + state
    if k < 2:
        return _P_LAST + k
    k -= 2
    if k < _FEEDBACK_STATES:
        return _D + k
    k -= _FEEDBACK_STATES
    return _ACTING + k if k < COMMAND_STATES else _PENDING + k - COMMAND_STATES


@compiled
def _step(state: int, numbers: Array, v: float, sliding: Array, law_states: int) -> float:
    """Return by how much a state, or the measured position after the last, is moved."""
    v_s = numbers[MODEL_FRICTION + 5, 0]
    # At rest nothing cancels, and abs(v) is no straight line: a step so much smaller.
    speed = _STEP_AT_REST * v_s if v == 0.0 else _STEP * min(v_s, abs(v))
    if state < law_states:
        return _SHARE * abs(sliding[state]) if sliding[state] != 0.0 else _SHARE
    if state == law_states or state == law_states + MEMORY_STATES:
        return speed * CONTROL_PERIOD
    return speed if state == law_states + 1 else 1.0


@compiled
def about(numbers: Array, v: float, inputs: Array, sliding: Array) -> int:
    """Write the reference and the law's state of sliding with it at a velocity, m/s.

    Returns
    -------
    int
        Number of states of the law.
    """
    for row in range(inputs.shape[1]):
        for axis in range(inputs.shape[2]):
            inputs[0, row, axis] = v if row == _V_REF else 0.0
    friction = friction_of(numbers, MODEL_FRICTION)
    return _sliding_state(int(numbers[LAW_NUMBER, 0]), friction, v, sliding)


@compiled
def write_probes(  # noqa: PLR0913, PLR0917 - what a state is made of
    first: int,
    numbers: Array,
    v: float,
    sliding: Array,
    law_states: int,
    states: Array,
    measured: Array,
) -> None:
    """Write sliding with the reference into lanes of states, the states from `first` on moved.

    Parameters
    ----------
    first : int
        State that is moved in the first two lanes; after the last comes the measured position.
    numbers : ndarray, shape (PARAMETER_ROWS, lanes)
        After `linear_numbers`.
    v : float
        Velocity, m/s; 0 is at rest.
    sliding, law_states
        As `about` gives them.
    states : ndarray, shape (STATE_ROWS, lanes)
        Overwritten.
    measured : ndarray, shape (1, lanes)
        Overwritten.
    """
    force = (
        0.0
        if v == 0.0
        else math.copysign(sliding_force(friction_of(numbers, MODEL_FRICTION), v), v)
    )
    added = force if numbers[_ENABLED, 0] > 0.0 else 0.0
    for lane in range(states.shape[1]):
        for row in range(states.shape[0]):
            states[row, lane] = 0.0
        states[_AGE, lane] = 2.0  # differences of the encoder are taken from the second tick on
        states[_FAILED, lane] = -1.0
        states[_P_LAST, lane], states[_V_LAST, lane] = -v * CONTROL_PERIOD, v
        states[LAW_OF_STATE, lane] = numbers[LAW_NUMBER, lane]
        for k in range(law_states):
            states[LAW_STATE + k, lane] = sliding[k]
        for command in (_ACTING, _PENDING):
            states[command, lane] = states[command + _ADDED, lane] = added
            states[command + _ESTIMATE, lane] = force
        measured[0, lane] = 0.0
        moved, last = first + lane // 2, law_states + MEMORY_STATES
        if moved > last:
            continue
        step = (1.0 - 2.0 * (lane % 2)) * _step(moved, numbers, v, sliding, law_states)
        if moved == last:
            measured[0, lane] = step
        else:
            states[_row(moved, law_states), lane] += step
            if moved == law_states:
                states[_E_LAST, lane] = -step


@compiled
def read_probes(  # noqa: PLR0913, PLR0917 - as `write_probes`
    first: int,
    numbers: Array,
    v: float,
    sliding: Array,
    law_states: int,
    states: Array,
    system: Array,
) -> None:
    """Write what lanes have become a period later into the system's columns, from `first` on.

    Parameters
    ----------
    system : ndarray, shape (CONTROLLER_SIZE, CONTROLLER_SIZE)
        From the measured position, m, to the opposite of the force command, N.
    """
    last = law_states + MEMORY_STATES
    for lane in range(0, states.shape[1], 2):
        moved = first + lane // 2
        if moved > last:
            break
        scale = 0.5 / _step(moved, numbers, v, sliding, law_states)
        for i in range(last):
            row = _row(i, law_states)
            system[i, moved] = (states[row, lane] - states[row, lane + 1]) * scale
        system[last, moved] = -(states[_ACTING, lane] - states[_ACTING, lane + 1]) * scale
        if v == 0.0 and moved < law_states and abs(system[moved, moved] - 1.0) < 1e-5:
            # A mover may rest anywhere, and no pole lies at 1.
            system[moved, moved] = math.exp(-CREEP * CONTROL_PERIOD)
