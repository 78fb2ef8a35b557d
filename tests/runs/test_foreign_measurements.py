"""Measurements in the conventions of other programs: right columns and rates, notes, refusals."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from motionlab.errors import ConfigError
from motionlab.runs.import_document import ImportOptions
from motionlab.runs.imports import Measurement, read_measurement
from motionlab.runs.measured_file import read_file

FOLDER = Path(__file__).parent.parent / "fixtures" / "foreign" / "measurements"
EXPECTED = tomllib.loads((FOLDER / "expected.toml").read_text(encoding="utf-8"))
FILES = sorted(path.name for path in FOLDER.iterdir() if path.name != "expected.toml")


def measured(path: Path) -> Measurement:
    return read_measurement(read_file(path), ImportOptions())


def test_every_file_has_its_values() -> None:
    assert sorted(EXPECTED) == FILES


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_another_program(name: str) -> None:
    expected = EXPECTED[name]
    if "refused" in expected:
        with pytest.raises(ConfigError, match=expected["refused"]):
            measured(FOLDER / name)
        return
    found = measured(FOLDER / name)
    document = found.document
    assert document.rows == expected["rows"]
    if "rate" in expected:
        assert document.problems == []
        assert document.rate == pytest.approx(expected["rate"], rel=1e-6)
    for problem in expected.get("problems", []):
        assert problem in "; ".join(document.problems)
    names = [column.name or column.channel for column in document.columns]
    assert names == expected.get("columns", names)
    units = [column.unit for column in document.columns]
    assert units == expected.get("units", units)
    for key in ("decimal", "encoding", "first_line"):
        assert document.text[key] == expected.get(key, document.text[key])
    for note in expected.get("notes", []):
        assert note in "; ".join(document.notes)
    assert expected.get("ignored", {}).items() <= document.ignored.items()
    assert document.columns[-1].missing == expected.get("missing", document.columns[-1].missing)
    if "begun" in expected:
        assert found.begun == pytest.approx(expected["begun"], abs=1e-6)
    if "x" in expected:
        column = next(c for c in document.columns if c.column == expected["column"])
        assert column.first[: len(expected["x"])] == expected["x"]
    assert all(np.isfinite(values).any() for values in found.values.values())
