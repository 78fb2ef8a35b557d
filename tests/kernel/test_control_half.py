"""The control half by itself computes what it computes within a tick."""

from __future__ import annotations

import numpy as np
import pytest

from motionlab.kernel.law_calls import laws_of
from motionlab.kernel.layout import STATE_ROWS, state_row
from motionlab.kernel.tick import control_once
from motionlab.lanes import WIDTH
from tests.kernel.lane_runs import at_rest, circle, inputs, lane, rows, run
from tests.nominal_motor import X, Y

MACHINE = slice(state_row("plant.p"), state_row("memory.p_last"))
CONTROLLER = np.r_[state_row("memory.p_last") : state_row("age"), state_row("law.s_0") : STATE_ROWS]


@pytest.mark.parametrize("delay", [0.0, 1.0])
@pytest.mark.parametrize(
    "law", ["off", "lugre-observer", "canudas-de-wit", "residual-k", "reversed-k"]
)
def test_it_needs_no_more_than_reference_and_measured_position(law: str, delay: float) -> None:
    changes = {"encoder.resolution": 0.0, "controller.delay": delay, "controller.observer": 1.0}
    both = [lane(axis, law, changes) for axis in (X, Y)]
    lanes = rows(both * (WIDTH // 2))
    motion = circle(400)
    driven = inputs(motion)
    state = at_rest(motion[0, 0])
    for k in range(len(driven)):
        before, alone = state.copy(), state.copy()
        p_meas = alone[state_row("plant.p")] + alone[state_row("plant.y")]
        run(lanes, state, driven[k : k + 1])
        control_once(lanes, alone, driven[k : k + 1], p_meas[None], laws_of(lanes))
        np.testing.assert_array_equal(alone[MACHINE], before[MACHINE])
        # The compiler fuses other products and sums here than within a tick.
        np.testing.assert_allclose(alone[CONTROLLER], state[CONTROLLER], rtol=1e-9, atol=1e-15)
    assert np.abs(state[state_row("acting.force")]).max() > 1.0
