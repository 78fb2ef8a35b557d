"""What is loaded, or on the first start compiled, before it is asked for."""

from __future__ import annotations

import importlib
import pkgutil

from motionlab import studies
from motionlab.config.load import load_scenario
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.design.fem.compute import compute
from motionlab.design.fem.geometry import Geometry
from motionlab.loop.linearise import linearise
from motionlab.service.routes import trajectories
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run


def warm_up() -> None:
    """Load, or on the first start compile, what simulations and paths need."""
    changes = {"trajectory": {"kind": "point", "duration": CONTROL_PERIOD}}
    prepared = prepare(load_scenario("circle", changes))
    document(prepared, run(prepared))
    linearise(prepared.scenario, "A", "x", v=0.0)
    trajectories.warm_up()


def load_the_rest() -> None:
    """Import what only some calls need: studies, scipy, and skfem by a preview of a force map."""
    compute(Geometry(), "preview")
    for module in pkgutil.walk_packages(studies.__path__, "motionlab.studies."):
        importlib.import_module(module.name)
