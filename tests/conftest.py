"""Settings for all tests."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import httpx
import pytest
from hypothesis import settings

from motionlab.executors import progress

if TYPE_CHECKING:
    from tests.server.openapi import Contract
    from tests.server.servers import Server

# The same examples on every run, and no assertion on timing.
settings.register_profile("motionlab", deadline=None, derandomize=True)
settings.load_profile("motionlab")

# Where a shell has started the tests behind its back, an interrupt is ignored, by servers too.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

TESTS = Path(__file__).parent
_skipped: list[str] = []
_retried: dict[str, str] = {}


@pytest.fixture(scope="session", autouse=True)
def _nothing_of_the_user(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Let servers and commands keep what they keep where no user looks, and be reached directly."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTIONLAB_DATA", str(tmp_path_factory.mktemp("data")))
        for name in ("MOTIONLAB_TOKEN", "MOTIONLAB_HOSTS"):
            patch.delenv(name, raising=False)
        for name in [name for name in os.environ if name.lower().endswith("_proxy")]:
            patch.delenv(name)
        # What a test reads of stderr must not depend on what was compiled before.
        patch.setattr(progress, "_notes_shown", {progress.COMPILING})
        yield


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    """A server for all tests that need no settings of their own."""
    from tests.server.servers import Server

    server = Server()
    yield server
    server.stop()


@pytest.fixture(scope="session")
def document() -> dict[str, Any]:
    """Return the OpenAPI document of a server without a token."""
    from tests.server.openapi import document

    return document()


@pytest.fixture(scope="session")
def contract(document: dict[str, Any]) -> Contract:
    from tests.server.openapi import Contract

    return Contract(document)


@pytest.fixture(scope="session")
def client(server: Server, contract: Contract) -> Iterator[httpx.Client]:
    """Return a client whose every answer has to be one that OpenAPI describes."""
    hooks: dict[str, list[Any]] = {"response": [contract.check]}
    with httpx.Client(base_url=server.url, event_hooks=hooks, timeout=120) as client:
        yield client


MAY_TAKE_TWO = {
    "drive/link/test_motion.py": "a machine that stands still for 60 ms ends a motion on drives",
    "drive/link/test_running.py": "a machine that stands still for 60 ms ends a motion on drives",
    "e2e/test_scene.py": "the 3-D view is drawn by software beside its server",
    "library/test_recording.py": "disks are filled and made read-only under servers that end",
    "drive/plug/test_motion.py": "a machine that stands still for 60 ms ends a motion on drives",
    "server/test_slow_clients.py": "what a slow client loses depends on when its process runs",
    "server/test_view3d.py": "processes are ended and started again while viewers connect",
}
"""Files of tests that may pass at the second try, and why."""

MOST_RETRIED = 2
"""Other tests that may, since a busy machine stands still now and then; with more, all fails."""


LONGEST = (
    "project/test_documented_commands.py",
    "server/test_fuzz.py",
    "drive/plug/test_motion.py",
    "executors/test_executors.py",
    "library/test_recording.py",
    "server/test_view3d.py",
    "server/test_job_processes.py",
    "project/test_wheel.py",
    "paper/test_reproduce.py",
    "server/test_connections.py",
    "drive/plug/test_routes.py",
    "server/test_workers.py",
    "server/test_jobs.py",
    "studies/identify/test_experiment.py",
    "motor_design/test_finite_elements.py",
    "studies/maps/test_command.py",
    "studies/identify/test_interval_coverage.py",
    "drive/link/test_running.py",
    "e2e/test_lab.py",
    "e2e/test_runs.py",
    "e2e/test_trajectories.py",
    "e2e/test_scene.py",
)
"""Files that take longest: they begin first, so that no core waits for one of them."""


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Begin with the longest files; try a failed test again where CI has other work.

    The second try tells what fails from what races. `make lowest` has no plugin for it.
    """
    order = {name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: order.get(item.path.relative_to(TESTS).as_posix(), len(order)))
    if os.environ.get("CI") != "true" or not config.pluginmanager.hasplugin("rerunfailures"):
        return
    for item in items:
        item.add_marker(pytest.mark.flaky(reruns=1))


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Keep why tests were skipped, and which were tried again."""
    if report.outcome == "rerun":
        _retried[report.nodeid] = report.longreprtext
    if report.skipped and isinstance(report.longrepr, tuple):
        _skipped.append(report.longrepr[2].removeprefix("Skipped: "))


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail the run for tests that needed a second try and are not on the list of those that may."""
    others = sum(not may_take_two(test) for test in _retried)
    if session.exitstatus == pytest.ExitCode.OK and others > MOST_RETRIED:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def may_take_two(nodeid: str) -> bool:
    """Tell whether a test may pass at the second try."""
    return nodeid.split("::", maxsplit=1)[0].removeprefix("tests/") in MAY_TAKE_TWO


def pytest_unconfigure() -> None:
    """Say last what was tried twice and why, how many tests were skipped, and how to get them."""
    for test, failure in _retried.items():
        print(f"tried twice, {'listed' if may_take_two(test) else 'not listed'}: {test}\n{failure}")
    for reason in dict.fromkeys(_skipped):
        print(f"{_skipped.count(reason)} tests skipped: {reason}")
