"""The page: a run as one HTML file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from motionlab.library.run import RunDetail
from motionlab.reports import results
from motionlab.reports.history import (
    again,
    events,
    heading,
    record,
    scenario_of,
    what_was_done,
)
from motionlab.reports.markup import Markup, element, escaped, section
from motionlab.reports.plots import plots
from motionlab.reports.style import style

if TYPE_CHECKING:
    from pyarrow import parquet


def run_page(run: RunDetail, file: parquet.ParquetFile, digest: str) -> bytes:
    """Return the report of a run as an HTML file.

    Parameters
    ----------
    run : RunDetail
        A run whose telemetry can be read.
    file : ParquetFile
        Its telemetry.
    digest : str
        SHA-256 of that file.

    Raises
    ------
    StoreError
        If it cannot be read.
    """
    scenario = scenario_of(run)
    happened = events(run)
    return document(
        f"{run.name}: report of {run.id}",
        heading(run),
        what_was_done(run, happened),
        section(
            "Metrics",
            results.diverged(run),
            results.window_of(run),
            results.metrics(results.columns_of(run)),
        ),
        section("Plots", plots(run, file, happened)),
        section("Stability margins", results.margins(scenario, run)),
        section("How to simulate it again", again(run, scenario)),
        section("Record", record(run, digest)),
    )


def document(title: str, *body: Markup) -> bytes:
    """Return a whole page: no scripts, nothing that is loaded."""
    policy = "default-src 'none'; style-src 'unsafe-inline'"
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("title", title),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("meta", http_equiv="Content-Security-Policy", content=policy),
        Markup(f"<style>{style()}</style>"),
    )
    foot = element("footer", element("small", "PSRM Motion Lab. Positive error: the mover lags."))
    page = element("html", head, element("body", element("main", *body), foot), lang="en")
    return f"<!doctype html>\n{escaped(page)}\n".encode("utf-8", errors="replace")
