"""Which answers the loop takes for those to its present cycle."""

from __future__ import annotations

import socket

import numpy as np
import pytest

from motionlab.drive.libc import new_clock, now
from motionlab.drive.link.bus import cyclic_bus, read_inputs

WAIT = 5_000_000
"""ns."""


@pytest.mark.parametrize("later", [1, 128, 128 * 256])
def test_an_answer_that_waited_is_never_taken_for_a_new_one(later: int) -> None:
    near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
    with near, far:
        clock = new_clock()
        bus = cyclic_bus(near.fileno(), b"", clock, clocks=True)
        assert not read_inputs(bus, 7, now(clock) + WAIT).good
        asked = far.recv(2048)
        far.send(asked)
        assert not read_inputs(bus, 7 + later, now(clock) + WAIT).good
        far.send(asked)
        far.send(far.recv(2048))
        taken = read_inputs(bus, 7 + later, now(clock) + WAIT)
        assert taken.good
        np.testing.assert_array_equal(bus.answer[: bus.read.size], bus.read)
