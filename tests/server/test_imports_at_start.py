"""A server answers before what only some calls need is imported."""

from __future__ import annotations

import subprocess
import sys

import pytest

LATER = {
    "scipy.interpolate",
    "scipy.optimize",
    "scipy.sparse",
    "skfem",
    "pyarrow",
    "pydantic_settings",
    "motionlab.studies.identify.experiment",
    "motionlab.studies.montecarlo.cases",
    "motionlab.paper.registry",
    "motionlab.studies.tune.search",
    "motionlab.drive",
}

APPLICATION = "from motionlab.server.app import create_app; create_app()"

STORED_MAP = """\
from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import prepare
prepare(load_scenario("circle", {"plant.force_map": "new-design"}))"""


@pytest.mark.parametrize("code", [APPLICATION, STORED_MAP])
def test_nothing_is_imported_that_only_some_calls_need(code: str) -> None:
    script = f"{code}\nimport sys; print(sys.modules.keys() & {LATER})"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "set()"
