"""The library of runs: index and telemetry together, within a quota."""

from __future__ import annotations

import contextlib
import functools
import logging
import os
import shutil
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from pyarrow import parquet

from motionlab import __version__
from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.config.timing import CONTROL_PERIOD, to_ticks
from motionlab.errors import (
    Busy,
    ConfigError,
    FieldError,
    MotionLabError,
    StoreError,
    StoreFull,
    Unknown,
)
from motionlab.executors.code import processor
from motionlab.kernel.force_maps import maps_of
from motionlab.lanes import model_hash
from motionlab.results.latest import latest_metrics
from motionlab.runs import spool
from motionlab.runs.description import differences, headline, labels, thumbnail
from motionlab.runs.files import RunFiles, column_descriptions, runs_url
from motionlab.runs.index import Index, index_url
from motionlab.runs.run import Event, Kind, RunDetail, new_id
from motionlab.runs.telemetry import recording as read_recording
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.result import metadata
from motionlab.store.files import data_root
from motionlab.telemetry import recorder
from motionlab.telemetry.recording import Recording

UNDO_SECONDS = 600.0
"""Time for which a deleted run can be restored."""

METRICS_SECONDS = 10.0
"""Time over which metrics of a live run are taken where its motion does not repeat."""

QUOTA = 10_000_000_000
"""Most that the telemetry of all runs takes, bytes; MOTIONLAB_RUNS_MAX is another one."""

FREE_LEAST = 200_000_000
"""Space that is left on the disk of the data, bytes."""

_LOG = logging.getLogger(__name__)
_SPOOLS = "recording"


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
            root.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise StoreError(f"{root} cannot be made: {error.strerror}") from error
        self.spools = spools(root)
        self.index = Index(index_url(root))
        self.files = RunFiles(runs_url(root))

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

    def complete(self, run_id: str) -> RunDetail:
        """Return a run whose telemetry can be read.

        Raises
        ------
        Unknown
            If there is none of that identifier, or it is deleted.
        Busy
            If it is still being recorded.
        """
        run = self.get(run_id)
        if run.deleted is not None:
            raise Unknown(f"no run {run_id!r}: it is deleted")
        if run.state == "recording":
            raise Busy(f"{run_id} is being recorded: it can be read when its session has ended")
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

        Parameters
        ----------
        prepared : Prepared
            What was run.
        recording : Recording
            All of it.
        result : dict
            Its result document.
        name : str
            What it is called; the scenario's name when left out.

        Raises
        ------
        StoreError
            If it cannot be kept; `StoreFull` where there is no room. Nothing is kept then.
        """
        run = _begun("simulation", prepared.scenario, result, name=name)
        with self._part(run.id) as part:
            recorder.write(recording, str(part), metadata=metadata(prepared.scenario))
            self.make_room(part.stat().st_size)
            return self._add(
                run,
                part,
                ticks=recording.ticks,
                result=result,
                picture=thumbnail(recording, prepared.window),
            )

    def finish(self, run_id: str) -> RunDetail | None:
        """Make a run of what a live session recorded; None if it recorded nothing.

        Parameters
        ----------
        run_id : str
            A spool that is closed, or whose server has ended.

        Raises
        ------
        StoreError
            If it cannot be kept; its spool stays then.
        """
        run, events = spool.begun(self.spools, run_id)
        gaps = [event for event in events if event.kind == "gap"]
        with self._part(run_id) as part:
            try:
                ticks = spool.compact(self.spools, run_id, part)
            except OSError as error:
                raise StoreError(f"{run_id} cannot be compacted: {error.strerror}") from error
            if ticks == 0:
                self.index.drop(run_id)
                spool.remove(self.spools, run_id)
                return None
            whole = spool.ended(self.spools, run_id)
            reason = _missing(gaps) if whole else "the server ended while it was being recorded"
            run = run.model_copy(
                update={
                    "events": events,
                    "state": "partial" if reason else "complete",
                    "reason": reason,
                }
            )
            result, picture = _latest(run, part, ticks)
            self.make_room(part.stat().st_size)
            kept = self._add(run, part, ticks=ticks, result=result, picture=picture)
        spool.remove(self.spools, run_id)
        return kept

    def recover(self) -> list[str]:
        """Make runs of what servers recorded that were killed; return the identifiers."""
        found = []
        for run_id in spool.abandoned(self.spools):
            try:
                if self.finish(run_id):
                    found.append(run_id)
            except MotionLabError as error:  # tried again at the next start
                _LOG.warning("%s", error)
        return found

    def change(self, run_id: str, changes: Mapping[str, Any]) -> RunDetail:
        """Change name, note, tags or pin of a run.

        Raises
        ------
        Unknown
            If there is none of that identifier.
        """
        run = self.get(run_id).model_copy(update=dict(changes))
        self.index.change(run)
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

    def purge(self) -> None:
        """Remove what was deleted longer than `UNDO_SECONDS` ago."""
        for run_id in self.index.deleted_before(time.time() - UNDO_SECONDS):
            self._remove(run_id)

    def make_room(self, size: int) -> None:
        """Evict unpinned runs, the oldest first, until one of `size` bytes fits the quota.

        Raises
        ------
        StoreFull
            If it does not fit however many are evicted, or the disk is nearly full.
        """
        most = quota()
        held = self.index.totals()
        excess = held["size"] + size - most
        if excess > 0:
            for run_id, freed in self.index.unpinned():
                if excess <= 0:
                    break
                self._remove(run_id)
                excess -= freed
        if excess > 0:
            raise StoreFull(
                f"runs may take {most} bytes (MOTIONLAB_RUNS_MAX), pinned ones take "
                f"{held['pinned_size']}; this one would take {size}: delete or unpin some"
            )
        free = shutil.disk_usage(self.spools.parent).free
        if free - size < FREE_LEAST:
            raise StoreFull(
                f"the disk of the data has {free} bytes left; a run of {size} would leave less "
                f"than {FREE_LEAST}"
            )

    def _add(
        self,
        run: RunDetail,
        part: Path,
        *,
        ticks: int,
        result: dict[str, Any],
        picture: dict[str, list[int]],
    ) -> RunDetail:

        columns = column_descriptions(parquet.read_schema(part))
        size = self.files.put(run.id, part)
        run = run.model_copy(
            update={
                "ticks": ticks,
                "duration": ticks * run.period,
                "size": size,
                "metrics": headline(result),
                "thumbnail": picture,
                "result": result,
                "columns": columns,
            }
        )
        try:
            self.index.put(run)
        except StoreError:
            with contextlib.suppress(StoreError):
                self.files.delete(run.id)
            raise
        return run

    def _remove(self, run_id: str) -> None:
        self.files.delete(run_id)
        self.index.drop(run_id)

    @contextlib.contextmanager
    def _part(self, run_id: str) -> Iterator[Path]:
        """Give a file to write, which is gone afterwards."""
        folder = self.spools.parent / ".parts"
        part = folder / f"{run_id}.parquet"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            yield part
        except OSError as error:
            raise StoreError(f"{run_id} cannot be kept: {error.strerror}") from error
        finally:
            part.unlink(missing_ok=True)


def spools(root: Path) -> Path:
    """Return the folder of what is being recorded."""
    return root / _SPOOLS


@functools.lru_cache(maxsize=1)
def _library(root: Path, _process: int, *_urls: str) -> Library:
    return Library(root)


def library() -> Library:
    """Return the library of the user's data; each process opens its own, once."""
    root = data_root()
    return _library(root, os.getpid(), index_url(root), runs_url(root))


def live_run(scenario: Scenario, run_id: str, created: float) -> RunDetail:
    """Return what is known of a live run at its beginning."""
    update = {"id": run_id, "created": created, "state": "recording"}
    return _begun("live", scenario, {}).model_copy(update=update)


def quota() -> int:
    """Return how many bytes of telemetry are kept.

    Raises
    ------
    ConfigError
        If MOTIONLAB_RUNS_MAX is no whole number of bytes.
    """
    text = os.environ.get("MOTIONLAB_RUNS_MAX") or str(QUOTA)
    if not text.isascii() or not text.isdigit():
        raise ConfigError(
            FieldError("MOTIONLAB_RUNS_MAX", "is no whole number", text, ">= 0", "bytes")
        )
    return int(text)


def _begun(kind: Kind, scenario: Scenario, result: dict[str, Any], *, name: str = "") -> RunDetail:
    about = _Code.of(scenario)
    return RunDetail(
        id=new_id(),
        kind=kind,
        state="complete",
        name=name or scenario.name,
        scenario=scenario.name,
        note="",
        tags=[],
        pinned=False,
        created=time.time(),
        duration=0.0,
        ticks=0,
        period=CONTROL_PERIOD,
        size=0,
        variants=list(scenario.variants),
        labels=labels(scenario),
        differences=differences(scenario),
        metrics={},
        thumbnail={},
        seed=scenario.seed,
        version=about.version,
        model=about.model,
        processor=about.processor,
        maps=about.maps,
        scenario_document=scenario.model_dump(mode="json"),
        events=[],
        result=result,
        columns=[],
    )


class _Code(NamedTuple):
    version: str
    model: str
    processor: str
    maps: dict[str, Any]

    @classmethod
    def of(cls, scenario: Scenario) -> _Code:

        return cls(__version__, model_hash(), processor(), maps_of(scenario))


def _latest(run: RunDetail, part: Path, ticks: int) -> tuple[dict[str, Any], dict[str, list[int]]]:
    """Return metrics and picture of the latest two periods, or ten seconds, of a live run."""
    prepared = prepare(load_scenario(run.scenario_document or {}), checked=True)
    period = prepared.reference.period
    length = min(ticks, 2 * period if period else to_ticks(METRICS_SECONDS))
    with parquet.ParquetFile(part) as file:
        recording = read_recording(file, run.variants, ticks - length, ticks)
    band = prepared.scenario.settling_band
    measured = latest_metrics(recording, prepared.reference, settling_band=band)
    window = (recording.first_tick, recording.first_tick + recording.ticks)
    return measured, thumbnail(recording, window)


def _missing(gaps: list[Event]) -> str:
    ticks = sum(gap.ticks or 0 for gap in gaps)
    if not gaps:
        return ""
    return f"{ticks * CONTROL_PERIOD:.3g} s are missing: {gaps[-1].reason}"
