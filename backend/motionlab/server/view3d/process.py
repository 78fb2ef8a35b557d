"""The 3-D view of a session: its child process and the feed of poses."""

from __future__ import annotations

import asyncio
import contextlib
import json
import secrets
import time
from collections.abc import Sequence

import numpy as np
from fastapi import HTTPException

from motionlab.config.load import load_scenario
from motionlab.config.plant import PlantConfig
from motionlab.kernel.force_maps import pole_pitch
from motionlab.scene3d import protocol
from motionlab.scene3d.view_settings import ViewSettings
from motionlab.server.live.notification import Listener
from motionlab.server.live.session import Session
from motionlab.server.view3d.phase_forces import PhaseForces, air_gap
from motionlab.timing import CONTROL_PERIOD

VIEWERS_MAX = 8
"""Viewers of one scene."""

VARIANTS_MAX = 2
"""Stages side by side: the first variants."""

_START_SECONDS = 60.0  # a busy machine that reads viser for the first time
_PATH_POINTS = 600
_POSE_TICKS = round(1.0 / protocol.RATE / CONTROL_PERIOD)


class Scene:
    """One 3-D view's process and its feed.

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
        self._starting: asyncio.Task[None] | None = None
        self._ended = False
        variants = [] if session is None else session.variants[:VARIANTS_MAX]
        self._rows = np.empty(0, np.intp)
        self._forces: tuple[PlantConfig, PhaseForces] | None = None
        if session is not None:
            rows = {name: row for row, (name, _) in enumerate(session.history.columns)}
            self._rows = np.array([rows[name] for name in protocol.column_names(variants)])

    @property
    def alive(self) -> bool:
        """Whether the process runs and its session lives."""
        running = self._process is not None and self._process.returncode is None
        return running and not (self.session is not None and self.session.closed)

    @property
    def pid(self) -> int | None:
        """Process id, once started."""
        return None if self._process is None else self._process.pid

    @property
    def starting(self) -> bool:
        """Whether the process is not ready yet."""
        return self._starting is None or not self._starting.done()

    async def started(self) -> None:
        """Start the process, or wait until it is ready.

        Raises
        ------
        HTTPException
            503 with the reason if it cannot be started.
        """
        if self._starting is None:
            self._starting = asyncio.create_task(self._start())
            # The client may have disconnected.
            self._starting.add_done_callback(lambda task: task.cancelled() or task.exception())
        await asyncio.shield(self._starting)

    async def _start(self) -> None:
        pipe = asyncio.subprocess.PIPE
        try:
            self._process = await asyncio.create_subprocess_exec(
                *self._command, stdin=pipe, stdout=pipe
            )
            if self._ended:
                self._process.kill()
            self._write(self._start_message())
            assert self._process.stdout is not None
            async with asyncio.timeout(_START_SECONDS):
                line = await self._process.stdout.readline()
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
            raise HTTPException(503, f"the 3-D view is not available: {reason}")
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

    def configure(self, viewer: str, settings: ViewSettings) -> None:
        """Tell the process what a viewer chose, who may still have to connect."""
        self._write(protocol.view(viewer, settings))

    async def end(self) -> None:
        """End the process; its viewers are disconnected."""
        self._ended = True
        if self._feeding is not None:
            self._feeding.cancel()
        if self._process is not None:
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()
            await self._process.wait()

    async def _feed(self, session: Session) -> None:
        """Send the newest pose whenever something has moved, at most at `protocol.RATE`, Hz."""
        listener = Listener()
        session.listeners.add(listener)
        try:
            await asyncio.to_thread(self._forces_of, session, self._at_rest(session)[0])  # loads it
            self._write(protocol.message(protocol.CLEAR) + self._past())
            while not session.closed:
                await listener.wake.wait()
                listener.wake.clear()
                if listener.was_reset:
                    listener.was_reset = False
                    self._write(protocol.message(protocol.CLEAR) + self._past())
                elif listener.has_changed:
                    listener.has_changed = False
                    # The motor may rest now: sent twice, also the parts that skip every other pose
                    # are drawn.
                    self._write(2 * self._newest(session))
                elif self._idle():
                    self._write(self._newest(session))
                await asyncio.sleep(1.0 / protocol.RATE)
        finally:
            session.listeners.discard(listener)
            session.touched = time.monotonic()

    def _newest(self, session: Session) -> bytes:
        ring = session.history.ring
        if ring.end == ring.first:
            return b""
        return self._with_forces(session, ring.read(self._rows, ring.end - 1, ring.end).T)

    def _with_forces(self, session: Session, poses: protocol.Values) -> bytes:
        return protocol.forces(self._forces_of(session, poses[-1])) + protocol.poses(poses)

    def _forces_of(self, session: Session, pose: protocol.Values) -> protocol.Values:
        """Return the forces of each phase at a pose, by the force maps in effect."""
        plant = session.simulation.scenario.plant
        if self._forces is None or self._forces[0] is not plant:
            self._forces = plant, PhaseForces(plant)
        position, currents = protocol.positions_and_currents(pose)
        return self._forces[1].at(position, currents).astype(np.float32)

    def _past(self) -> bytes:
        """Return the poses of the last seconds, or where the motor rests before its first tick."""
        if self.session is None:
            return protocol.poses(np.zeros((1, protocol.width(VARIANTS_MAX)), np.float32))
        ring = self.session.history.ring
        if ring.end == ring.first:
            return self._with_forces(self.session, self._at_rest(self.session))
        span = round(protocol.TRAIL_SECONDS * protocol.RATE) * _POSE_TICKS
        first = max(ring.first, ring.end - 1 - span)
        past = ring.read(self._rows, first, ring.end)[:, ::-1][:, ::_POSE_TICKS][:, ::-1]
        return self._with_forces(self.session, past.T)

    def _at_rest(self, session: Session) -> protocol.Values:
        """Return the pose at the trajectory's first place, without current."""
        names = protocol.column_names(session.variants[:VARIANTS_MAX])
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
        return protocol.SceneDescription(self.origin, _axes(scenario.plant), labels, path).encode()

    def _idle(self) -> bool:
        """Return whether the process has consumed all that was sent."""
        stdin = None if self._process is None else self._process.stdin
        return stdin is not None and stdin.transport.get_write_buffer_size() == 0

    def _write(self, data: bytes) -> None:
        if self._process is not None and self._process.stdin is not None:
            self._process.stdin.write(data)


def _axes(plant: PlantConfig) -> tuple[protocol.DrawnAxis, protocol.DrawnAxis]:
    x, y = (
        protocol.DrawnAxis(
            axis.stroke,
            pole_pitch(axis.force_map),
            axis.force_map.offset,
            air_gap(axis.force_map),
        )
        for axis in (plant.x, plant.y)
    )
    return x, y
