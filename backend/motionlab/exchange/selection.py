"""Which part of a run is exported, and in which form."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec

FORMATS = {
    "csv": "text/csv",
    "parquet": "application/vnd.apache.parquet",
    "mat": "application/x-matlab-data",
    "mcap": "application/octet-stream",
    "mf4": "application/octet-stream",
}
"""Media types by format, which is also the ending of a file's name."""

ALL = "*"
"""Stands for all channels, beside expressions."""


def formats() -> list[str]:
    """Return the formats that can be written here: MDF needs asammdf, an extra."""
    return [name for name in FORMATS if name != "mf4" or find_spec("asammdf") is not None]


@dataclass(frozen=True)
class Selection:
    """Which part of a run is exported.

    Attributes
    ----------
    columns : tuple of str
        Names of channels, in the order of the file, then expressions; all channels when empty or
        where one is `ALL`.
    start, stop : int
        Samples [start, stop), counted from the first; `stop` None for all to the end.
    """

    columns: tuple[str, ...] = ()
    start: int = 0
    stop: int | None = None
