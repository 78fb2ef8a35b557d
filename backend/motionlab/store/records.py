"""Records of finished jobs: one file each, its first line a summary, its second the whole."""

from __future__ import annotations

import logging
import re
from pathlib import Path

from motionlab.store.files import replace

FILES_MAX = 500
SIZE_MAX = 20_000_000
"""Largest record, bytes."""

_ID = re.compile(r"[A-Za-z0-9_-]{12}")
_LOG = logging.getLogger(__name__)


class RecordStore:
    """A folder of records; the oldest go when there are too many.

    Parameters
    ----------
    folder : Path
        Where they lie; made when the first is kept.
    files_max : int
        How many are kept.
    """

    def __init__(self, folder: Path, *, files_max: int = FILES_MAX) -> None:
        self._folder = folder
        self._files_max = files_max

    def keep(self, record_id: str, summary: bytes, whole: bytes) -> bool:
        """Keep a record; return whether that went well, and log why where it did not.

        A result that cannot be recorded is no reason to lose it: the caller still has it.

        Parameters
        ----------
        record_id : str
            Twelve of the letters of base64url.
        summary, whole : bytes
            JSON without line breaks.
        """
        if len(whole) > SIZE_MAX:
            _LOG.warning("job %s is not recorded: %d bytes are too many", record_id, len(whole))
            return False
        try:
            replace(self._path(record_id), summary + b"\n" + whole + b"\n")
            for old in self._files()[: -self._files_max]:
                old.unlink(missing_ok=True)
        except OSError as error:
            _LOG.warning("job %s is not recorded: %s", record_id, error)
            return False
        return True

    def summaries(self) -> list[bytes]:
        """Return the first line of every record that can be read, the oldest first."""
        lines = []
        for path in self._files():
            try:
                with path.open("rb") as file:
                    lines.append(file.readline())
            except OSError as error:
                _LOG.warning("record %s cannot be read: %s", path.name, error)
        return lines

    def read(self, record_id: str) -> bytes | None:
        """Return the second line of a record, or None where there is none of that id."""
        if not _ID.fullmatch(record_id):
            return None
        try:
            return self._path(record_id).read_bytes().partition(b"\n")[2]
        except OSError:
            return None

    def _files(self) -> list[Path]:
        dated = []
        for path in self._folder.glob("*.jsonl"):
            try:
                dated.append((path.stat().st_mtime_ns, path))
            except FileNotFoundError:  # another server of the same folder was faster
                continue
        return [path for _, path in sorted(dated)]

    def _path(self, record_id: str) -> Path:
        return self._folder / f"{record_id}.jsonl"
