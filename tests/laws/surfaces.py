"""What the lab computes with a law: ``python -m tests.laws.surfaces LAW`` prints it as JSON."""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.loop.document import loop_document
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from tests.targets.scenario_runs import differences, run_in_module

SHORT = {"trajectory.laps": 1, "trajectory.lead_in": 0.1}


def surfaces(law: str) -> dict[str, Any]:
    """Return the largest recorded estimate, that of the page's module, and the phase margin."""
    changes = {"variants.B.controller.compensation.law": law}
    prepared = prepare(load_scenario("circle", SHORT | changes))
    estimate = run(prepared).variants["B"].channel("friction_estimate", "x")
    module = differences(prepared, run_in_module(prepared).recording)
    loop = loop_document(prepared.scenario).model_dump()["variants"]["B"]["axes"]["x"]
    return {
        "recorded": float(np.abs(estimate).max()),
        "module_error": module["B"].channels["friction_estimate"],
        "phase_margin": loop["phase_margin"],
    }


if __name__ == "__main__":
    print(json.dumps(surfaces(sys.argv[1])))
