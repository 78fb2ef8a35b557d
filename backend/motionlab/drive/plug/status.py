"""What a person needs to know of a drive link: the document of `GET /drive`."""

from __future__ import annotations

import time

from pydantic import BaseModel, Field

from motionlab.config.drive import DriveAxisConfig, DriveConfig
from motionlab.config.planar import AXES
from motionlab.drive.faults import DRIVE_ERRORS
from motionlab.drive.lease import Lease
from motionlab.drive.link.link import DriveLink
from motionlab.drive.link.readings import FaultNow
from motionlab.drive.link.shared import Figure, State, Status
from motionlab.drive.plug.history import DriveHistory, LastStop, PastFault, Recent
from motionlab.drive.process_data import STO_ACTIVE
from motionlab.timing import CONTROL_PERIOD

_CURRENT = 0.25  # s; a loop whose machine has stalled for this long says nothing of now


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
    known: bool = Field(
        description="Whether `drives`, `axes` and counters of the bus are those of now; false: of "
        "the last telegram, and what the drives do is not known"
    )
    age: float | None = Field(
        description="Time since the last good telegram of the drives, s; null before the first"
    )
    other_drives: str = Field(
        description="Why these drives cannot be armed: serial numbers other than those that were "
        "commissioned; or empty",
    )
    bus: BusFacts
    drives: list[OneDrive]
    axes: list[OneAxis]
    loop: LoopFigures


def drive_status(
    config: DriveConfig, link: DriveLink, lease: Lease, history: DriveHistory, other_drives: str
) -> DriveStatus:
    """Return the state of a link, its drives and its loop at the moment.

    `other_drives` says why they are not those that were commissioned; empty where they are.
    """
    bus, identities = config.link, link.identities
    # A fault of this moment is in the list, too.
    history.note()
    known, age = _telegram(config, link)
    figures = [
        link.figure(figure) for figure in (Figure.POSITION, Figure.VELOCITY, Figure.FOLLOWING_ERROR)
    ]
    return DriveStatus(
        title=config.title,
        virtual=config.virtual,
        state=link.state.name.lower(),
        problem="the drive loop has ended: reset begins it anew" if link.ended else link.problem,
        step=next((report["step"] for report in reversed(link.reports) if "step" in report), ""),
        fault=link.fault(),
        faults=history.faults,
        holder=lease.holder or None,
        held_since=lease.since if lease.holder else None,
        asking=lease.asking or None,
        stopped=history.stopped,
        known=known,
        age=age,
        other_drives=other_drives,
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
                error_name=error.name if (error := DRIVE_ERRORS.get(drive.error)) else "",
                sto=_sto(config, drive.status_word) if known else None,
                current=drive.torque * node.rated_current * 1e-3,
                current_max=getattr(config, node.axis).current_max,
                rated_current=node.rated_current,
                vendor=node.vendor,
                product=node.product,
                answers=Identity(**link.answers[number]) if link.answers else None,
                found=Found(**identities[number]) if identities else None,
            )
            for number, (node, drive) in enumerate(zip(config.nodes, link.drives, strict=True))
        ],
        axes=[
            OneAxis(
                axis=axis,
                position=p,
                velocity=v,
                following_error=e,
                limits=getattr(config, axis),
            )
            for axis, p, v, e in zip(AXES, *figures, strict=True)
        ],
        loop=_loop_figures(config, link, history),
    )


def _telegram(config: DriveConfig, link: DriveLink) -> tuple[bool, float | None]:
    """Return whether the last telegram is the state of now, and its age, s."""
    cycle, missed = _cycle_age(link), link.status(Status.MISSED_NOW)
    if cycle is None:
        return False, None
    slow = config.link.slow
    age = cycle + missed * CONTROL_PERIOD * slow
    answers = link.state is not State.OFFLINE and not link.ended
    return answers and age < _CURRENT + config.link.loss * slow, age


def _cycle_age(link: DriveLink) -> float | None:
    """Return the time since the last cycle of the loop, s; None before the first."""
    updated = link.status(Status.UPDATED)  # in the machine's time, however slow the link is
    return max(0.0, time.monotonic() - updated * 1e-9) if updated else None


def _sto(config: DriveConfig, status_word: int) -> bool | None:
    """Return whether STO is active; bit 14 is known to mean it in the virtual drive only."""
    active = bool(status_word & STO_ACTIVE)
    return active if active or config.virtual else None


def _loop_figures(config: DriveConfig, link: DriveLink, history: DriveHistory) -> LoopFigures:
    status = link.status
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
        recent=history.recent(),
        age=_cycle_age(link),
        priority_wanted=config.link.priority,
        priority=status(Status.PRIORITY),
        memory_locked=bool(status(Status.MEMORY_LOCKED)),
    )
