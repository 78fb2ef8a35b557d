"""Row layout of the kernel's arrays: lane parameters, state, inputs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple, get_type_hints

import numpy as np
from numpy.typing import NDArray

from motionlab.control.compensation import Compensation
from motionlab.control.filters import Biquad
from motionlab.control.position import PositionController
from motionlab.effects import effect
from motionlab.force_sharing.functions import CLOSED_FORM, SharingParameters
from motionlab.force_sharing.share import ForceModel, Sharing
from motionlab.lanes import Lanes, compiled, pack, unpack
from motionlab.plant.current import Amplifiers
from motionlab.plant.encoder import Encoder, Subdivision
from motionlab.plant.friction import LuGre
from motionlab.plant.machine import PlantState
from motionlab.plant.magnetics import AnalyticMap
from motionlab.plant.mechanics import Mechanics
from motionlab.plant.resonance import Resonance
from motionlab.plant.table_map import MotorMap, TableMap
from motionlab.telemetry.channels import Sample


class Inputs(NamedTuple):
    """Inputs common to all variants: one value per axis and tick."""

    p_ref: Lanes  # m
    v_ref: Lanes  # m/s
    a_ref: Lanes  # m/s^2
    load: Lanes  # external load force f_d, N
    encoder_noise: Lanes  # m
    current_a: Lanes  # ripple and noise of the currents, A
    current_b: Lanes
    current_c: Lanes
    learnt: Lanes  # force that was learnt of the motion, N
    encoder_jitter: Lanes  # time by which the encoder samples late, s


class ControllerState(NamedTuple):
    """State of the controller, its commands apart."""

    p_last: Lanes  # last measured position, m
    v_last: Lanes  # and velocity, m/s
    e_last: Lanes  # last following error, m
    d: Lanes  # disturbance estimate, N
    n_1: Lanes  # states of the notch, N
    n_2: Lanes
    f_1: Lanes  # states of the three filters after it, N
    f_2: Lanes
    f_3: Lanes
    f_4: Lanes
    f_5: Lanes
    f_6: Lanes


class Command(NamedTuple):
    """Force and currents of one period with their terms, acting or pending."""

    force: Lanes  # realised within the limits, N
    estimate: Lanes  # friction estimate, N
    added: Lanes  # the part of the estimate that was added, N
    K: Lanes  # m/s
    current_a: Lanes  # A
    current_b: Lanes
    current_c: Lanes


class State(NamedTuple):
    """State of a lane between ticks; those of its law and effects lie in rows of their own."""

    plant: PlantState
    memory: ControllerState
    acting: Command
    pending: Command  # computed but not yet in effect
    age: Lanes  # ticks since the start
    failed: Lanes  # tick at which the lane diverged; -1 while it has not


class LawParameters(NamedTuple):
    """Parameters of a lane's law, in the order of its own record."""

    p_0: Lanes
    p_1: Lanes
    p_2: Lanes
    p_3: Lanes
    p_4: Lanes
    p_5: Lanes
    p_6: Lanes
    p_7: Lanes


class LawState(NamedTuple):
    """State of a lane's law, in the order of its own record."""

    s_0: Lanes
    s_1: Lanes
    s_2: Lanes
    s_3: Lanes
    s_4: Lanes
    s_5: Lanes
    s_6: Lanes
    s_7: Lanes


class _Clock(NamedTuple):
    age: Lanes
    failed: Lanes


class Limits(NamedTuple):
    """Limits of each lane."""

    error: Lanes  # following error beyond which the lane has diverged, m


class Parameters(NamedTuple):
    """The parameter groups of a lane, those of its effects apart.

    Plant and controller's model are separate.
    """

    friction: LuGre
    force_map: MotorMap
    amplifiers: Amplifiers
    encoder: Encoder
    mechanics: Mechanics
    resonance: Resonance
    controller: PositionController
    notch: Biquad
    filter_1: Biquad
    filter_2: Biquad
    filter_3: Biquad
    compensation: Compensation
    model_friction: LuGre
    model_subdivision: Subdivision
    force_model: ForceModel
    limits: Limits
    law: LawParameters


def _paths(record: Any, prefix: str = "") -> Iterator[str]:
    """Yield the dotted path of every number of a record of records, in the order of its rows."""
    for name, kind in get_type_hints(record).items():
        if hasattr(kind, "_fields"):
            yield from _paths(kind, f"{prefix}{name}.")
        else:
            yield prefix + name


def _first_rows(paths: tuple[str, ...]) -> list[int]:
    """Return the first row of each group: compiled code takes it as a constant."""
    owners = [path.rpartition(".")[0] for path in paths]
    return [row for row, owner in enumerate(owners) if owner not in owners[max(row - 1, 0) : row]]


def _of_effects(letter: str, count: int) -> list[str]:
    """Return the paths of the effects of a lane: the number of each, 0 for none, then its own."""
    names = ("number", *(f"{letter}_{k}" for k in range(count)))
    return [f"effects.{slot}.{name}" for slot in range(effect.SLOTS) for name in names]


EFFECT_PARAMETERS = _of_effects("p", effect.PARAMETER_ROWS)
EFFECT_STATES = _of_effects("s", effect.STATE_ROWS)
PARAMETERS = (*_paths(Parameters), *EFFECT_PARAMETERS)
"""The dotted path of each row of an array of lane parameters."""
PARAMETER_ROWS = len(PARAMETERS)
LAW_STATES = (*(f"law.{name}" for name in LawState._fields), "law_number")
STATES = (*_paths(State), *LAW_STATES, *EFFECT_STATES)
"""The dotted path of each row of an array of states."""
STATE_ROWS = len(STATES)
INPUT_ROWS = len(Inputs._fields)
SAMPLE_ROWS = len(Sample._fields)


def parameter_row(path: str) -> int:
    """Return the row of a lane parameter, such as ``controller.k_p``, in a parameter array."""
    return PARAMETERS.index(path)


def state_row(path: str) -> int:
    """Return the row of a field of the state, such as ``plant.p``, in an array of states."""
    return STATES.index(path)


def column(par: Any, effects: list[float] | None = None) -> list[float]:
    """Return the numbers of `Parameters` of one lane, and of its effects, in order of their rows.

    `effects` are `EFFECT_PARAMETERS`; left out, there are none.
    """
    return [*_numbers(par), *([0.0] * len(EFFECT_PARAMETERS) if effects is None else effects)]


def _numbers(par: Any) -> list[float]:
    numbers: list[float] = []
    for each in par:
        numbers += _numbers(each) if isinstance(each, tuple) else (float(each),)
    return numbers


_, _MEMORY, _ACTING, _PENDING, _CLOCK, LAW_STATE, LAW_OF_STATE, EFFECT_STATE, *_ = _first_rows(
    STATES
)


@compiled
def read_state(state: NDArray[np.float64], width: Lanes) -> State:
    """Return `State` from an array, (STATE_ROWS, lanes), as wide as other lanes."""
    clock = unpack(_Clock, state, _CLOCK, width)
    return State(
        unpack(PlantState, state, 0, width),
        unpack(ControllerState, state, _MEMORY, width),
        unpack(Command, state, _ACTING, width),
        unpack(Command, state, _PENDING, width),
        clock.age,
        clock.failed,
    )


@compiled
def write_state(s: State, state: NDArray[np.float64]) -> None:
    """Write `State` into an array, (STATE_ROWS, lanes)."""
    pack(s.plant, state[:_MEMORY])
    pack(s.memory, state[_MEMORY:_ACTING])
    pack(s.acting, state[_ACTING:_PENDING])
    pack(s.pending, state[_PENDING:_CLOCK])
    pack(_Clock(s.age, s.failed), state[_CLOCK:LAW_STATE])


LAW_NUMBER = parameter_row("compensation.law")
FORCE_LIMIT_ROW = parameter_row("controller.force_limit")
_TABLED = [
    parameter_row(path)
    for path in (
        "force_map.table.thrust",
        "force_model.map.table.thrust",
        "force_model.sharing.law",
    )
]
(
    _FRICTION,
    _FORMULA,
    _TABLE,
    _AMPLIFIERS,
    _ENCODER,
    _MECHANICS,
    _RESONANCE,
    CONTROLLER,
    _NOTCH,
    _FILTER_1,
    _FILTER_2,
    _FILTER_3,
    _COMPENSATION,
    MODEL_FRICTION,
    _MODEL_SUBDIVISION,
    _MODEL_FORMULA,
    _MODEL_TABLE,
    _SHARING,
    _SHARING_PARAMETERS,
    _LIMITS,
    LAW_PARAMETERS,
    EFFECT,
    *_,
) = _first_rows(PARAMETERS)


@compiled
def groups(parameters: NDArray[np.float64], width: Lanes) -> Parameters:
    """Return the groups of `Parameters` of an array, (PARAMETER_ROWS, lanes), as wide as others."""
    return Parameters(
        unpack(LuGre, parameters, _FRICTION, width),
        MotorMap(
            unpack(AnalyticMap, parameters, _FORMULA, width),
            unpack(TableMap, parameters, _TABLE, width),
        ),
        unpack(Amplifiers, parameters, _AMPLIFIERS, width),
        unpack(Encoder, parameters, _ENCODER, width),
        unpack(Mechanics, parameters, _MECHANICS, width),
        unpack(Resonance, parameters, _RESONANCE, width),
        unpack(PositionController, parameters, CONTROLLER, width),
        unpack(Biquad, parameters, _NOTCH, width),
        unpack(Biquad, parameters, _FILTER_1, width),
        unpack(Biquad, parameters, _FILTER_2, width),
        unpack(Biquad, parameters, _FILTER_3, width),
        unpack(Compensation, parameters, _COMPENSATION, width),
        unpack(LuGre, parameters, MODEL_FRICTION, width),
        unpack(Subdivision, parameters, _MODEL_SUBDIVISION, width),
        ForceModel(
            MotorMap(
                unpack(AnalyticMap, parameters, _MODEL_FORMULA, width),
                unpack(TableMap, parameters, _MODEL_TABLE, width),
            ),
            unpack(Sharing, parameters, _SHARING, width),
            unpack(SharingParameters, parameters, _SHARING_PARAMETERS, width),
        ),
        unpack(Limits, parameters, _LIMITS, width),
        unpack(LawParameters, parameters, LAW_PARAMETERS, width),
    )


def reads_tables(parameters: NDArray[np.float64]) -> list[bool]:
    """Return of each of the lanes of `parameters` whether it needs the kernel with tables."""
    plant, model, law = (parameters[row] for row in _TABLED)
    return ((plant >= 0.0) | (model >= 0.0) | (law != CLOSED_FORM)).tolist()
