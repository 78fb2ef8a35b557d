"""Runs whose beginning has gone: times count from the first sample, or are those of the session."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pyarrow import parquet

from motionlab.analysis.comparison_options import Comparing
from motionlab.analysis.run_comparison import compare
from motionlab.exchange.exports import Source, check_selection, export, within
from motionlab.exchange.selection import Selection
from motionlab.library import recorded
from motionlab.library.columns import of_run
from motionlab.library.library import library
from motionlab.library.run import Event, RunDetail, new_id
from motionlab.reports.history import events
from motionlab.reports.plots import marks
from motionlab.reports.run_reports import run_report
from motionlab.server.routes.run_files import _file_name
from motionlab.telemetry.recorder import parquet_writer
from motionlab.timing import CONTROL_PERIOD
from tests.library.test_replay import keep, replayed

GONE = 800


@pytest.fixture(scope="module")
def whole() -> RunDetail:
    """Return a run from tick 0 on."""
    return keep()


@pytest.fixture(scope="module")
def rolled(whole: RunDetail) -> RunDetail:
    """Return the same as the record of a session, without its beginning."""
    table = parquet.read_table(library().files.path(whole.id)).slice(GONE)
    run = whole.model_copy(
        update={
            "id": new_id(),
            "kind": "live",
            "state": "partial",
            "first_tick": GONE,
            "ticks": whole.ticks - GONE,
            "events": [
                Event(tick=0, kind="gap", ticks=GONE, reason="rolled"),
                Event(tick=GONE + 100, kind="change", set={}),
            ],
        }
    )

    def write(part: str) -> None:
        with parquet_writer(Path(part), table.schema) as writer:  # pyright: ignore[reportArgumentType]
            writer.write_table(table, row_group_size=700)

    return library().keep_file(run, write)


def test_it_is_simulated_again_from_tick_0(rolled: RunDetail) -> None:
    again = replayed(rolled)
    assert again.identical
    assert (again.ticks, again.missing) == (rolled.ticks, GONE)


def test_it_is_compared_by_the_time_of_its_session(whole: RunDetail, rolled: RunDetail) -> None:
    both = compare(of_run(whole.id), of_run(rolled.id), Comparing(exact=True))
    assert both.b.start == pytest.approx(GONE * CONTROL_PERIOD)
    assert both.start is not None
    assert both.start.time == pytest.approx(GONE * CONTROL_PERIOD)
    assert both.holds


def test_its_windows_are_those_of_the_same_samples(whole: RunDetail, rolled: RunDetail) -> None:
    first, second = (recorded.of_run(run.id, None, None) for run in (whole, rolled))
    assert first.first - second.first == GONE
    assert second.stop == rolled.ticks
    channel = "A.x.following_error"
    np.testing.assert_array_equal(first.column(channel), second.column(channel))
    assert not isinstance(second.scenario, str)


def test_its_report_has_the_times_of_its_plots(rolled: RunDetail) -> None:
    times = [each.time for each in events(rolled)]
    assert times == pytest.approx([-GONE * CONTROL_PERIOD, 100 * CONTROL_PERIOD])
    assert [mark.at for mark in marks(rolled, events(rolled))] == pytest.approx(times[1:])
    start, end = rolled.measured() or (0.0, 0.0)
    assert 0.0 <= start < end == pytest.approx(rolled.duration)
    assert run_report(rolled.id)


def test_its_files_have_the_times_of_its_session(rolled: RunDetail, tmp_path: Path) -> None:
    file = tmp_path / "part.parquet"
    with library().files.open(rolled.id) as opened:
        source = Source.of(opened, rolled)
        times = (0.45, 0.5)
        selection = check_selection(source, within(source, Selection(), *times))
        export(source, selection, file, "parquet")
    table = parquet.read_table(file)
    assert (table["time"][0].as_py(), table["time"][-1].as_py()) == pytest.approx(times)
    assert table["tick"][0].as_py() == 900
    assert _file_name(rolled, selection) == f"{rolled.id}_0.45-0.5s"
