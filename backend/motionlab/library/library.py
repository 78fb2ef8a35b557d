"""The library of runs: index and telemetry together, within a quota."""

from __future__ import annotations

import contextlib
import functools
import logging
import os
import re
import shutil
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motionlab.config.load import load_scenario
from motionlab.config.named_configs import data_root
from motionlab.errors import (
    Busy,
    ConfigError,
    FieldError,
    MotionLabError,
    StoreError,
    StoreFull,
    Unknown,
)
from motionlab.files import failure, private_file, private_folder
from motionlab.library.description import differences_after, headline, thumbnail
from motionlab.library.files import RunFiles, runs_url
from motionlab.library.new_run import new_run
from motionlab.library.quota import Room, quota
from motionlab.library.run import NAME, Event, RunDetail, check_name, is_id
from motionlab.library.run_name import run_name
from motionlab.telemetry import recorder
from motionlab.telemetry.parquet import column_descriptions
from motionlab.telemetry.recording import Recording
from motionlab.timing import CONTROL_PERIOD, to_ticks

if TYPE_CHECKING:
    from motionlab.simulation.prepare import Prepared

UNDO_SECONDS = 600.0
"""Time for which a deleted run can be restored."""

METRICS_SECONDS = 10.0
"""Time over which metrics of a live run are taken where its motion does not repeat."""

FREE_LEAST = 200_000_000
"""Space that is left on the disk of the data, bytes."""

_LOG = logging.getLogger(__name__)
_SPOOLS = "recording"
_SMALLER = 8  # a run than its recording, at most
_ROLLED = "a recording takes half of MOTIONLAB_RUNS_MAX at most, and its beginning goes"
_REMOVED = "unrecorded: its recording was removed from the folder of the data"
_CUT_OFF = "its recording was cut off: its server was killed, or could not write its end"


class Library:
    """All runs of a folder of data.

    Parameters
    ----------
    root : Path
        The folder; holds the index and telemetry unless MOTIONLAB_DATABASE_URL and
        MOTIONLAB_RUNS_URL say otherwise, and always what is being recorded.

    Raises
    ------
    StoreError
        If the index cannot be opened.
    """

    def __init__(self, root: Path) -> None:
        try:
            private_folder(root)
        except OSError as error:
            raise StoreError(f"{root} cannot be made: {error.strerror}") from error
        from motionlab.library.database import index_url
        from motionlab.library.index import Index

        self.spools = spools(root)
        self.index = Index(index_url(root))
        self.files = RunFiles(runs_url(root))
        self.room = Room(self.index, self.spools, self._remove)

    def close(self) -> None:
        """Close the index."""
        self.index.close()

    def get(self, run_id: str) -> RunDetail:
        """Return a run.

        Raises
        ------
        Unknown
            If there is none of that identifier.
        """
        run = self.index.get(run_id)
        if run is None:
            raise Unknown(f"no run {run_id!r}")
        return run

    def named(self, text: str, loc: str = "RUN") -> str:
        """Return the identifier of a run, given that or a name that no other run has.

        Raises
        ------
        ConfigError
            If it is neither, naming `loc`. What has the form of an identifier may be gone.
        """
        if is_id(text):
            return text
        identifiers = self.index.named(text) if re.fullmatch(NAME, text) else []
        if len(identifiers) == 1:
            return identifiers[0]
        message = "is the name of several runs" if identifiers else "no kept run of that name"
        allowed = "r- and 12 characters, or the name of one run alone; `motionlab runs` lists them"
        raise ConfigError(FieldError(loc, message, text, allowed))

    def complete(self, run_id: str) -> RunDetail:
        """Return a run whose telemetry can be read.

        Raises
        ------
        Unknown
            If there is none of that identifier, or it is deleted.
        Busy
            If it is still being recorded.
        """
        run: RunDetail | None = self.get(run_id)
        if run is not None and run.state == "recording":  # or was, when its server was killed
            run = self.finish(run_id)
            if run is None:
                raise Busy(f"{run_id} is being recorded: it can be read when its session has ended")
        if run is None or run.deleted is not None:
            raise Unknown(f"no run {run_id!r}: it is deleted")
        return run

    def keep(
        self,
        prepared: Prepared,
        recording: Recording,
        result: dict[str, Any],
        *,
        name: str = "",
    ) -> RunDetail:
        """Keep a simulation as a run.

        Raises
        ------
        ConfigError
            If its name is no text, too long, or has control characters.
        StoreError
            If it cannot be kept; `StoreFull` where there is no room. Nothing is kept then.
        """
        check_name(name)
        run = new_run("simulation", prepared.scenario, result, name=name)
        run = run.model_copy(
            update={
                "ticks": recording.ticks,
                "thumbnail": thumbnail(recording, prepared.window),
            }
        )
        from motionlab.simulation.result import metadata

        about = metadata(prepared.scenario)
        return self.keep_file(run, lambda part: recorder.write(recording, part, metadata=about))

    def keep_file(self, run: RunDetail, write: Callable[[str], None]) -> RunDetail:
        """Keep a run whose telemetry a function writes.

        Raises
        ------
        StoreError
            If it cannot be kept; `StoreFull` where there is no room. Nothing is kept then.
        """
        with self._part(run.id) as part:
            write(str(part))
            self.room.make_room(part.stat().st_size)
            _check_disk(self.spools)
            return self._add(run, part, ticks=run.ticks, result=run.result, picture=run.thumbnail)

    def finish(self, run_id: str) -> RunDetail | None:
        """Make a run of what a live session recorded.

        Returns
        -------
        RunDetail or None
            None if nothing was recorded, or its server or another process is at it; without
            samples where its recording was removed.

        Raises
        ------
        StoreError
            If it cannot be kept; its spool stays then.
        """
        from motionlab.library import spool

        with spool.claimed(self.spools, run_id) as mine:
            if mine:
                return self._finish(run_id)
        return self._unrecorded(run_id)

    def _unrecorded(self, run_id: str) -> RunDetail | None:
        """Say of a run that nothing of it is left, where its recording was removed."""
        from motionlab.library import spool

        run = self.index.get(run_id)
        if run is None or run.state != "recording" or not spool.gone(self.spools, run_id):
            return None
        _LOG.warning("%s: %s", run_id, _REMOVED)
        run = run.model_copy(update={"state": "partial", "reason": _REMOVED})
        self.index.put(run)
        return run

    def note_removed(self) -> None:
        """Say so of the runs whose recordings were removed while they were written."""
        for run_id in self.index.recording():
            self._unrecorded(run_id)

    def _finish(self, run_id: str) -> RunDetail | None:
        from motionlab.library import spool

        run, events = spool.begun(self.spools, run_id)
        first = spool.first_tick(self.spools, run_id)
        if first:
            lost = Event(tick=0, kind="gap", ticks=first, reason=_ROLLED)
            later = (e for e in events if e.kind != "gap" or e.tick + (e.ticks or 0) > first)
            events = [lost, *later]
        # Refused before the work, and not again and again after it.
        self.room.check(spool.size_of(self.spools, run_id) // _SMALLER)
        with self._part(run_id) as part:
            ticks = spool.compact(self.spools, run_id, part)
            if ticks == 0:
                self.index.drop(run_id)
                spool.remove(self.spools, run_id)
                return None
            gaps = [event for event in events if event.kind == "gap"]
            reason = _missing(gaps, first) if spool.ended(self.spools, run_id) else _CUT_OFF
            stop = next((event for event in events if event.kind == "stop"), None)
            update: dict[str, Any] = {
                "events": events,
                "first_tick": first,
                "state": "partial" if reason else "complete",
                "reason": reason,
                "stopped": "" if stop is None else stop.reason or "STOP",
                "stopped_at": None if stop is None else (stop.tick - first) * run.period,
            }
            update["differences"] = differences_after(run, events)
            run = run.model_copy(update=update)
            run = run.model_copy(update={"name": run_name(run)})
            begin = gaps[-1].tick + (gaps[-1].ticks or 0) if gaps else 0
            result, picture = _latest(run, part, begin, stop and stop.tick)
            self.room.make_room(part.stat().st_size, instead_of=run_id)
            kept = self._add(run, part, ticks=ticks, result=result, picture=picture)
        spool.remove(self.spools, run_id)
        return kept

    def list_changes(self, run_id: str) -> None:
        """Take the changes that a run has had so far into its differences, while it is recorded.

        Raises
        ------
        StoreError
            If they cannot be read.
        """
        from motionlab.library import spool

        run, events = spool.begun(self.spools, run_id)
        run = run.model_copy(update={"differences": differences_after(run, events)})
        changes: dict[str, Any] = {"differences": run.differences}
        if (known := self.index.get(run_id)) is not None and not known.named:
            changes["name"] = run_name(run)
        self.index.change(run_id, changes)

    def recover(self) -> list[str]:
        """Make runs of what servers recorded that were killed; return the identifiers."""
        from motionlab.library import spool

        spool.remove_leftovers(self.spools)
        recovered = []
        for run_id in spool.waiting(self.spools):
            try:
                if self.finish(run_id):
                    recovered.append(run_id)
            except MotionLabError as error:  # tried again later
                _LOG.warning("%s", error)
        return recovered

    def add_margins(self) -> bool:
        """Compute margins of some runs of an earlier version; return whether any were due."""
        due = self.index.margins_due()
        if due:
            from motionlab.library.stability_margins import margins_of

            for run_id in due:
                if (run := self.index.get(run_id)) is not None:
                    self.index.add_margins(run_id, margins_of(run))
        return bool(due)

    def change(self, run_id: str, changes: Mapping[str, Any]) -> RunDetail:
        """Change `CHANGEABLE` fields of a run; who names, notes or tags it keeps it.

        Raises
        ------
        Unknown
            If there is none of that identifier.
        """
        if any(changes.get(name) for name in ("name", "note", "tags")):
            changes = {**changes, "kept": True}
        if changes.get("name"):
            changes = {**changes, "named": True}
        run = self.index.change(run_id, changes)
        if run is None:
            raise Unknown(f"no run {run_id!r}")
        return run

    def delete(self, run_id: str) -> RunDetail:
        """Delete a run; for `UNDO_SECONDS` it can be restored.

        Raises
        ------
        Unknown
            If there is none of that identifier, or it is deleted already.
        Busy
            If it is still being recorded.
        """
        self.complete(run_id)
        return self.change(run_id, {"deleted": time.time()})

    def restore(self, run_id: str) -> RunDetail:
        """Take the deletion of a run back."""
        return self.change(run_id, {"deleted": None})

    def purge(self, *deletions: tuple[str, float]) -> None:
        """Remove runs that were deleted, each as `Index.deleted` lists it, and those condemned."""
        for run_id, deleted in self.index.deleted():
            due = deleted == 0.0 or (run_id, deleted) in deletions
            if due and self.index.condemn(run_id, deleted):
                self._remove(run_id)

    def _add(
        self,
        run: RunDetail,
        part: Path,
        *,
        ticks: int,
        result: dict[str, Any],
        picture: dict[str, list[int]],
    ) -> RunDetail:
        from pyarrow import parquet

        columns = column_descriptions(parquet.read_schema(part))
        run = run.model_copy(update={"ticks": ticks})
        metrics = {**run.metrics, **headline(result)}
        if run.scenario_document is not None:
            from motionlab.library.stability_margins import margins_of

            metrics |= margins_of(run)
        size = self.files.put(run.id, part)
        run = run.model_copy(
            update={
                "duration": ticks * run.period,
                "size": size,
                "metrics": metrics,
                "thumbnail": picture,
                "result": result,
                "columns": columns,
            }
        )
        try:
            return self.index.finish(run)
        except StoreError:
            with contextlib.suppress(StoreError):
                self.files.delete(run.id)
            raise

    def _remove(self, run_id: str) -> None:
        self.files.delete(run_id)
        self.index.drop(run_id)

    @contextlib.contextmanager
    def _part(self, run_id: str) -> Iterator[Path]:
        """Give a file to write, which is gone afterwards."""
        part = self.spools / f".{run_id}.parquet"  # a form that `spool.remove_leftovers` knows
        try:
            private_folder(self.spools)
            private_file(part)
            yield part
        except OSError as error:
            raise failure(f"{run_id} cannot be kept", error) from error
        finally:
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)


def spools(root: Path) -> Path:
    """Return the folder of what is being recorded."""
    return root / _SPOOLS


@functools.lru_cache(maxsize=1)
def _library(root: Path, _process: int, *_urls: str) -> Library:
    return Library(root)


def library() -> Library:
    """Return the library of the user's data; each process opens its own, once."""
    places = ("MOTIONLAB_DATABASE_URL", "MOTIONLAB_RUNS_URL")
    return _library(data_root(), os.getpid(), *(os.environ.get(name, "") for name in places))


def check_places(root: Path) -> None:
    """Refuse settings of the library that can never work, before it is used.

    Raises
    ------
    ConfigError
        Naming MOTIONLAB_DATABASE_URL, MOTIONLAB_RUNS_URL or MOTIONLAB_RUNS_MAX.
    """
    quota()
    if os.environ.get("MOTIONLAB_DATABASE_URL"):
        from motionlab.library.database import check_address

        check_address(root)
    if os.environ.get("MOTIONLAB_RUNS_URL"):
        RunFiles(runs_url(root)).check()


def _check_disk(folder: Path) -> None:
    free = shutil.disk_usage(folder).free
    if free < FREE_LEAST:
        raise StoreFull(
            f"the disk of the data is nearly full: keeping this would leave {free} bytes, less "
            f"than {FREE_LEAST}"
        )


def _latest(
    run: RunDetail, part: Path, begin: int, stop: int | None
) -> tuple[dict[str, Any], dict[str, list[int]]]:
    """Return metrics and picture of the latest two periods, or ten seconds.

    They begin at tick `begin` at the earliest, and end at a stop, after which no variant follows
    the reference.
    """
    from pyarrow import parquet

    # What records are measured with loads the compiler, which lists and imports do without.
    from motionlab.analysis.latest_metrics import latest_metrics
    from motionlab.library.telemetry import recording as read_recording
    from motionlab.library.telemetry import reference_path
    from motionlab.simulation.prepare import prepare

    prepared = prepare(load_scenario(run.scenario_document or {}), checked=True)
    period = prepared.reference.period
    length = 2 * period if period else to_ticks(METRICS_SECONDS)
    with parquet.ParquetFile(part) as file:
        first = int(file.read_row_group(0, columns=["tick"])["tick"][0].as_py())
        begin, end = max(first, begin), first + file.metadata.num_rows
        if stop is not None and begin < stop:
            end = min(end, stop)
        start = max(begin, end - length)
        recording = read_recording(file, run.variants, start - first, end - first)
        followed = None if stop is None else stop - first
        path = reference_path(file, start - first, end - first, followed)
    band = prepared.scenario.settling_band
    measured = latest_metrics(recording, prepared.reference, path, settling_band=band)
    return measured, thumbnail(recording, (start, end))


def _missing(gaps: list[Event], first_tick: int) -> str:
    """Return what a run lacks, and why: its beginning, and what could not be written."""
    begun = 1 if first_tick else 0  # gaps that are its beginning
    parts = [f"its first {first_tick * CONTROL_PERIOD:.6g} s have gone: {_ROLLED}"] * begun
    if later := gaps[begun:]:
        ticks = sum(gap.ticks or 0 for gap in later)
        lost = f"{ticks * CONTROL_PERIOD:.3g} s are missing: " if ticks else ""
        parts.append(lost + later[-1].reason)
    return "; ".join(parts)
