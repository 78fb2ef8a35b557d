"""Files that would take long or much memory are refused before they do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

from motionlab.errors import ConfigError
from motionlab.exchange.measurements import csv_form
from motionlab.exchange.measurements import csv_table as measured_csv
from motionlab.exchange.measurements.document import COLUMNS_MAX
from motionlab.exchange.measurements.table_file import numbers_in, read_file


def table(columns: int, names: str = "x") -> str:
    return "\n".join(",".join([text] * columns) for text in (names, "1.5", "2.5"))


def write(folder: Path, text: str) -> Path:
    path = folder / "file.csv"
    path.write_text(text)
    return path


def test_equal_names_are_told_apart(tmp_path: Path) -> None:
    file = read_file(write(tmp_path, table(COLUMNS_MAX)))
    names = [column.header for column in file.columns]
    assert names[:3] == ["x", "x (2)", "x (3)"]
    assert len(set(names)) == COLUMNS_MAX


def test_columns_are_counted_before_they_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(measured_csv, "layout_of", None)  # not reached
    monkeypatch.setattr(csv_form, "layout_of", None)
    with pytest.raises(ConfigError, match=f"too many columns; got 2000; allowed <= {COLUMNS_MAX}"):
        read_file(write(tmp_path, table(2000)))


@pytest.mark.parametrize("row", ["{},1\n1,2\n2,3\n", "t,x\n1,{}\n2,3\n", 't,x\n1,"{}\n2,3\n'])
def test_a_field_that_is_too_long_is_refused_in_words(row: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="field larger than field limit"):
        read_file(write(tmp_path, row.format("9" * 200_000)))


def test_a_number_of_many_digits_is_none(tmp_path: Path) -> None:
    rows = "".join(f"{i},{i}\n" for i in range(5))
    with pytest.raises(ConfigError, match="line 7, column 'x': is no finite number"):
        read_file(write(tmp_path, f"t,x\n{rows}6,{'9' * 60_000}x\n"))


def test_numbers_of_a_packed_file_are_known_before_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "file.parquet"
    parquet.write_table(pa.table({"t": np.arange(1000.0), "x": np.zeros(1000)}), path)
    assert numbers_in(path) == 2000
    path.write_bytes(path.read_bytes()[:-100])
    assert numbers_in(path) == 0
    assert numbers_in(write(tmp_path, table(3))) == 0


def test_columns_of_a_packed_file_are_counted_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "file.parquet"
    parquet.write_table(pa.table({f"c{i}": [1.0, 2.0] for i in range(COLUMNS_MAX + 1)}), path)
    monkeypatch.setattr(parquet.ParquetFile, "read", None)  # not reached
    with pytest.raises(ConfigError, match="too many columns; got 1001"):
        read_file(path)
