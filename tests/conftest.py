"""Settings for all tests."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

# The same examples on every run, and no assertion on timing.
settings.register_profile("motionlab", deadline=None, derandomize=True)
settings.load_profile("motionlab")

# Where a shell has started the tests behind its back, an interrupt is ignored, by servers too.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

_skipped: list[str] = []


@pytest.fixture(scope="session", autouse=True)
def _nothing_of_the_user(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Let servers and commands keep what they keep where no user looks, and be reached directly."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTIONLAB_DATA", str(tmp_path_factory.mktemp("data")))
        for name in ("MOTIONLAB_TOKEN", "MOTIONLAB_HOSTS"):
            patch.delenv(name, raising=False)
        for name in [name for name in os.environ if name.lower().endswith("_proxy")]:
            patch.delenv(name)
        yield


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give what waits on processes, sockets and browsers a second try where CI has other work."""
    if os.environ.get("CI") != "true":
        return
    root = Path(__file__).parent
    for item in items:
        if item.path.relative_to(root).parts[0] in {"e2e", "service"}:
            item.add_marker(pytest.mark.flaky(reruns=1))


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Keep why tests were skipped."""
    if report.skipped and isinstance(report.longrepr, tuple):
        _skipped.append(report.longrepr[2].removeprefix("Skipped: "))


def pytest_unconfigure() -> None:
    """Say last how many tests were skipped, and how to get them."""
    for reason in dict.fromkeys(_skipped):
        print(f"{_skipped.count(reason)} tests skipped: {reason}")
