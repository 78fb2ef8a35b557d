"""Calls of laws from the kernel, `motionlab.kernel.row_calls`.

What a law reads and writes lies in rows of eight lanes; a call writes the lanes that have this law,
and no others.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numba.extending import overload
from numpy.typing import NDArray

from motionlab.control.position import PositionController
from motionlab.kernel.effect_calls import effects_of, enter_effects, leave_effects
from motionlab.kernel.layout import (
    CONTROLLER,
    INPUT_ROWS,
    LAW_NUMBER,
    LAW_OF_STATE,
    LAW_PARAMETERS,
    LAW_STATE,
    MODEL_FRICTION,
    SAMPLE_ROWS,
    LawParameters,
    LawState,
    Parameters,
)
from motionlab.kernel.motion import Ahead, Motion, seen
from motionlab.kernel.row_calls import OnRows, RowCode, caller, chosen
from motionlab.lanes import (
    WIDTH,
    Lanes,
    axes_at,
    compiled,
    load_vectors,
    pack,
    record,
    store_vectors,
    unpack,
)
from motionlab.laws import OWN, SHIPPED, SOURCES, base_of
from motionlab.laws.law import Estimate, Law
from motionlab.plant.friction import LuGre

Array = NDArray[np.float64]


class _Number(NamedTuple):
    law: Lanes


# -- rows of a call -------------------------------------------------------------------------------

_RECORDS: tuple[Any, ...] = (
    _Number,
    LawParameters,
    PositionController,
    LuGre,
    LawState,
    Motion,
    Ahead,
    Estimate,
    _Number,
)
_FIRST = np.cumsum([0, *(len(record._fields) for record in _RECORDS)]).tolist()
(
    _NUMBER,
    _PARAMETERS,
    _CONTROLLER,
    _FRICTION,
    _STATE,
    _MOTION,
    AHEAD_ROW,
    _ESTIMATE,
    _CALLED,
    ROWS,
) = _FIRST

_FROM = np.concatenate(
    [
        np.arange(first, first + len(record._fields))
        for record, first in zip(
            _RECORDS[:4], (LAW_NUMBER, LAW_PARAMETERS, CONTROLLER, MODEL_FRICTION), strict=True
        )
    ]
)
"""Row of a parameter array for each row before the state."""
_STATES = len(LawState._fields)


class Laws(NamedTuple):
    """The laws that lanes side by side may have, and the rows of their calls; so for effects."""

    addresses: NDArray[np.int64]  # of the machine code of each law, (laws,)
    used: NDArray[np.int64]  # 1 where a lane has this law; overwritten
    rows: Array  # (vectors, ROWS, WIDTH); overwritten
    carried: NDArray[np.int64]  # row of the state of one law for each of another; -1: none
    effects: Any  # `motionlab.kernel.effect_calls.Effects`, or None where no lane has one


@compiled
def adopt_states(parameters: Array, state: Array, carried: NDArray[np.int64]) -> None:
    """Give lanes whose law has changed a state of their new one.

    Fields of the same name are carried over, others begin at 0: a number of one law means nothing
    to another.
    """
    laws = carried.shape[0]
    for place in range(state.shape[1]):
        before, after = int(state[LAW_OF_STATE, place]), int(parameters[LAW_NUMBER, place])
        if before != after and 0 <= before < laws and 0 <= after < laws:
            old = (  # a tuple: code for browsers has no memory to take
                state[LAW_STATE, place],
                state[LAW_STATE + 1, place],
                state[LAW_STATE + 2, place],
                state[LAW_STATE + 3, place],
                state[LAW_STATE + 4, place],
                state[LAW_STATE + 5, place],
                state[LAW_STATE + 6, place],
                state[LAW_STATE + 7, place],
            )
            for row in range(_STATES):
                source = carried[before, after, row]
                state[LAW_STATE + row, place] = old[source] if source >= 0 else 0.0
            state[LAW_OF_STATE, place] = after


@compiled
def enter_laws(parameters: Array, state: Array, laws: Laws) -> None:
    """Write parameters and state of lanes into the rows of their laws' and effects' calls."""
    adopt_states(parameters, state, laws.carried)
    enter_effects(parameters, state, laws.effects)
    used, rows = laws.used, laws.rows
    used[:] = 0
    for vector in range(rows.shape[0]):
        for lane in range(WIDTH):
            place = vector * WIDTH + lane
            for row in range(_STATE):
                rows[vector, row, lane] = parameters[_FROM[row], place]
            for row in range(_STATES):
                rows[vector, _STATE + row, lane] = state[LAW_STATE + row, place]
            for law in range(used.shape[0]):  # a lane without a number is of no law
                if rows[vector, _NUMBER, lane] == law:
                    used[law] = 1


@compiled
def leave_laws(state: Array, laws: Laws) -> None:
    """Write the state of laws and effects back into the state of their lanes."""
    leave_effects(state, laws.effects)
    rows = laws.rows
    for vector in range(rows.shape[0]):
        for lane in range(WIDTH):
            for row in range(_STATES):
                state[LAW_STATE + row, vector * WIDTH + lane] = rows[vector, _STATE + row, lane]


@compiled
def look_ahead(laws: Laws, inputs: Array, k: int, width: Lanes) -> None:
    """Write the motion to come into the rows of laws' calls, where inputs have rows of it."""
    if inputs.shape[1] > INPUT_ROWS:
        ahead = axes_at(Ahead, inputs[:, INPUT_ROWS:], k, width)
        store_vectors(ahead, laws.rows, AHEAD_ROW)


@compiled
def record_laws(laws: Laws, samples: NDArray[np.float32], k: int, width: Lanes) -> None:
    """Record the states of laws, where samples have rows for them."""
    if samples.shape[1] > SAMPLE_ROWS:
        state = load_vectors(LawState, laws.rows, _STATE, width)
        record(state, samples[:, SAMPLE_ROWS:], k)


@compiled
def estimate_friction(laws: Laws, motion: Any) -> Estimate:
    """Return the friction estimate of each lane by its own law, and step the laws' states."""
    store_vectors(motion, laws.rows, _MOTION)
    for law in range(laws.addresses.shape[0]):
        if laws.used[law] != 0:
            for vector in range(laws.rows.shape[0]):
                for lane in range(WIDTH):
                    laws.rows[vector, _CALLED, lane] = law
                call_law(law, laws.addresses, laws.rows, vector)
    return load_vectors(Estimate, laws.rows, _ESTIMATE, motion.p)


# -- code of a law --------------------------------------------------------------------------------


def on_rows(law: Law) -> OnRows:
    """Return the function that calls a law on the rows of eight lanes, (ROWS, WIDTH).

    It knows no number of the law, and so may run under any.
    """
    step, par_record, state_record = law.step, law.Parameters, law.State
    stateless = not state_record._fields

    @compiled
    def call(rows: Array) -> None:
        par = unpack(par_record, rows, _PARAMETERS)
        state = unpack(state_record, rows, _STATE)
        motion, friction = unpack(Motion, rows, _MOTION), unpack(LuGre, rows, _FRICTION)
        ahead = unpack(Ahead, rows, AHEAD_ROW)
        known = seen(unpack(PositionController, rows, _CONTROLLER), friction, motion, ahead)
        estimate, after = step(par, state, known)
        own = unpack(_Number, rows, _NUMBER).law == unpack(_Number, rows, _CALLED).law
        before = unpack(Estimate, rows, _ESTIMATE)
        pack(chosen(own, estimate, before), rows[_ESTIMATE:_CALLED])
        if not stateless:
            pack(chosen(own, after, state), rows[_STATE : _STATE + len(state)])

    return call


def _numbered() -> tuple[dict[str, int], list[Law]]:
    """Return the number of each law, and a law of each number; laws of one step share it.

    Those that ship come first: their numbers stand in the page's module.
    """
    numbers: dict[str, int] = {}
    by_number: dict[Any, Law] = {}
    for law in (*SHIPPED.values(), *OWN.values()):
        own = law.name if law.name in OWN else ""  # whose step may become another
        alike = (law.step, law.Parameters, law.State, law.limits, law.sliding, own)
        by_number.setdefault(alike, law)
        numbers[law.name] = list(by_number).index(alike)
    return numbers, list(by_number.values())


_NUMBERS, LAWS_BY_NUMBER = _numbered()
SHIPPED_BY_NUMBER = LAWS_BY_NUMBER[: 1 + max(_NUMBERS[name] for name in SHIPPED)]


def _carried(laws: list[Law]) -> NDArray[np.int64]:
    """Return the row of one law's state that each row of another's takes over, or -1.

    Shape (laws, laws, rows of a state): from, to.
    """
    rows = np.full((len(laws), len(laws), _STATES), -1, dtype=np.int64)
    for i, before in enumerate(laws):
        for j, after in enumerate(laws):
            versions = i != j and base_of(before.name) == base_of(after.name)
            resets = after.resets if versions else ()
            if before.State is after.State and not resets:
                rows[i, j] = np.arange(_STATES)
                continue
            for row, name in enumerate(after.State._fields):
                if name in before.State._fields and name not in resets:
                    rows[i, j, row] = before.State._fields.index(name)
    return rows


_CARRIED = [_carried(LAWS_BY_NUMBER)]
"""One table, which another one replaces."""
SHIPPED_CARRIED = _carried(SHIPPED_BY_NUMBER)
_CODE = RowCode(len(LAWS_BY_NUMBER), ROWS)


def law_of(par: Parameters) -> Law:
    """Return the law of one lane, or one that shares its step."""
    return LAWS_BY_NUMBER[int(par.compensation.law)]


def law_parameters(par: Parameters) -> Any:
    """Return the parameters of one lane's law as its own record."""
    record = law_of(par).Parameters
    return record(*par.law[: len(record._fields)])


def law_number(name: str) -> float:
    """Return the number of a law in the kernel."""
    return float(_NUMBERS[name])


def all_laws() -> Laws:
    """Return the calls of every law for eight lanes, whose parameters may change to any other."""
    for number in range(len(LAWS_BY_NUMBER)):
        _require(number)
    return _calls(1, None)


def laws_of(parameters: Array) -> Laws:
    """Return the calls of the laws and effects of lanes, compiled, or loaded, if not there.

    Parameters
    ----------
    parameters : ndarray, shape (..., PARAMETER_ROWS, lanes)
        Parameters of lanes side by side, or of several such blocks.
    """
    for number in {int(number) for number in parameters[..., LAW_NUMBER, :].ravel().tolist()}:
        _require(number)
    return _calls(parameters.shape[-1] // WIDTH, effects_of(parameters))


def _calls(vectors: int, effects: Any) -> Laws:
    addresses, rows = _CODE.addresses, np.zeros((vectors, ROWS, WIDTH))
    return Laws(addresses, np.zeros_like(addresses), rows, _CARRIED[0], effects)


def _require(number: int) -> None:
    _CODE.require(number, lambda: _code(number))


def _code(number: int) -> tuple[OnRows, str | None]:
    law = LAWS_BY_NUMBER[number]
    return on_rows(law), SOURCES.get(law.name)


def compiled_law(law: Law, source: str) -> Any:
    """Return the machine code of a version of a law of one's own, which `put_laws` takes."""
    return _CODE.compiled(on_rows(law), source)


def code_of(name: str) -> Any:
    """Return the machine code that runs under the name of a law; None where none has yet."""
    return _CODE.code.get(_NUMBERS.get(name, -1))


def put_laws(laws: Mapping[str, Law], code: Mapping[str, Any]) -> None:
    """Have laws of one's own run under their names from now on.

    Parameters
    ----------
    laws : mapping of str to Law
        By name; one that is not there yet gets a number of its own, and numbers stay.
    code : mapping of str to machine code
        Of those that run other code than before; None: it is compiled when a lane first has it.
    """
    with _CODE.lock:
        for name, law in laws.items():
            number = _NUMBERS.setdefault(name, len(LAWS_BY_NUMBER))
            LAWS_BY_NUMBER[number : number + 1] = [law]
            if name in code:
                _CODE.put(number, code[name])
        _CARRIED[:] = [_carried(LAWS_BY_NUMBER)]


_call = caller(ROWS)


def call_law(law: int, _addresses: NDArray[np.int64], rows: Array, vector: int) -> None:
    """Call a law on the rows of one vector of lanes."""
    _CODE.code[law](rows[vector])


@overload(call_law, inline="always", strict=False)
def _overload_call_law(law: Any, _addresses: Any, rows: Any, vector: Any) -> Any:
    def at_address(law: int, _addresses: NDArray[np.int64], rows: Array, vector: int) -> None:
        _call(_addresses[law], rows, vector)  # pyright: ignore[reportCallIssue]

    return at_address
