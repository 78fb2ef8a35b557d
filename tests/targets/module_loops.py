"""The loops of a scenario's axes by the module under node."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.kernel.build import lane_parameters
from motionlab.lanes.bank import TABLES
from motionlab.loop.family import VELOCITIES
from motionlab.targets.wasm_exports import EXPORTS, LOOP_BYTES, Block
from tests.targets.module_run import Memory

Array = NDArray[np.float64]


class LoopOfModule(NamedTuple):
    """What the module writes of one loop."""

    radii: Array  # (v,)
    limits: Array  # (2, 2): k_p and k_d at standstill and sliding
    worst: Array  # (3, 2): value and velocity
    seconds: tuple[float, float]  # processor time of `linearise` and `margins`


def loops_in_module(scenario: Scenario) -> dict[tuple[str, str], LoopOfModule]:
    """Return the loop of each variant and axis."""
    memory = Memory()
    exports = {export.function.__name__: export.parameters for export in EXPORTS}
    at = {"tables": memory.put(TABLES.values), "speeds": memory.put(np.array(VELOCITIES))}
    for name in ("linearise", "margins"):
        for block in exports[name]:
            if isinstance(block, Block) and block.name in LOOP_BYTES and block.name != "speeds":
                at[block.name] = memory.put(np.zeros(LOOP_BYTES[block.name] // 8))
    parts = {}
    lanes = lane_parameters(scenario)
    for number, variant in enumerate(scenario.variants):
        own = lanes[0, :, 2 * number : 2 * number + 2]
        at["parameters"] = memory.put(np.ascontiguousarray(own))
        for axis, letter in enumerate(AXES):
            part = [np.zeros((1, len(VELOCITIES))), np.zeros((2, 2)), np.zeros((3, 2))]
            parts[variant, letter] = part
            for name, array in zip(("radii", "limits", "worst"), part, strict=True):
                at[name] = memory.result(array)
            for name in ("linearise", "margins"):
                blocks = exports[name]
                memory.call(name, *(axis if isinstance(b, str) else at[b.name] for b in blocks))
    seconds = memory.run()
    return {
        key: LoopOfModule(radii[0], limits, worst, (seconds[2 * i], seconds[2 * i + 1]))
        for i, (key, (radii, limits, worst)) in enumerate(parts.items())
    }
