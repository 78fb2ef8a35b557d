"""The loop and a virtual segment in lockstep: every cycle at its time, on any machine."""

from __future__ import annotations

import copy
import os
import struct
from collections.abc import Mapping
from functools import cache
from typing import Any, cast
from unittest import mock

import numpy as np
from numpy.typing import NDArray

from motionlab.config.drive import DriveConfig
from motionlab.config.load import load_scenario
from motionlab.drive.ethercat import (
    DATAGRAM_HEADER,
    FRAME_HEADER,
    WORKING_COUNTER,
    Datagram,
    datagrams,
    frame,
)
from motionlab.drive.libc import new_clock
from motionlab.drive.link import bring_up, mailbox
from motionlab.drive.link.bring_up import BringUp
from motionlab.drive.link.bus import Inputs, cyclic_bus
from motionlab.drive.link.carrier import Carrier, LinkError
from motionlab.drive.link.cycle import act
from motionlab.drive.link.memory import PERIOD, Count, Layout, new_memory
from motionlab.drive.link.process import layout_of
from motionlab.drive.link.shared import Command, Order, State, Status, attach, create, write_set
from motionlab.drive.loop_parameters import LoopParameters
from motionlab.drive.motion import held_parameters, on_drives
from motionlab.drive.process_data import INPUT, NODES, OUTPUT
from motionlab.drive.virtual.datagrams import answer
from motionlab.drive.virtual.layout import ERROR_CODE, MAIL
from motionlab.drive.virtual.segment import Segment, default_drive
from motionlab.timing import CONTROL_PERIOD

SHIFT = 100_000
"""ns from SYNC0 to the first frame; the second follows 50 us later."""

_HEADER = FRAME_HEADER + DATAGRAM_HEADER
_OUTPUTS = slice(_HEADER, _HEADER + NODES * OUTPUT.itemsize)
_INPUTS = slice(_HEADER, _HEADER + NODES * INPUT.itemsize)
_READ = struct.Struct(
    f"<{_INPUTS.stop}xH{DATAGRAM_HEADER}xQ{WORKING_COUNTER + DATAGRAM_HEADER}xH{WORKING_COUNTER}x"
)
"""Of the answer to the first frame: working counter, system time, AL status."""

_WRITTEN = struct.Struct(f"<{_OUTPUTS.stop}xH")
"""Of the answer to the second one: working counter."""


class _Wire:
    """Takes frames to a segment as its `exchange` does, which serves mail; here where there is any.

    Parameters
    ----------
    segment : Segment
        The drives.
    """

    def __init__(self, segment: Segment) -> None:
        self.segment = segment
        nodes = segment.arrays.nodes
        self._errors, self._mail = nodes[:, ERROR_CODE], nodes[:, MAIL]

    def exchange(self, sent: Any, now: int) -> NDArray[np.uint8] | None:
        """Return the answer to a frame of bytes, or None where none comes back."""
        came = np.array(np.frombuffer(sent, np.uint8))
        there = answer(self.segment.arrays, came, 0, len(came), now)
        if self._mail.any() or self._errors.tolist() != self.segment._mail._errors_sent:
            self.segment.serve_mail()
        return came if there else None


class _Carrier:
    """Exchanges of the bring-up, half a period of the segment apart."""

    def __init__(self, segment: Segment) -> None:
        self.wire = _Wire(segment)
        self.now = 0

    def exchange(self, *sent: Datagram, **_: Any) -> list[Datagram]:
        self.now += PERIOD // 2
        answer = self.wire.exchange(frame(sent), self.now)
        if answer is None:
            raise LinkError("no answer")
        return list(datagrams(answer.tobytes()))


class _Clock:
    """What `time` is to a bring-up: the segment's, so that no machine is too slow for it."""

    def __init__(self, carrier: _Carrier) -> None:
        self._carrier = carrier

    def monotonic(self) -> float:
        return 1e-9 * self._carrier.now

    def sleep(self, _: float) -> None:
        """Every exchange takes its time."""


class Lockstep:
    """A loop, its drives in OP, and the frames between them.

    Parameters
    ----------
    start : tuple of float
        Position of the mover, m.
    changes : mapping of str to value, optional
        Of the motor, as `Segment` takes them.
    config, machine : DriveConfig
        What the loop takes the drives for, and what they are; the shipped ones when left out.
    fresh : bool
        Whether to bring up the shipped drives once more, rather than to take over how they were
        when that was done before.

    Attributes
    ----------
    read_lost, write_lost : bool
        Whether the first, and the second, frame of a cycle is lost on its way.
    left : int
        Why the loop was left, or 0.
    master : BringUp
        What brought the drives up.
    """

    def __init__(
        self,
        start: tuple[float, float] = (0.0, 0.0),
        changes: Mapping[str, Any] | None = None,
        *,
        config: DriveConfig | None = None,
        machine: DriveConfig | None = None,
        fresh: bool = False,
    ) -> None:
        self.config = config or default_drive()
        self.segment = Segment(start=start, drive=machine or self.config, changes=changes)
        self._wire = _Wire(self.segment)
        self.memory = new_memory()
        descriptor = create()
        self.shared = attach(descriptor)
        os.close(descriptor)
        self.bus = cyclic_bus(-1, b"", new_clock(), clocks=True)
        self.read_lost = self.write_lost = self.silent = False
        self.left = 0
        self.layout: Layout
        if not (fresh or config or machine or changes):
            self._as_brought_up(_brought_up(start))
        else:
            self.bring_up()
        self.put(_held())

    def bring_up(self) -> None:
        """Bring the drives to OP, as the loop's process does."""
        carrier = _Carrier(self.segment)
        carrier.now = self.segment.arrays.clock[0]
        self.master = master = BringUp(cast(Carrier, carrier), self.config)
        clock = _Clock(carrier)
        with mock.patch.object(bring_up, "time", clock), mock.patch.object(mailbox, "time", clock):
            master.bring_up()
        self.layout = layout_of(self.config, master.sync_start)
        read = self._wire.exchange(self.bus.read, carrier.now + 1)
        assert read is not None
        _, system, _ = _READ.unpack_from(read.data)
        late = (system - master.sync_start - SHIFT) % PERIOD
        self.now = carrier.now + 1 - late
        self._begin()

    def _as_brought_up(self, other: Lockstep) -> None:
        """Take over what the same drives were when another loop had brought them up."""
        for name in self.segment.arrays.dtype.names:
            if name != "tables":  # an address
                self.segment.arrays[name][...] = other.segment.arrays[name]
        mine, theirs = self.segment._mail, other.segment._mail
        mine._last, mine._errors_sent = theirs._last.copy(), theirs._errors_sent.copy()
        for dictionary, known in zip(mine._dictionaries, theirs._dictionaries, strict=True):
            dictionary._pdo_counts.update(known._pdo_counts)
        same = {id(each): each for each in (other.config, self.segment)}
        same[id(other.segment)] = self.segment
        self.master = copy.deepcopy(other.master, same)
        self.layout, self.now = copy.deepcopy(other.layout), other.now
        self._begin()

    def _begin(self) -> None:
        self.shared.status[Status.PHASE_LOCKED] = 1
        self.shared.status[Status.FAULT] = 0
        self.shared.status[Status.STATE] = State.READY
        self.memory.count[Count.CYCLE] = 0
        self.written, self.left = -1, 0

    @property
    def state(self) -> State:
        return State(int(self.shared.status[Status.STATE]))

    @property
    def fault(self) -> tuple[int, int]:
        """Code, and the drive or axis."""
        status = self.shared.status
        return int(status[Status.FAULT]), int(status[Status.FAULT_PLACE])

    @property
    def outputs(self) -> NDArray[Any]:
        """What the loop wants the drives to get."""
        return self.bus.write[_OUTPUTS].view(OUTPUT)

    @property
    def inputs(self) -> NDArray[Any]:
        """What the drives said last."""
        return self.bus.answer[_INPUTS].view(INPUT)

    def cycle(self, count: int = 1) -> None:
        """Let a number of cycles pass."""
        for _ in range(count):
            self.now += PERIOD
            if not self.silent:
                self.shared.command[Command.HEARTBEAT] = self.now
            read = self._read()
            self.left = act(read, self.now, self.bus, self.layout, self.shared, self.memory)
            self.memory.count[Count.CYCLE] += 1
            self.shared.status[Status.CYCLES] += 1
            answer = None
            if not self.write_lost:
                answer = self._wire.exchange(self.bus.write, self.now + 50_000)
            self.written = -1 if answer is None else _WRITTEN.unpack_from(answer.data)[0]

    def _read(self) -> Inputs:
        answer = None
        if not self.read_lost:
            answer = self._wire.exchange(self.bus.read, self.now)
        if answer is None:
            return Inputs(False, 0, 0, 0, 300_000, self.written)
        self.bus.answer[: len(answer)] = answer
        counter, system_time, al_status = _READ.unpack_from(answer.data)
        return Inputs(True, counter, al_status, system_time, 20_000, self.written)

    def sleep(self, periods: int) -> None:
        """Have the loop sleep through some periods."""
        self.now += periods * PERIOD
        self.memory.count[Count.SKIPPED] = periods

    def put(self, parameters: LoopParameters, first: int = 0) -> None:
        """Put parameters in effect from the next cycle on, or from a tick of the motion."""
        command = self.shared.command
        write_set(self.shared, 1 - command[Command.PARAMETERS], parameters, first)
        command[Command.PARAMETERS] = 1 - command[Command.PARAMETERS]

    def order(self, order: Order, stops: int | None = None) -> bool:
        """Give an order that knows of so many stops, or all; return whether it was obeyed."""
        command = self.shared.command
        command[Command.STOPS_BEFORE] = command[Command.STOPS] if stops is None else stops
        command[Command.ORDER] = order
        command[Command.SEQUENCE] += 1
        self.cycle()
        return not self.shared.status[Status.REFUSED]

    def arm(self) -> None:
        """Have the drives hold their position."""
        assert self.order(Order.ARM)
        self.cycle(20)
        assert self.state == State.HOLDING

    def follow(self, reference: NDArray[np.float64]) -> None:
        """Begin a motion, recorded from its first tick on."""
        self.shared.reference[: len(reference)] = reference
        self.shared.command[Command.RUN_TICKS] = len(reference)
        self.shared.command[Command.RUN_FIRST] = 0
        self.shared.command[Command.RUN] += 1
        assert self.order(Order.START)

    def line(self, speed: float = 0.05, ticks: int = 2000) -> None:
        """Begin a motion in x: up to a speed within 0.1 s, and on at that speed."""
        v = speed * np.minimum(np.arange(ticks) * CONTROL_PERIOD / 0.1, 1.0)
        reference = np.zeros((ticks, 3, 2))
        reference[:, 0, 0] = np.cumsum(v) * CONTROL_PERIOD
        reference[:, 1, 0] = v
        reference[:, 2, 0] = np.gradient(v) / CONTROL_PERIOD
        reference[:, 0] += self.memory.reference[0]
        self.follow(reference)

    def moving(self) -> None:
        """Be on the way along x, at 50 mm/s."""
        self.arm()
        self.line()
        self.cycle(400)
        assert self.state == State.MOVING
        assert (self.outputs["torque"] > 0).any()

    def stop(self) -> None:
        """As anyone may."""
        self.shared.command[Command.STOPS] += 1

    def without_torque(self) -> bool:
        """Return whether no torque is commanded."""
        return not self.outputs["torque"].any()


@cache
def _brought_up(start: tuple[float, float]) -> Lockstep:
    """Return a loop of the shipped drives that no test touches: the bring-up takes long."""
    return Lockstep(start, fresh=True)


@cache
def _held() -> LoopParameters:
    return held_parameters(on_drives(load_scenario("circle"), "B"))
