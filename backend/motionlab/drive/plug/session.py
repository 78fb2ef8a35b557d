"""A live session on drives: the same commands and streams, paced by the drives themselves."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from typing import Any

from motionlab.drive.link.carrier import LinkError
from motionlab.drive.motion import DriveMotion, changes_on_drives
from motionlab.drive.plug.drives import Drives
from motionlab.library.run import Event
from motionlab.server.live.clock import Clock
from motionlab.server.live.run_recorder import RunRecorder
from motionlab.server.live.session import Session
from motionlab.server.live.session_info import RecordState, State, WrongState
from motionlab.server.live.sessions import Sessions
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.simulation import ReadyEpoch

_SWITCH = 0.2
"""s before a scheduled change, in which one of a person waits for it."""
_POLL = 0.01  # s
_LOG = logging.getLogger(__name__)


async def create_session(
    sessions: Sessions, drives: Drives, prepare: Callable[[], Prepared]
) -> DriveSession:
    """Create a session on drives, as `Sessions.create`."""

    def make(clock: Clock, threads: Executor, recorder: RunRecorder | None) -> DriveSession:
        motion = DriveMotion(prepare(), drives.link, drives.next_motion())
        return DriveSession(motion, clock, threads, recorder, drives=drives)

    return await sessions.add(make)


class DriveSession(Session):
    """One variant of a scenario on drives; runs once from its start to its end, or to a stop.

    STOP is taken from anyone, changes of its controller from who holds the lease. They take effect
    while the drives move, and where they hold their position after the motion.
    """

    def __init__(
        self,
        motion: DriveMotion,
        clock: Clock,
        threads: Executor,
        recorder: RunRecorder | None = None,
        *,
        drives: Drives,
    ) -> None:
        self._motion = motion
        self._drives = drives
        self._lease = drives.lease
        super().__init__(motion.prepared, clock, threads, recorder, drive=drives.config.title)

    async def begin(self, stops: int) -> None:
        """Approach the start of the trajectory, and follow it in real time.

        `stops` is as of `DriveLink.order`.

        Raises
        ------
        LinkError
            If the drives do not hold their position.
        """
        await self._in_thread(self._motion.begin, stops)
        await super().play()

    async def play(self, speed: float | None = None, by: str = "") -> None:
        """Refuse: who moves drives holds their lease."""
        raise WrongState("a motion on drives is begun by POST /api/v1/drive/motions, and runs once")

    async def pause(self, by: str = "") -> None:
        """Refuse: a motion of real mass ends by braking."""
        raise WrongState("drives cannot pause within a motion: STOP brakes them to rest")

    async def step(self, ticks: int) -> None:
        """Refuse."""
        raise WrongState("drives cannot step")

    async def reset(self, by: str = "") -> None:
        """Refuse: what was measured stays; a further motion is a session of its own."""
        raise WrongState("a motion on drives runs once: begin another one")

    async def push(self, axis: int, force: float, seconds: float, by: str = "") -> int:
        """Refuse."""
        raise WrongState("only a hand can push the mover of a drive")

    def authorise(self, lease: str) -> None:
        """Refuse who does not hold the lease of the drives."""
        self._lease.check(lease)

    def stop(self, by: str = "") -> None:
        """Brake to rest, then switch the torque off; also when this motion is over."""
        self._drives.note_stop("STOP of the session", by)
        self._motion.stop()  # at once, not with the clock's next look
        if self.state != "finished":
            super().stop(by)

    def keep_up(self, now: float) -> None:
        """Take what the drives have done since the last time."""
        try:
            if self.state == "playing" and self._motion.braking:
                self._note_stop("stopping")
            if self.runs:
                self._advance(self._motion.available, self.state)
            if self.state == "playing" and self._motion.stopped:  # by a fault
                self._note_stop("stopped")
            elif self.runs and self._motion.stopped:  # it stopped without a further sample
                self._advance_slice(0)
            self._recorded()
        except LinkError as error:  # what comes would not be the run that was asked for
            _LOG.warning("session %s: %s", self.id, error)
            self._drives.note_stop("failure of the motion")
            self._motion.stop()
            self._note_stop("stopped", str(error))
            self._recorded()

    async def _change(self, changes: Mapping[str, Any], *, by: str, undo: bool = False) -> int:
        while self._motion.switches_within(_SWITCH):  # to be made over what that leaves
            await asyncio.sleep(_POLL)
        self._refuse_when("stopping", "stopped")
        on_drives = changes_on_drives(changes, self.variants[0])
        return await super()._change(on_drives, by=by, undo=undo)

    async def _put_in_effect(self, changes: Sequence[ReadyEpoch], event: Event) -> int:
        """Wait for the loop in a thread: a stop must not wait meanwhile."""
        tick = await self._in_thread(self._motion.adopt, changes)
        async with self._lock.claimed():
            self._note(event.model_copy(update={"tick": tick}))
        return tick

    def _note_stop(self, state: State, reason: str = "") -> None:
        """Take over that the drives stop, or have stopped, without an order of this session."""
        fault = self._motion.fault
        with self._lock.slice:
            self._stop_tick = self.tick
            by = self._drives.stopped_by if fault is None and not reason else ""
            reason = reason if fault is None else fault.name
            self._note(Event(tick=self.tick, kind="stop", by=by, reason=reason))
            self.state = state
            self._failed = self._motion.failed_ticks
            self._untold = True

    @property
    def _record_state(self) -> RecordState:
        """The run, also once it is complete: no other one follows it in this session."""
        record = self._record
        return (None, "", 0) if record is None else (record.kept, record.problem, record.begins)

    def _machine(self) -> DriveMotion:
        return self._motion

    def close(self) -> None:
        """Stop what moves, and end."""
        if self.runs:
            self._drives.note_stop("end of the session")
            self._motion.stop()
        super().close()
