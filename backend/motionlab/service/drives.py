"""The drive link of a server: one link, one lease, one motion at a time."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from collections.abc import Callable, Sequence

from pydantic import BaseModel, Field

from motionlab.config.drive import DriveAxisConfig, DriveConfig
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.config.shipped import data_root
from motionlab.config.timing import CONTROL_PERIOD
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
from motionlab.drive.faults import DRIVE_ERRORS
from motionlab.drive.lease import Lease
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.link.link import DriveLink, FaultNow
from motionlab.drive.link.shared import Figure, Order, State, Status
from motionlab.drive.motion import held_parameters, on_drives
from motionlab.drive.process_data import STO_ACTIVE
from motionlab.errors import MotionLabError, StoreError
from motionlab.service.drive_history import DriveHistory, LastStop, PastFault, Recent

_LOG = logging.getLogger(__name__)

_WATCH = 0.2  # s
_TEXT_MAX = 1000
TORQUE_STEPS: dict[StepName, Callable[[StepRun], Finding]] = {
    "currents": phase_currents,
    "commutation": commutation_offset,
    "homing": find_stops,
    "hold": hold_with_low_gains,
}
_TORQUE = {State.ARMING, State.HOLDING, State.MOVING, State.TESTING}
_ACTIVE = _TORQUE | {State.STOPPING}


class Found(BaseModel):
    """What a drive says of itself."""

    vendor: int
    product: int
    revision: int
    serial: int
    name: str
    rated_current: float = Field(description="A")


class Identity(BaseModel):
    """What a drive's information memory says of it."""

    vendor: int
    product: int


class OneDrive(BaseModel):
    """One drive at the moment."""

    axis: str
    phase: str
    state: str = Field(description="In the words of CiA 402")
    status_word: int = Field(description="Object 6041")
    error: int = Field(description="Object 603F")
    error_name: str
    sto: bool | None = Field(
        description="Whether safe torque off is active; null where the drive does not report it"
    )
    current: float = Field(description="A")
    current_max: float = Field(description="Limit of the loop and of the drive, A")
    rated_current: float = Field(description="A")
    vendor: int = Field(description="Object 1018:01, as expected")
    product: int = Field(description="Object 1018:02, as expected")
    answers: Identity | None = Field(
        description="While there is no link: who answers in this place of the bus, if known"
    )
    found: Found | None = Field(description="What the drive says of itself, once it is found")


class OneAxis(BaseModel):
    """One axis at the moment, m and m/s, and its limits."""

    axis: str
    position: float
    velocity: float
    following_error: float
    limits: DriveAxisConfig


class LoopFigures(BaseModel):
    """How the loop keeps its time."""

    cycles: int
    late: int = Field(description="Cycles that ended after the next should have begun")
    late_run: int = Field(description="Longest run of these")
    missed: int = Field(description="Cycles without a good answer; the last command was held")
    working_counter: int
    al_status: int = Field(description="Application-layer status of all drives, or-ed")
    phase_error: float = Field(description="Of the exchange against SYNC0, s")
    phase_locked: bool
    round_trip: float = Field(description="Latest, s")
    wake_late: float = Field(description="Longest time from a period's start until it was awake, s")
    control_time: float = Field(description="Longest time of the controller's half, s")
    period: float = Field(description="s")
    recent: Recent
    age: float | None = Field(description="Time since the last cycle, s; null before the first")
    priority_wanted: int = Field(description="Of the configuration")
    priority: int = Field(description="Under SCHED_FIFO; 0 where it is not permitted")
    memory_locked: bool


class BusFacts(BaseModel):
    """Where the drives are, and when they stop by themselves."""

    carrier: str
    place: str = Field(description="Address and port, or network card")
    slow: int = Field(description="How many times slower than real time link and drives run")
    distributed_clocks: bool
    watchdog: float = Field(description="Of the drives, s")
    loss: float = Field(description="Without an answer for this long the loop latches a fault, s")


class DriveStatus(BaseModel):
    """What a person needs to know of the link."""

    title: str
    virtual: bool = Field(description="Whether a virtual drive answers")
    state: str = Field(
        description="offline, ready, arming, holding, moving, testing, stopping, fault"
    )
    problem: str = Field(description="Why there is no link; empty when all is well")
    step: str = Field(description="Latest step of bring-up")
    fault: FaultNow | None
    faults: list[PastFault] = Field(description="Since the server began, the latest first")
    holder: str | None = Field(description="Who controls the drives")
    held_since: float | None = Field(description="Wall clock, s since 1970")
    asking: str | None = Field(description="Who asked for control in the last minute")
    stopped: LastStop | None = Field(description="The last stop since the server began")
    bus: BusFacts
    drives: list[OneDrive]
    axes: list[OneAxis]
    loop: LoopFigures


class RunningStep(BaseModel):
    """A step of commissioning that goes on."""

    step: StepName
    since: float = Field(description="Wall clock, s since 1970")
    progress: float = Field(ge=0.0, le=1.0, description="Share that is done")
    text: str = Field(description="What it does at the moment")


class Drives:
    """A drive link with its lease.

    Parameters
    ----------
    config : DriveConfig
        The link, as its file has it.

    Attributes
    ----------
    link : DriveLink
        The drives.
    lease : Lease
        Who may move them.
    commissioning : Commissioning
        Its steps and what they found.
    running : RunningStep or None
        A step with torque that goes on.
    torque_steps : dict of str to callable
        What each step with torque does, in a thread.
    """

    def __init__(self, config: DriveConfig) -> None:
        self.commissioning = Commissioning(config, data_root() / "commissioning.json")
        self.link = DriveLink(self.config)
        self.lease = Lease()
        self.running: RunningStep | None = None
        self.torque_steps = dict(TORQUE_STEPS)
        self._step: StepRun | None = None
        self._doing: asyncio.Task[None] | None = None
        self._history = DriveHistory(self.link)
        self._motions = 0
        self._beginning = asyncio.Lock()
        self._watching = asyncio.create_task(self._watch())

    @property
    def config(self) -> DriveConfig:
        """The link in effect: its file with the changes that commissioning took."""
        return self.commissioning.config

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
        await asyncio.to_thread(self.link.order, order)

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
            if self.link.ended:  # no other request has begun one meanwhile
                await self._begin_anew()

    async def arm(self, load: Callable[[], Scenario], variant: str | None, token: str) -> None:
        """Switch the torque on, with a scenario's gains holding the position.

        Raises
        ------
        ConfigError
            If drives cannot carry the scenario out.
        """
        self.lease.check(token)
        self.check_free()

        def arm() -> None:
            if self.link.state is not State.READY:  # gains of what moves stay as they are
                raise LinkError(f"not possible while the link is {self.link.state.name.lower()}")
            if not self.link.status(Status.PHASE_LOCKED):
                raise LinkError("not yet in phase with SYNC0 of the drives: wait a moment")
            self.link.load(held_parameters(on_drives(load(), variant)))
            self.link.order(Order.ARM)

        await asyncio.to_thread(arm)

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
            If it is of another link, or the drives have torque.
        ConfigError
            If a value is out of its range.
        StoreError
            If it cannot be kept.
        """
        await self._reconfigure(lambda: self.commissioning.load(record))

    async def _reconfigure(self, change: Callable[[], None]) -> None:
        self.check_free()
        async with self._beginning:
            if self.link.state in _ACTIVE:
                raise LinkError(f"not possible while the link is {self.link.state.name.lower()}")
            before = self.config
            await asyncio.to_thread(change)
            if self.config != before:
                await self._begin_anew()

    async def _begin_anew(self) -> None:
        """End the loop and begin another one, with the configuration in effect."""
        await asyncio.to_thread(self.link.close)
        self.link = await asyncio.to_thread(DriveLink, self.config)
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
        state, found = self.link.state, self.link.found
        if state is not State.READY or not found:
            raise LinkError(
                f"commissioning needs drives without torque: the link is {state.name.lower()}"
            )
        if step_of(name).torque and not self.link.status(Status.PHASE_LOCKED):
            raise LinkError("not yet in phase with SYNC0 of the drives: wait a moment")
        commissioning = self.commissioning
        commissioning.begin(name)
        if name == "encoders":
            commissioning.by_hand = ByHand(self.link.figure(Figure.POSITION))
            return
        if step_of(name).torque:
            self._begin_step(name)
            return
        judge = {"drives": find_drives, "identity": compare_identity}[name]
        await asyncio.to_thread(commissioning.put, name, judge(self.config, found))

    def check_free(self) -> None:
        """Refuse while a step of commissioning goes on.

        Raises
        ------
        LinkError
            Naming it.
        """
        if self.running is not None:
            raise LinkError(f"not possible while the step {self.running.step} goes on")

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
            finding = await asyncio.to_thread(self.torque_steps[name], run)
        except Stopped as error:
            finding = Finding(at=time.time(), holds=False, text=f"ended before its end: {error}")
        except MotionLabError as error:
            self.link.stop()
            finding = Finding(at=time.time(), holds=False, text=str(error)[:_TEXT_MAX])
        except Exception:
            self.link.stop()
            _LOG.exception("step %s of commissioning", name)
            finding = Finding(at=time.time(), holds=False, text="it failed: see the server's log")
        with contextlib.suppress(StoreError):  # it is shown, and kept with the next step
            await asyncio.to_thread(self.commissioning.put, name, finding)
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
            with contextlib.suppress(StoreError):  # it is shown, and kept with the next step
                await asyncio.to_thread(self.commissioning.put, "encoders", finding)

    def note_stop(self, cause: str, by: str = "") -> None:
        """Keep who or what is about to switch the torque off, where it is on."""
        if self.running is not None or self.link.state in _TORQUE:
            self._history.note_stop(cause, by)

    def give_up(self, token: str) -> None:
        """End a lease; armed drives stop first."""
        self.lease.check(token)
        self.note_stop("control given up", self.lease.holder)
        if self.running is not None or self.link.state in _TORQUE:
            self.stop("control was given up")
        elif self.link.state is not State.STOPPING:
            self.lease.free()
            return
        self.lease.end()

    def next_motion(self) -> int:
        """Return the number of a further motion."""
        self._motions += 1
        return self._motions

    async def close(self) -> None:
        """Stop, and end the link."""
        self._watching.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await self._watching
        if self._doing is not None:
            self.stop("the server ended")
            await self._doing
        await asyncio.to_thread(self.link.close)

    def status(self) -> DriveStatus:
        """Return what a person needs to know of the link at the moment."""
        link, bus, found = self.link, self.config.link, self.link.found
        self._history.note()
        figures = [
            link.figure(figure)
            for figure in (Figure.POSITION, Figure.VELOCITY, Figure.FOLLOWING_ERROR)
        ]
        return DriveStatus(
            title=self.config.title,
            virtual=self.config.virtual,
            state=link.state.name.lower(),
            problem="the drive loop has ended: reset begins it anew"
            if link.ended
            else link.problem,
            step=next(
                (report["step"] for report in reversed(link.reports) if "step" in report), ""
            ),
            fault=link.fault(),
            faults=self._history.faults,
            holder=self.lease.holder or None,
            held_since=self.lease.since if self.lease.holder else None,
            asking=self.lease.asking or None,
            stopped=self._history.stopped,
            bus=BusFacts(
                carrier=bus.carrier,
                place=bus.interface or f"{bus.address}:{bus.port}",
                slow=bus.slow,
                distributed_clocks=bus.distributed_clocks,
                watchdog=bus.watchdog,
                loss=bus.loss,
            ),
            drives=[
                OneDrive(
                    axis=node.axis,
                    phase=node.phase,
                    state=drive.state,
                    status_word=drive.status_word,
                    error=drive.error,
                    error_name=known.name if (known := DRIVE_ERRORS.get(drive.error)) else "",
                    sto=self._sto(drive.status_word),
                    current=drive.torque * node.rated_current * 1e-3,
                    current_max=getattr(self.config, node.axis).current_max,
                    rated_current=node.rated_current,
                    vendor=node.vendor,
                    product=node.product,
                    answers=Identity(**link.answers[number]) if link.answers else None,
                    found=Found(**found[number]) if found else None,
                )
                for number, (node, drive) in enumerate(
                    zip(self.config.nodes, link.drives, strict=True)
                )
            ],
            axes=[
                OneAxis(
                    axis=axis,
                    position=p,
                    velocity=v,
                    following_error=e,
                    limits=getattr(self.config, axis),
                )
                for axis, p, v, e in zip(AXES, *figures, strict=True)
            ],
            loop=self._loop_figures(),
        )

    def _sto(self, status_word: int) -> bool | None:
        """Return whether STO is active; bit 14 is known to mean it in the virtual drive only."""
        active = bool(status_word & STO_ACTIVE)
        known = self.config.virtual and self.link.state is not State.OFFLINE
        return active if active or known else None

    def _loop_figures(self) -> LoopFigures:
        status = self.link.status
        updated, slow = status(Status.UPDATED), self.config.link.slow
        return LoopFigures(
            cycles=status(Status.CYCLES),
            late=status(Status.LATE),
            late_run=status(Status.LATE_RUN),
            missed=status(Status.MISSED),
            working_counter=status(Status.WORKING_COUNTER),
            al_status=status(Status.AL_STATUS),
            phase_error=status(Status.PHASE_ERROR) * 1e-9,
            phase_locked=bool(status(Status.PHASE_LOCKED)),
            round_trip=status(Status.ROUND_TRIP) * 1e-9,
            wake_late=status(Status.WAKE_LATE) * 1e-9,
            control_time=status(Status.CONTROL_TIME) * 1e-9,
            period=CONTROL_PERIOD,
            recent=self._history.recent(),
            age=max(0.0, time.monotonic() - updated * slow * 1e-9) if updated else None,
            priority_wanted=self.config.link.priority,
            priority=status(Status.PRIORITY),
            memory_locked=bool(status(Status.MEMORY_LOCKED)),
        )

    async def _watch(self) -> None:
        """Stop what moves when the heartbeat of the lease ends; then free it."""
        while True:
            await asyncio.sleep(_WATCH)
            self._history.note()
            await self._note_by_hand()
            if self.lease.expired:
                self.note_stop("no heartbeat", self.lease.holder)
                if self.running is not None or self.link.state in _TORQUE:
                    self.stop("control of the drives ended")
                elif self.link.state is not State.STOPPING:
                    self.lease.free()
