"""The drive link of a server: one link, one lease, one motion at a time."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from pydantic import BaseModel, Field

from motionlab.config.drive import DriveConfig
from motionlab.config.named_configs import data_root
from motionlab.config.scenario import Scenario
from motionlab.drive.commissioning.checks import (
    ByHand,
    compare_identity,
    find_drives,
    judge_encoders,
)
from motionlab.drive.commissioning.commutation import commutation_offset
from motionlab.drive.commissioning.currents import phase_currents
from motionlab.drive.commissioning.hold import hold_with_low_gains
from motionlab.drive.commissioning.homing import find_stops
from motionlab.drive.commissioning.record import (
    CommissioningRecord,
    ConfigChange,
    Finding,
    StepName,
    step_of,
)
from motionlab.drive.commissioning.run import StepRun, Stopped
from motionlab.drive.commissioning.steps import Commissioning
from motionlab.drive.lease import Lease
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.link.link import DriveLink
from motionlab.drive.link.shared import Figure, Order, State, Status
from motionlab.drive.motion import held_parameters, on_drives
from motionlab.drive.plug.history import DriveHistory
from motionlab.drive.plug.status import DriveStatus, drive_status
from motionlab.errors import MotionLabError, StoreError

_LOG = logging.getLogger(__name__)

_WATCH = 0.2  # s
_TEXT_MAX = 1000
_THREADS = 4  # an order, a step of commissioning, its document, a link that is brought up
TORQUE_STEPS: dict[StepName, Callable[[StepRun], Finding]] = {
    "currents": phase_currents,
    "commutation": commutation_offset,
    "homing": find_stops,
    "hold": hold_with_low_gains,
}
_TORQUE = {State.ARMING, State.HOLDING, State.MOVING, State.TESTING}
_ACTIVE = _TORQUE | {State.STOPPING}


class RunningStep(BaseModel):
    """A step of commissioning that goes on."""

    step: StepName
    since: float = Field(description="Wall clock, s since 1970")
    progress: float = Field(ge=0.0, le=1.0, description="Share that is done")
    text: str = Field(description="What it does at the moment")


class Drives:
    """A drive link with its lease."""

    def __init__(self, config: DriveConfig) -> None:
        self.commissioning = Commissioning(config, data_root() / "commissioning.json")
        self.link = DriveLink(self.config)
        # Not the loop's own threads, where an order would wait for the disk of other requests.
        self._threads = ThreadPoolExecutor(_THREADS, thread_name_prefix="drives")
        self.lease = Lease()
        self.running: RunningStep | None = None
        self.torque_steps = dict(TORQUE_STEPS)
        self._step: StepRun | None = None
        self._doing: asyncio.Task[None] | None = None
        self._renewing: asyncio.Task[None] | None = None
        self._history = DriveHistory(self.link)
        self._motions = 0
        self._beginning = asyncio.Lock()
        self._ordering = False
        self._watching = asyncio.create_task(self._watch())

    @property
    def config(self) -> DriveConfig:
        """The link in effect: its file with the changes that commissioning took."""
        return self.commissioning.config

    def note_serials(self) -> None:
        """Let commissioning know which drives were found."""
        self.commissioning.follow([drive["serial"] for drive in self.link.identities])

    def _check_identities(self) -> None:
        """Refuse drives that were not found yet, or are up with values of others.

        Raises
        ------
        LinkError
            Saying which.
        """
        if not self.link.identities:
            raise LinkError(f"not possible while the link is {self.link.state.name.lower()}")
        self.note_serials()
        if self._of_others:
            raise LinkError("not possible until the link is up with the values of these drives")

    @property
    def active(self) -> bool:
        """Whether the drives have torque, or a step of commissioning goes on."""
        return self.running is not None or self.link.state in _ACTIVE

    async def order(self, order: Order, token: str) -> None:
        """Give an order in the name of who holds the lease.

        Raises
        ------
        NotHeld
            If the token is not that of the lease.
        LinkError
            If the loop refuses.
        """
        self.lease.check(token)
        self._history.note()  # a fault that is about to be reset
        if order is Order.DISARM:
            self.note_stop("disarmed", self.lease.holder)
        try:
            await self._in_thread(self.link.order, order)
        finally:
            if order is Order.DISARM:  # what was asked for before it, and is on its way, too
                self.stop("disarmed")

    async def reset(self, token: str) -> None:
        """Clear a latched fault, or bring the drives up again; never arms.

        A loop whose process has ended, by itself or killed, begins anew.
        """
        self.lease.check(token)
        self.check_free()
        if not self.link.ended:
            await self.order(Order.RESET, token)
            return
        async with self._beginning:
            await self._begin_anew()

    async def arm(self, load: Callable[[], Scenario], variant: str | None, token: str) -> None:
        """Switch the torque on, with a scenario's gains holding the position.

        Raises
        ------
        ConfigError
            If drives cannot carry the scenario out.
        LinkError
            If the loop refuses, or there was a stop, or the end of a lease, meanwhile; or the
            drives are not those that were commissioned.
        """
        self.lease.check(token)
        link, stops = self.link, self.link.stops

        def arm() -> None:
            if link.state is not State.READY:  # gains of what moves stay as they are
                raise LinkError(f"not possible while the link is {link.state.name.lower()}")
            if not link.status(Status.PHASE_LOCKED):
                raise LinkError("not yet in phase with SYNC0 of the drives: wait a moment")
            self._check_identities()
            if other := self.commissioning.other_drives:
                raise LinkError(
                    f"{other}: do the steps again, or load the document of these drives"
                )
            link.load(held_parameters(on_drives(load(), variant)))
            link.order(Order.ARM, stops)

        with self.ordering():
            await self._in_thread(arm)

    @contextlib.contextmanager
    def ordering(self) -> Iterator[None]:
        """Arm, or begin a motion: one at a time, and not while something else goes on.

        Raises
        ------
        LinkError
            If something does, as `check_free`.
        """
        self.check_free()
        self._ordering = True
        try:
            yield
        finally:
            self._ordering = False

    async def take(self, name: StepName, changes: Sequence[ConfigChange]) -> None:
        """Take the changes that a step shows, and bring the link up with them.

        Raises
        ------
        LinkError
            If these are not the changes that it shows, or the drives have torque.
        ConfigError
            If a value is out of its range.
        StoreError
            If the document cannot be kept.
        """
        await self._reconfigure(lambda: self.commissioning.take(name, changes))

    async def load_commissioning(self, record: CommissioningRecord) -> None:
        """Take another document; the link is brought up anew where that changes it.

        Raises
        ------
        LinkError
            If it is of another link or other drives, or the drives have torque.
        ConfigError
            If it is not as this server wrote it.
        StoreError
            If it cannot be kept.
        """
        await self._reconfigure(lambda: self.commissioning.load(record))

    async def _reconfigure(self, change: Callable[[], None]) -> None:
        self.check_free()
        async with self._beginning:
            if self.link.state in _ACTIVE:
                raise LinkError(f"not possible while the link is {self.link.state.name.lower()}")
            self.note_serials()
            before = self.config
            await self._in_thread(change)
            if self.config != before:
                await self._begin_anew()

    async def _begin_anew(self) -> None:
        """End the loop and begin another one, with the configuration in effect."""
        await self._in_thread(self.link.close)
        self.link = await self._in_thread(DriveLink, self.config)
        self._history.follow(self.link)

    async def do_step(self, name: StepName) -> None:
        """Do a step of commissioning; one with torque, or by hand, only begins, and ends later.

        Raises
        ------
        LinkError
            If a step before it does not hold, or the drives are not as it needs them.
        StoreError
            If what was found cannot be kept.
        """
        self.check_free()
        state, identities = self.link.state, self.link.identities
        if state is not State.READY or not identities:
            raise LinkError(
                f"commissioning needs drives without torque: the link is {state.name.lower()}"
            )
        if step_of(name).torque and not self.link.status(Status.PHASE_LOCKED):
            raise LinkError("not yet in phase with SYNC0 of the drives: wait a moment")
        self._check_identities()
        commissioning = self.commissioning
        commissioning.begin(name)
        if name == "encoders":
            commissioning.by_hand = ByHand(self.link.figure(Figure.POSITION))
            return
        if step_of(name).torque:
            self._begin_step(name)
            return
        judge = {"drives": find_drives, "identity": compare_identity}[name]
        await self._in_thread(commissioning.put, name, judge(self.config, identities))

    def check_free(self) -> None:
        """Refuse during a step of commissioning, another order, or a link that is brought up.

        Raises
        ------
        LinkError
            Saying which.
        """
        if self.running is not None:
            raise LinkError(f"not possible while the step {self.running.step} goes on")
        if self._beginning.locked():
            raise LinkError("not possible while the link is brought up anew")
        if self._ordering:
            raise LinkError("not possible while torque is switched on, or a motion begun")

    def stop(self, why: str = "STOP") -> None:
        """Stop whatever has torque, and a step of commissioning with all that it would do yet."""
        if self._step is None:
            self.link.stop()
        else:
            self._step.stop(why)

    def _begin_step(self, name: StepName) -> None:
        """Begin a step with torque."""

        def report(share: float, text: str) -> None:
            if self.running is not None:
                update = {"progress": min(share, 1.0), "text": text}
                self.running = self.running.model_copy(update=update)

        self.running = RunningStep(step=name, since=time.time(), progress=0.0, text="begins")
        self._step = StepRun(self.link, self.next_motion, report)
        self._doing = asyncio.create_task(self._finish_step(name, self._step))

    async def _finish_step(self, name: StepName, run: StepRun) -> None:
        """Do a step with torque to its end, and keep what it found."""
        try:
            finding = await self._in_thread(self.torque_steps[name], run)
        except Stopped as error:
            finding = Finding(at=time.time(), holds=False, text=f"ended before its end: {error}")
        except MotionLabError as error:
            self.note_stop(f"failure of the step {name}")
            self.link.stop()
            finding = Finding(at=time.time(), holds=False, text=str(error)[:_TEXT_MAX])
        except Exception:
            self.note_stop(f"failure of the step {name}")
            self.link.stop()
            _LOG.exception("step %s of commissioning", name)
            finding = Finding(at=time.time(), holds=False, text="it failed: see the server's log")
        try:
            await self._in_thread(self.commissioning.put, name, finding)
        except MotionLabError as error:  # it is shown, and kept with the next step
            _LOG.warning("step %s of commissioning: %s", name, error)
        finally:
            self.running = self._step = None

    async def _note_by_hand(self) -> None:
        """Follow a mover that is pushed by hand, for as long as torque is off."""
        by_hand = self.commissioning.by_hand
        if by_hand is None:
            return
        if self.link.state is not State.READY:
            self.commissioning.by_hand = None
            return
        by_hand.note(self.link.figure(Figure.POSITION))
        if by_hand.complete:
            finding = judge_encoders(self.config, by_hand)
            with contextlib.suppress(StoreError, LinkError):  # kept with the next step; begun anew
                await self._in_thread(self.commissioning.put, "encoders", finding)

    def note_stop(self, cause: str, by: str = "") -> None:
        """Keep who or what is about to switch the torque off, where it is on."""
        state, again = self.link.state, self._history.stopped_lately
        if self.running is not None or state in (_ACTIVE if again else _TORQUE):
            self._history.note_stop(cause, by)

    @property
    def stopped_by(self) -> str:
        """Who stopped the drives a moment ago; empty where no person is known to have."""
        stopped = self._history.stopped
        return stopped.by if stopped is not None and self._history.stopped_lately else ""

    def give_up(self, token: str) -> None:
        """End a lease; armed drives stop first."""
        self.lease.check(token)
        self._end_control("control given up", "control was given up")

    def _end_control(self, cause: str, why: str) -> None:
        """Stop what moves, and whatever is about to; the lease is free once nothing does."""
        active = self.active
        self.note_stop(cause, self.lease.holder)
        self.stop(why)
        if active:
            self.lease.end()
        else:
            self.lease.free()

    def next_motion(self) -> int:
        """Return the number of a further motion."""
        self._motions += 1
        return self._motions

    async def close(self) -> None:
        """Stop, and end the link."""
        self._watching.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await self._watching
        self.note_stop("the server ended")
        if self._doing is not None:
            self.stop("the server ended")
            await self._doing
        if self._renewing is not None:
            await self._renewing
        await self._in_thread(self.link.close)
        self._threads.shutdown(wait=False)

    def status(self) -> DriveStatus:
        """Return what a person needs to know of the link at the moment."""
        self.note_serials()
        other_drives = self.commissioning.other_drives
        return drive_status(self.config, self.link, self.lease, self._history, other_drives)

    async def _in_thread(self, work: Callable[..., Any], *arguments: Any) -> Any:
        return await asyncio.get_running_loop().run_in_executor(self._threads, work, *arguments)

    async def _watch(self) -> None:
        """Stop what moves when the heartbeat of the lease ends; then free it."""
        while True:
            await asyncio.sleep(_WATCH)
            try:
                self._watch_lease()
                self._history.note()
                await self._note_by_hand()
                self._watch_identities()
            except Exception:  # whatever it is, the next heartbeat that is missing counts
                _LOG.exception("watching the drives")

    def _watch_identities(self) -> None:
        """Bring the link up anew where other drives were found than those its values are of."""
        self.note_serials()
        busy = self.active or self._ordering or self._beginning.locked()
        if self._of_others and self.link.state is State.READY and not busy:
            self._renewing = asyncio.create_task(self._renew())

    async def _renew(self) -> None:
        async with self._beginning:
            if self._of_others:
                await self._begin_anew()

    @property
    def _of_others(self) -> bool:
        """Whether the link is up with values that are not those of the drives it found."""
        return self.config != self.link.config

    def _watch_lease(self) -> None:
        """Stop what moves without a heartbeat, or without a lease."""
        if self.lease.expired:
            self._end_control("no heartbeat", "control of the drives ended")
        elif not self.lease.holder and self.link.state in _TORQUE:
            self.note_stop("no one in control", "")
            self.stop("no one controls the drives")
