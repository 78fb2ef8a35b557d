"""Application layer: states, their checks, the watchdog."""

from __future__ import annotations

import struct

import pytest

from motionlab.drive import process_data as pd
from motionlab.drive.ethercat import (
    INIT,
    OP,
    PREOP,
    REGISTER_DC_ACTIVATION,
    REGISTER_SYNC_MANAGER,
    REGISTER_WATCHDOG_PROCESS_DATA,
    SAFEOP,
)
from motionlab.drive.virtual.segment import Segment
from tests.drive.virtual.bus import NODES, PERIOD, Bus, Refused


@pytest.mark.parametrize(
    ("state", "code"), [(SAFEOP, 0x11), (OP, 0x11), (3, 0x13), (5, 0x12), (0, 0x12)]
)
def test_a_state_that_cannot_be_reached_raises_an_error(bus: Bus, state: int, code: int) -> None:
    bus.address()
    assert bus.request(0, state) == (INIT | 0x10, code)
    bus.mailboxes(0)
    assert bus.request(0, PREOP) == (INIT | 0x10, code)  # not acknowledged
    assert bus.request(0, INIT | 0x10) == (INIT, 0)
    assert bus.request(0, PREOP) == (PREOP, 0)


def test_mailboxes_have_to_be_set_up(bus: Bus) -> None:
    bus.address()
    assert bus.request(2, PREOP) == (INIT | 0x10, 0x16)


@pytest.mark.parametrize(
    ("outputs", "inputs", "code"), [(5, 16, 0x1D), (0, 16, 0x1D), (6, 15, 0x1E), (6, 16, 0)]
)
def test_sizes_of_process_data(bus: Bus, outputs: int, inputs: int, code: int) -> None:
    bus.to_preop()
    bus.process_data(0, outputs, inputs)
    assert bus.request(0, SAFEOP) == ((PREOP | 0x10, code) if code else (SAFEOP, 0))


def test_a_drive_needs_its_watchdog(bus: Bus) -> None:
    bus.to_preop()
    bus.process_data(0)
    for ticks, code in ((0, 0x1F), (1001, 0x1F), (1000, 0)):
        bus.write(0, REGISTER_WATCHDOG_PROCESS_DATA, struct.pack("<H", ticks))
        assert bus.request(0, SAFEOP | 0x10) == ((PREOP | 0x10, code) if code else (SAFEOP, 0))


def test_down_is_allowed_from_everywhere(bus: Bus) -> None:
    bus.to_op()
    for state in (SAFEOP, PREOP, INIT):
        assert bus.request(1, state) == (state, 0)


@pytest.mark.parametrize("sync0", [False, True])
def test_a_gap_of_19_ms_is_stood_and_one_of_22_ms_is_not(bus: Bus, sync0: bool) -> None:
    bus.to_op(sync0)
    bus.enable()
    bus.outputs["torque"] = 500
    for _ in range(20):
        bus.now += PERIOD
        bus.exchange_all()
    bus.now += 19_000_000
    found = bus.exchange_all()
    assert [bus.state(n) for n in range(NODES)] == [(OP, 0)] * NODES
    assert {pd.drive_state(int(v)) for v in found["status"]} == {"operation enabled"}
    assert (found["torque"] > 490).all()
    bus.now += 22_000_000
    assert [bus.state(n) for n in range(NODES)] == [(SAFEOP | 0x10, 0x1B)] * NODES
    bus.exchange_all()
    bus.now += 4 * PERIOD
    found = bus.exchange_all()  # the counter is right in SAFEOP too
    assert {pd.drive_state(int(v)) for v in found["status"]} == {"fault"}
    assert (found["torque"] == 0).all()
    assert (found["error"] == 0x8700).all()

    # Nothing moves again by itself: acknowledge, OP, fault reset, and all transitions.
    for n in range(NODES):
        assert bus.request(n, SAFEOP | 0x10) == (SAFEOP, 0)
        assert bus.request(n, OP) == (OP, 0)
    bus.outputs["torque"] = 0
    assert {pd.drive_state(int(v)) for v in bus.control(pd.ENABLED)["status"]} == {"fault"}
    assert {pd.drive_state(int(v)) for v in bus.enable()["status"]} == {"operation enabled"}


def test_the_watchdog_is_as_long_as_set(bus: Bus) -> None:
    bus.to_op()
    bus.write(0, REGISTER_WATCHDOG_PROCESS_DATA, struct.pack("<H", 50))
    bus.exchange_all()
    bus.now += 4_900_000
    assert bus.state(0) == (OP, 0)
    bus.now += 200_000
    assert bus.state(0) == (SAFEOP | 0x10, 0x1B)
    assert bus.state(1) == (OP, 0)


def test_init_forgets_settings(bus: Bus) -> None:
    bus.to_preop()
    bus.download(0, 0x6073, 0, struct.pack("<H", 700))
    assert bus.upload(0, 0x6073) == struct.pack("<H", 700)
    assert bus.request(0, INIT) == (INIT, 0)
    assert bus.request(0, PREOP) == (PREOP, 0)
    assert bus.upload(0, 0x6073) == struct.pack("<H", 1000)


def test_sync0_has_to_run_before_safeop_and_op(bus: Bus) -> None:
    bus.to_preop()
    bus.clocks()
    bus.download(0, 0x1C32, 1, b"\x02\0")
    bus.process_data(0)
    assert bus.request(0, SAFEOP) == (PREOP | 0x10, 0x30)
    bus.start_sync0(bus.system_time() + 10_000_000, 250_001)
    assert bus.request(0, SAFEOP | 0x10) == (PREOP | 0x10, 0x35)
    bus.start_sync0(bus.system_time() - 1)  # has passed: it never begins
    assert bus.request(0, SAFEOP | 0x10) == (PREOP | 0x10, 0x30)
    bus.start_sync0(bus.system_time() + 10_000_000)
    assert bus.request(0, SAFEOP | 0x10) == (SAFEOP, 0)
    assert bus.request(0, OP) == (SAFEOP | 0x10, 0x2D)
    bus.now += 11_000_000
    assert bus.request(0, OP | 0x10) == (OP, 0)
    bus.write(0, REGISTER_DC_ACTIVATION, b"\0")
    assert bus.state(0) == (SAFEOP | 0x10, 0x1A)


def test_timing_is_set_in_preop_alone(bus: Bus) -> None:
    bus.to_op()
    with pytest.raises(Refused, match="0x08000022"):
        bus.download(0, 0x1C32, 1, b"\x02\0")


def test_a_mailbox_is_sent_again_on_request(bus: Bus) -> None:
    bus.to_preop()
    answer = bus.mail(0, struct.pack("<HBHB4x", 2 << 12, 0x40, 0x1018, 4))
    assert not bus.number(0, REGISTER_SYNC_MANAGER + 13, 1) & 8
    bus.write(0, REGISTER_SYNC_MANAGER + 14, b"\x03")  # repeat
    assert bus.number(0, REGISTER_SYNC_MANAGER + 15, 1) == 2
    again = bus.read(0, 0x1080, 128)
    assert again[6 : 6 + len(answer)] == answer


def test_a_segment_stands_still_and_goes_on(segment: Segment, bus: Bus) -> None:
    bus.to_op(sync0=True)
    bus.now += 3_600_000_000_000  # an hour
    assert bus.state(0) == (SAFEOP | 0x10, 0x1B)
    assert segment.status()["counters"]["skipped_ns"] > 3_599_000_000_000
    bus.request(0, SAFEOP | 0x10)
    assert bus.request(0, OP) == (OP, 0)
