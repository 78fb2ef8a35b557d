"""Imports and compiles in advance of the first request.

``python -m motionlab.server.preload`` does all of it once, for later processes to find.
"""

from __future__ import annotations

import importlib
import pkgutil

from motionlab import studies
from motionlab.config.load import load_scenario
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.loop.linearise import linearise
from motionlab.motor_design.fem.compute import compute
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.server.routes import trajectories
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from motionlab.telemetry.expressions import evaluate


def warm_up() -> None:
    """Load simulations and path checks; compile them on the first start."""
    changes = {"trajectory": {"kind": "point", "duration": CONTROL_PERIOD}}
    prepared = prepare(load_scenario("circle", changes))
    document(prepared, run(prepared))
    linearise(prepared.scenario, "A", "x", v=0.0)
    trajectories.warm_up()
    importlib.import_module("motionlab.library.spool")  # which the first Play needs


def load_the_rest() -> None:
    """Import rarely used modules: studies, runs, scipy, and skfem by a force-map preview."""
    compute(Geometry(), "preview")
    for module in pkgutil.walk_packages(studies.__path__, "motionlab.studies."):
        importlib.import_module(module.name)
    evaluate.warm_up()
    importlib.import_module("motionlab.library.index")
    importlib.import_module("pyarrow.parquet")


if __name__ == "__main__":
    warm_up()
    load_the_rest()
