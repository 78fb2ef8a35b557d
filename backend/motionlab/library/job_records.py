"""Records of jobs: one file each, its first line a summary, its second the whole."""

from __future__ import annotations

import contextlib
import logging
import os
import re
import time
from pathlib import Path

from motionlab.errors import StoreError
from motionlab.files import failure, opened, replace

FILES_MAX = 500
SIZE_MAX = 20_000_000
"""Largest record, bytes."""

SUMMARY_MAX = 2_000_000
"""Largest summary, bytes; it holds the request."""

_ID = re.compile(r"[A-Za-z0-9_-]{12}")
_LOG = logging.getLogger(__name__)


class RecordStore:
    """A folder of records; the oldest are deleted when there are too many."""

    def __init__(self, folder: Path, *, files_max: int = FILES_MAX) -> None:
        self._folder = folder
        self._files_max = files_max

    def keep(self, record_id: str, summary: bytes, whole: bytes) -> None:
        """Save or replace the record of an id.

        Parameters
        ----------
        record_id : str
            Twelve of the letters of base64url.
        summary, whole : bytes
            JSON without line breaks.

        Raises
        ------
        StoreError
            If it cannot be kept; `StoreFull` where there is no room. What was kept before stays.
        """
        if len(whole) > SIZE_MAX or len(summary) >= SUMMARY_MAX:
            size = len(summary) + len(whole)
            raise StoreError(f"a record of {size} bytes is too large; {SIZE_MAX} are the most")
        path = self._path(record_id)
        try:
            latest = max((path.stat().st_mtime_ns for path in self._files()[-1:]), default=0)
            replace(path, summary + b"\n" + whole + b"\n")
            # The times of files put them in order, also where the clock has been set back.
            newest = max(time.time_ns(), latest + 1)
            os.utime(path, ns=(newest, newest))
            for old in self._files()[: -self._files_max]:
                if old != path:
                    old.unlink(missing_ok=True)
        except OSError as error:
            raise failure("the record cannot be written", error) from error

    def drop(self, record_id: str) -> None:
        """Delete a record, if that can be done."""
        with contextlib.suppress(OSError):
            self._path(record_id).unlink()

    def summaries(self) -> list[bytes]:
        """Return the first line of every record that can be read, the oldest first."""
        lines = []
        for path in self._files():
            try:
                with opened(path) as file:
                    line = file.readline(SUMMARY_MAX)
            except OSError as error:
                _LOG.warning("record %s cannot be read: %s", path.name, error)
            else:
                if line.endswith(b"\n"):  # else damaged
                    lines.append(line)
        return lines

    def read(self, record_id: str) -> bytes | None:
        """Return the second line of a record, or None if there is none."""
        if not _ID.fullmatch(record_id):
            return None
        try:
            with opened(self._path(record_id)) as file:
                file.readline(SUMMARY_MAX)
                return file.read(SIZE_MAX + 2)
        except OSError:
            return None

    def _files(self) -> list[Path]:
        dated = []
        for path in self._folder.glob("*.jsonl"):
            try:
                dated.append((path.stat().st_mtime_ns, path))
            except OSError:  # another server of the same folder was faster, or a link to itself
                continue
        return [path for _, path in sorted(dated)]

    def _path(self, record_id: str) -> Path:
        return self._folder / f"{record_id}.jsonl"
