"""A live session on drives: the same commands and streams, paced by the drives themselves."""

from __future__ import annotations

from concurrent.futures import Executor

from motionlab.drive.motion import DriveMotion
from motionlab.service.live.clock import Clock
from motionlab.service.live.run_recorder import RunRecorder
from motionlab.service.live.session import Session, WrongState

_NO_PAUSE = "drives cannot pause within a motion: STOP brakes them to rest"


class DriveSession(Session):
    """One variant of a scenario on drives; runs once from its start to its end, or to a stop.

    Parameters
    ----------
    motion : DriveMotion
        What the drives are to do.
    clock, threads, recorder
        As `Session` takes them.
    """

    def __init__(
        self,
        motion: DriveMotion,
        clock: Clock,
        threads: Executor,
        recorder: RunRecorder | None = None,
    ) -> None:
        self._motion = motion
        super().__init__(motion.prepared, clock, threads, recorder)

    async def begin(self) -> None:
        """Approach the start of the trajectory, and follow it in real time.

        Raises
        ------
        LinkError
            If the drives do not hold their position.
        """
        await self._in_thread(self._motion.begin)
        super().play()

    def play(self, speed: float | None = None) -> None:
        """Refuse: who moves drives holds their lease."""
        raise WrongState("a motion on drives is begun by POST /api/v1/drive/motions, and runs once")

    def pause(self) -> None:
        """Refuse: a motion of real mass ends by braking."""
        raise WrongState(_NO_PAUSE)

    async def step(self, ticks: int) -> None:
        """Refuse."""
        raise WrongState("drives cannot step")

    async def reset(self) -> None:
        """Refuse: what was measured stays; a further motion is a session of its own."""
        raise WrongState("a motion on drives runs once: create another session")

    def push(self, axis: int, force: float, seconds: float) -> int:
        """Refuse."""
        raise WrongState("only a hand can push the mover of a drive")

    def keep_up(self, now: float) -> None:
        """Take what the drives have done since the last time."""
        state = self.state
        if self.runs:
            self._advance(self._motion.available, state)
        if self.runs and self._motion.stopped:  # it stopped without a further sample
            self._advance_slice(0)
            self._recorded()

    def _machine(self) -> DriveMotion:
        return self._motion

    def close(self) -> None:
        """Stop what moves, and end."""
        if self.runs:
            self._motion.stop()
        super().close()
