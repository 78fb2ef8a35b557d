"""Runs exported to each format come back with equal numbers."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io
from mcap.reader import make_reader
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.named_configs import parse_text
from motionlab.errors import ConfigError
from motionlab.exchange import exports
from motionlab.exchange.exports import Source, check_selection, export, within
from motionlab.exchange.mcap_files import identifiers, topics
from motionlab.exchange.selection import Selection
from motionlab.simulation.result import metadata
from motionlab.telemetry import recorder
from tests.recordings import noise

TICKS = 1000
COLUMNS = ("B.y.K", "x.position_reference", "A.x.following_error", "A.x.velocity")
ORDERED = ("x.position_reference", "A.x.following_error", "A.x.velocity", "B.y.K")
CREATED = 1_700_000_000.25


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording in several row groups, the samples of B missing in the end."""
    file = tmp_path_factory.mktemp("runs") / "run.parquet"
    recording = noise(TICKS)
    recording.variants["B"].samples[..., 900:] = np.nan
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recorder, "ROWS", 256)
        recorder.write(recording, str(file), metadata=metadata(load_scenario("circle")))
    assert pq.read_metadata(file).num_row_groups > 3
    return file


@pytest.fixture
def source(path: Path) -> Iterator[Source]:
    found = Source.of_file(path)
    with found.file:
        about = found.about | {"created": "2023-11-14T22:13:20.250000+00:00"}
        yield Source(found.file, CREATED, about)


def exported(source: Source, selection: Selection, folder: Path, format: str) -> Path:
    file = folder / f"out.{format}"
    export(source, check_selection(source, selection), file, format)
    return file


def expected(path: Path, start: int = 0, stop: int | None = None) -> dict[str, NDArray[Any]]:
    table = pq.read_table(path)
    return {name: table[name].to_numpy()[start:stop] for name in ("tick", "time", *ORDERED)}


def same(found: dict[str, NDArray[Any]], wanted: dict[str, NDArray[Any]]) -> None:
    assert list(found) == list(wanted)
    for name, values in wanted.items():
        np.testing.assert_array_equal(found[name], values, name)
        assert found[name].dtype == values.dtype


@pytest.mark.parametrize("format", ["csv", "parquet"])
@pytest.mark.parametrize(("start", "stop"), [(0, None), (200, 700), (999, 1000)])
def test_tables(
    source: Source, path: Path, tmp_path: Path, format: str, start: int, stop: int | None
) -> None:
    file = exported(source, Selection(COLUMNS, start, stop), tmp_path, format)
    back = recorder.read(str(file))
    same({name: column.values for name, column in back.items()}, expected(path, start, stop))
    assert [column.unit for column in back.values()] == ["1", "s", "m", "m", "m/s", "m/s"]


def test_mdf_comes_back_equal(source: Source, path: Path, tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf", reason="no asammdf: pip install asammdf")
    file = exported(source, Selection(COLUMNS, 200, 950), tmp_path, "mf4")
    wanted = expected(path, 200, 950)
    with asammdf.MDF(file) as back:
        assert back.start_time.timestamp() == CREATED
        found = {name: back.get(name) for name in ("tick", *ORDERED)}
        assert back.extract_attachment(index=0)[1].name == "scenario.toml"
    times = found["tick"].timestamps
    same({name: s.samples for name, s in found.items()} | {"time": times}, mdf_order(wanted))
    assert [s.unit for s in found.values()] == ["1", "m", "m", "m/s", "m/s"]
    assert found["A.x.velocity"].comment == "true velocity"
    assert [each.name for each in tmp_path.iterdir()] == ["out.mf4"]


def mdf_order(wanted: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    return {name: wanted[name] for name in ("tick", *ORDERED, "time")}


def test_mdf_is_an_extra(source: Source, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(exports, "find_spec", lambda _: None)
    with pytest.raises(ConfigError, match="needs the extra mdf: "):
        exports.size_of(check_selection(source, Selection()), "mf4")


def test_csv_is_read_by_anybody(source: Source, path: Path, tmp_path: Path) -> None:
    file = exported(source, Selection(COLUMNS, 890, 910), tmp_path, "csv")
    with file.open(encoding="ascii") as lines:
        header, *rows = csv.reader(lines)
    assert header[:3] == ["tick [1]", "time [s]", "x.position_reference [m]"]
    assert [row[5] == "" for row in rows] == [False] * 10 + [True] * 10
    wanted = expected(path, 890, 910)
    assert [np.float32(row[3]) for row in rows] == wanted["A.x.following_error"].tolist()
    assert [float(row[1]) for row in rows] == wanted["time"].tolist()


def test_parquet_keeps_its_metadata(source: Source, path: Path, tmp_path: Path) -> None:
    file = exported(source, Selection(COLUMNS), tmp_path, "parquet")
    before, after = pq.read_schema(path), pq.read_schema(file)
    assert after.field("B.y.K").metadata == before.field("B.y.K").metadata
    assert {key: after.metadata[key] for key in before.metadata} == before.metadata
    again = Source.of_file(file)
    again.file.close()
    assert again.created == CREATED


@pytest.mark.parametrize(("start", "stop"), [(0, None), (200, 700)])
def test_mat(source: Source, path: Path, tmp_path: Path, start: int, stop: int | None) -> None:
    file = exported(source, Selection(COLUMNS, start, stop), tmp_path, "mat")
    run = scipy.io.loadmat(file, squeeze_me=True, struct_as_record=False)["run"]
    assert list(run.channels) == list(ORDERED)
    assert list(run.fields) == [name.replace(".", "_") for name in ORDERED]
    found = {"tick": run.tick, "time": run.time} | {
        channel: getattr(run, field)
        for channel, field in zip(run.channels, run.fields, strict=True)
    }
    same(found, expected(path, start, stop))
    assert (run.units.time, run.units.A_x_velocity) == ("s", "m/s")
    assert json.loads(run.metadata.scenario)["name"] == "circle"


def test_a_mat_file_has_column_vectors_and_format_5(source: Source, tmp_path: Path) -> None:
    file = exported(source, Selection(COLUMNS), tmp_path, "mat")
    assert file.read_bytes()[:20] == b"MATLAB 5.0 MAT-file "
    run = scipy.io.loadmat(file)["run"][0, 0]
    assert run["time"].shape == run["A_x_velocity"].shape == (TICKS, 1)


def test_a_mat_file_that_would_be_too_large(
    source: Source, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(exports, "MAT_MAX", 31_999)
    with pytest.raises(ConfigError, match=r"fewer columns.*got 32000; allowed <= 31999 bytes"):
        exported(source, Selection(COLUMNS), tmp_path, "mat")


def decoded(data: bytes, count: int) -> list[np.float32]:
    """Return the floats of a protobuf message whose fields come in their order."""
    place, found = 0, []
    for number in range(1, count + 1):
        tag = number << 3 | 5
        wanted = bytes([tag]) if tag < 128 else bytes([tag & 127 | 128, tag >> 7])
        assert data[place : place + len(wanted)] == wanted
        place += len(wanted)
        found.append(np.frombuffer(data, "<f4", 1, place)[0])
        place += 4
    assert place == len(data)
    return found


@pytest.mark.parametrize(("start", "stop"), [(0, None), (200, 700)])
def test_mcap(source: Source, path: Path, tmp_path: Path, start: int, stop: int | None) -> None:
    file = exported(source, Selection((), start, stop), tmp_path, "mcap")
    table = pq.read_table(path)
    found: dict[str, list[np.float32]] = {name: [] for name in table.column_names[2:]}
    times: dict[str, list[int]] = {}
    with file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            assert schema.encoding == channel.message_encoding == "protobuf"
            names = [key[8:] for key in channel.metadata if key.startswith("channel.")]
            columns = [channel.metadata[f"channel.{name}"] for name in names]
            for column, value in zip(columns, decoded(message.data, len(names)), strict=True):
                found[column].append(value)
            times.setdefault(channel.topic, []).append(message.log_time)
            assert message.publish_time == message.log_time
    assert list(found) == table.column_names[2:]
    for name, values in found.items():
        np.testing.assert_array_equal(values, table[name].to_numpy()[start:stop], name)
    epoch = 1_700_000_000_250_000_000
    ticks = table["tick"].to_numpy()[start:stop]
    assert set(times) == {f"/{group}/{axis}" for group in ("reference", "A", "B") for axis in "xy"}
    assert all(each == (epoch + 500_000 * ticks).tolist() for each in times.values())


def test_the_schema_of_an_mcap_topic(source: Source, tmp_path: Path) -> None:
    """Compare a descriptor with what protobuf's own compiler makes of the same message."""
    file = exported(source, Selection(("x.position_reference", "x.load_force")), tmp_path, "mcap")
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    (schema,) = summary.schemas.values()
    assert (schema.name, schema.encoding) == ("motionlab.reference_x", "protobuf")
    # message reference_x {float position_reference = 1; float load_force = 2;}, syntax proto3
    assert schema.data == (
        b"\x0a\x6f"
        b"\x0a\x1bmotionlab.reference_x.proto"
        b"\x12\x09motionlab"
        b"\x22\x3d"
        b"\x0a\x0breference_x"
        b"\x12\x1a\x0a\x12position_reference\x18\x01\x20\x01\x28\x02"
        b"\x12\x12\x0a\x0aload_force\x18\x02\x20\x01\x28\x02"
        b"\x62\x06proto3"
    )
    (channel,) = summary.channels.values()
    assert channel.metadata == {
        "unit.position_reference": "m",
        "unit.load_force": "N",
        "channel.position_reference": "x.position_reference",
        "channel.load_force": "x.load_force",
    }


def test_what_else_an_mcap_file_carries(source: Source, tmp_path: Path) -> None:
    file = exported(source, Selection(), tmp_path, "mcap")
    with file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == 6 * TICKS
        assert summary.statistics.chunk_count == len(summary.chunk_indexes) > 0
        (attachment,) = reader.iter_attachments()
        (record,) = reader.iter_metadata()
        # Any span of time is found by the index of its chunk.
        epoch = 1_700_000_000_250_000_000
        some = list(
            reader.iter_messages(
                "/A/y", starting_at=epoch + 50_000_000, ending_before=epoch + 51_000_000
            )
        )
    assert [message.sequence for _, _, message in some] == [100, 101]
    assert attachment.name == "scenario.toml"
    scenario = load_scenario(parse_text(attachment.data, loc="body", size_max=10**6))
    assert scenario == load_scenario("circle")
    assert record.name == "motionlab"
    assert record.metadata["seed"] == str(scenario.seed)


def test_topics() -> None:
    found = topics(["x.position_reference", "A.x.K", "Temp 1 [°C]", "y.load_force", "Temp.1"])
    assert [(topic.name, topic.fields) for topic in found] == [
        ("/reference/x", ("position_reference",)),
        ("/A/x", ("K",)),
        ("/other", ("Temp_1___C_", "Temp_1")),
        ("/reference/y", ("load_force",)),
    ]


def test_identifiers_differ_and_are_bounded() -> None:
    assert identifiers(["a.b", "a.b", "1", "", "time"], 4, ["time"]) == [
        "a_b",
        "a__2",
        "c_1",
        "c_",
        "ti_2",
    ]
    long = identifiers(["x" * 100, "x" * 100], 63)
    assert [len(name) for name in long] == [63, 63]
    assert len(set(long)) == 2


def test_a_part_by_time(source: Source) -> None:
    part = within(source, Selection(), 0.1, 0.3)
    assert (part.start, part.stop) == (200, 601)
    assert within(source, Selection(), None, None) == Selection((), 0, TICKS)
    with pytest.raises(ConfigError, match="not finite"):
        within(source, Selection(), float("nan"), None)


@pytest.mark.parametrize(
    ("selection", "why"),
    [
        (Selection(("A.x.nothing",)), "no column of that name"),
        (Selection(("A.x.K", "A.x.K")), "comes twice"),
        (Selection((), TICKS), "no sample lies there"),
        (Selection((), 5, 5), "no sample lies there"),
    ],
)
def test_a_selection_of_nothing(source: Source, selection: Selection, why: str) -> None:
    with pytest.raises(ConfigError, match=why):
        check_selection(source, selection)


def test_memory_does_not_grow_with_the_length(tmp_path: Path) -> None:
    groups, rows, names = 40, 16_384, [f"c{number}" for number in range(10)]
    wave = pa.array(np.random.default_rng(1).standard_normal(rows).astype(np.float32))
    file = tmp_path / "long.parquet"
    schema = pa.schema(
        [("tick", pa.int64()), ("time", pa.float64()), *((name, pa.float32()) for name in names)]
    )
    with recorder.parquet_writer(file, schema) as writer:
        for first in range(0, groups * rows, rows):
            ticks = np.arange(first, first + rows)
            arrays = [pa.array(ticks), pa.array(ticks * 0.0005), *[wave] * len(names)]
            writer.write_batch(pa.RecordBatch.from_arrays(arrays, schema=schema))
    before = pa.total_allocated_bytes()
    with Source.of_file(file).file as opened:
        source = Source(opened, CREATED, {})
        read = exports.batches(source, check_selection(source, Selection()))
        taken = [pa.total_allocated_bytes() - before for _ in read]
    assert len(taken) == groups
    assert max(taken) < 5 * rows * (16 + 4 * len(names))
