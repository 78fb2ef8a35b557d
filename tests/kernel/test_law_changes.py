"""A law that replaces another has the other's state as far as both have it, and no more."""

from __future__ import annotations

from motionlab.kernel.law_calls import law_number
from motionlab.kernel.layout import state_row
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
