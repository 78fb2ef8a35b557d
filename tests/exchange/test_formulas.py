"""Names of columns reach no spreadsheet as formulas, and come back as they were."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from motionlab.exchange.exports import Source, check_selection, export
from motionlab.exchange.formulas import inert, original
from motionlab.exchange.measurements.document import ImportOptions
from motionlab.exchange.measurements.runs import import_file
from motionlab.exchange.measurements.table_file import read_file
from motionlab.exchange.selection import Selection
from motionlab.library.library import Library

NAMES = ("=1+1", "+x", "-x", "@SUM(1)", "'=x", "'x", "x", "")


@pytest.mark.parametrize("name", NAMES)
def test_names_come_back(name: str) -> None:
    assert not inert(name).startswith(("=", "+", "-", "@"))
    if name != "'=x":  # which is what another program has made inert
        assert original(inert(name)) == name


@pytest.mark.parametrize("name", ["=SUM(1;1)", "@SUM", "+cmd", "-x"])
def test_a_measurement_leaves_without_formulas_and_is_imported_again(
    tmp_path: Path, name: str
) -> None:
    file = tmp_path / "measured.csv"
    rows = "".join(f"{i / 2000},{i},{i}\n" for i in range(8))
    file.write_text(f"time [s],x_act [mm],{name} [V]\n{rows}")
    library = Library(tmp_path / "data")
    _, run = import_file(file, ImportOptions(), library=library, name="m")
    assert run is not None
    assert name in [column["name"] for column in run.columns]
    out = tmp_path / "out.csv"
    with library.files.open(run.id) as telemetry:
        source = Source.of(telemetry, run)
        export(source, check_selection(source, Selection((), 0, None)), out, "csv")
    library.close()
    with out.open() as text:
        headers = next(csv.reader(text))
    assert f"'{name} [V]" in headers
    assert name in [c.header.removesuffix(" [V]") for c in read_file(out).columns]
    with Source.of_file(out).file as again:
        assert name in again.schema_arrow.names
