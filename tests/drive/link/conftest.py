"""One virtual drive and one link for a file of tests."""

from collections.abc import Iterator

import pytest

from tests.drive.link.rig import Rig


@pytest.fixture(scope="module")
def rig() -> Iterator[Rig]:
    with Rig() as running:
        yield running
