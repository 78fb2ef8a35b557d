"""What lies in which row of the kernel's arrays: a lane's parameters, its state and its inputs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.control.compensation import Compensation
from motionlab.control.notch import Notch
from motionlab.control.position import PositionController
from motionlab.force_sharing.functions import LEAST_NORM, Sharing
from motionlab.lanes import Lanes, compiled, pack, unpack
from motionlab.plant.current import Amplifiers
from motionlab.plant.encoder import Encoder
from motionlab.plant.friction import LuGre
from motionlab.plant.magnetics import ForceMap, Phases
from motionlab.plant.mechanics import Mechanics
from motionlab.plant.resonance import Resonance
from motionlab.plant.table_map import TableMap
from motionlab.telemetry.channels import Sample


class Inputs(NamedTuple):
    """What acts on all variants of a run alike: one value an axis and tick."""

    p_ref: Lanes  # m
    v_ref: Lanes  # m/s
    a_ref: Lanes  # m/s^2
    load: Lanes  # external load force f_d, N
    encoder_noise: Lanes  # m
    current_a: Lanes  # ripple and noise of the currents, A
    current_b: Lanes
    current_c: Lanes


class PlantState(NamedTuple):
    """State of the machine."""

    p: Lanes  # position, m
    v: Lanes  # velocity, m/s
    z: Lanes  # bristle state, m
    y: Lanes  # deflection that the encoder sees, m
    y_rate: Lanes  # m/s
    i_a: Lanes  # phase currents, A
    i_b: Lanes
    i_c: Lanes


class Memory(NamedTuple):
    """State of the controller, its commands apart."""

    p_last: Lanes  # last measured position, m
    v_last: Lanes  # and velocity, m/s
    e_last: Lanes  # last following error, m
    z_hat: Lanes  # bristle estimate, m
    residual: Lanes  # filtered force balance, N
    d: Lanes  # disturbance estimate, N
    n_1: Lanes  # the notch's memory, N
    n_2: Lanes


class Command(NamedTuple):
    """Force of one period, and what it was made with; either acting or pending (loop delay)."""

    force: Lanes  # realised within the limits, N
    estimate: Lanes  # friction estimate, N
    added: Lanes  # the part of the estimate that was added, N
    K: Lanes  # m/s


class State(NamedTuple):
    """Everything a lane remembers from one tick to the next."""

    plant: PlantState
    memory: Memory
    acting: Command
    pending: Command  # computed but not yet in effect
    pending_current: Phases  # current commands not yet in effect, A
    age: Lanes  # ticks since the start
    failed: Lanes  # tick at which the lane diverged; -1 while it has not


class _Clock(NamedTuple):
    age: Lanes
    failed: Lanes


class Limits(NamedTuple):
    """Limits of each lane."""

    current: Lanes  # largest current command, A
    error: Lanes  # following error beyond which the lane has diverged, m


class Parameters(NamedTuple):
    """The parameter groups of a lane; the plant's truth and the controller's model are apart."""

    friction: LuGre
    force_map: ForceMap
    amplifiers: Amplifiers
    encoder: Encoder
    mechanics: Mechanics
    resonance: Resonance
    controller: PositionController
    notch: Notch
    compensation: Compensation
    model_friction: LuGre
    model_force_map: ForceMap
    limits: Limits
    table: TableMap
    model_table: TableMap
    sharing: Sharing


_GROUPS: tuple[type[NamedTuple], ...] = (
    LuGre,
    ForceMap,
    Amplifiers,
    Encoder,
    Mechanics,
    Resonance,
    PositionController,
    Notch,
    Compensation,
    LuGre,
    ForceMap,
    Limits,
    TableMap,
    TableMap,
    Sharing,
)
_NAMES = tuple(Parameters._fields)
_SIZES = [len(group._fields) for group in _GROUPS]
(_R0, _R1, _R2, _R3, _R4, _R5, _R6, _R7, _R8, _R9, _R10, _R11, _R12, _R13, _R14, PARAMETER_ROWS) = (
    sum(_SIZES[:i]) for i in range(len(_SIZES) + 1)
)
_STATE_NAMES = [
    *(f"plant.{name}" for name in PlantState._fields),
    *(f"memory.{name}" for name in Memory._fields),
    *(f"acting.{name}" for name in Command._fields),
    *(f"pending.{name}" for name in Command._fields),
    *(f"pending_current.{name}" for name in Phases._fields),
    *_Clock._fields,
]
STATE_ROWS = len(_STATE_NAMES)
_S1, _S2, _S3, _S4, _S5 = (
    _STATE_NAMES.index(name)
    for name in ("memory.p_last", "acting.force", "pending.force", "pending_current.a", "age")
)
INPUT_ROWS = len(Inputs._fields)
SAMPLE_ROWS = len(Sample._fields)


def parameter_row(path: str) -> int:
    """Return the row of a lane parameter, such as ``controller.k_p``, in a parameter array."""
    group, _, field = path.partition(".")
    index = _NAMES.index(group)
    return sum(_SIZES[:index]) + _GROUPS[index]._fields.index(field)


def state_row(path: str) -> int:
    """Return the row of a field of the state, such as ``plant.p``, in an array of states."""
    return _STATE_NAMES.index(path)


@compiled
def read_state(state: NDArray[np.float64], width: Lanes) -> State:
    """Return `State` from an array, (STATE_ROWS, lanes), as wide as other lanes."""
    clock = unpack(_Clock, state, _S5, width)
    return State(
        unpack(PlantState, state, 0, width),
        unpack(Memory, state, _S1, width),
        unpack(Command, state, _S2, width),
        unpack(Command, state, _S3, width),
        unpack(Phases, state, _S4, width),
        clock.age,
        clock.failed,
    )


@compiled
def write_state(s: State, state: NDArray[np.float64]) -> None:
    """Write `State` into an array, (STATE_ROWS, lanes)."""
    pack(s.plant, state[:_S1])
    pack(s.memory, state[_S1:_S2])
    pack(s.acting, state[_S2:_S3])
    pack(s.pending, state[_S3:_S4])
    pack(s.pending_current, state[_S4:_S5])
    pack(_Clock(s.age, s.failed), state[_S5:])


FORCE_LIMIT_ROW = parameter_row("controller.force_limit")
_TABLED = [parameter_row(path) for path in ("table.thrust", "model_table.thrust", "sharing.law")]


@compiled
def groups(parameters: NDArray[np.float64], width: Lanes) -> Parameters:
    """Return the groups of `Parameters` of an array, (PARAMETER_ROWS, lanes), as wide as others."""
    return Parameters(
        unpack(LuGre, parameters, _R0, width),
        unpack(ForceMap, parameters, _R1, width),
        unpack(Amplifiers, parameters, _R2, width),
        unpack(Encoder, parameters, _R3, width),
        unpack(Mechanics, parameters, _R4, width),
        unpack(Resonance, parameters, _R5, width),
        unpack(PositionController, parameters, _R6, width),
        unpack(Notch, parameters, _R7, width),
        unpack(Compensation, parameters, _R8, width),
        unpack(LuGre, parameters, _R9, width),
        unpack(ForceMap, parameters, _R10, width),
        unpack(Limits, parameters, _R11, width),
        unpack(TableMap, parameters, _R12, width),
        unpack(TableMap, parameters, _R13, width),
        unpack(Sharing, parameters, _R14, width),
    )


def reads_tables(parameters: NDArray[np.float64]) -> list[bool]:
    """Return of each of the lanes of `parameters` whether it needs the kernel with tables."""
    plant, model, law = (parameters[row] for row in _TABLED)
    return ((plant >= 0.0) | (model >= 0.0) | (law != LEAST_NORM)).tolist()
