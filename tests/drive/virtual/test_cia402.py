"""The drive profile: states, torque, limits, faults."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from motionlab.drive import process_data as pd
from motionlab.drive.virtual.segment import Segment
from tests.drive.virtual.bus import NODES, PERIOD, Bus


def states(found: np.ndarray) -> set[str]:
    return {pd.drive_state(int(status)) for status in found["status"]}


def test_control_words_lead_through_the_states(bus: Bus) -> None:
    bus.to_op()
    for word, state in (
        (pd.DISABLE_VOLTAGE, "switch on disabled"),
        (pd.ENABLED, "switch on disabled"),  # not without ready to switch on
        (pd.SHUTDOWN, "ready to switch on"),
        (pd.SWITCHED_ON, "switched on"),
        (pd.ENABLED, "operation enabled"),
        (pd.SWITCHED_ON, "switched on"),
        (pd.ENABLED, "operation enabled"),
        (pd.SHUTDOWN, "ready to switch on"),
        (pd.QUICK_STOP, "switch on disabled"),
        (pd.SHUTDOWN, "ready to switch on"),
        (pd.ENABLED, "operation enabled"),
        (pd.DISABLE_VOLTAGE, "switch on disabled"),
    ):
        assert states(bus.control(word)) == {state}, hex(word)


def test_one_transition_in_a_period(bus: Bus) -> None:
    bus.to_op()
    bus.control(pd.SHUTDOWN)
    bus.outputs["control"] = pd.ENABLED
    seen = []
    for _ in range(2):
        bus.now += PERIOD
        seen.append(states(bus.exchange_all()))
    assert seen == [{"switched on"}, {"operation enabled"}]


def test_current_follows_the_target_within_its_limits(bus: Bus) -> None:
    bus.to_preop()
    bus.download(1, 0x6073, 0, struct.pack("<H", 300))
    bus.to_op()
    assert bus.upload(1, 0x6073) == struct.pack("<H", 1000)  # lost at INIT
    bus.download(1, 0x6073, 0, struct.pack("<H", 300))
    bus.enable()
    bus.outputs["torque"] = (500, 500, -500, 1000, 1001, 0)
    found = bus.periods(20)
    assert found["torque"].tolist() == [500, 300, 0, 1000, 1000, 0]
    limited = [bool(status & 0x0800) for status in found["status"]]
    assert limited == [False, True, True, False, True, False]


def test_no_torque_in_another_mode(bus: Bus) -> None:
    bus.to_op()
    bus.outputs["mode"] = 8
    bus.enable()
    bus.outputs["torque"] = 500
    bus.outputs["mode"] = 8
    found = bus.periods(10)
    assert (found["torque"] == 0).all()
    assert (found["mode"] == 10).all()  # what it was when it was enabled


def test_a_quick_stop_takes_the_current_down_in_10_ms(bus: Bus) -> None:
    bus.to_op()
    bus.enable()
    bus.outputs["torque"] = 1000
    for _ in range(20):
        bus.now += PERIOD
        bus.exchange_all()
    bus.outputs["control"] = pd.QUICK_STOP
    torques, words = [], []
    for _ in range(30):
        found = bus.periods(1)
        torques.append(int(found["torque"][1]))
        words.append(pd.drive_state(int(found["status"][1])))
    assert words[0] == "quick stop active"
    assert words[-1] == "switch on disabled"
    assert 17 <= words.index("switch on disabled") <= 21
    assert 450 < torques[10] < 600
    assert torques[-1] == 0


def test_safe_torque_off(segment: Segment, bus: Bus) -> None:
    bus.to_op()
    bus.enable()
    bus.outputs["torque"] = 500
    bus.control(pd.ENABLED)
    segment.switch(sto=True)
    found = bus.control(pd.ENABLED)
    assert states(found) == {"switch on disabled"}
    assert (found["status"] & pd.STO_ACTIVE).all()
    found = bus.periods(10)
    assert (found["torque"] == 0).all()
    assert states(bus.control(pd.SHUTDOWN)) == {"switch on disabled"}
    segment.switch(sto=False)
    found = bus.control(pd.ENABLED)
    assert states(found) == {"switch on disabled"}  # by itself it does not come back
    assert not (found["status"] & pd.STO_ACTIVE).any()


def test_a_failed_drive_waits_for_a_reset(segment: Segment, bus: Bus) -> None:
    bus.to_op()
    bus.enable()
    bus.outputs["torque"] = 500
    segment.switch(fault={"node": 2, "code": 0x2310})
    bus.now += PERIOD
    bus.exchange_all()
    found = bus.periods(1)
    words = [pd.drive_state(int(found["status"][1]))]  # its reaction takes a step of the machine
    found = bus.periods(20)
    words.append(pd.drive_state(int(found["status"][1])))
    assert words[0] == words[-1] == "fault"
    assert found["error"].tolist() == [0, 0x2310, 0, 0, 0, 0]
    assert found["torque"][1] == 0 and found["torque"][0] == 500
    assert bus.upload(1, 0x1001) == b"\1"
    found = bus.control(pd.FAULT_RESET)
    assert states(found) == {"switch on disabled"}
    assert not found["error"].any()


def test_a_reset_needs_a_rising_bit(segment: Segment, bus: Bus) -> None:
    bus.to_op()
    bus.control(pd.FAULT_RESET)
    segment.switch(fault={"node": 1, "code": 0x2310})
    assert pd.drive_state(int(bus.control(pd.FAULT_RESET)["status"][0])) == "fault"
    bus.control(0)
    assert pd.drive_state(int(bus.control(pd.FAULT_RESET)["status"][0])) == "switch on disabled"


def test_a_lost_encoder_cannot_be_reset(segment: Segment, bus: Bus) -> None:
    bus.to_op()
    bus.enable()
    segment.switch(encoder_loss="y")
    found = bus.control(pd.ENABLED)
    assert found["error"].tolist() == [0, 0, 0, 0x7305, 0, 0]
    bus.control(0)
    assert bus.control(pd.FAULT_RESET)["error"][3] == 0x7305
    segment.switch(encoder_loss="")
    bus.control(0)
    assert bus.control(pd.FAULT_RESET)["error"][3] == 0


def test_leaving_op_takes_the_torque_away(segment: Segment, bus: Bus) -> None:
    bus.to_op()
    bus.enable()
    bus.outputs["torque"] = 500
    bus.control(pd.ENABLED)
    bus.request_all(4)
    assert not segment.arrays.command.any()
    found = bus.exchange_all()
    assert found["error"].tolist() == [0] * NODES
    for n in range(NODES):
        assert bus.request(n, 8) == (8, 0)
    assert states(bus.control(pd.ENABLED)) == {"switch on disabled"}


@pytest.mark.parametrize("sync0", [False, True])
def test_it_moves(segment: Segment, bus: Bus, sync0: bool) -> None:
    bus.to_op(sync0)
    bus.enable()
    bus.outputs["torque"] = (0, 700, 0, 0, 0, 700)
    found = bus.periods(100)
    x, y = segment.position
    assert abs(x) > 1e-4 and abs(y) > 1e-4
    assert found["position"][0] == pytest.approx(
        x / 50e-9, abs=2 * abs(found["velocity"][0]) * 5e-4 + 1
    )
    assert found["position"][[1, 2, 4, 5]].tolist() == [0] * 4
    assert np.sign(found["velocity"][0]) == np.sign(found["position"][0])
