"""What the bring-up refuses and writes, in lockstep with the virtual segment."""

from __future__ import annotations

from typing import Any

import pytest

from motionlab.drive.ethercat import OP, REGISTER_AL_STATUS
from motionlab.drive.link.bring_up import startup_list
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.link.mailbox import Mailbox
from motionlab.drive.process_data import NODES
from tests.drive.link.lockstep import Lockstep


@pytest.fixture
def loop() -> Lockstep:
    """Drives that are in INIT again."""
    loop = Lockstep()
    loop.master.shut_down()
    return loop


def assert_refused(loop: Lockstep, message: str) -> None:
    """Check that the drives are not brought up, and that none gets as far as OP."""
    with pytest.raises(LinkError, match=message):
        loop.bring_up()
    assert (loop.segment.arrays.memory[:, REGISTER_AL_STATUS] & 0x0F < OP).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"vendor": 0x1234}, r"nodes\.2\.vendor: drive 3 is 0xe0000001, 0x1234 expected"),
        ({"product": 0x5002}, r"nodes\.2\.product: drive 3 is 0x5001, 0x5002 expected"),
        ({"rated_current": 5.0}, r"nodes\.2\.rated_current = 5 A: drive 3 says 10 A"),
    ],
    ids=["vendor", "product", "rated current"],
)
def test_another_drive_than_configured(
    loop: Lockstep, change: dict[str, Any], message: str
) -> None:
    nodes = list(loop.config.nodes)
    nodes[2] = nodes[2].model_copy(update=change)
    loop.config = loop.config.model_copy(update={"nodes": tuple(nodes)})
    assert_refused(loop, message)


def test_another_number_of_drives(loop: Lockstep) -> None:
    loop.segment.switch(link=5)
    assert_refused(loop, "5 drives on the bus, 6 expected")


def test_drives_without_the_mode(loop: Lockstep, monkeypatch: pytest.MonkeyPatch) -> None:
    number = Mailbox.number
    monkeypatch.setattr(
        Mailbox,
        "number",
        lambda self, index, sub=0: 1 if index == 0x6502 else number(self, index, sub),
    )
    assert_refused(loop, "drive 1 has no cyclic synchronous torque mode")


def test_limits_are_written_each_time(loop: Lockstep) -> None:
    loop.bring_up()
    limits = {0x6065, 0x6066, 0x6072, 0x6073, 0x607D}
    for _ in range(2):
        written = set()
        for node, config in enumerate(loop.config.nodes):
            mailbox = loop.master._mailboxes[node]
            for parameter in startup_list(loop.config, config):
                if parameter.index in limits:
                    found = mailbox.number(parameter.index, parameter.subindex)
                    assert found == parameter.value % (1 << 8 * parameter.size), parameter
                    written.add((node, parameter.index))
        assert len(written) == 2 * NODES + 3 * 2  # of each drive, and of those with an encoder
        # Drives forget them at power-off, and others may be wanted.
        loop.config = loop.config.model_copy(
            update={
                "x": loop.config.x.model_copy(update={"current_max": 4.0}),
                "y": loop.config.y.model_copy(update={"position_max": 0.02}),
            }
        )
        loop.bring_up()
