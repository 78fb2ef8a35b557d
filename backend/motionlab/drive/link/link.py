"""The link as its server sees it: orders in, state and samples out."""

from __future__ import annotations

import contextlib
import json
import logging
import os
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.drive import DriveConfig
from motionlab.config.planar import AXES
from motionlab.drive.faults import DRIVE_ERRORS, DRIVE_FAULT, FAULTS, OF_AN_AXIS
from motionlab.drive.link.bounds import OpenLoopTest, check_reference, check_test
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.link.readings import DriveNow, FaultNow, Loaded
from motionlab.drive.link.shared import (
    NEVER,
    RING_TICKS,
    Command,
    Figure,
    Order,
    State,
    Status,
    attach,
    create,
    write_set,
)
from motionlab.drive.loop_parameters import LoopParameters
from motionlab.drive.process_data import NODES
from motionlab.timing import CONTROL_PERIOD

_LOG = logging.getLogger(__name__)
_HEARTBEAT = 0.1  # s
_ORDER_TIMEOUT = 1.0  # s; the loop answers within a period
_REPORTS_KEPT = 100
_SAME_PLACE = 1e-9  # m
_END_TIMEOUT = 5.0  # s
_ENDED = "the drive loop has ended: reset begins it anew"
_STEPS = {
    "compiling": "compiling the loop; a new version takes a minute or two",
    "finding drives": "finding drives",
    "operational": "drives operational, without torque",
}
_WITH_TORQUE = {State.HOLDING, State.MOVING, State.TESTING, State.STOPPING}


class DriveLink:
    """A process that runs a drive link, and the memory shared with it."""

    def __init__(self, config: DriveConfig) -> None:
        self.config = config
        self.reports: deque[dict[str, Any]] = deque(maxlen=_REPORTS_KEPT)
        self._note({"time": time.time(), "step": "compiling"})  # or loading what is compiled
        self.problem = ""
        self.identities: list[dict[str, Any]] = []
        self.answers: list[dict[str, Any]] = []
        self._lock = threading.RLock()
        self._stops = threading.Lock()
        self._loads = 0
        self._closed = threading.Event()
        descriptor = create()
        self._shared = attach(descriptor)
        self._shared.command[Command.HEARTBEAT] = time.monotonic_ns()
        read, write = os.pipe()
        self._process = subprocess.Popen(
            [sys.executable, "-m", "motionlab.drive.link.process", str(descriptor), str(write)],
            stdin=subprocess.PIPE,
            pass_fds=(descriptor, write),
        )
        os.close(write)
        os.close(descriptor)
        assert self._process.stdin is not None
        with self._process.stdin as stdin:
            stdin.write(config.model_dump_json().encode())
        threading.Thread(target=self._read_reports, args=(read,), daemon=True).start()
        threading.Thread(target=self._beat, name="drive heartbeat", daemon=True).start()

    @property
    def ended(self) -> bool:
        """Whether the process of the loop has ended; it does not begin again."""
        return self._process.poll() is not None

    @property
    def state(self) -> State:
        """What the loop does."""
        if self.ended:
            return State.OFFLINE
        return State(int(self._shared.status[Status.STATE]))

    def status(self, name: Status) -> int:
        """Return one number of the loop's status."""
        return int(self._shared.status[name])

    def figure(self, name: Figure) -> tuple[float, float]:
        """Return a pair of figures of the loop, of x and of y."""
        x, y = self._shared.figures[name : name + 2]
        return float(x), float(y)

    @property
    def drives(self) -> list[DriveNow]:
        """The six drives at the moment."""
        status = self._shared.status
        return [
            DriveNow(
                int(status[Status.NODE_STATUS + node]),
                int(status[Status.NODE_ERROR + node]),
                int(status[Status.NODE_TORQUE + node]),
            )
            for node in range(NODES)
        ]

    @property
    def round_trips(self) -> NDArray[np.int64]:
        """Histogram of the time from request to answer, bins of 1 us; a copy."""
        return self._shared.round_trips.copy()

    @property
    def stops(self) -> int:
        """How many stops there have been."""
        return int(self._shared.command[Command.STOPS])

    def order(self, order: Order, stops: int | None = None) -> None:
        """Give an order and wait until it is carried out.

        After a stop beyond `stops`, None for those that there have been by now, the loop refuses
        what needs torque.

        Raises
        ------
        LinkError
            If the loop refuses it in its present state, or does not answer.
        """
        with self._lock:
            command = self._shared.command
            command[Command.STOPS_BEFORE] = self.stops if stops is None else stops
            sequence = int(command[Command.SEQUENCE]) + 1
            command[Command.ORDER] = order
            command[Command.SEQUENCE] = sequence
            try:
                self._await(lambda: self._shared.status[Status.DONE] == sequence)
            except LinkError:
                command[Command.ORDER] = Order.NONE  # nothing is carried out that late
                raise
            refused = self._shared.status[Status.REFUSED]
        if refused and stops not in {None, self.stops}:
            raise LinkError("there was a STOP")
        if refused and order in {Order.ARM, Order.TEST} and self.state == State.READY:
            error = abs(self.status(Status.PHASE_ERROR)) * 1e-3
            raise LinkError(
                f"not in phase with SYNC0 yet: {error:.0f} \u00b5s; "
                "below 50 \u00b5s for 0.2 s is needed"
            )
        if refused:
            raise LinkError(f"not possible while the link is {self.state.name.lower()}")

    def stop(self) -> None:
        """Brake to rest, then switch the torque off; returns at once, whatever else goes on."""
        with self._stops:
            self._shared.command[Command.STOPS] += 1

    def load(self, parameters: LoopParameters, *, after: int | None = None) -> Loaded:
        """Put controller parameters in effect, all at one tick; where there is torque, at the next.

        `after` is the number of the set that they are to replace, which must be the latest.

        Raises
        ------
        LinkError
            If another set has come since, or the loop did not take the new one. It goes on
            with what it had then.
        """
        with self._lock:
            self._check_latest(after)
            torque = self.state in _WITH_TORQUE
            if after is not None and not torque:
                raise LinkError("the drives are without torque: gains go with the next motion")
            self.withdraw()
            command = self._shared.command
            present = int(command[Command.PARAMETERS])
            self._await(
                lambda: self.state not in _WITH_TORQUE or self.status(Status.PARAMETERS) == present
            )
            # The loop reads one set at any time: the other is written, then named.
            write_set(self._shared, 1 - present, parameters)
            command[Command.PARAMETERS] = 1 - present
            try:
                self._await(
                    lambda: (
                        self.state not in _WITH_TORQUE
                        or self.status(Status.PARAMETERS) == 1 - present
                    )
                )
                if torque and self.status(Status.PARAMETERS) == present:
                    raise LinkError("the drives lost their torque before the new gains were in use")
            except LinkError:
                command[Command.PARAMETERS] = present
                raise
            self._loads += 1
            return Loaded(self._loads, self.status(Status.PARAMETERS_TICK))

    def schedule(self, parameters: LoopParameters, tick: int, *, after: int) -> int:
        """Have the loop put parameters in effect by itself, at a tick of the motion.

        Ticks count from 1; one that is over by now counts as the next. The set `after`, as of
        `load`, must be in effect. Returns the number of the new one.

        Raises
        ------
        LinkError
            If another set has come since, or waits.
        """
        with self._lock:
            self._check_latest(after)
            if self.taken is None:
                raise LinkError("other gains wait for their tick")
            other = 1 - int(self._shared.command[Command.PARAMETERS])
            write_set(self._shared, other, parameters, tick)
            self._shared.command[Command.PARAMETERS] = other
            self._loads += 1
            return self._loads

    @property
    def taken(self) -> int | None:
        """First tick of the motion with the latest set; None while that waits."""
        if self.status(Status.PARAMETERS) != self._shared.command[Command.PARAMETERS]:
            return None
        return self.status(Status.PARAMETERS_TICK)

    def withdraw(self) -> bool:
        """Take back a set that waits for its tick; return whether one did.

        Raises
        ------
        LinkError
            If the loop does not answer.
        """
        with self._lock:
            command, first = self._shared.command, self._shared.first
            latest = int(command[Command.PARAMETERS])
            if self.taken is not None or first[latest] == 0:
                return False
            first[latest] = NEVER
            cycles = self.status(Status.CYCLES)
            self._await(
                lambda: self.state not in _WITH_TORQUE or self.status(Status.CYCLES) > cycles
            )
            present = self.status(Status.PARAMETERS)  # the latest, if that cycle took it
            command[Command.PARAMETERS] = present
            return present != latest

    def _check_latest(self, number: int | None) -> None:
        """Refuse where another set has come since."""
        if number not in {None, self._loads}:
            raise LinkError("the drives have the gains of another motion, or of arming, by now")

    def start(
        self,
        reference: NDArray[np.float64],
        first: int,
        number: int,
        stops: int | None = None,
        *,
        lap: tuple[int, int] = (0, 0),
    ) -> None:
        """Begin a motion: position, velocity and acceleration of x and y, shape (ticks, 3, 2).

        It begins where the drives hold. Ticks before `first` are the approach, which is not
        recorded. `number` grows from one motion to the next; `stops` is as of `order`. The motion
        itself has the first of `lap` ticks, each lap the second: of them laws know the phase.

        Raises
        ------
        LinkError
            If it is too long or beyond a limit, or the drives do not hold their position.
        """
        check_reference(reference, self.config)
        with self._lock:
            self.check_holding()
            away = np.abs(reference[0, 0] - self.figure(Figure.REFERENCE)).max()
            if away > _SAME_PLACE:
                raise LinkError(
                    f"the motion begins {1e3 * away:.3f} mm from where the drives hold: they have "
                    "moved since it was asked for"
                )
            self._shared.reference[: len(reference)] = reference
            command = self._shared.command
            command[Command.RUN_TICKS] = len(reference)
            command[Command.RUN_FIRST] = first
            command[Command.RUN] = number
            command[Command.MOTION_TICKS], command[Command.LAP_TICKS] = lap
            self.order(Order.START, stops)

    def test(self, test: OpenLoopTest, number: int, stops: int) -> None:
        """Begin an open-loop test: torque on, the currents of its table, torque off.

        `number` and `stops` are as of `start`.

        Raises
        ------
        LinkError
            If it is beyond a bound, there was a stop, or the drives are not ready.
        """
        check_test(test, self.config)
        with self._lock:
            if self.state != State.READY:
                raise LinkError(f"not possible while the link is {self.state.name.lower()}")
            self._shared.reference[: len(test.currents)] = test.currents
            command = self._shared.command
            command[Command.RUN_TICKS] = len(test.currents)
            command[Command.RUN_FIRST] = 0
            command[Command.RUN] = number
            for axis in range(len(AXES)):
                command[Command.TRAVEL_X + axis] = round(test.travel[axis] * 1e9)
            command[Command.REST_TICKS] = test.rest_ticks
            command[Command.REST_FROM] = test.rest_from
            self.order(Order.TEST, stops)

    @property
    def at_stop(self) -> int:
        """Axis from 1 that ended the latest test by resting; else 0."""
        return self.status(Status.AT_STOP)

    def check_holding(self) -> None:
        """Refuse unless the drives hold their position.

        Raises
        ------
        LinkError
            Saying what they do.
        """
        if self.state != State.HOLDING:
            raise LinkError(f"not possible while the link is {self.state.name.lower()}")

    @property
    def recorded(self) -> tuple[int, int]:
        """Number of the present motion, and how many of its ticks have been recorded."""
        status = self._shared.status
        return int(status[Status.RUN]), int(status[Status.END])

    def samples(self, start: int, stop: int) -> NDArray[np.float32]:
        """Return samples of ticks [start, stop), shape (ticks, channels, 2); a copy.

        Raises
        ------
        LinkError
            If they have been overwritten: not read for half a minute.
        """
        places = np.arange(start, stop) % RING_TICKS
        samples = self._shared.samples[places]
        if self._shared.status[Status.END] - start > RING_TICKS:
            raise LinkError("samples of the drives were lost: the server was held up")
        return samples

    def fault(self) -> FaultNow | None:
        """Return the latched fault; None without one."""
        if self.state != State.FAULT:
            return None
        status, figures = self._shared.status, self._shared.figures
        code = int(status[Status.FAULT])
        if code not in FAULTS:  # it was reset at this moment
            return None
        fault = FAULTS[code]
        place = int(status[Status.FAULT_PLACE])
        value, limit = (float(figures[i]) for i in (Figure.FAULT_VALUE, Figure.FAULT_LIMIT))
        error = int(value) if code == DRIVE_FAULT else 0
        fault = DRIVE_ERRORS.get(error, fault)
        return FaultNow(
            code=code,
            error=error,
            name=fault.name,
            subject="axis" if code in OF_AN_AXIS else "drive" if place else "link",
            place=place,
            value=value * fault.factor if fault.unit else None,
            limit=limit * fault.factor if fault.unit else None,
            unit=fault.unit,
            remedy=fault.remedy,
        )

    def close(self) -> None:
        """Switch the torque off and end the process."""
        self.stop()
        deadline = time.monotonic() + _END_TIMEOUT
        while self.state in _WITH_TORQUE and time.monotonic() < deadline:
            time.sleep(_HEARTBEAT)
        with contextlib.suppress(LinkError):
            self.order(Order.QUIT)
        self._closed.set()
        try:
            self._process.wait(_END_TIMEOUT)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _await(self, condition: Callable[[], bool]) -> None:
        """Wait for something that the loop does within a period."""
        deadline = time.monotonic() + _ORDER_TIMEOUT
        while not condition():
            if self.ended:
                raise LinkError(_ENDED)
            if time.monotonic() > deadline:
                raise LinkError("the drive loop does not answer: it is bringing the drives up")
            time.sleep(CONTROL_PERIOD)

    def _beat(self) -> None:
        while not self._closed.wait(_HEARTBEAT):
            self._shared.command[Command.HEARTBEAT] = time.monotonic_ns()

    def _note(self, report: dict[str, Any]) -> None:
        self.reports.append(report)
        _LOG.info("drive link: %s", report.get("problem") or _STEPS[report["step"]])

    def _read_reports(self, descriptor: int) -> None:
        with open(descriptor, encoding="utf-8") as lines:
            for line in lines:
                report = json.loads(line)
                self._note(report)
                if "problem" in report:
                    self.problem = report["problem"]
                    self.answers = report.get("answers", [])
                elif report.get("step") == "operational":
                    self.problem, self.answers = "", []
                    self.identities = report["identities"]
        if not self._closed.is_set() and not self.problem:
            self.problem = _ENDED
