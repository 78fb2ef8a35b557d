"""The circle with changes, and lane parameters of B's law on x: printed as JSON."""

from __future__ import annotations

import json
import sys

from motionlab.config.load import load_scenario
from motionlab.kernel.build import lane
from motionlab.kernel.layout import PARAMETERS

if __name__ == "__main__":
    scenario = load_scenario("circle", json.loads(sys.argv[1]))
    law = lane(scenario, scenario.variants["B"].controller, "x").law
    first = next(row for row, path in enumerate(PARAMETERS) if path.startswith("law."))
    print(json.dumps([scenario.model_dump(mode="json"), first, law]))
