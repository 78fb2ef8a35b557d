"""A segment and a master for its tests."""

import pytest

from motionlab.drive.virtual.segment import Segment
from tests.drive.virtual.bus import Bus


@pytest.fixture
def segment() -> Segment:
    return Segment()


@pytest.fixture
def bus(segment: Segment) -> Bus:
    return Bus(segment.exchange)
