"""What holds while phase currents come from a table, with no controller: docs/drive.md."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from motionlab.drive import faults
from motionlab.drive.link.bounds import OpenLoopTest, check_test
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.link.commanding import MEASURED
from motionlab.drive.link.cycle import GONE, HEARTBEAT
from motionlab.drive.link.shared import Command, Order, State, Status
from tests.drive.link.lockstep import Lockstep
from tests.drive.link.test_safety import assert_off, states

FIELD = 3.0  # A
TICKS = 4000


@pytest.fixture
def loop() -> Lockstep:
    return Lockstep()


def begin(loop: Lockstep, current: float = FIELD, travel: float = 0.02, rest: int = 0) -> None:
    """Begin a test of x: phase b with a current, y without."""
    table = np.zeros((TICKS, 3, 2))
    table[:, 1, 0] = current
    loop.shared.reference[:TICKS] = table
    command = loop.shared.command
    command[Command.RUN_TICKS] = TICKS
    command[Command.RUN_FIRST] = 0
    command[Command.RUN] += 1
    command[Command.TRAVEL_X] = command[Command.TRAVEL_Y] = round(travel * 1e9)
    command[Command.REST_TICKS] = rest
    assert loop.order(Order.TEST)


def testing(loop: Lockstep, current: float = FIELD, travel: float = 0.02) -> None:
    """Be within a test, the mover at rest where phase b draws it."""
    begin(loop, current, travel)
    loop.cycle(1000)
    assert loop.state == State.TESTING
    assert states(loop) == {"operation enabled"}


testing.__test__ = False  # pyright: ignore[reportFunctionMemberAccess]


def push(loop: Lockstep, force: float) -> None:
    loop.segment.switch(push={"axis": "x", "force": force, "time": 0.5})


def test_only_the_phase_of_the_table_has_its_current(loop: Lockstep) -> None:
    testing(loop)
    assert loop.outputs["torque"].tolist() == [0, 300, 0, 0, 0, 0]
    assert loop.inputs["torque"].tolist() == [0, 300, 0, 0, 0, 0]
    end = int(loop.shared.status[Status.END])
    assert end > 900
    measured = loop.shared.samples[:end, MEASURED, 0]
    assert measured[-1] == np.float32(loop.memory.position[0])
    assert measured[-1] - measured[0] == pytest.approx(-1.2e-3, abs=0.4e-3)


def test_at_its_end_the_torque_is_off(loop: Lockstep) -> None:
    begin(loop)
    loop.cycle(TICKS + 10)
    assert loop.state == State.READY
    assert loop.shared.status[Status.END] == TICKS
    assert loop.shared.status[Status.AT_STOP] == 0
    assert_off(loop)


@pytest.mark.parametrize(("current", "most"), [(9.0, 400), (-5.0, 0)])
def test_its_currents_are_bounded(loop: Lockstep, current: float, most: int) -> None:
    testing(loop, current)
    assert loop.outputs["torque"][:3].tolist() == [0, most, 0]


def test_a_current_that_is_no_number_never_reaches_a_coil(loop: Lockstep) -> None:
    testing(loop)
    loop.shared.reference[:, 1, 0] = np.nan
    loop.cycle()
    assert loop.fault == (faults.NOT_A_NUMBER, 2)
    assert loop.without_torque()
    assert_off(loop)


def further(loop: Lockstep) -> None:
    push(loop, 20.0)


def further_than_any_test(loop: Lockstep) -> None:
    loop.layout = loop.layout._replace(test_travel=np.array([2e-3, 1.0]))
    loop.shared.command[Command.TRAVEL_X] = 10**9
    push(loop, 20.0)


def faster(loop: Lockstep) -> None:
    loop.layout = loop.layout._replace(test_velocity=np.array([10e-3, 1.0]))
    push(loop, 20.0)


def where_it_cannot_be(loop: Lockstep) -> None:
    loop.segment.switch(jump_x=20_000)


def without_answers(loop: Lockstep) -> None:
    loop.read_lost = True


def safe_torque_off(loop: Lockstep) -> None:
    loop.segment.switch(sto=True)


def a_failing_drive(loop: Lockstep) -> None:
    loop.segment.switch(fault={"node": 5, "code": 0x2310})


def a_drive_in_safeop(loop: Lockstep) -> None:
    loop.segment.switch(safeop={"node": 3, "code": 0x1B})


@pytest.mark.parametrize(
    ("cause", "code", "place"),
    [
        (further, faults.TRAVEL, 1),
        (further_than_any_test, faults.TRAVEL, 1),
        (faster, faults.SPEED_LIMIT, 1),
        (where_it_cannot_be, faults.ENCODER, 1),
        (without_answers, faults.LINK_LOST, 0),
        (safe_torque_off, faults.STO, 1),
        (a_failing_drive, faults.DRIVE_FAULT, 5),
        (a_drive_in_safeop, faults.LEFT_OPERATION, 0),
    ],
)
def test_a_fault_ends_it(
    loop: Lockstep, cause: Callable[[Lockstep], None], code: int, place: int
) -> None:
    testing(loop, travel=3e-3)
    cause(loop)
    for _ in range(2000):
        loop.cycle()
        if loop.state != State.TESTING:
            break
    assert loop.fault == (code, place)
    assert loop.without_torque()
    loop.segment.switch(clear=True)
    loop.read_lost = False
    loop.cycle(50)
    assert loop.state == State.FAULT
    assert_off(loop)
    assert not loop.order(Order.TEST)


def test_limits_of_position_do_not_count_before_homing(loop: Lockstep) -> None:
    loop.layout = loop.layout._replace(position_max=np.array([-1.0, -1.0]))
    testing(loop)


def test_it_goes_on_with_time_over_missed_cycles(loop: Lockstep) -> None:
    testing(loop)
    end = int(loop.shared.status[Status.END])
    loop.read_lost = True
    loop.cycle(3)
    assert loop.outputs["torque"].tolist() == [0, 300, 0, 0, 0, 0]
    loop.read_lost = False
    loop.sleep(4)
    loop.cycle()
    assert loop.shared.status[Status.END] == end + 8
    assert np.isnan(loop.shared.samples[end : end + 7, MEASURED, 0]).all()


@pytest.mark.parametrize("how", ["stop", "disarm"])
def test_stop_switches_the_torque_off_at_once(loop: Lockstep, how: str) -> None:
    testing(loop)
    if how == "stop":
        loop.stop()
        loop.cycle()
    else:
        loop.order(Order.DISARM)
    assert loop.state == State.READY
    assert loop.without_torque()
    assert_off(loop)


def test_a_silent_server_ends_it_and_the_loop(loop: Lockstep) -> None:
    testing(loop)
    loop.silent = True
    loop.shared.command[Command.HEARTBEAT] = loop.now - HEARTBEAT
    loop.cycle()
    assert loop.left == GONE
    assert_off(loop)


def test_it_ends_where_the_mover_rests_against_something(loop: Lockstep) -> None:
    begin(loop, rest=200)
    loop.cycle(200)
    assert loop.state == State.TESTING
    loop.cycle(800)
    assert loop.state == State.READY
    assert loop.shared.status[Status.AT_STOP] == 1
    assert loop.fault == (0, 0)
    assert_off(loop)


@pytest.mark.parametrize("order", [Order.ARM, Order.TEST])
def test_what_was_asked_for_before_a_stop_is_refused_after_it(loop: Lockstep, order: Order) -> None:
    stops = int(loop.shared.command[Command.STOPS])
    loop.stop()
    assert not loop.order(order, stops)
    loop.cycle(300)
    assert loop.state == State.READY
    assert_off(loop)


def test_nothing_is_tested_out_of_phase_or_with_torque(loop: Lockstep) -> None:
    loop.shared.status[Status.PHASE_LOCKED] = 0
    assert not loop.order(Order.TEST)
    loop.shared.status[Status.PHASE_LOCKED] = 1
    loop.arm()
    assert not loop.order(Order.TEST)
    assert loop.state == State.HOLDING


@pytest.mark.parametrize("current", [4.1, -0.1, np.nan])
def test_a_table_beyond_the_bound_is_refused(loop: Lockstep, current: float) -> None:
    table = np.zeros((100, 3, 2))
    table[50, 2, 1] = current
    with pytest.raises(LinkError, match="a test of y has currents beyond 0 to 4 A"):
        check_test(OpenLoopTest(table, (0.01, 0.01)), loop.config)
    check_test(OpenLoopTest(np.abs(np.nan_to_num(table)).clip(0, 4), (0.01, 0.01)), loop.config)
