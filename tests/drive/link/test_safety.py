"""What the loop promises, each shown in lockstep with the virtual segment: docs/drive.md."""

from __future__ import annotations

import numpy as np
import pytest

from motionlab.drive import faults
from motionlab.drive.ethercat import OP, REGISTER_AL_STATUS, REGISTER_AL_STATUS_CODE
from motionlab.drive.link.bus import Inputs
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.link.commanding import ARMING, REST, _command_currents
from motionlab.drive.link.cycle import (
    BRING_UP,
    GONE,
    HEARTBEAT,
    PHASE_CYCLES,
    QUITTING,
    _follow_clock,
    act,
)
from motionlab.drive.link.memory import PERIOD
from motionlab.drive.link.shared import Figure, Order, State, Status
from motionlab.drive.process_data import DISABLE_VOLTAGE, NODES, drive_state
from motionlab.drive.virtual.objects import Dictionary
from motionlab.kernel.layout import parameter_row
from motionlab.telemetry.channels import Sample
from motionlab.timing import CONTROL_PERIOD
from tests.drive.link.lockstep import Lockstep

ERROR = Sample._fields.index("following_error")
COMMAND = Sample._fields.index("current_command_a")
PROFILE_POSITION = 1


@pytest.fixture
def loop() -> Lockstep:
    return Lockstep()


def states(loop: Lockstep) -> set[str]:
    """Return the states of the drives, in words."""
    return {drive_state(int(word)) for word in loop.inputs["status"]}


def assert_off(loop: Lockstep) -> None:
    """Check that neither loop nor drives have torque."""
    assert loop.without_torque()
    loop.cycle(5)
    assert loop.without_torque()
    assert "operation enabled" not in states(loop)
    assert not loop.segment.arrays.command.any()


def says(
    loop: Lockstep, monkeypatch: pytest.MonkeyPatch, name: str, drive: int, value: int
) -> None:
    """Have a drive say something from now on."""
    read = loop._read

    def changed() -> Inputs:
        inputs = read()
        loop.inputs[name][drive - 1] = value
        return inputs

    monkeypatch.setattr(loop, "_read", changed)


# Loss of the link


@pytest.mark.parametrize("missed", [1, 2])
def test_one_or_two_missed_cycles_hold_the_last_command(loop: Lockstep, missed: int) -> None:
    loop.moving()
    before = loop.outputs["torque"].copy()
    loop.read_lost = True
    loop.cycle(missed)
    np.testing.assert_array_equal(loop.outputs["torque"], before)
    loop.read_lost = False
    loop.cycle(200)
    assert loop.state == State.MOVING
    end = loop.shared.status[Status.END]
    errors = loop.shared.samples[:end, ERROR, 0]
    assert np.isnan(errors).sum() == missed
    assert np.nanmax(np.abs(errors)) < 20e-6


def test_it_is_ready_with_its_first_inputs(loop: Lockstep) -> None:
    loop.shared.status[Status.STATE] = State.OFFLINE
    loop.read_lost = True
    loop.cycle(3)
    assert loop.state == State.OFFLINE
    loop.read_lost = False
    loop.cycle()
    assert loop.state == State.READY


@pytest.mark.parametrize("lost", ["read_lost", "write_lost"])
def test_10_ms_without_a_good_frame_latch_the_fault_of_the_link(loop: Lockstep, lost: str) -> None:
    loop.moving()
    setattr(loop, lost, True)
    # That an output was lost is seen one cycle later.
    loop.cycle(19 if lost == "read_lost" else 20)
    assert loop.state == State.MOVING
    loop.cycle()
    assert loop.fault == (faults.LINK_LOST, 0)
    assert loop.without_torque()
    assert loop.shared.figures[Figure.FAULT_VALUE] == pytest.approx(0.010)
    setattr(loop, lost, False)
    loop.cycle(50)
    assert loop.state == State.FAULT
    assert_off(loop)


def test_outputs_that_not_every_drive_takes_are_a_lost_link(loop: Lockstep) -> None:
    loop.moving()
    for _ in range(20):
        assert loop.state == State.MOVING
        loop.written = NODES - 1
        loop.cycle()
    assert loop.fault == (faults.LINK_LOST, 0)
    assert_off(loop)


def test_a_cable_out_behind_a_drive_is_a_lost_link(loop: Lockstep) -> None:
    loop.moving()
    loop.segment.switch(link=3)
    loop.cycle(20)
    assert loop.fault == (faults.LINK_LOST, 0)
    loop.segment.switch(clear=True)
    loop.cycle(5)
    assert_off(loop)


def test_a_loop_that_stood_still_for_10_ms_stops_too(loop: Lockstep) -> None:
    loop.moving()
    loop.sleep(20)
    loop.cycle()
    assert loop.fault == (faults.LINK_LOST, 0)
    assert_off(loop)


def test_a_loop_that_slept_through_some_periods_makes_up_for_them(loop: Lockstep) -> None:
    loop.moving()
    end = int(loop.shared.status[Status.END])
    loop.sleep(4)
    loop.cycle()
    assert loop.shared.status[Status.END] == end + 5
    assert np.isnan(loop.shared.samples[end : end + 4, ERROR, 0]).all()
    loop.cycle(100)
    assert loop.state == State.MOVING
    assert np.nanmax(np.abs(loop.shared.samples[end : end + 105, ERROR, 0])) < 20e-6


@pytest.mark.parametrize(("gap", "stays"), [(19, True), (22, False)])
def test_without_its_master_a_drive_switches_off(loop: Lockstep, gap: int, stays: bool) -> None:
    loop.moving()
    loop.segment.advance(loop.now + 50_000 + gap * 1_000_000)
    memory = loop.segment.arrays.memory
    al = {int(status) & 0x1F for status in memory[:, REGISTER_AL_STATUS]}
    assert al == ({OP} if stays else {0x14})
    assert bool(loop.segment.arrays.command.any()) is stays
    if not stays:
        assert (memory[:, REGISTER_AL_STATUS_CODE] == 0x1B).all()


def test_no_motion_after_the_link_returns_until_reset_and_arm(loop: Lockstep) -> None:
    loop.moving()
    loop.segment.switch(black_hole=True)
    loop.read_lost = loop.write_lost = True
    loop.cycle(100)
    assert loop.fault == (faults.LINK_LOST, 0)
    loop.segment.switch(clear=True)
    loop.read_lost = loop.write_lost = False
    where = loop.segment.position
    loop.cycle(200)
    assert loop.state == State.FAULT
    assert not loop.order(Order.ARM)
    assert not loop.order(Order.START)
    assert_off(loop)
    assert loop.segment.position == pytest.approx(where, abs=5e-3)  # it has run out

    loop.order(Order.RESET)
    assert loop.left == BRING_UP  # the watchdogs of the drives had fallen
    loop.bring_up()
    loop.cycle(60)
    assert loop.state == State.READY  # the reset has cleared the drives' own fault 0x8700
    assert loop.without_torque()
    where = loop.segment.position
    loop.cycle(200)
    assert loop.segment.position == pytest.approx(where, abs=1e-6)
    loop.arm()
    loop.line()
    loop.cycle(400)
    assert loop.state == State.MOVING


# What the drives say


def test_al_status_is_judged_although_the_working_counter_is_right(loop: Lockstep) -> None:
    loop.moving()
    read = loop._read()
    assert (read.working_counter, read.al_status) == (NODES, OP)
    args = loop.bus, loop.layout, loop.shared, loop.memory
    act(read._replace(al_status=0x1C, written=NODES), loop.now, *args)
    assert loop.fault == (faults.LEFT_OPERATION, 0)
    assert loop.without_torque()


def test_a_drive_that_falls_to_safeop_stops_all(loop: Lockstep) -> None:
    loop.moving()
    loop.segment.switch(safeop={"node": 3, "code": 0x1B})
    loop.cycle(10)
    assert loop.state == State.FAULT
    assert_off(loop)


def test_a_fault_of_one_drive_switches_all_off_and_is_told(loop: Lockstep) -> None:
    loop.moving()
    loop.segment.switch(fault={"node": 5, "code": 0x2310})
    loop.cycle(3)
    assert loop.fault == (faults.DRIVE_FAULT, 5)
    assert loop.shared.figures[Figure.FAULT_VALUE] == 0x2310
    assert (loop.outputs["control"] == DISABLE_VOLTAGE).all()
    assert_off(loop)
    loop.order(Order.RESET)
    loop.cycle(60)
    assert loop.state == State.READY
    assert states(loop) == {"ready to switch on"}
    assert not loop.inputs["error"].any()


def test_a_drive_that_is_no_longer_enabled_stops_all(loop: Lockstep) -> None:
    loop.moving()
    word = int(loop.inputs["status"][3])
    read = loop._read()
    loop.inputs["status"][3] = word & ~0x04  # switched on, not enabled
    args = loop.bus, loop.layout, loop.shared, loop.memory
    act(read._replace(written=NODES), loop.now, *args)
    assert loop.fault == (faults.NOT_ENABLED, 4)
    assert loop.without_torque()


def test_a_drive_that_does_not_enable_in_time_is_a_fault(
    loop: Lockstep, monkeypatch: pytest.MonkeyPatch
) -> None:
    says(loop, monkeypatch, "status", 4, 0x0231)  # ready to switch on
    assert loop.order(Order.ARM)
    loop.cycle(ARMING)
    assert loop.state == State.ARMING
    loop.cycle()
    assert loop.fault == (faults.NOT_ENABLED, 0)
    assert_off(loop)


def test_a_drive_that_leaves_its_mode_stops_all(
    loop: Lockstep, monkeypatch: pytest.MonkeyPatch
) -> None:
    loop.moving()
    says(loop, monkeypatch, "mode", 3, PROFILE_POSITION)
    loop.cycle()
    assert loop.fault == (faults.WRONG_MODE, 3)
    assert_off(loop)


def test_drives_that_enable_in_another_mode_get_no_torque(
    loop: Lockstep, monkeypatch: pytest.MonkeyPatch
) -> None:
    says(loop, monkeypatch, "mode", 3, PROFILE_POSITION)
    loop.order(Order.ARM)
    while loop.state == State.ARMING:
        loop.cycle()
    assert loop.fault == (faults.WRONG_MODE, 3)
    assert_off(loop)


def test_safe_torque_off_stops_all_and_says_so(loop: Lockstep) -> None:
    loop.moving()
    loop.segment.switch(sto=True)
    loop.cycle(3)
    assert loop.fault == (faults.STO, 1)
    assert_off(loop)
    loop.order(Order.RESET)
    loop.cycle(60)
    assert loop.state == State.READY
    assert loop.order(Order.ARM)
    loop.cycle(20)
    assert loop.fault == (faults.STO, 1)
    assert_off(loop)


# Limits


def test_a_drive_that_did_not_take_a_limit_is_refused(
    loop: Lockstep, monkeypatch: pytest.MonkeyPatch
) -> None:
    write = Dictionary.write

    def of_its_own(self: Dictionary, index: int, subindex: int, data: bytes, **exact: bool) -> None:
        own = self._n == 2 and index == 0x6072
        write(self, index, subindex, (900).to_bytes(2, "little") if own else data, **exact)

    monkeypatch.setattr(Dictionary, "write", of_its_own)
    told = "drive 3 did not take object 6072:00, .*: 1000 written, 900 read back"
    with pytest.raises(LinkError, match=told):
        loop.bring_up()
    assert OP not in set(loop.segment.arrays.memory[:, REGISTER_AL_STATUS].tolist())


def test_a_command_that_is_no_number_never_reaches_a_coil(loop: Lockstep) -> None:
    loop.moving()
    loop.shared.parameters[:, :, 0] = np.nan
    for _ in range(3):
        loop.cycle()
        assert loop.without_torque()
    assert loop.fault[0] in {faults.NOT_A_NUMBER, faults.DIVERGED}
    assert_off(loop)


@pytest.mark.parametrize("current", [np.nan, np.inf, -np.inf, -1.0, 1e9])
def test_no_current_is_negative_too_large_or_no_number(loop: Lockstep, current: float) -> None:
    loop.moving()
    loop.memory.samples[0, COMMAND : COMMAND + 3, :2] = current
    _command_currents(loop.layout, loop.shared, loop.memory)
    highest = 1000 if current == 1e9 else 0
    np.testing.assert_array_equal(loop.memory.torque, highest)
    if not np.isfinite(current):
        assert loop.fault == (faults.NOT_A_NUMBER, 1)


def test_a_controller_that_diverges_stops_all(loop: Lockstep) -> None:
    loop.moving()
    loop.shared.parameters[:, parameter_row("limits.error"), 0] = 1e-9
    loop.cycle(2)
    assert loop.fault == (faults.DIVERGED, 1)
    assert_off(loop)


def test_the_following_error_may_leave_its_window_for_its_time(loop: Lockstep) -> None:
    loop.arm()
    cycles = int(loop.layout.window_cycles[0])
    assert cycles == round(0.010 / CONTROL_PERIOD)
    loop.layout = loop.layout._replace(window=np.array([10e-6, 1.0]))
    loop.segment.switch(push={"axis": "x", "force": 30.0, "time": 1.0})
    while not loop.memory.outside[0]:
        loop.cycle()
    loop.cycle(cycles - 1)
    assert loop.state == State.HOLDING
    loop.cycle()
    assert loop.fault == (faults.FOLLOWING_ERROR, 1)
    assert_off(loop)


@pytest.mark.parametrize(
    ("limit", "value", "code"),
    [
        ("position_max", 5e-3, faults.POSITION_LIMIT),
        ("position_min", 1e-3, faults.POSITION_LIMIT),
        ("velocity_max", 40e-3, faults.SPEED_LIMIT),
    ],
)
def test_position_and_speed_are_limited(
    loop: Lockstep, limit: str, value: float, code: int
) -> None:
    loop.moving()
    limits = getattr(loop.layout, limit).copy()
    limits[0] = value if limit != "position_min" else 1.0
    loop.layout = loop.layout._replace(**{limit: limits})
    loop.cycle()
    assert loop.fault == (code, 1)
    assert_off(loop)


def test_a_position_that_cannot_be_is_a_fault_of_the_encoder(loop: Lockstep) -> None:
    loop.moving()
    loop.segment.switch(jump_x=20_000)  # 1 mm within a period
    loop.cycle()
    assert loop.fault == (faults.ENCODER, 1)
    assert loop.without_torque()


def test_currents_stay_positive_and_within_the_limit(loop: Lockstep) -> None:
    loop.layout = loop.layout._replace(current_max=np.array([0.5, 10.0]))
    loop.arm()
    loop.segment.switch(push={"axis": "x", "force": 20.0, "time": 0.5})
    highest = 0
    for _ in range(200):
        loop.cycle()
        highest = max(highest, *loop.outputs["torque"][:3].tolist())
        assert (loop.outputs["torque"] >= 0).all()
        assert (loop.outputs["torque"][:3] <= 50).all()
    assert highest == 50


def test_commands_are_whole_per_mille_of_the_rated_current(loop: Lockstep) -> None:
    loop.moving()
    wanted = loop.memory.samples[0, COMMAND : COMMAND + 3, :2].T.ravel()
    sent = 10.0 * loop.outputs["torque"] / 1000.0
    assert np.abs(sent - wanted).max() <= 5e-3 + 1e-6
    assert np.abs(sent - wanted).max() > 0.0
    ratings = np.array([5.0, 10.0, 20.0, 5.0, 10.0, 20.0])
    loop.layout = loop.layout._replace(rated=ratings)
    loop.cycle()
    wanted = loop.memory.samples[0, COMMAND : COMMAND + 3, :2].T.ravel()
    np.testing.assert_array_equal(loop.outputs["torque"], np.rint(1000.0 * wanted / ratings))


# Commands


def test_stop_brakes_to_rest_then_switches_the_torque_off(loop: Lockstep) -> None:
    loop.moving()
    speed = float(loop.memory.reference[1, 0])
    loop.stop()
    loop.cycle()
    assert loop.state == State.STOPPING
    braking = 0
    while loop.memory.reference[1, 0] > 0.0:
        assert loop.state == State.STOPPING
        assert not loop.without_torque()
        loop.cycle()
        braking += 1
    deceleration = speed / ((braking + 1) * CONTROL_PERIOD)
    assert deceleration == pytest.approx(loop.layout.deceleration[0], rel=0.1)
    loop.cycle(REST - 1)
    assert loop.state == State.STOPPING
    loop.cycle(2)
    assert loop.state == State.READY
    assert_off(loop)


def test_stop_turns_back_drives_that_are_arming(loop: Lockstep) -> None:
    loop.order(Order.ARM)
    assert loop.state == State.ARMING
    loop.stop()
    loop.cycle()
    assert loop.state == State.READY
    loop.cycle(20)
    assert loop.state == State.READY
    assert_off(loop)


def test_a_motion_ends_by_holding_its_end(loop: Lockstep) -> None:
    loop.arm()
    loop.line(speed=0.0, ticks=100)
    loop.cycle(150)
    assert loop.state == State.HOLDING
    assert loop.shared.status[Status.END] == 100


def test_samples_end_with_the_motion_although_it_is_stopped_at_its_end(loop: Lockstep) -> None:
    loop.arm()
    loop.line(ticks=400)
    loop.cycle(395)
    loop.stop()
    loop.cycle(300)
    assert loop.state == State.READY
    assert loop.shared.status[Status.END] == 400


def test_a_silent_server_stops_the_motion_and_ends_the_loop(loop: Lockstep) -> None:
    loop.arm()
    loop.line(0.02, ticks=HEARTBEAT // PERIOD + 1000)
    loop.cycle(400)
    loop.silent = True
    loop.cycle(HEARTBEAT // PERIOD)
    assert loop.state == State.MOVING
    loop.cycle()
    assert loop.state == State.STOPPING
    while not loop.left:
        loop.cycle()
    assert loop.left == GONE
    assert loop.memory.reference[1, 0] == 0.0
    assert_off(loop)


def test_a_loop_that_is_ended_in_motion_leaves_without_torque(loop: Lockstep) -> None:
    loop.moving()
    loop.order(Order.QUIT)
    assert loop.left == QUITTING
    assert (loop.outputs["control"] == DISABLE_VOLTAGE).all()
    assert loop.without_torque()


def test_nothing_arms_out_of_phase_or_moves_without_being_armed(loop: Lockstep) -> None:
    loop.shared.status[Status.PHASE_LOCKED] = 0
    assert not loop.order(Order.ARM)
    loop.shared.status[Status.PHASE_LOCKED] = 1
    assert not loop.order(Order.START)
    loop.cycle(20)
    assert loop.state == State.READY
    loop.arm()
    loop.order(Order.DISARM)
    assert loop.state == State.READY
    assert_off(loop)


def test_out_of_phase_for_long_is_a_fault_and_a_late_exchange_is_not(loop: Lockstep) -> None:
    loop.moving()
    read = loop._read()
    late = read._replace(system_time=loop.layout.sync_start + loop.layout.sync_shift + PERIOD // 3)
    args = loop.layout, loop.shared, loop.memory
    for k in range(PHASE_CYCLES):
        _follow_clock(late if k % 10 == 0 else read, *args)
    assert loop.shared.status[Status.PHASE_LOCKED] == 1
    for _ in range(PHASE_CYCLES):
        _follow_clock(late, *args)
    assert loop.state == State.MOVING
    for _ in range(100):
        _follow_clock(late, *args)
    assert loop.fault == (faults.PHASE, 0)


def test_the_first_fault_stays_the_one_that_is_told(loop: Lockstep) -> None:
    loop.moving()
    loop.segment.switch(jump_x=20_000)
    loop.cycle()
    loop.segment.switch(fault={"node": 2, "code": 0x2310})
    loop.cycle(50)
    assert loop.fault == (faults.ENCODER, 1)
