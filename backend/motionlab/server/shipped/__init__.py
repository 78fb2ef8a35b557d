"""Results that the screens open with: reports of jobs that were computed for the program.

``python -m motionlab.server.shipped`` writes them. Each file is a record as of any job, compressed.
"""

from __future__ import annotations

import functools
import gzip
from pathlib import Path

FOLDER = Path(__file__).parent
_SUFFIX = ".jsonl.gz"


def id_of(kind: str) -> str:
    """Return the identifier of the shipped result of a kind of job, of the form that all have."""
    return f"{kind:-<12.12}"


def path_of(kind: str, folder: Path = FOLDER) -> Path:
    """Return the file of the shipped result of a kind of job."""
    return folder / f"{kind}{_SUFFIX}"


def summaries() -> list[bytes]:
    """Return the summary of each shipped result, JSON."""
    return [summary for summary, _ in _records().values()]


def report(job_id: str) -> bytes | None:
    """Return the report of a shipped result, JSON; None if the identifier is of none."""
    _, whole = _records().get(job_id, (b"", None))
    return whole


@functools.cache
def _records() -> dict[str, tuple[bytes, bytes]]:
    """Return summary and report of each, by identifier."""
    records = {}
    for path in sorted(FOLDER.glob(f"*{_SUFFIX}")):
        summary, whole, _ = gzip.decompress(path.read_bytes()).split(b"\n")
        records[id_of(path.name.removesuffix(_SUFFIX))] = summary, whole
    return records
