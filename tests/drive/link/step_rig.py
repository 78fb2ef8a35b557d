"""A step of commissioning on a loop in lockstep: whatever it waits for passes in cycles."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable
from typing import Any

from motionlab.config.drive import DriveConfig
from motionlab.drive.commissioning.run import StepRun
from motionlab.drive.link.link import DriveLink
from motionlab.drive.link.shared import Status
from motionlab.timing import CONTROL_PERIOD
from tests.drive.link.lockstep import Lockstep


class _Running:
    """The process of a loop that runs."""

    @staticmethod
    def poll() -> None:
        return None


class LockstepLink(DriveLink):
    """A link whose loop runs by as many cycles as are waited for.

    Parameters
    ----------
    loop : Lockstep
        The loop.
    """

    def __init__(self, loop: Lockstep) -> None:
        self.loop = loop
        self.config: DriveConfig = loop.config
        self._shared = loop.shared
        self.identities = [{"serial": n + 1} for n, _ in enumerate(loop.config.nodes)]
        self._lock = threading.RLock()
        self._stops = threading.Lock()
        self._loads = 0
        self._process: Any = _Running()

    def _await(self, condition: Callable[[], bool]) -> None:
        while not condition():
            self.loop.cycle()


class StepRig:
    """A step, and what happens while it goes on.

    Parameters
    ----------
    loop : Lockstep
        The loop, without torque.

    Attributes
    ----------
    at : dict of int to callable
        What happens once so many ticks of a motion or a test have been recorded.
    """

    def __init__(self, loop: Lockstep) -> None:
        self.loop = loop
        self.at: dict[int, Callable[[], Any]] = {}
        self.told: list[tuple[float, str]] = []
        numbers = itertools.count(1)
        self.run = StepRun(
            LockstepLink(loop),
            lambda: next(numbers),
            report=lambda share, text: self.told.append((share, text)),
            wait=self._wait,
        )

    def _wait(self, seconds: float) -> None:
        self.loop.cycle(round(seconds / CONTROL_PERIOD))
        for tick in [tick for tick in self.at if self.loop.shared.status[Status.END] >= tick]:
            self.at.pop(tick)()
