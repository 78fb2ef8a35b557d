"""Files of laws of one's own while a server runs: a changed or new one is tried, then taken.

Each is tried in another process, `motionlab.own_laws.standby`; if it can be taken, all
sessions have it from their next tick on. One that cannot leaves the former version.
"""

from __future__ import annotations

import asyncio
import dataclasses
import hashlib
import logging
import os
import re
from contextlib import AsyncExitStack
from pathlib import Path

import numpy as np

from motionlab.config.planar import AXES
from motionlab.declarations import DeclarationError
from motionlab.errors import ConfigError, FieldError
from motionlab.files import failure, replace
from motionlab.kernel.law_renewal import LawVersion, Renewal
from motionlab.laws import FILES, PARAMETERS, SOURCES, base_of
from motionlab.library.new_run import variants_with
from motionlab.library.run import Event
from motionlab.own_files import OwnFile, files_in
from motionlab.own_laws.accepted import LINKS, REFUSED, WATCHED, accept, accept_again
from motionlab.own_laws.cost import LawCost
from motionlab.own_laws.standby import Standby
from motionlab.own_laws.versions import Versions
from motionlab.server.live.session import Session
from motionlab.server.live.session_info import WrongState
from motionlab.server.live.sessions import Sessions
from motionlab.simulation.simulation import Simulation

_PERIOD = 0.1  # s between looks at the files
_DIGITS = 6  # of a jump of force, N
_ON_DRIVES = "drives keep the version with which their loop began"
_BESIDE_DRIVES = (
    "is declared otherwise, or new, while a session moves drives: save it again once that has ended"
)
_LOG = logging.getLogger(__name__)

_Stamp = tuple[int, int]
_Jump = dict[str, dict[str, float]]


class OwnLaws:
    """The laws of one's own of a server.

    Parameters
    ----------
    sessions : Sessions
        Whose controllers have them.
    """

    def __init__(self, sessions: Sessions) -> None:
        self.problems: dict[str, FieldError] = {}
        """Why the present version of a law's file is not the one that runs, by name."""
        self.refused = {_path_of(each): each for each in REFUSED}
        """Why files that hold no law which runs cannot be taken, by path."""
        # Those of installed packages are imported once.
        self._watched = {
            name: file.path
            for name, file in FILES.items()
            if not file.module and name == base_of(name)
        }
        self.versions = {name: Versions((SOURCES[name],)) for name in self._watched}
        """The versions of each law that have been taken."""
        self.costs: dict[tuple[str, str], LawCost] = {}
        """What laws cost, by name and text of the version, as far as that has been measured."""
        self._sessions = sessions
        self._standby = Standby()
        self._seen = {path: _stamp(path) for path in self._paths()}
        self._order, self._writing = asyncio.Lock(), asyncio.Lock()

    async def keep_watching(self) -> None:
        """Look at the files of laws until cancelled."""
        if not self._watched and not any(WATCHED):
            return
        for name, path in self._watched.items():  # whatever the files hold later
            accept(name, SOURCES[name], SOURCES[name], path)
        if self._watched:
            await asyncio.to_thread(self._standby.start)
        while True:
            await asyncio.sleep(_PERIOD)
            for path in self._paths():
                stamp = _stamp(path)
                if stamp is not None and stamp != self._seen.get(path):
                    self._seen[path] = stamp
                    async with self._order:
                        await self._saved(path)
            self.refused = {path: why for path, why in self.refused.items() if path.exists()}

    def _paths(self) -> set[Path]:
        """Return the files of laws, and those that may become one."""
        paths = set(self._watched.values())
        for file in files_in(os.pathsep.join(WATCHED)):
            path = file.resolve()
            if file.is_symlink():
                LINKS.add(path)
            paths.add(path)
        return paths

    async def move(self, name: str, by: int, person: str = "") -> None:
        """Take the version before of a law, `by` -1, or the one after, 1, again.

        Raises
        ------
        WrongState
            If there is none, or a session has a value that it does not allow.
        """
        async with self._order:
            present = self.versions[name]
            if (versions := present.moved(by)) is None:
                which = "first" if by < 0 else "last"
                raise WrongState(
                    f"version {present.number} of law {name} is the {which} of those that are kept"
                )
            try:
                await self._take(name, versions, self._watched[name], person)
            except DeclarationError as error:
                raise WrongState(str(error)) from None

    async def write(self, name: str, text: bytes, digest: str) -> None:
        """Write the file of a law, which is then taken as if it had been saved by an editor.

        Parameters
        ----------
        name : str
            Of the law.
        text : bytes
            What the file is to hold.
        digest : str
            `digest_of` what it is known to hold.

        Raises
        ------
        WrongState
            If it holds something else by now, or is a link; it is untouched.
        StoreError
            If it cannot be written.
        """
        async with self._writing:
            await asyncio.to_thread(_write, self._watched[name], text, digest)

    async def _saved(self, path: Path) -> None:
        """Try a file that was saved, and take it where that is possible."""
        known = next((name for name, each in self._watched.items() if each == path), "")
        if not known and OwnFile(path).declares("EFFECT"):
            return
        try:
            if (tried := await asyncio.to_thread(self._tried, known, path)) is None:
                return
            name, text, problem = tried
        except Exception as error:
            _LOG.exception("a law could not be tried")
            problem = FieldError(known or path.stem, f"could not be tried: {error}")
            problem, name, text = problem.at(str(path)), known, ""
        if problem is None and text != SOURCES.get(name):
            versions = self.versions[name].saved(text) if known else Versions((text,))
            try:
                await self._take(name, versions, path)
            except DeclarationError as error:
                problem = error.error.at(str(path))
        if problem is None:
            self.problems.pop(name, None)
            self.refused.pop(path, None)
            return
        if known:
            self.problems[known] = problem
        else:
            self.refused[path] = problem
        _LOG.warning("law not taken: %s", problem)
        event = Event(tick=0, kind="law", law=known or name or path.stem, reason=str(problem))
        for session in self._sessions.all():
            session.law_changed(event)

    def _tried(self, name: str, path: Path) -> tuple[str, str, FieldError | None] | None:
        """Return law and text of a file that was saved, and why it cannot be taken.

        None if it has been saved again: the next look at the files finds that.
        """
        try:
            text = OwnFile(path).text()
        except DeclarationError as error:
            return name, "", error.error
        if _stamp(path) != self._seen[path]:  # it may be half of what is being written
            return None
        result = self._standby.try_version(name, path, text)
        return name or result.name, text, next(iter(result.problems), None)

    async def _take(self, name: str, versions: Versions, path: Path, person: str = "") -> None:
        """Have another version run, or a new law, in all sessions from the same moment on.

        Raises
        ------
        DeclarationError
            If it cannot be used; the former one runs on.
        """
        present = LawVersion(name, versions.running, versions.before, OwnFile(path))
        renewal = await asyncio.to_thread(Renewal, [present])
        event = Event(tick=0, kind="law", law=name, by=person, version=versions.number)
        sessions = self._sessions.all()
        simulated = [each for each in sessions if not each.drive]
        if renewal.redeclares and len(simulated) < len(sessions):
            raise DeclarationError(FieldError(name, _BESIDE_DRIVES))
        async with AsyncExitStack() as stack:  # no tick between the event and the version
            if renewal.redeclares:
                for session in simulated:
                    await stack.enter_async_context(session.in_order())
            for session in simulated:
                await stack.enter_async_context(session.held())
            jumps = await asyncio.to_thread(_put, renewal, present, simulated)
            self._watched[name], self.versions[name] = path, versions
            kept = set(versions.texts)
            self.costs = {
                version: cost
                for version, cost in self.costs.items()
                if base_of(version[0]) != name or version[1] in kept
            }
            for session, jump in zip(simulated, jumps, strict=True):
                session.law_changed(event.model_copy(update={"jump": jump}))
        for session in sessions:
            if session.drive:
                session.law_changed(event.model_copy(update={"reason": _ON_DRIVES}))

    def close(self) -> None:
        """End the process that tries laws."""
        self._standby.close()


def digest_of(text: bytes) -> str:
    """Return the SHA-256 of a file's text."""
    return hashlib.sha256(text).hexdigest()


def _write(path: Path, text: bytes, digest: str) -> None:
    if path in LINKS or path.is_symlink():
        raise WrongState(f"{path.name} is elsewhere, where a link in a folder of laws leads")
    try:
        if not path.is_file():
            raise WrongState(f"{path.name} is no regular file")
        present = path.read_bytes()
        if digest_of(present) != digest:
            raise WrongState(
                f"{path.name} was changed on the disk since it was read: nothing was written; "
                "read it again"
            )
        replace(path, text, mode=None)
    except OSError as error:
        raise failure(f"{path.name}: cannot be written", error) from error


def _put(renewal: Renewal, version: LawVersion, sessions: list[Session]) -> list[_Jump]:
    """Put versions in place, and return how the force commands of each session jump.

    Raises
    ------
    DeclarationError
        If a session has a value that is no longer allowed; nothing has changed then.
    """
    before = [_forces(session, version.name) for session in sessions]
    parameters = dict(PARAMETERS)
    # Before whoever sees the new text asks for what it computes.
    accepted = accept(version.name, version.text, version.before, version.file.path)
    renewal.take()
    try:
        scenarios = [each.redeclared(parameters) for each in sessions if renewal.redeclares]
    except ConfigError as error:
        renewal.take_back()
        accept_again(accepted)
        first = error.errors[0]
        why = f"{first.message} as a session has it: change it there, or allow it"
        raise DeclarationError(dataclasses.replace(first, message=why)) from None
    for session in sessions:
        if isinstance(session.simulation, Simulation):
            session.simulation.law_taken(renewal)
    for put in scenarios:
        put()
    after = [_forces(session, version.name) for session in sessions]
    return [
        {
            variant: {
                axis: round(force, _DIGITS)
                for axis, force in zip(AXES, (new[variant] - forces).tolist(), strict=True)
                if np.isfinite(force)
            }
            for variant, forces in old.items()
        }
        for old, new in zip(before, after, strict=True)
    ]


def _forces(session: Session, law: str) -> dict[str, np.ndarray]:
    """Return what the controllers that have a law are about to command, N, by variant."""
    simulation = session.simulation
    variants = variants_with(simulation.scenario, law)
    if not variants or not isinstance(simulation, Simulation):
        return {}
    forces = simulation.force_commands()
    if forces is None:
        return {}
    return {name: forces[session.variants.index(name)] for name in variants}


def _path_of(problem: FieldError) -> Path:
    """Return the file that a problem is of; its line may follow."""
    return Path(re.sub(r":\d+$", "", problem.place))


def _stamp(path: Path) -> _Stamp | None:
    try:
        status = path.stat()
    except OSError:
        return None  # between two versions, or gone: the one that runs stays
    if status.st_size == 0:
        return None  # about to be written, however long a busy disk takes
    return status.st_mtime_ns, status.st_size
