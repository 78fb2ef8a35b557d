"""What lies in which row of the kernel's arrays: a lane's parameters, its state and its inputs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.control.compensation import Compensation
from motionlab.control.notch import Notch
from motionlab.control.position import PositionController
from motionlab.force_sharing.functions import LEAST_NORM, Sharing
from motionlab.lanes import Lanes, compiled, unpack
from motionlab.plant.current import Amplifiers
from motionlab.plant.encoder import Encoder
from motionlab.plant.friction import LuGre
from motionlab.plant.magnetics import ForceMap
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


class State(NamedTuple):
    """Everything a lane remembers from one tick to the next."""

    p: Lanes  # plant: position, m
    v: Lanes  # velocity, m/s
    z: Lanes  # bristle state, m
    y: Lanes  # deflection that the encoder sees, m
    y_rate: Lanes  # m/s
    i_a: Lanes  # phase currents, A
    i_b: Lanes
    i_c: Lanes
    p_last: Lanes  # controller: last measured position, m
    v_last: Lanes  # and velocity, m/s
    e_last: Lanes  # last following error, m
    z_hat: Lanes  # bristle estimate, m
    residual: Lanes  # filtered force balance, N
    d: Lanes  # disturbance estimate, N
    n_1: Lanes  # the notch's memory, N
    n_2: Lanes
    f_acting: Lanes  # in effect over the last period: realised force, N
    f_hat_acting: Lanes  # the friction estimate it was made with, N
    f_added_acting: Lanes  # the part of the estimate that was added, N
    K_acting: Lanes  # m/s
    f_pending: Lanes  # the same, computed but not yet in effect (loop delay)
    f_hat_pending: Lanes
    f_added_pending: Lanes
    K_pending: Lanes
    c_a_pending: Lanes  # current commands not yet in effect, A
    c_b_pending: Lanes
    c_c_pending: Lanes
    age: Lanes  # ticks since the start
    failed: Lanes  # tick at which the lane diverged; -1 while it has not


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
STATE_ROWS = len(State._fields)
INPUT_ROWS = len(Inputs._fields)
SAMPLE_ROWS = len(Sample._fields)


def parameter_row(path: str) -> int:
    """Return the row of a lane parameter, such as ``controller.k_p``, in a parameter array."""
    group, _, field = path.partition(".")
    index = _NAMES.index(group)
    return sum(_SIZES[:index]) + _GROUPS[index]._fields.index(field)


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
