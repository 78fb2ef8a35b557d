"""The module gives the same bytes in Chromium, in Firefox and under node."""

from __future__ import annotations

import functools
from ctypes.util import find_library

import pytest

from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import Prepared, prepare
from tests.e2e.conftest import CHROMIUM, missing
from tests.targets.browser_engines import FIREFOX, Evaluate, in_chromium, in_firefox, run_in
from tests.targets.scenario_runs import ModuleRun, run_in_module

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module", params=[{}, {"plant.force_map": "new-design"}])
def prepared(request: pytest.FixtureRequest) -> Prepared:
    """Return a lap of the circle with the formula of the force map, and with its tables."""
    return prepare(load_scenario("circle", {"trajectory.laps": 1} | request.param))


@pytest.fixture(scope="module")
def under_node(prepared: Prepared) -> ModuleRun:
    """Return its run under node."""
    return run_in_module(prepared)


@pytest.mark.parametrize("browser", ["Chromium", "Firefox"])
def test_the_same_bytes(prepared: Prepared, under_node: ModuleRun, browser: str) -> None:
    evaluate: Evaluate = in_firefox if browser == "Firefox" else in_chromium
    if (FIREFOX if browser == "Firefox" else CHROMIUM) is None:
        missing(f"no {browser} on this machine: make browser installs Debian's")
    if browser == "Chromium" and find_library("atomic") is None:
        missing("the driver of the browser needs libatomic: make browser installs it")
    run = run_in_module(prepared, functools.partial(run_in, evaluate))
    for name, record in under_node.recording.variants.items():
        other = run.recording.variants[name]
        assert record.samples.tobytes() == other.samples.tobytes(), name
        assert under_node.tallies[name].tobytes() == run.tallies[name].tobytes()
        assert under_node.nearest[name].tobytes() == run.nearest[name].tobytes()
