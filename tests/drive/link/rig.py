"""A virtual drive and a link to it, slower than real time: a stall of the machine counts less."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.drive import DriveConfig
from motionlab.config.load import load_scenario
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.link.link import DriveLink
from motionlab.drive.link.shared import Order, State, Status
from motionlab.drive.motion import DriveMotion, held_parameters, on_drives
from motionlab.drive.virtual.process import VirtualDrive
from motionlab.drive.virtual.segment import default_drive
from motionlab.kernel.layout import SAMPLE_ROWS
from motionlab.lanes import WIDTH
from motionlab.simulation.prepare import prepare

SLOW = 6
PATIENCE = 60.0  # s
CIRCLE: dict[str, Any] = {"trajectory.laps": 1, "trajectory.lead_in": 0.5}


def linked(drive: VirtualDrive, **changes: Any) -> DriveConfig:
    """Return the configuration of a link to a virtual drive, with changes of its link."""
    config = default_drive()
    link = config.link.model_copy(update={"port": drive.port, "slow": SLOW, **changes})
    return config.model_copy(update={"link": link})


class Rig:
    """Both processes, and what a person does with them."""

    def __init__(self) -> None:
        self.drive = VirtualDrive(priority=70, slow=SLOW)
        self.numbers = 0

    def __enter__(self) -> Rig:
        self.drive.__enter__()
        self.attach()
        return self

    def attach(self) -> None:
        """Link to a virtual drive that runs."""
        self.link = DriveLink(linked(self.drive))

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.link.close()
        self.drive.__exit__(kind, error, traceback)

    def wait(self, condition: Callable[[], bool], what: str) -> None:
        """Wait until something holds."""
        deadline = time.monotonic() + PATIENCE
        while not condition():
            told = f"{self.link.state.name}, {self.link.fault()}, {self.link.problem!r}"
            assert time.monotonic() < deadline, f"not {what}: {told}"
            time.sleep(0.005)

    def until(self, *states: State) -> None:
        """Wait for a state of the loop."""
        self.wait(lambda: self.link.state in states, " or ".join(state.name for state in states))

    def ready(self) -> None:
        """Let nothing be wrong any more, and have the drives operational without torque."""
        link = self.link
        self.drive.switch(clear=True)
        link.stop()
        sound = 0

        def is_sound() -> bool:
            nonlocal sound
            down = link.state == State.OFFLINE and bool(link.problem)
            if link.state == State.FAULT or down:
                with contextlib.suppress(LinkError):  # while it tries once more by itself
                    link.order(Order.RESET)
            locked = link.status(Status.PHASE_LOCKED) == 1
            sound = sound + 1 if link.state == State.READY and locked else 0
            return sound > 20  # drives that stood still may tell late that they left OP

        self.wait(is_sound, "ready")

    def arm(self) -> None:
        """Have the drives hold their position."""
        self.link.load(held_parameters(on_drives(load_scenario("circle", CIRCLE), "B")))
        self.link.order(Order.ARM)
        self.until(State.HOLDING, State.FAULT)
        assert self.link.state == State.HOLDING, self.link.fault()

    def motion(self) -> DriveMotion:
        """Return the circle, begun."""
        self.numbers += 1
        motion = DriveMotion(
            prepare(on_drives(load_scenario("circle", CIRCLE), "B")), self.link, self.numbers
        )
        motion.begin()
        return motion

    def moving(self) -> DriveMotion:
        """Return a motion along the circle that is well under way."""
        self.ready()
        self.arm()
        motion = self.motion()
        self.wait(lambda: motion.available > 1500 or motion.stopped, "moving")
        assert self.link.state == State.MOVING, self.link.fault()
        return motion

    def take(self, motion: DriveMotion) -> NDArray[np.float32]:
        """Return the samples of a motion, once it has ended: shape (ticks, channels, 2)."""
        page = np.empty((1, 4096, SAMPLE_ROWS, WIDTH), np.float32)
        taken = []

        def ended() -> bool:
            if count := motion.advance(page):
                taken.append(page[0, :count, :, :2].copy())
            return motion.stopped or motion.tick == motion.timeline.end

        self.wait(ended, "at the end of the motion")
        return np.concatenate(taken)


def pid_of(link: DriveLink) -> int:
    """Return the process of a loop."""
    return link._process.pid
