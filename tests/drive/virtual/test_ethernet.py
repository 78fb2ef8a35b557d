"""Link and virtual drive on network cards, in raw Ethernet frames."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest

from motionlab.drive.link.link import DriveLink
from motionlab.drive.link.shared import State
from motionlab.drive.virtual.process import VirtualDrive
from tests.drive.link.rig import SLOW, linked

pytestmark = pytest.mark.realtime
PATIENCE = 90.0  # s, with what is to be compiled


def wait(condition: Callable[[], bool]) -> bool:
    deadline = time.monotonic() + PATIENCE
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.005)
    return condition()


def test_our_master_exchanges_process_data_on_a_network_card(cards: tuple[str, str]) -> None:
    with VirtualDrive(interface=cards[0], slow=SLOW) as drive:
        link = DriveLink(linked(drive, carrier="ethernet", interface=cards[1], port=1))
        try:
            assert wait(lambda: link.state != State.OFFLINE or bool(link.problem))
            assert link.state == State.READY, (link.problem, link.fault())
            status = drive.status()
            assert {node["al_state"] for node in status["nodes"]} == {8}
            frames = status["counters"]["frames"]
            assert wait(lambda: drive.status()["counters"]["frames"] > frames + 500)
            assert link.state == State.READY, link.fault()
            drive.switch(link=0)
            assert wait(lambda: link.state in {State.FAULT, State.OFFLINE})
        finally:
            link.close()
