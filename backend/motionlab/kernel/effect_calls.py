"""Calls of the plant's effects from the kernel, `motionlab.kernel.row_calls`.

Each lane has some slots, each for one effect, with rows of their own. Where no lane has an effect
the kernel is compiled without any of this.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba.extending import overload
from numpy.typing import NDArray

from motionlab.effects import OWN, SHIPPED, SOURCES
from motionlab.effects.effect import (
    PARAMETER_ROWS,
    SLOTS,
    STATE_ROWS,
    Effect,
    MidStep,
)
from motionlab.kernel.layout import EFFECT, EFFECT_STATE
from motionlab.kernel.row_calls import OnRows, RowCode, caller, chosen
from motionlab.lanes import WIDTH, Lanes, compiled, load_vectors, pack, store_vectors, unpack

Array = NDArray[np.float64]


class _Number(NamedTuple):
    effect: Lanes


class _Lasting(NamedTuple):
    lasts: Lanes  # 1: the state goes on from the step's end; 0: it stays


class Resisted(NamedTuple):
    """The forces of all effects of a lane over a step."""

    force: Lanes  # subtracted from the thrust, N
    damping: Lanes  # N s/m
    friction: Lanes  # the part of the force that is friction, N


_NUMBER = 0
_PARAMETERS = 1
_STATE = _PARAMETERS + PARAMETER_ROWS
_SEEN = _STATE + STATE_ROWS
_LASTING = _SEEN + len(MidStep._fields)
_RESISTED = _LASTING + 1
ROWS = _RESISTED + len(Resisted._fields)

_EACH, _EACH_STATE = 1 + PARAMETER_ROWS, 1 + STATE_ROWS
"""Rows of a slot among parameters and states of a lane."""


class Effects(NamedTuple):
    """The effects that lanes side by side may have, and the rows of their calls."""

    addresses: NDArray[np.int64]  # of the machine code of each effect by number, 0: none
    used: NDArray[np.int64]  # (slots, numbers), 1 where a lane has this effect; overwritten
    rows: Array  # (slots, vectors, ROWS, WIDTH); overwritten


# -- calls ----------------------------------------------------------------------------------------


@compiled
def enter_effects(parameters: Array, state: Array, effects: Effects | None) -> None:
    """Write parameters and state of lanes into the rows of their effects' calls.

    An effect that was not there before begins with a state of zero.
    """
    if effects is not None:
        used, rows = effects.used, effects.rows
        used[:] = 0
        rows[:] = 0.0
        for slot in range(rows.shape[0]):
            for vector in range(rows.shape[1]):
                for lane in range(WIDTH):
                    place = vector * WIDTH + lane
                    first, of_state = EFFECT + slot * _EACH, EFFECT_STATE + slot * _EACH_STATE
                    for row in range(_EACH):
                        rows[slot, vector, row, lane] = parameters[first + row, place]
                    number = parameters[first, place]
                    if state[of_state, place] != number:
                        state[of_state, place] = number
                        for row in range(STATE_ROWS):
                            state[of_state + 1 + row, place] = 0.0
                    for row in range(STATE_ROWS):
                        rows[slot, vector, _STATE + row, lane] = state[of_state + 1 + row, place]
                    used[slot, int(number)] = 1


@compiled
def leave_effects(state: Array, effects: Effects | None) -> None:
    """Write the state of effects back into the state of their lanes."""
    if effects is not None:
        rows = effects.rows
        for slot in range(rows.shape[0]):
            for vector in range(rows.shape[1]):
                for lane in range(WIDTH):
                    first = EFFECT_STATE + slot * _EACH_STATE + 1
                    for row in range(STATE_ROWS):
                        value = rows[slot, vector, _STATE + row, lane]
                        state[first + row, vector * WIDTH + lane] = value


@compiled
def resist(effects: Effects, seen: MidStep, lasts: Lanes) -> Resisted:
    """Return the forces of all effects of each lane, and step their states where that `lasts`."""
    force = damping = friction = 0.0 * seen.M
    for slot in range(effects.rows.shape[0]):
        rows = effects.rows[slot]
        store_vectors(seen, rows, _SEEN)
        store_vectors(_Lasting(lasts), rows, _LASTING)
        for number in range(1, effects.addresses.shape[0]):
            if effects.used[slot, number] != 0:
                for vector in range(rows.shape[0]):
                    call_effect(number, effects.addresses, rows, vector)
        forces = load_vectors(Resisted, rows, _RESISTED, seen.M)
        force = force + forces.force
        damping = damping + forces.damping
        friction = friction + forces.friction
    return Resisted(force, damping, friction)


# -- code of an effect ----------------------------------------------------------------------------


def on_rows(number: int, effect: Effect) -> OnRows:
    """Return the function that calls an effect on the rows of eight lanes, (ROWS, WIDTH)."""
    step, par_record, state_record = effect.step, effect.Parameters, effect.State
    stateless, share = not state_record._fields, float(effect.friction)

    @compiled
    def call(rows: Array) -> None:
        par = unpack(par_record, rows, _PARAMETERS)
        state = unpack(state_record, rows, _STATE)
        resistance, after = step(par, state, unpack(MidStep, rows, _SEEN))
        force, damping = resistance.force, resistance.damping
        own = unpack(_Number, rows, _NUMBER).effect == float(number)
        before = unpack(Resisted, rows, _RESISTED)
        pack(chosen(own, Resisted(force, damping, share * force), before), rows[_RESISTED:ROWS])
        if not stateless:
            lasting = own & (unpack(_Lasting, rows, _LASTING).lasts > 0.0)
            pack(chosen(lasting, after, state), rows[_STATE : _STATE + len(state)])

    return call


_BY_NUMBER = (*SHIPPED.values(), *OWN.values())
_NUMBERS = {effect.name: 1.0 + k for k, effect in enumerate(_BY_NUMBER)}
_CODE = RowCode(1 + len(_BY_NUMBER), ROWS)


def effect_numbers(lanes: list[tuple[str, Any]]) -> list[float]:
    """Return the rows of the effects of one lane, of the name and `Parameters` of each."""
    rows: list[float] = []
    for name, par in lanes:
        rows += [_NUMBERS[name], *map(float, par), *[0.0] * (PARAMETER_ROWS - len(par))]
    return rows + [0.0] * (SLOTS * _EACH - len(rows))


def effects_of(parameters: Array) -> Effects | None:
    """Return the calls of the effects of lanes, compiled, or loaded, if not there; None for none.

    Parameters
    ----------
    parameters : ndarray, shape (..., PARAMETER_ROWS, lanes)
        As `motionlab.kernel.law_calls.laws_of` takes them.
    """
    numbers = parameters[..., EFFECT : EFFECT + SLOTS * _EACH : _EACH, :]
    if not numbers.any():
        return None
    for number in {int(number) for number in numbers.ravel().tolist()} - {0}:
        _CODE.require(number, lambda number=number: _code(number))
    slots = max(slot for slot in range(SLOTS) if numbers[..., slot, :].any()) + 1
    return Effects(
        _CODE.addresses,
        np.zeros((slots, len(_CODE.addresses)), dtype=np.int64),
        np.zeros((slots, parameters.shape[-1] // WIDTH, ROWS, WIDTH)),
    )


def _code(number: int) -> tuple[OnRows, str | None]:
    effect = _BY_NUMBER[number - 1]
    return on_rows(number, effect), SOURCES.get(effect.name)


_call = caller(ROWS)


def call_effect(number: int, _addresses: NDArray[np.int64], rows: Array, vector: int) -> None:
    """Call an effect on the rows of one vector of lanes."""
    _CODE.code[number](rows[vector])


@overload(call_effect, inline="always", strict=False)
def _overload_call_effect(number: Any, _addresses: Any, rows: Any, vector: Any) -> Any:
    def at_address(number: int, _addresses: NDArray[np.int64], rows: Array, vector: int) -> None:
        _call(_addresses[number], rows, vector)  # pyright: ignore[reportCallIssue]

    return at_address
