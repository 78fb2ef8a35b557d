"""A law that replaces another has the other's state as far as both have it, and no more."""

from __future__ import annotations

import math

import numpy as np
import pytest

from motionlab.kernel.law_calls import all_laws, law_number
from motionlab.kernel.layout import INPUT_ROWS, parameter_row, state_row
from motionlab.kernel.tick import control_once
from motionlab.lanes import WIDTH
from tests.kernel.lane_runs import Array, at_rest, circle, inputs, lane, rows, run
from tests.nominal_motor import X, Y

Z, RESIDUAL, OWNER = (state_row(name) for name in ("law.s_0", "law.s_1", "law_number"))


def lanes(law: str) -> Array:
    return rows([lane(axis, law) for axis in (X, Y)] * (WIDTH // 2))


def test_the_bristle_is_carried_over_and_the_residual_is_not() -> None:
    motion = circle(600)
    driven = inputs(motion)
    state = at_rest(motion[0, 0])
    run(lanes("residual-k"), state, driven[:400])
    bristle, residual = state[Z].copy(), state[RESIDUAL].copy()
    assert (residual != 0.0).all()

    same, other = state.copy(), state.copy()
    run(lanes("reversed-k"), same, driven[400:401])
    run(lanes("lugre-observer"), other, driven[400:401])
    assert (abs(other[Z] - bristle) < 0.1 * abs(bristle)).all()
    assert (other[RESIDUAL] == 0.0).all()
    assert (same[RESIDUAL] != 0.0).all()
    assert (other[OWNER] == law_number("lugre-observer")).all()


@pytest.mark.parametrize("number", [math.nan, -1.0, 1e9])
def test_a_lane_whose_law_is_no_law_writes_no_memory_of_others(number: float) -> None:
    parameters = lanes("residual-k")
    parameters[parameter_row("compensation.law"), 3] = number
    laws = all_laws()
    around = np.zeros(3 * len(laws.used), dtype=np.int64)
    used = around[len(laws.used) : 2 * len(laws.used)]
    state = at_rest(circle(1)[0, 0])
    reference = np.zeros((1, INPUT_ROWS, 2))
    control_once(parameters, state, reference, np.zeros((1, WIDTH)), laws._replace(used=used))
    assert list(np.flatnonzero(used)) == [law_number("residual-k")]
    assert around.sum() == 1
