"""The motor behind the drives: the plant of the simulation, step by step."""

from __future__ import annotations

import ctypes
from typing import Any, NamedTuple

import numba
import numpy as np
from llvmlite import binding
from numba import types
from numpy.typing import NDArray

from motionlab.drive.virtual.layout import (
    INPUT_ROWS,
    PARAMETER_ROWS,
    PERIODS,
    PLANT_ROWS,
    PLANT_TIME,
    PUSH_STEPS_X,
    PUSH_X,
    STEP_NS,
    STEPS,
    WIDTH,
    Arrays,
    cache,
    part,
)
from motionlab.kernel.layout import Inputs, PlantState, parameter_row
from motionlab.lanes import (
    Lanes,
    axes_at,
    compiled,
    flush_subnormals,
    pack,
    restore_mode,
    unpack,
)
from motionlab.plant.current import Amplifiers, half_step, settled_current
from motionlab.plant.encoder import Encoder, measure
from motionlab.plant.friction import LuGre
from motionlab.plant.magnetics import AnalyticMap, Phases
from motionlab.plant.mechanics import Mechanics, Mover, advance, end_stop_force
from motionlab.plant.resonance import Resonance, ring
from motionlab.plant.table_map import MotorMap, TableMap, thrust_of
from motionlab.timing import PLANT_STEP, SUBSTEPS

_LOAD = Inputs._fields.index("load")
_FRICTION = parameter_row("friction.sigma_0")
_FORMULA = parameter_row("force_map.formula.tau")
_TABLE = parameter_row("force_map.table.thrust")
_AMPLIFIERS = parameter_row("amplifiers.half_step")
_ENCODER = parameter_row("encoder.resolution")
_MECHANICS = parameter_row("mechanics.M")
_RESONANCE = parameter_row("resonance.compliance")
_numba: Any = numba  # whose types do not name all that it exports
_carray = _numba.carray


class Reading(NamedTuple):
    """What the encoders read."""

    p: Lanes  # m


@compiled
def one_step(
    parameters: NDArray[np.float64],
    s: PlantState,
    command: Phases,
    at: Inputs,
    tables: NDArray[np.float64] | None,
) -> PlantState:
    """Return the state of the machine PLANT_STEP later: a fifth of `motionlab.kernel.move.move`."""
    amplifiers = unpack(Amplifiers, parameters, _AMPLIFIERS)
    mechanics = unpack(Mechanics, parameters, _MECHANICS)
    motor_map = MotorMap(
        unpack(AnalyticMap, parameters, _FORMULA), unpack(TableMap, parameters, _TABLE)
    )
    disturbance = Phases(at.current_a, at.current_b, at.current_c)
    target = settled_current(amplifiers, command, disturbance)
    mover, current = Mover(s.p, s.v, s.z), Phases(s.i_a, s.i_b, s.i_c)
    middle = half_step(amplifiers, current, target)
    p_mid = mover.p + (0.5 * PLANT_STEP) * mover.v
    force = thrust_of(motor_map, tables, p_mid, middle)
    net = force - at.load + end_stop_force(mechanics, p_mid, mover.v)
    mover = advance(mechanics, unpack(LuGre, parameters, _FRICTION), mover, net, PLANT_STEP)
    y, y_rate = ring(unpack(Resonance, parameters, _RESONANCE), s.y, s.y_rate, force)
    current = half_step(amplifiers, middle, target)
    return PlantState(mover.p, mover.v, mover.z, y, y_rate, current.a, current.b, current.c)


@compiled
def _turn(  # noqa: PLR0913, PLR0917 - fields of a segment
    parameters: NDArray[np.float64],
    plant: NDArray[np.float64],
    command: NDArray[np.float64],
    at: NDArray[np.float64],
    measured: NDArray[np.float64],
    tables: NDArray[np.float64],
    moves: int,
) -> None:
    """Advance the machine by one step where it `moves`, else read the encoders."""
    inputs = axes_at(Inputs, at, 0)
    state = unpack(PlantState, plant, 0)
    mode = flush_subnormals()
    if moves:
        state = one_step(parameters, state, unpack(Phases, command, 0), inputs, tables)
        pack(state, plant)
    else:
        encoder = unpack(Encoder, parameters, _ENCODER)
        pack(Reading(measure(encoder, state.p + state.y, inputs.encoder_noise)), measured)
    restore_mode(mode)


def _compile_turn() -> Any:
    """Return `_turn` for compiled code to call by its address.

    Else numba would compile it once more into each of the functions on the way to it.
    """
    numbers, whole, name = types.CPointer(types.float64), types.intp, "motionlab_vdrive_turn"

    @cache.callback(types.void(numbers, numbers, numbers, numbers, numbers, numbers, whole, whole))
    def turn(  # noqa: PLR0913, PLR0917 - addresses of fields
        parameters: Any, plant: Any, command: Any, at: Any, measured: Any, tables: Any,
        table_size: int, moves: int,
    ) -> None:  # fmt: skip
        _turn(
            _carray(parameters, (PARAMETER_ROWS, WIDTH)),
            _carray(plant, (PLANT_ROWS, WIDTH)),
            _carray(command, (3, WIDTH)),
            _carray(at, (1, INPUT_ROWS, 2)),
            _carray(measured, (1, WIDTH)),
            _carray(tables, (table_size,)),
            moves,
        )

    binding.add_symbol(name, turn.address)
    call = types.ExternalFunction(name, types.void(*[whole] * 8))

    @part
    def step(s: Arrays, moves: int) -> None:
        call(
            s.parameters.ctypes.data,
            s.plant.ctypes.data,
            s.command.ctypes.data,
            s.at.ctypes.data,
            s.measured.ctypes.data,
            s.tables[0],
            s.tables[1],
            moves,
        )

    return step


def _plain_step(s: Arrays, moves: int) -> None:
    kind = ctypes.c_double * int(s.tables[1])
    tables = np.ctypeslib.as_array(kind.from_address(int(s.tables[0])))
    _turn(s.parameters, s.plant, s.command, s.at, s.measured, tables, moves)


_step = _plain_step if _numba.config.DISABLE_JIT else _compile_turn()


@part
def _inputs_now(s: Arrays) -> None:
    period = (s.clock[STEPS] // SUBSTEPS) % s.clock[PERIODS]
    for row in range(INPUT_ROWS):
        for axis in range(2):
            s.at[0, row, axis] = s.inputs[period, row, axis]


@part
def run_machine(s: Arrays, steps: int) -> None:
    """Advance the machine by `steps` of the plant and read the encoders at the end."""
    for _ in range(steps):
        _inputs_now(s)
        for axis in range(2):
            if s.switches[PUSH_STEPS_X + axis] > 0.0:
                s.switches[PUSH_STEPS_X + axis] -= 1.0
                s.at[0, _LOAD, axis] -= s.switches[PUSH_X + axis]
        _step(s, 1)
        s.clock[STEPS] += 1
    _inputs_now(s)
    _step(s, 0)


@part
def run_machine_to(s: Arrays, time: int) -> None:
    """Advance the machine by the whole steps that fit before `time`; the rest is carried."""
    steps = (time - s.clock[PLANT_TIME]) // STEP_NS
    if steps > 0:
        run_machine(s, steps)
        s.clock[PLANT_TIME] += steps * STEP_NS
