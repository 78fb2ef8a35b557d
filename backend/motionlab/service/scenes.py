"""The scenes of a server: a child process for each session that somebody watches in 3-D.

A child ends when nobody has watched it for a while, when its session ends, or with this process,
whose end closes its stdin. One that died comes back with the next request: viewers ask by
themselves.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import secrets
import sys
import time
from collections.abc import Sequence

import numpy as np
from fastapi import HTTPException

from motionlab.config.load import load_scenario
from motionlab.config.plant import PlantConfig
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.scene import feed
from motionlab.service.sessions import Listener, Session
from motionlab.simulation.maps import pole_pitch

COMMAND = (sys.executable, "-m", "motionlab.scene")
UNWATCHED_SECONDS = 30.0
VIEWERS_MAX = 8
"""Viewers of one scene."""

VARIANTS_MAX = 2
"""Stages side by side: the first variants."""

_START_SECONDS = 60.0  # a busy machine that reads viser for the first time
_SWEEP_SECONDS = 2.0
_SETTLE_SECONDS = 0.2
_PATH_POINTS = 600
_POSE_TICKS = round(1.0 / feed.RATE / CONTROL_PERIOD)


class Scene:
    """One scene's process, and what feeds it.

    Parameters
    ----------
    session : Session or None
        What is shown; None shows the nominal motor at rest.
    command : sequence of str
        What starts the process.
    """

    def __init__(self, session: Session | None, command: Sequence[str]) -> None:
        self.session = session
        self.origin = f"lab://{secrets.token_hex(16)}"
        self.tag = f'"{secrets.token_hex(8)}"'
        self.port = 0
        self.viewers = 0
        self.watched = time.monotonic()
        self._command = command
        self._process: asyncio.subprocess.Process | None = None
        self._feeding: asyncio.Task[None] | None = None
        variants = [] if session is None else session.variants[:VARIANTS_MAX]
        self._rows: list[int] = []
        if session is not None:
            rows = {name: row for row, (name, _) in enumerate(session.columns)}
            self._rows = [rows[name] for name in feed.column_names(variants)]

    @property
    def alive(self) -> bool:
        """Whether the process runs and its session lives."""
        running = self._process is not None and self._process.returncode is None
        return running and not (self.session is not None and self.session.closed)

    @property
    def pid(self) -> int | None:
        """Process id, once started."""
        return None if self._process is None else self._process.pid

    async def start(self) -> None:
        """Start the process, or answer 503 with the reason."""
        pipe = asyncio.subprocess.PIPE
        try:
            self._process = await asyncio.create_subprocess_exec(
                *self._command, stdin=pipe, stdout=pipe
            )
            self._write(self._start_message())
            assert self._process.stdout is not None
            line = await asyncio.wait_for(self._process.stdout.readline(), _START_SECONDS)
            answer = json.loads(line) if line else {}
            reason = answer.get("error") or "its process ended before it was ready"
            self.port = answer.get("port", 0)
        except TimeoutError:
            reason = f"its process was not ready within {_START_SECONDS:g} s"
        except OSError as error:
            reason = f"its process cannot be started: {error.strerror}"
        except ValueError:
            reason = "its process answered nothing that can be understood"
        if not self.port:
            await self.end()
            raise HTTPException(503, f"the 3-D stage is not available: {reason}")
        if self.session is None:
            self._write(self._past())

    def enter(self) -> None:
        """Count a viewer in; the first one starts the feed."""
        if self.viewers >= VIEWERS_MAX:
            raise HTTPException(429, f"{VIEWERS_MAX} viewers watch this scene already")
        self.viewers += 1
        if self.session is not None and self._feeding is None:
            self._feeding = asyncio.create_task(self._feed(self.session))

    def leave(self) -> None:
        """Count a viewer out; the last one ends the feed."""
        self.viewers -= 1
        self.watched = time.monotonic()
        if self.viewers == 0 and self._feeding is not None:
            self._feeding.cancel()
            self._feeding = None

    async def end(self) -> None:
        """End the process; its viewers are disconnected."""
        if self._feeding is not None:
            self._feeding.cancel()
        if self._process is not None:
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()
            await self._process.wait()

    async def _feed(self, session: Session) -> None:
        """Send the newest pose whenever something has moved, at most `feed.RATE` times a second."""
        listener = Listener()
        session.listeners.add(listener)
        settled = True
        try:
            self._write(feed.message(feed.CLEAR) + self._past())
            while not session.closed:
                try:
                    async with asyncio.timeout(None if settled else _SETTLE_SECONDS):
                        await listener.wake.wait()
                except TimeoutError:
                    settled = True
                    self._write(self._newest(session))  # again, for what is not shown each time
                    continue
                settled = False
                listener.wake.clear()
                if listener.was_reset:
                    listener.was_reset = False
                    self._write(feed.message(feed.CLEAR) + self._past())
                elif self._idle():
                    self._write(self._newest(session))
                await asyncio.sleep(1.0 / feed.RATE)
        finally:
            session.listeners.discard(listener)
            session.touched = time.monotonic()

    def _newest(self, session: Session) -> bytes:
        end = session.ring.end
        if end == session.ring.first:
            return b""
        return feed.poses(session.ring.read(self._rows, end - 1, end).T)

    def _past(self) -> bytes:
        """Return the poses of the last seconds, or where the motor rests before its first tick."""
        if self.session is None:
            return feed.poses(np.zeros((1, feed.width(VARIANTS_MAX)), np.float32))
        ring = self.session.ring
        if ring.end == ring.first:
            return feed.poses(self._at_rest(self.session))
        span = round(feed.TRAIL_SECONDS * feed.RATE) * _POSE_TICKS
        first = max(ring.first, ring.end - 1 - span)
        past = ring.read(self._rows, first, ring.end)[:, ::-1][:, ::_POSE_TICKS][:, ::-1]
        return feed.poses(past.T)

    def _at_rest(self, session: Session) -> feed.Values:
        """Return the pose at the trajectory's first place, without current."""
        names = feed.column_names(session.variants[:VARIANTS_MAX])
        place = dict(zip("xy", session.prepared.reference.position[0], strict=True))
        split = [name.rpartition(".") for name in names]
        pose = [
            place[owner[-1]] if channel in {"position", "position_reference"} else 0.0
            for owner, _, channel in split
        ]
        return np.array([pose], np.float32)

    def _start_message(self) -> bytes:
        if self.session is None:
            scenario = load_scenario("circle")
            path: list[tuple[float, float]] = []
        else:
            scenario = self.session.prepared.scenario
            position = self.session.prepared.reference.position
            chosen = np.linspace(0, len(position) - 1, min(len(position), _PATH_POINTS))
            path = [(float(x), float(y)) for x, y in position[chosen.astype(int)]]
        variants = list(scenario.variants.items())[:VARIANTS_MAX]
        labels = {name: variant.label for name, variant in variants}
        return feed.Start(self.origin, _axes(scenario.plant), labels, path).encode()

    def _idle(self) -> bool:
        """Return whether the process has taken what it was sent."""
        stdin = None if self._process is None else self._process.stdin
        return stdin is not None and stdin.transport.get_write_buffer_size() == 0

    def _write(self, data: bytes) -> None:
        if self._process is not None and self._process.stdin is not None:
            self._process.stdin.write(data)


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


def _axes(plant: PlantConfig) -> tuple[feed.Axis, feed.Axis]:
    x, y = (
        feed.Axis(axis.stroke, pole_pitch(axis.force_map), axis.force_map.offset)
        for axis in (plant.x, plant.y)
    )
    return x, y
