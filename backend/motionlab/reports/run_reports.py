"""Reports of kept runs by their identifiers."""

from __future__ import annotations

from collections.abc import Callable

from motionlab.analysis.comparison_options import Comparing
from motionlab.analysis.run_comparison import size
from motionlab.library.columns import of_run
from motionlab.library.library import library
from motionlab.library.run import RunDetail
from motionlab.reports import results
from motionlab.reports.comparison_page import Side, comparison_page
from motionlab.reports.experiment import experiments, experiments_memory, program
from motionlab.reports.history import events, scenario_of
from motionlab.reports.page import page
from motionlab.reports.plots import plots, plots_memory

Hold = Callable[[int], object]
"""Reserves memory, bytes."""

_PAGE = 16_000_000  # bytes, for the page itself


def run_report(run_id: str, hold: Hold = lambda _: None) -> bytes:
    """Return the report of a run as an HTML file.

    Raises
    ------
    Unknown
        If there is none of that identifier.
    Busy
        If it is still being recorded.
    StoreError
        If it cannot be read.
    """
    run = library().complete(run_id)
    hold(plots_memory(run) + experiments_memory(run) + _PAGE)
    happened = events(run)
    with library().files.open(run_id) as file:
        return page(
            "run.html.j2",
            f"{run.name}: report of {run.id}",
            run=run,
            scenario=scenario_of(run),
            events=happened,
            metrics=results.metrics(results.columns_of(run)),
            plots=plots(run, file, happened),
            digest=library().files.digest(run_id),
            program=program(),
            experiments=experiments({"": run}),
        )


def comparison_report(
    baseline: str, candidate: str, how: Comparing, hold: Hold = lambda _: None
) -> bytes:
    """Return the report of a comparison as an HTML file.

    Raises
    ------
    Unknown, Busy, StoreError
        As `run_report`.
    ConfigError
        See `motionlab.analysis.aligned_runs.align`.
    """
    first, second = _side(baseline), _side(candidate)
    compared = size(first.columns, second.columns)
    hold(compared + experiments_memory(first.run, second.run) + _PAGE)
    return comparison_page(first, second, how)


def _side(run_id: str) -> Side:
    run: RunDetail = library().complete(run_id)
    return Side(run, of_run(run_id), library().files.digest(run_id))
