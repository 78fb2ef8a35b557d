"""The scenes of a server: a child process for each session watched in 3-D.

A child ends after a while without viewers, when its session ends, or with this process,
whose end closes its stdin. One that crashed is started again by the next request: viewers reconnect
by themselves.
"""

from __future__ import annotations

import asyncio
import logging
import sys
import time
from collections.abc import Sequence

from fastapi import HTTPException

from motionlab.server.live.session import Session
from motionlab.server.view3d import proxy
from motionlab.server.view3d.process import Scene

COMMAND = (sys.executable, "-m", "motionlab.scene3d")
UNWATCHED_SECONDS = 30.0
_EVICTION_PERIOD = 2.0
_LOG = logging.getLogger(__name__)


class Scenes:
    """All scenes."""

    def __init__(self, *, most: int, command: Sequence[str] = COMMAND) -> None:
        self._most = most
        self._command = command
        self._scenes: dict[str, Scene] = {}
        self._ending: set[asyncio.Task[None]] = set()

    def all(self) -> list[Scene]:
        """Return the scenes, oldest first."""
        return list(self._scenes.values())

    async def of(self, session: Session | None) -> Scene:
        """Return the scene of a session, started if need be; only callers for this session wait.

        Raises
        ------
        HTTPException
            429 if too many are watched, 503 if the process cannot be started.
        """
        key = "" if session is None else session.id
        scene = self._scenes.get(key)
        if scene is None or not (scene.starting or scene.alive):
            if scene is not None:
                self.drop(scene)
            self._make_room()
            scene = self._scenes[key] = Scene(session, self._command)
        scene.watched = time.monotonic()
        try:
            await scene.started()
        except HTTPException:
            self.drop(scene)
            raise
        return scene

    def find(self, session: Session) -> Scene | None:
        """Return the scene of a session that is shown already, without starting one."""
        scene = self._scenes.get(session.id)
        return scene if scene is not None and not scene.starting and scene.alive else None

    def drop(self, scene: Scene) -> None:
        """End a scene without waiting for it; the next request starts another one."""
        self._scenes = {key: kept for key, kept in self._scenes.items() if kept is not scene}
        ending = asyncio.create_task(scene.end())
        self._ending.add(ending)
        ending.add_done_callback(self._ending.discard)

    async def keep_evicting(self) -> None:
        """End scenes that are over or hang, periodically; runs for ever."""
        while True:
            await asyncio.sleep(_EVICTION_PERIOD)
            await self.evict_idle()

    async def evict_idle(self) -> None:
        """End views that are unwatched, unresponsive, or without a session."""
        ready = [scene for scene in self.all() if not scene.starting]
        for scene in ready:
            unwatched = time.monotonic() - scene.watched > UNWATCHED_SECONDS
            if not scene.alive or (scene.viewers == 0 and unwatched):
                self.drop(scene)
        kept = [scene for scene in self.all() if not scene.starting]
        answers = await asyncio.gather(*(proxy.answers(scene) for scene in kept))
        for scene, answered in zip(kept, answers, strict=True):
            if not answered:
                _LOG.warning("the 3-D process %s does not answer and is ended", scene.pid)
                self.drop(scene)

    async def close(self) -> None:
        """End every scene."""
        for scene in self.all():
            self.drop(scene)
        await asyncio.gather(*self._ending)

    def _make_room(self) -> None:
        """End the scene that has been unwatched longest where there is no room, or answer 429."""
        if len(self._scenes) < self._most:
            return
        idle = [scene for scene in self.all() if scene.viewers == 0 and not scene.starting]
        if not idle:
            raise HTTPException(429, f"{self._most} scenes are watched already; close one")
        self.drop(min(idle, key=lambda scene: scene.watched))
