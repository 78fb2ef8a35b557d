"""What is said of a file that is imported, and what was found out of it."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import BaseModel, Field

VALUES_MAX = 40_000_000
"""Most numbers of a file that is imported."""

COLUMNS_MAX = 1000
"""Columns with numbers in a file that is imported."""

GAPS_SHOWN = 100
"""Gaps that are listed one by one."""

RATE_MAX = 10_000_000.0
"""Largest sample rate, Hz."""

FIRST_SHOWN = 4
"""First values of a column that are shown."""

DELIMITERS = ("comma", "semicolon", "tab")
"""Signs between the fields of a text table."""

DECIMALS = ("point", "comma")
"""Decimal signs of a text table."""


class ImportedColumn(BaseModel):
    """A column of the file, and what becomes of it."""

    column: str = Field(description="Header in the file")
    channel: str = Field(
        description="Channel that it becomes, time, - if left out; empty where it keeps its name"
    )
    name: str = Field(description="Column of the run; empty for time and what is left out")
    unit: str = Field(description="Unit in the file")
    factor: float = Field(description="From the file's unit to the run's")
    why: str = Field(description="What channel and unit are guessed from, or map")
    minimum: float = Field(description="In the file's unit")
    maximum: float
    missing: int = Field(description="Rows without a number")
    missing_at: str = Field(description="Where the first of these is, such as line 12")
    first: list[float | None] = Field(
        description="Values of the first rows, in the file's unit; null where there is none"
    )


class ImportedGap(BaseModel):
    """A place where samples are missing."""

    start: float = Field(description="Time of the last sample before it, s")
    end: float = Field(description="Time of the first sample after it, s")
    samples: int = Field(description="Samples that are missing")
    place: str = Field(description="Where the first sample after it is, such as line 12")


class Merged(BaseModel):
    """How a second file came onto the time of the first: t = offset + (1 + drift) t of the second.

    Half widths are of 95 % intervals, by twenty blocks of the record; null where nothing was
    estimated.
    """

    rows: int = Field(description="Rows of the second file")
    samples: int = Field(description="Rows of the first file that the second one covers")
    offset: float = Field(description="s")
    offset_half_width: float | None = Field(description="s")
    drift: float = Field(description="Clock of the first file over that of the second, less 1")
    drift_half_width: float | None
    first: str = Field(description="Column of the first file that was aligned; empty where none")
    second: str = Field(description="Column of the second file")
    correlation: float | None = Field(description="Of the two, aligned")


class Import(BaseModel):
    """How a file is read as a run: what was found out, guessed, derived."""

    run: str | None = Field(default=None, description="The run that was kept; null in a preview")
    format: str
    text: dict[str, str | int] = Field(
        description="Of CSV: delimiter, decimal sign, encoding, first line of numbers"
    )
    rows: int
    columns: list[ImportedColumn]
    ignored: dict[str, str] = Field(description="What is not read, and why")
    rate: float | None = Field(description="Sample rate, Hz; null where the file has no time")
    rate_from: str = Field(description="Column of time, or rate")
    duration: float | None = Field(description="s")
    ticks: int | None = Field(description="Samples of the run, missing ones included")
    median_rate: float | None = Field(
        description="One over the median time between two samples of the file, Hz"
    )
    jitter: float | None = Field(
        description="Largest distance of a sample's time from equal steps, s"
    )
    gaps: list[ImportedGap] = Field(description=f"The first {GAPS_SHOWN}")
    gap_count: int
    missing: int = Field(description="Samples that are missing in all gaps")
    resampled: float | None = Field(description="Sample rate of the file, where another is kept")
    merged: Merged | None = Field(
        default=None, description="Of two files: how the second came onto the time of the first"
    )
    derived: list[str] = Field(description="Channels that are computed from others")
    notes: list[str] = Field(description="What was passed over, cut off or guessed")
    problems: list[str] = Field(description="What must be said before it can be kept")
    channels: dict[str, str] = Field(description="What a column can become: SI unit by channel")
    units: dict[str, list[str]] = Field(description="Units that are understood, by SI unit")


@dataclass(frozen=True)
class ImportOptions:
    """What a user says of a file.

    Attributes
    ----------
    name : str
        What the run is called; empty for the name of the file.
    rate : float or None
        Sample rate, Hz, of a file without time.
    resample : float or None
        Sample rate, Hz, that is kept, by linear interpolation; None for the file's.
    mapping : tuple of str
        ``COLUMN=CHANNEL[UNIT]`` each; they go before what is guessed.
    delimiter : str
        Of CSV: one of DELIMITERS; empty to find it out.
    decimal : str
        Of CSV: one of DECIMALS; empty to find it out.
    align : str
        Of two files: ``COLUMN``, or ``A=B`` of the first and the second, ``A=-B`` of opposite
        signs; empty for one that both have.
    offset : float or None
        Of two files: what is added to times of the second, s; None to estimate it.
    """

    name: str = ""
    rate: float | None = None
    resample: float | None = None
    mapping: tuple[str, ...] = ()
    delimiter: str = ""
    decimal: str = ""
    align: str = ""
    offset: float | None = None


GUESSED = ImportOptions()
"""Nothing is said: all is found out."""
