"""A step with torque on its way: tests and motions one after the other, until one is stopped."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.drive import DriveConfig
from motionlab.config.planar import AXES
from motionlab.drive.link.bounds import OpenLoopTest
from motionlab.drive.link.link import DriveLink
from motionlab.drive.link.shared import Order, State
from motionlab.drive.loop_parameters import LoopParameters
from motionlab.errors import MotionLabError
from motionlab.telemetry.channels import Sample
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]

_POLL = 0.02  # s
_ENABLE_TIME = 5.0  # s of the drives
_COLUMN = {name: row for row, name in enumerate(Sample._fields)}
_CURRENTS = slice(_COLUMN["current_a"], _COLUMN["current_c"] + 1)


class Stopped(MotionLabError):
    """A step that was ended by a person, by a fault, or by the end of control."""


class Traced(NamedTuple):
    """What was measured at each tick; NaN in cycles without an answer."""

    position: Array  # (ticks, 2), m
    error: Array  # (ticks, 2), following error, m; NaN in an open-loop test
    current: Array  # (ticks, 3, 2), of the phases a, b, c, A
    at_stop: bool  # whether it ended with an axis at rest against something


class StepRun:
    """One step with torque: what it does on the drives, and how it is stopped.

    `number` returns the number of a further motion; `report` is called with the share that is done
    and what is done, in words. The step ends with the first stop beyond `stops`, those that there
    had been when it began.
    """

    def __init__(
        self,
        link: DriveLink,
        number: Callable[[], int],
        report: Callable[[float, str], None] = lambda _share, _text: None,
        wait: Callable[[float], None] = time.sleep,
    ) -> None:
        self.link = link
        self.config: DriveConfig = link.config
        self._number = number
        self._report = report
        self._wait = wait
        self.stops = link.stops
        self._why = ""
        self._part = (0.0, 1.0)
        self._text = ""

    def stop(self, why: str) -> None:
        """End the step: the drives lose their torque, or brake first where a controller holds."""
        self._why = self._why or why
        self.link.stop()

    @contextmanager
    def part(self, begin: float, end: float, text: str) -> Iterator[None]:
        """Do a part of the step, from one share of it to another."""
        self._part, self._text = (begin, end), text
        self._report(begin, text)
        yield
        self._report(end, text)

    def test(self, test: OpenLoopTest) -> Traced:
        """Do an open-loop test, and return what was measured.

        Raises
        ------
        Stopped
            If it ended before its end, other than by resting.
        LinkError
            If it is refused.
        """
        self.check()
        number = self._number()
        self.link.test(test, number, self.stops)
        samples = self._samples(number, len(test.currents), {State.ARMING, State.TESTING})
        at_stop = bool(self.link.at_stop)
        if not at_stop and len(samples) < len(test.currents):
            raise Stopped("the torque was switched off")
        return _traced(samples, at_stop)

    @contextmanager
    def holding(self, parameters: LoopParameters) -> Iterator[None]:
        """Hold the position with a controller; the torque is off afterwards.

        Raises
        ------
        Stopped
            If it ends before.
        LinkError
            If the drives do not enable.
        """
        self.check()
        self.link.load(parameters)
        self.link.order(Order.ARM, self.stops)
        try:
            while self.link.state == State.ARMING:
                self._wait(_POLL)
            self.check()
            yield
            self.check()
        finally:
            if self.link.state in {State.HOLDING, State.ARMING}:
                self.link.order(Order.DISARM)
            elif self.link.state == State.MOVING:
                self.link.stop()

    def follow(self, reference: Array) -> Traced:
        """Follow a reference, as of `DriveLink.start`, and return what was measured.

        Raises
        ------
        Stopped
            If it ended before its end.
        LinkError
            If it is refused.
        """
        self.check()
        number = self._number()
        self.link.start(reference, 0, number, self.stops)
        samples = self._samples(number, len(reference), {State.MOVING})
        if len(samples) < len(reference):
            raise Stopped("the torque was switched off")
        return _traced(samples, at_stop=False)

    def report_part(self, share: float) -> None:
        """Tell which share of the present part is done."""
        begin, end = self._part
        self._report(begin + (end - begin) * min(share, 1.0), self._text)

    def check(self) -> None:
        """Refuse to go on after a stop, a fault, or without a link.

        Raises
        ------
        Stopped
            Saying which.
        """
        if fault := self.link.fault():
            figures = ""
            if fault.value is not None and fault.limit is not None:
                figures = f", {fault.value:.4g} {fault.unit}, limit {fault.limit:.4g}"
            place = AXES[fault.place - 1] if fault.subject == "axis" else f"drive {fault.place}"
            place = f"{place}: " if fault.place else ""
            raise Stopped(f"fault: {place}{fault.name}{figures}")
        if self.link.state == State.OFFLINE:
            raise Stopped("the link was lost")
        if self.link.stops != self.stops:
            raise Stopped(self._why or "STOP")

    def _samples(self, number: int, ticks: int, under_way: set[State]) -> NDArray[np.float32]:
        """Return the samples of a motion, once it has ended."""
        taken, tick = [], 0
        while True:
            goes_on = self.link.state in under_way
            run, recorded = self.link.recorded
            if run == number and recorded > tick:
                taken.append(self.link.samples(tick, recorded))
                tick = recorded
                self.report_part(tick / ticks)
            if not goes_on:
                break
            self._wait(_POLL)
        self.check()
        if not taken:
            raise Stopped("the torque was switched off")
        return np.concatenate(taken)


def ticks_of(seconds: float) -> int:
    """Return a time in control periods."""
    return round(seconds / CONTROL_PERIOD)


def _traced(samples: NDArray[np.float32], at_stop: bool) -> Traced:
    values = samples.astype(np.float64)
    return Traced(
        position=values[:, _COLUMN["position_measured"]],
        error=values[:, _COLUMN["following_error"]],
        current=values[:, _CURRENTS],
        at_stop=at_stop,
    )
