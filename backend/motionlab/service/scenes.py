"""The scenes of a server: a child process for each session that somebody watches in 3-D.

A child ends when nobody has watched it for a while, when its session ends, or with this process,
whose end closes its stdin. One that died comes back with the next request: viewers ask by
themselves.
"""

from __future__ import annotations

import asyncio
import sys
import time
from collections.abc import Sequence

from fastapi import HTTPException

from motionlab.service.scene import Scene
from motionlab.service.session import Session

COMMAND = (sys.executable, "-m", "motionlab.scene")
UNWATCHED_SECONDS = 30.0
_SWEEP_SECONDS = 2.0


class Scenes:
    """All scenes.

    Parameters
    ----------
    most : int
        Scenes that may be shown at once.
    command : sequence of str, optional
        What starts a scene's process.
    """

    def __init__(self, *, most: int, command: Sequence[str] = COMMAND) -> None:
        self._most = most
        self._command = command
        self._scenes: dict[str, Scene] = {}
        self._lock = asyncio.Lock()

    def all(self) -> list[Scene]:
        """Return the scenes, oldest first."""
        return list(self._scenes.values())

    async def of(self, session: Session | None) -> Scene:
        """Return the scene of a session, started if need be.

        Raises
        ------
        HTTPException
            429 if too many are watched, 503 if the process cannot be started.
        """
        key = "" if session is None else session.id
        async with self._lock:
            scene = self._scenes.get(key)
            if scene is not None and scene.alive:
                scene.watched = time.monotonic()
                return scene
            self._scenes.pop(key, None)
            await self._make_room()
            scene = Scene(session, self._command)
            await scene.start()
            self._scenes[key] = scene
            return scene

    async def sweep(self) -> None:
        """End scenes that nobody watches or whose session is gone; runs for ever."""
        while True:
            await asyncio.sleep(_SWEEP_SECONDS)
            await self.sweep_once()

    async def sweep_once(self) -> None:
        """End scenes that nobody watches or whose session is gone."""
        async with self._lock:
            for key, scene in list(self._scenes.items()):
                unwatched = time.monotonic() - scene.watched > UNWATCHED_SECONDS
                if not scene.alive or (scene.viewers == 0 and unwatched):
                    del self._scenes[key]
                    await scene.end()

    async def close(self) -> None:
        """End every scene."""
        scenes = self.all()
        self._scenes.clear()
        await asyncio.gather(*(scene.end() for scene in scenes))

    async def _make_room(self) -> None:
        """End the scene that has been unwatched longest where there is no room, or answer 429."""
        if len(self._scenes) < self._most:
            return
        idle = [item for item in self._scenes.items() if item[1].viewers == 0]
        if not idle:
            raise HTTPException(429, f"{self._most} scenes are watched already; close one")
        key, scene = min(idle, key=lambda item: item[1].watched)
        del self._scenes[key]
        await scene.end()
