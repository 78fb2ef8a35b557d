"""A segment and a master for its tests, and network cards."""

import os
import shutil
import socket
import subprocess
from collections.abc import Iterator

import pytest

from motionlab.drive.virtual.segment import Segment
from tests.drive.virtual.bus import Bus

NO_RIGHT = "no right to make network cards: needs root, or CAP_NET_ADMIN and CAP_NET_RAW"


@pytest.fixture
def segment() -> Segment:
    return Segment()


@pytest.fixture
def bus(segment: Segment) -> Bus:
    return Bus(segment.exchange)


@pytest.fixture(scope="module")
def cards() -> Iterator[tuple[str, str]]:
    """Make two network cards that are joined, and remove them at the end."""
    program = shutil.which("ip") or shutil.which("ip", path="/usr/sbin:/sbin")
    if program is None:
        pytest.skip("no ip: apt-get install iproute2")
    ends = f"ml{os.getpid()}a", f"ml{os.getpid()}b"

    def ip(*words: str) -> bool:
        done = subprocess.run([program, "link", *words], check=False, capture_output=True)
        return done.returncode == 0

    if not ip("add", ends[0], "type", "veth", "peer", "name", ends[1]):
        pytest.skip(NO_RIGHT)
    try:
        if not all(ip("set", end, "up") for end in ends):
            pytest.skip(NO_RIGHT)
        try:
            socket.socket(socket.AF_PACKET, socket.SOCK_RAW, 0).close()
        except PermissionError:
            pytest.skip(NO_RIGHT)
        yield ends
    finally:
        ip("del", ends[0])
