"""On a machine that has nothing compiled, the scenario that opens first is answered at once."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.force_sharing.ripple import reachable_over
from motionlab.kernel.build import _linear_range
from motionlab.kernel.force_maps import force_model
from motionlab.simulation.lane_run import Known, lane_run
from motionlab.simulation.prepare import prepare

ANSWER = """\
import sys
from motionlab.config.load import load_scenario
from motionlab.simulation.lane_run import Known, lane_run
from motionlab.simulation.prepare import prepare
from motionlab.simulation.simulation import Simulation
prepared = prepare(load_scenario(sys.argv[1]))
Simulation(prepared, endless=True)  # of its session
sys.stdout.buffer.write(lane_run(prepared, None, prepared.reference.ticks, Known()).packed())"""


@pytest.mark.parametrize("name", ["circle", "circle-matched", "stair-y-500nm"])
def test_session_and_lanes_need_no_compiled_code(name: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", ANSWER, name],
        env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        check=True,
    )
    assert [path.name for path in tmp_path.rglob("*.nbi")] == []
    prepared = prepare(load_scenario(name))
    here = lane_run(prepared, None, prepared.reference.ticks, Known()).packed()
    assert hashlib.sha256(done.stdout).digest() == hashlib.sha256(here).digest()


@pytest.mark.parametrize("changes", [{}, {"h_2": 0.1, "h_3": 0.05, "offset": 1e-3}])
@pytest.mark.parametrize("limit", [2.0, 10.0])
def test_the_linear_range_in_closed_form_is_what_a_search_finds(
    changes: dict[str, float], limit: float
) -> None:
    controller = load_scenario("circle").variants["A"].controller
    force_map = controller.model.x.force_map.model_copy(update=changes)
    model = force_model(force_map, controller.sharing, limit)
    found = _linear_range(model)
    pitch = np.linspace(0.0, model.map.formula.tau, found.shape[1])
    for row, forward in zip(found, (False, True), strict=True):
        searched = reachable_over(model, position=pitch, forward=forward)
        np.testing.assert_allclose(row, searched, rtol=1e-11)
