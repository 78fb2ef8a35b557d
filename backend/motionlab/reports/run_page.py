"""The page: a run as one HTML file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from motionlab.library.run import RunDetail
from motionlab.reports import results
from motionlab.reports.history import events, scenario_of
from motionlab.reports.page import page
from motionlab.reports.plots import plots

if TYPE_CHECKING:
    from pyarrow import parquet


def run_page(run: RunDetail, file: parquet.ParquetFile, digest: str) -> bytes:
    """Return the report of a run, of its telemetry with its SHA-256, as an HTML file.

    Raises
    ------
    StoreError
        If it cannot be read.
    """
    happened = events(run)
    return page(
        "run.html.j2",
        f"{run.name}: report of {run.id}",
        run=run,
        scenario=scenario_of(run),
        events=happened,
        metrics=results.metrics(results.columns_of(run)),
        plots=plots(run, file, happened),
        digest=digest,
    )
