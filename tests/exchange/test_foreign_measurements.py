"""Measurements in the conventions of other programs: right columns and rates, notes, refusals."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io
from mcap.writer import CompressionType, Writer

from motionlab.errors import ConfigError
from motionlab.exchange.exports import Selection, Source, check_selection, export
from motionlab.exchange.measurements.channels import Measurement, read_measurement
from motionlab.exchange.measurements.column_guess import channel_of, label, si_of
from motionlab.exchange.measurements.document import ImportOptions
from motionlab.exchange.measurements.table_file import read_file

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


# -- other formats --------------------------------------------------------------------------------

ROWS = 60
TIMES = np.arange(ROWS) / 1000
START = 1_700_000_000_000_000_000


def columns_of(found: Measurement) -> list[tuple[str, str]]:
    return [(c.name or c.channel, c.unit) for c in found.document.columns]


def test_columns_of_a_matrix_have_its_name(tmp_path: Path) -> None:
    content = {"t": TIMES[:, None], "pos": np.c_[TIMES, -TIMES], "name": "rig", "cube": np.ones(8)}
    content["cube"] = content["cube"].reshape(2, 2, 2)
    scipy.io.savemat(tmp_path / "a.mat", content)
    found = measured(tmp_path / "a.mat")
    assert columns_of(found) == [("time", "s"), ("pos(1)", ""), ("pos(2)", "")]
    assert found.document.ignored == {"name": "is text", "cube": "has 3 dimensions"}


def test_structs_and_cells_of_matlab(tmp_path: Path) -> None:
    cells = np.array([np.arange(3.0), "text"], dtype=object)
    log = {"Time": TIMES, "axis": {"x_ref": TIMES, "x_act": TIMES}, "cells": cells}
    scipy.io.savemat(tmp_path / "a.mat", {"log": log})
    found = measured(tmp_path / "a.mat")
    assert [name for name, _ in columns_of(found)] == [
        "time",
        "x.position_reference",
        "M.x.position_measured",
    ]
    assert found.document.ignored == {"cells": "is a cell array"}


@pytest.mark.parametrize("rate", [3000, 12_800, 44_100])
def test_nanoseconds_that_are_no_microseconds(tmp_path: Path, rate: int) -> None:
    stamps = START + np.round(np.arange(ROWS) * 1e9 / rate).astype(np.int64)
    table = pa.table({"time": pa.array(stamps, pa.timestamp("ns")), "x [um]": TIMES})
    pq.write_table(table, tmp_path / "a.parquet")
    found = measured(tmp_path / "a.parquet")
    assert found.document.rate == rate
    assert found.begun == pytest.approx(START / 1e9)
    assert found.document.jitter == pytest.approx(0.0, abs=1e-9)


def test_types_of_time_in_parquet(tmp_path: Path) -> None:
    whole = np.arange(ROWS, dtype=np.int64)
    for kind in (pa.duration("us"), pa.time64("us"), pa.timestamp("ms", tz="Europe/Berlin")):
        factor = 1 if kind == pa.timestamp("ms", tz="Europe/Berlin") else 1000
        stamps = pa.array(factor * whole, pa.int64()).cast(kind)
        pq.write_table(pa.table({"x_act": TIMES, "when": stamps}), tmp_path / "a.parquet")
        assert measured(tmp_path / "a.parquet").document.rate == 1000, kind


def test_columns_of_one_name_are_read_by_their_place(tmp_path: Path) -> None:
    arrays = [pa.array(a) for a in (TIMES, TIMES, 100 + TIMES, ["a"] * ROWS, 200 + TIMES)]
    names = ["time [s]", "x [um]", "x [um]", "note", "x [um]"]
    pq.write_table(pa.Table.from_arrays(arrays, names=names), tmp_path / "a.parquet")
    found = measured(tmp_path / "a.parquet")
    assert [column.first[0] for column in found.document.columns] == [0.0, 0.0, 100.0, 200.0]


def test_an_index_of_instants_is_the_time(tmp_path: Path) -> None:
    stamps = pa.array(START + 1_000_000 * np.arange(ROWS), pa.timestamp("ns"))
    table = pa.table({"x [um]": TIMES, "__index_level_0__": stamps, "n": np.arange(ROWS)})
    pq.write_table(table, tmp_path / "a.parquet")
    found = measured(tmp_path / "a.parquet")
    assert found.document.rate == 1000
    assert found.document.columns[1].why == "the only column of instants"


def recording(path: Path, bodies: list[dict], topic: str = "/m", **options: Any) -> Path:
    with path.open("wb") as file:
        writer = Writer(file, **options)
        writer.start()
        schema = writer.register_schema("m", "jsonschema", b"{}")
        channel = writer.register_channel(topic, "json", schema)
        for number, body in enumerate(bodies):
            stamp = START + number * 1_000_000
            writer.add_message(channel, stamp, json.dumps(body).encode(), stamp, number)
        writer.finish()
    return path


def test_arrays_and_texts_of_messages(tmp_path: Path) -> None:
    body = {"x_ist": 1e-6, "force": [1, 2.5], "axes": [{"v": 1.0}], "state": "on", "scan": [0] * 99}
    found = measured(recording(tmp_path / "a.mcap", [body] * 9))
    assert [name for name, _ in columns_of(found)] == [
        "time",
        "M.x.position_measured",
        "m.force.0",
        "m.force.1",
        "m.axes.0.v",
    ]
    assert found.document.ignored == {
        "m.state": "is text",
        "m.scan": "is an array of more than 64 values",
    }


@pytest.mark.parametrize("compression", [CompressionType.NONE, CompressionType.LZ4])
@pytest.mark.parametrize("share", [0.4, 0.6, 0.9])
def test_a_recording_without_its_end(
    tmp_path: Path, compression: CompressionType, share: float
) -> None:
    bodies = [{"x": float(n)} for n in range(400)]
    path = recording(tmp_path / "a.mcap", bodies, chunk_size=2000, compression=compression)
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    found = measured(path)
    assert 20 < found.document.rows <= 400
    assert found.document.notes[0].startswith("the file ends in the middle: the recorder was cut")
    path.write_bytes(content[:60])
    with pytest.raises(ConfigError, match="ends before its first whole chunk"):
        measured(path)


def test_messages_that_are_not_read_are_named(tmp_path: Path) -> None:
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("sensor_msgs/Imu", "ros2msg", b"")
        channel = writer.register_channel("/imu", "cdr", schema)
        writer.add_message(channel, START, b"\0" * 8, START)
        writer.finish()
    with pytest.raises(ConfigError, match="/imu: its messages are cdr"):
        measured(tmp_path / "a.mcap")


@pytest.mark.parametrize(
    ("header", "channel"),
    [
        ("drive.x.pos", "M.x.position_measured"),
        ("MAIN.fbAxisX.ActPos", "M.x.position_measured"),
        ("Axis 1.ActPos", "M.x.position_measured"),
        ("status.error", None),
        ("m.T_motor", None),
        ("m.t", "time"),
        ("cycle time", None),
        ("Time (s)", "time"),
        ("time_stamp", "time"),
        ("Zeitstempel", "time"),
        ("force cell x", None),
        ("y error count", None),
        ("x-axis", None),
        ("pos 2", None),
        ("current 2", "M.x.current_b"),
        ("e_x", "M.x.following_error"),
        ("v", "M.x.velocity_measured"),
    ],
)
def test_names_among_other_words(header: str, channel: str | None) -> None:
    name = label(header)
    assert channel_of(name.name, (si_of(name.unit) or ("",))[0])[0] == channel


NAMES = [
    "2nd stage",
    "Größe",
    "gain=1",
    "a [b]",
    "pos(2)",
    'say "so"',
    "it's",
    "x_ist",
    "pos_um",
    "μ μ",
    "a.b/c",
    "100",
    "=SUM(A1)",
    "#1",
    "M.x",
    "x [mm]",
    "日本",
    "time (2)",
    "e" * 100,
    "2nd_stage",
]
UNITS = ["um", "", "V", "mm", "1", "°C"]


@pytest.mark.parametrize("format", ["csv", "parquet", "mat", "mcap"])
def test_names_and_units_survive_export_and_import(tmp_path: Path, format: str) -> None:
    count = 4
    values = [pa.array(np.full(count, k, "f4")) for k in range(len(NAMES))]
    units = [UNITS[k % len(UNITS)] for k in range(len(NAMES))]
    fields = [
        pa.field("tick", pa.int64(), metadata={"unit": "1"}),
        pa.field("time", pa.float64(), metadata={"unit": "s"}),
        *(
            pa.field(name, pa.float32(), metadata={"unit": unit})
            for name, unit in zip(NAMES, units, strict=True)
        ),
    ]
    schema = pa.schema(fields, metadata={"version": "1"})
    arrays = [pa.array(np.arange(count)), pa.array(np.arange(count) / 1000), *values]
    pq.write_table(pa.Table.from_arrays(arrays, schema=schema), tmp_path / "run.parquet")
    source = Source.of_file(tmp_path / "run.parquet")
    path = tmp_path / f"out.{format}"
    with source.file:
        export(source, check_selection(source, Selection()), path, format)
    found = measured(path)
    assert found.document.problems == []
    assert found.document.ignored == {}
    assert {name: unit for name, (unit, _) in found.columns.items()} == dict(
        zip(NAMES, units, strict=True)
    )
    for number, name in enumerate(NAMES):
        assert found.values[name].tolist() == [number] * count
