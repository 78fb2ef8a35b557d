"""What the lab computes with a law: ``python -m tests.laws.surfaces LAW`` prints it as JSON."""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

from motionlab.config.load import load_scenario
from motionlab.loop.document import loop_document
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from tests.export.controller_unit import current_error
from tests.targets.scenario_runs import differences, run_in_module

SHORT = {"trajectory.laps": 1, "trajectory.lead_in": 0.1}


def surfaces(law: str) -> dict[str, Any]:
    """Return what a recording, the page's module, the margins and an FMU have of a law."""
    changes = {"variants.B.controller.compensation.law": law}
    prepared = prepare(load_scenario("circle", SHORT | changes))
    estimate = run(prepared).variants["B"].channel("friction_estimate", "x")
    module = differences(prepared, run_in_module(prepared).recording)
    loop = loop_document(prepared.scenario).model_dump()["variants"]["B"]["axes"]["x"]
    return {
        "recorded": float(np.abs(estimate).max()),
        "module_error": module["B"].channels["friction_estimate"],
        "phase_margin": loop["phase_margin"],
        **_unit(SHORT | changes),
    }


def _unit(changes: dict[str, Any]) -> dict[str, Any]:
    """Return the largest error of an FMU's currents, A, and the names of its parameters."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "unit.fmu"
        error = current_error(path, changes, 0.5)
        variables: Any = fmpy.read_model_description(str(path)).modelVariables
    parameters = [each.name for each in variables if each.causality == "parameter"]
    return {"unit_error": error, "unit_parameters": parameters}


if __name__ == "__main__":
    print(json.dumps(surfaces(sys.argv[1])))
