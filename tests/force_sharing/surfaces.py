"""What the lab makes of a sharing function: ``python -m tests.force_sharing.surfaces NAME``."""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np

from motionlab.config.fields import fields_of
from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.config.schema import schema_text
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.targets.lane_code import lane_code
from tests.targets.scenario_runs import differences, run_in_module

EXACT = {f"plant.{axis}.encoder.resolution": 0.0 for axis in "xy"}
SHORT = {"trajectory.laps": 1, "trajectory.lead_in": 0.1}
SHARING = "variants.*.controller.sharing"


def surfaces(name: str) -> dict[str, Any]:
    """Return the function's entries in fields, schema and lane code, and runs with it."""
    fields = fields_of(Scenario)
    changes = {f"{SHARING.replace('*', 'B')}.law": name}
    prepared = prepare(load_scenario("circle", SHORT | EXACT | changes))
    variants = run(prepared).variants
    commands = [variants[each].channel("current_command_a", "x") for each in "AB"]
    return {
        "choices": [each.value for each in fields[f"{SHARING}.law"].choices or ()],
        "fields": {
            path.rpartition(".")[2]: entry.used_with
            for path, entry in fields.items()
            if path.startswith(f"{SHARING}.") and entry.used_with
        },
        "schema": name in schema_text("controller"),
        "lane_code": json.dumps(name) in lane_code(),
        "differs": float(np.abs(commands[0] - commands[1]).max()),
        "module_error": differences(prepared, run_in_module(prepared).recording)["B"].channels[
            "current_command_a"
        ],
    }


if __name__ == "__main__":
    print(json.dumps(surfaces(sys.argv[1])))
