"""Measurements of real machines become runs: guessed, corrected, refused."""

from __future__ import annotations

import contextlib
import json
import struct
import tracemalloc
import zlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io
from mcap.writer import Writer

from motionlab.errors import ConfigError
from motionlab.exchange.exports import Selection, Source, check_selection, export
from motionlab.exchange.measurements import table_file as measured_file
from motionlab.exchange.measurements.channels import Measurement, read_measurement
from motionlab.exchange.measurements.column_guess import Label, channel_of, label, si_of
from motionlab.exchange.measurements.document import Import, ImportOptions
from motionlab.exchange.measurements.runs import import_file
from motionlab.exchange.measurements.sample_times import sample_times
from motionlab.exchange.measurements.table_file import FileColumn, MeasuredFile, read_file
from motionlab.library.library import Library
from motionlab.library.run import RunDetail
from motionlab.telemetry import recorder
from tests.recordings import noise

ROWS = 400
PERIOD = 0.0005
TIMES = np.arange(ROWS) * PERIOD
REFERENCE = 0.01 * np.sin(2 * np.pi * 5 * TIMES)  # m
POSITION = REFERENCE - 2e-6 * np.cos(2 * np.pi * 5 * TIMES)

Given = Callable[..., Measurement]


@pytest.fixture
def given(tmp_path: Path) -> Given:
    """Read a text as a measurement."""

    def read(text: str | bytes, *mapping: str, **options: Any) -> Measurement:
        path = tmp_path / "measured.csv"
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        said = ImportOptions(mapping=mapping, **options)
        return read_measurement(read_file(path, said), said)

    return read


def lines(*rows: str, header: str) -> str:
    return "\n".join([header, *rows, ""])


CLEAN = lines(
    *(
        f"{t:.4f},{1e3 * r:.9f},{1e3 * p:.9f}"
        for t, r, p in zip(TIMES, REFERENCE, POSITION, strict=True)
    ),
    header="time [s],x_ref [mm],x_act [mm]",
)


def near(found: np.ndarray, wanted: Any) -> None:
    np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-11, equal_nan=True)


def test_a_clean_csv(given: Given) -> None:
    found = given(CLEAN)
    document = found.document
    assert document.problems == []
    assert document.text == {
        "delimiter": "comma",
        "decimal": "point",
        "encoding": "utf-8",
        "first_line": 2,
    }
    assert (document.rows, document.ticks, document.rate) == (ROWS, ROWS, 2000.0)
    assert document.jitter == pytest.approx(0.0, abs=1e-12)
    assert document.gaps == []
    assert [(c.column, c.channel, c.unit) for c in document.columns] == [
        ("time [s]", "time", "s"),
        ("x_ref [mm]", "x.position_reference", "mm"),
        ("x_act [mm]", "M.x.position_measured", "mm"),
    ]
    assert document.derived == ["M.x.following_error"]
    assert list(found.columns) == [
        "x.position_reference",
        "M.x.position_measured",
        "M.x.following_error",
    ]
    near(found.values["x.position_reference"], REFERENCE)
    near(found.values["M.x.following_error"], REFERENCE - POSITION)
    assert found.columns["M.x.following_error"] == ("m", "reference less measured position")


def test_a_german_csv_of_windows(given: Given) -> None:
    rows = (
        f"{t:.4f};{1e6 * r:.3f};{1e6 * p:.3f};1,5"
        for t, r, p in zip(TIMES, REFERENCE, POSITION, strict=True)
    )
    text = lines(
        *(row.replace(".", ",") for row in rows),
        header="Zeit [s];Sollposition X [µm];Istposition X [µm];Strom U",
    )
    found = given(text.replace("\n", "\r\n").encode("cp1252"))
    document = found.document
    assert document.text["delimiter"] == "semicolon"
    assert document.text["decimal"] == "comma"
    assert document.text["encoding"] == "cp1252"
    near(found.values["M.x.position_measured"], np.round(POSITION, 9))
    near(found.values["M.x.current_a"], np.full(ROWS, 1.5))
    assert document.columns[3].why.startswith("name; no axis in it, so x")


def test_a_tab_and_a_line_of_units_and_a_preamble(given: Given) -> None:
    text = "Rig 7, controller B\n# 2026-11-22\n# t\tx soll\tx ist\n[s]\t[mm]\t[mm]\n"
    text += "".join(
        f"{t:.4f}\t{1e3 * r:.6f}\t{1e3 * r:.6f}\n" for t, r in zip(TIMES, REFERENCE, strict=True)
    )
    found = given(text)
    assert found.document.text["delimiter"] == "tab"
    assert found.document.text["first_line"] == 5
    near(found.values["x.position_reference"], np.round(REFERENCE, 9))


def test_missing_samples(given: Given) -> None:
    rows = CLEAN.splitlines()
    del rows[101:151]  # samples 100 to 149
    rows[11] = "0.0050,,0"
    rows[12] = "0.0055,NaN,0"
    found = given("\n".join(rows))
    document = found.document
    assert (document.ticks, document.missing, document.gap_count) == (ROWS, 50, 1)
    (gap,) = document.gaps
    assert (gap.start, gap.end) == pytest.approx((0.0495, 0.075))
    assert (gap.samples, gap.place) == (50, "line 102")
    assert (document.columns[1].missing, document.columns[1].missing_at) == (2, "line 12")
    wanted = REFERENCE.copy()
    wanted[100:150] = wanted[10:12] = np.nan
    near(found.values["x.position_reference"], wanted)
    assert found.gaps == [(100, 50)]


def test_another_rate(given: Given) -> None:
    times = np.arange(300) / 12_800
    text = lines(*(f"{1e3 * t:.6f},{t}" for t in times), header="t [ms],x [m]")
    found = given(text)
    assert found.document.rate == 12_800
    assert found.document.ticks == 300
    again = given(text, resample=2000.0)
    assert again.document.resampled == 12_800
    assert again.document.rate == 2000
    wanted = np.arange(int(times[-1] * 2000) + 1) / 2000
    np.testing.assert_allclose(again.values["M.x.position_measured"], wanted, rtol=1e-6, atol=1e-9)


def test_times_that_are_rounded_or_jitter(given: Given) -> None:
    """2 kHz with times in whole milliseconds, and with 0.1 ms of jitter."""
    rounded = given(lines(*(f"{t:.3f},{t}" for t in TIMES), header="t [s],x [m]"))
    assert rounded.document.rate == pytest.approx(2000, rel=1e-2)
    assert rounded.document.ticks == ROWS
    assert rounded.document.gaps == []
    near(rounded.values["M.x.position_measured"], TIMES)
    shaken = TIMES + np.random.default_rng(1).uniform(-1e-4, 1e-4, ROWS)
    found = given(lines(*(f"{t:.6f},{t}" for t in shaken), header="t [s],x [m]"))
    assert found.document.rate == pytest.approx(2000, rel=1e-3)
    assert found.document.jitter == pytest.approx(1e-4, rel=0.3)
    assert found.document.ticks == ROWS


def test_times_too_uneven_are_resampled_only_when_asked(given: Given) -> None:
    times = np.cumsum(np.random.default_rng(2).uniform(0.2, 1.4, ROWS)) * PERIOD
    text = lines(*(f"{t:.7f},{t:.7f}" for t in times), header="t [s],x [m]")
    refused = given(text)
    assert refused.values == {}
    assert "give the rate to resample to" in refused.document.problems[0]
    found = given(text, resample=2000.0)
    ticks = np.arange(len(found.values["M.x.position_measured"]))
    near(found.values["M.x.position_measured"], float(f"{times[0]:.7f}") + ticks / 2000)


def test_nothing_is_interpolated_across_a_gap(given: Given) -> None:
    times = np.delete(TIMES, slice(100, 200))
    found = given(lines(*(f"{t:.4f},{t}" for t in times), header="t,x"), resample=1000.0)
    values = found.values["M.x.position_measured"]
    assert np.flatnonzero(np.isnan(values)).tolist() == list(range(50, 100))


def test_a_rate_instead_of_times(given: Given) -> None:
    text = lines(*(f"{1e3 * r},7" for r in REFERENCE), header="x,Temp [degC]")
    preview = given(text)
    assert "no column of time" in preview.document.problems[0]
    assert preview.values == {}
    found = given(text, rate=5000.0)
    assert (found.period, found.document.rate_from) == (1 / 5000, "rate")
    near(found.values["M.x.position_measured"], REFERENCE)
    assert found.columns["Temp"] == ("degC", "column 'Temp [degC]' of the file")


def test_dates_as_times(given: Given) -> None:
    text = lines(
        *(f"2026-11-22T10:00:{t:09.6f}Z,{r},on" for t, r in zip(TIMES, REFERENCE, strict=True)),
        header="stamp,x [m],state",
    )
    found = given(text, "stamp=time")
    assert found.begun == 1_795_341_600.0
    assert found.document.rate == 2000
    assert found.document.ignored == {"state": "is text"}


def test_what_the_user_says_goes_first(given: Given) -> None:
    header = "time [s],foo,x_act [mm]"
    text = CLEAN.replace("time [s],x_ref [mm],x_act [mm]", header)
    guessed = given(text)
    assert [c.name for c in guessed.document.columns] == ["", "foo", "M.x.position_measured"]
    assert guessed.columns["foo"][0] == ""
    found = given(text, "foo=x.position_reference[mm]", "x_act=M.y.position_measured[um]")
    near(found.values["x.position_reference"], REFERENCE)
    near(found.values["M.y.position_measured"], 1e-3 * POSITION)
    assert found.document.columns[1].why == "map"
    left = given(text, "foo=-", "x_act [mm]=")
    assert list(left.values) == ["x_act"]


@pytest.mark.parametrize(
    ("mapping", "why"),
    [
        (("foo=x.position_reference",), "no column of that name.*one of time \\[s\\], x_ref"),
        (("x_ref=M.x.nothing",), "no channel of that name"),
        (("x_ref=A.x.position",), "no channel of that name"),
        (("x_ref",), "is no mapping"),
        (("x_ref=x.position_reference[A]",), "is no unit of that channel.*allowed m, cm, mm"),
        (("x_ref=M.x.current_a",), "has another unit; got 'mm'"),
        (("x_ref=-", "x_ref [mm]=-"), "comes twice"),
        (("x_ref=time[s]", "time=time"), "comes twice"),
    ],
)
def test_a_mapping_that_cannot_be(given: Given, mapping: tuple[str, ...], why: str) -> None:
    with pytest.raises(ConfigError, match=why):
        given(CLEAN, *mapping)


NONSENSE = {
    "empty": ("", "has no line of numbers"),
    "prose": ("Dear reader,\nthis is not a table.\n", "has no line of numbers"),
    "letters": (
        CLEAN.replace("\n0.0040,", "\n0.0040,oops").replace("\n0.0045", "\n0.0045"),
        "line 10, column 'x_ref \\[mm\\]': is no finite number",
    ),
    "too large": (CLEAN.replace("\n0.0040,", "\n0.0040,1e999"), "line 10, column 'x_ref"),
    "a field too many": (
        CLEAN.replace("\n0.0040,", "\n0.0040,1,"),
        "line 10: 4 fields instead of 3",
    ),
    "a field too few": (CLEAN.replace("\n0.0040,", "\n0.0040;"), "line 10: 2 fields instead of 3"),
    "time backwards": (CLEAN.replace("\n0.0040,", "\n0.0010,"), "line 10: its time is before"),
    "no time": (CLEAN.replace("\n0.0040,", "\n,"), "line 10: has no time"),
    "a gap without end": (CLEAN + "1e9,1,1\n", "line 402: the gap before it is longer"),
    "one row": ("t,x\n0,1\n", "two numbers or more"),
    "aeons": ("t,x\n0,1\n1e300,2\n2e300,3\n", "at most 1e\\+09 s"),
    "no time at all": ("t,x\n0,1\n1e-300,2\n2e-300,3\n", "steps of 1e-09 s or more"),
    "a standstill": ("t,x\n5,1\n5,2\n5,3\n", "all its times are equal"),
    "two signs": (
        "t;x\n0,1;1\n0,2;2\n0,3;1.000,5\n0,4;4\n",
        "line 4, column 'x': is no finite number \\(decimal comma\\); got '1.000,5'",
    ),
    "a field without end": ("t,x\n0," + 200_000 * "1" + "x\n1,2\n", "is no table: field larger"),
    "binary": ("t,x\n0,1\0\n", "is neither a text nor"),
    "no Parquet": ("PAR1 but not for long", "is no Parquet file"),
    "no MAT": ("MATLAB 5.0 MAT-file" + 200 * " ", "is no MAT file"),
    "no MCAP": (b"\x89MCAP0\r\nand nothing", "is no MCAP file"),
}


@pytest.mark.parametrize(("text", "why"), NONSENSE.values(), ids=NONSENSE)
def test_nonsense_is_refused(given: Given, text: str | bytes, why: str) -> None:
    with pytest.raises(ConfigError, match=why):
        given(text)


def test_more_numbers_than_are_read(given: Given, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measured_file, "VALUES_MAX", 1000)
    with pytest.raises(ConfigError, match="more than 1000 numbers"):
        given(CLEAN)


@pytest.mark.parametrize("rate", [0.0, -1.0, 1e9, float("nan"), float("inf")])
def test_a_rate_that_is_none(given: Given, rate: float) -> None:
    for options in ({"rate": rate}, {"resample": rate}):
        with pytest.raises(ConfigError, match="is out of range"):
            given(CLEAN, **options)


def test_more_columns_than_a_run_may_have(given: Given) -> None:
    head = ",".join(["t", *(f"c{i}" for i in range(1000))])
    rows = (",".join([f"{0.001 * k}", *["1"] * 1000]) for k in range(3))
    with pytest.raises(ConfigError, match="too many columns; got 1001"):
        given("\n".join([head, *rows]))


GUESSES = {
    "Position X (mm)": ("M.x.position_measured", "m"),
    "y_soll_um": ("y.position_reference", "m"),
    "Kraftbefehl X [N]": ("M.x.force_command", "N"),
    "Lagesollwert y (mm)": ("y.position_reference", "m"),
    "v_x [mm/s]": ("M.x.velocity_measured", "m/s"),
    "vel_ref_y_mm_s": ("y.velocity_reference", "m/s"),
    "acc x / m/s^2": ("M.x.acceleration", "m/s^2"),
    "Schleppfehler_Y": ("M.y.following_error", ""),
    "ia [A]": ("M.x.current_a", "A"),
    "I_v_x [mA]": ("M.x.current_b", "A"),
    "Kraft X [N]": ("M.x.thrust", "N"),
    "force command y": ("M.y.force_command", ""),
    "load force x": ("x.load_force", ""),
    "B.y.K [m/s]": ("M.y.K", "m/s"),
    "t_ms": ("time", "s"),
    "Zeit": ("time", ""),
    "Temperature [degC]": (None, ""),
    "state": (None, ""),
    "counter": (None, ""),
}


@pytest.mark.parametrize(("header", "wanted"), GUESSES.items())
def test_guesses(header: str, wanted: tuple[str | None, str]) -> None:
    found = label(header)
    si = (si_of(found.unit) or ("", 0.0))[0]
    assert (channel_of(found.name, si)[0], si) == wanted


def test_no_unit_is_looked_for_in_an_endless_header() -> None:
    header = "x" + " [" * 200_000
    assert label(header) == Label(header, "")


@pytest.mark.parametrize(
    ("header", "name", "unit"),
    [
        ("axis[0].pos", "axis[0].pos", ""),
        ("stAxis[1].fPos_mm", "stAxis[1].fPos", "mm"),
        ("x [mm] raw", "x [mm] raw", ""),
        ("pos(2)", "pos(2)", ""),
        ("pos [mm] (2)", "pos (2)", "mm"),
    ],
)
def test_brackets_within_a_header_are_no_unit(header: str, name: str, unit: str) -> None:
    assert label(header) == Label(name, unit)


def test_an_endless_word_is_no_compound() -> None:
    assert channel_of("a" * 3_000_000, "") == (None, "")


@pytest.mark.parametrize(("factor", "unit"), [(1.0, "m"), (1e3, "mm"), (1e6, "um"), (1e9, "nm")])
def test_a_unit_from_the_range(given: Given, factor: float, unit: str) -> None:
    amplitude = 0.1 * factor
    text = lines(
        *(f"{t:.4f},{amplitude * np.sin(50 * t)},{0.001 * amplitude}" for t in TIMES),
        header="t,x,e_x",
    )
    found = given(text)
    assert [column.unit for column in found.document.columns] == ["s", unit, unit]
    near(found.values["M.x.position_measured"], 0.1 * np.sin(50 * TIMES))


# -- other formats ---------------------------------------------------------------------------------


def measured(path: Path, *mapping: str) -> Measurement:
    return read_measurement(read_file(path), ImportOptions(mapping=mapping))


def test_a_parquet_file(tmp_path: Path) -> None:
    path = tmp_path / "x.parquet"
    fields = [
        pa.field("t", pa.float64(), metadata={"unit": "ms"}),
        pa.field("x.ist", pa.float32(), metadata={"unit": "um"}),
        pa.field("on", pa.string()),
    ]
    arrays = [
        pa.array(1e3 * TIMES),
        pa.array((1e6 * POSITION).astype("f4")),
        pa.array(["a"] * ROWS),
    ]
    pq.write_table(pa.Table.from_arrays(arrays, schema=pa.schema(fields)), path)
    found = measured(path)
    assert found.document.format == "parquet"
    assert found.document.ignored == {"on": "is string"}
    near(found.values["M.x.position_measured"], POSITION)


@pytest.mark.parametrize("struct", [True, False])
def test_a_mat_file(tmp_path: Path, struct: bool) -> None:
    path = tmp_path / "x.mat"
    content: dict[str, Any] = {"t": TIMES, "x_ist_mm": 1e3 * POSITION, "gain": 7.0, "short": [1, 2]}
    scipy.io.savemat(path, {"log": content} if struct else content)
    found = measured(path)
    assert found.document.ignored == {
        "gain": "is a single number, 7",
        "short": f"has 2 values instead of {ROWS}",
    }
    near(found.values["M.x.position_measured"], POSITION)


def test_a_mat_file_of_another_version(tmp_path: Path) -> None:
    path = tmp_path / "x.mat"
    path.write_bytes(b"MATLAB 7.3 MAT-file" + 105 * b" " + b"\x00\x02IM" + 100 * b"\0")
    with pytest.raises(ConfigError, match="save it with -v7"):
        measured(path)


def test_an_mcap_file_with_json(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("any", "jsonschema", b"{}")
        fast = writer.register_channel("/drive/x", "json", schema)
        slow = writer.register_channel("/slow", "json", schema)
        other = writer.register_channel("/picture", "cdr", schema)
        for tick, position in enumerate(POSITION):
            instant = 1_700_000_000_000_000_000 + 500_000 * tick
            data = {"pos_mm": 1e3 * position, "state": "on", "nested": {"ok": True}}
            writer.add_message(fast, instant, json.dumps(data).encode(), instant)
            if tick % 10 == 0:
                writer.add_message(slow, instant + 1000, b'{"Temp": 20.5, "x": [1]}', instant)
        writer.add_message(other, 1_700_000_000_000_000_000, b"", 0)
        writer.finish()
    found = measured(path)
    assert found.begun == 1_700_000_000.0
    assert found.document.rate == 2000
    assert found.document.ignored == {
        "/picture": "its messages are cdr",
        "drive.x.state": "is text",
    }
    assert (found.values["slow.x.0"][::10] == 1.0).all()
    near(found.values["M.x.position_measured"], POSITION)
    assert np.flatnonzero(np.isfinite(found.values["slow.Temp"])).tolist() == [*range(0, ROWS, 10)]
    assert (found.values["drive.x.nested.ok"] == 1.0).all()


@pytest.mark.parametrize("format", ["csv", "parquet", "mat", "mcap"])
def test_what_an_export_wrote_comes_back_equal(tmp_path: Path, format: str) -> None:
    columns = (
        "x.position_reference",
        "A.x.position_measured",
        "A.x.K",
        "A.y.current_b",
        "y.load_force",
    )
    written, path = tmp_path / "run.parquet", tmp_path / f"out.{format}"
    recorder.write(noise(ROWS), str(written), metadata={})
    source = Source.of_file(written)
    with source.file:
        export(source, check_selection(source, Selection(columns)), path, format)
    found = measured(path)
    wanted = pq.read_table(written)
    assert found.document.rate == 2000
    assert found.document.derived == ["M.x.following_error"]
    for column in columns:
        name = column.replace("A.", "M.")
        np.testing.assert_array_equal(found.values[name], wanted[column].to_numpy(), column)


def test_periods_of_many_rates() -> None:
    for rate in (1.0, 50.0, 333.0, 2000.0, 12_800.0, 1e6):
        grid = sample_times(np.arange(1000) / rate, str)
        assert grid.period == pytest.approx(1 / rate, rel=1e-9)
        assert grid.gaps == []


# -- runs -----------------------------------------------------------------------------------------


@pytest.fixture
def library(tmp_path: Path) -> Any:
    library = Library(tmp_path / "data")
    yield library
    library.close()


def test_delimiter_and_decimal_sign_that_are_said(given: Given) -> None:
    text = "t [s];x [um]\n0;1\n1;2\n2;3,5\n"
    assert given(text).document.text["decimal"] == "comma"
    said = given("t [s],x [um]\n0,1\n1,2\n", delimiter="comma", decimal="point").document
    assert (said.text["delimiter"], said.text["decimal"]) == ("comma", "point")
    with pytest.raises(ConfigError, match=r"line 4, column 'x \[um\]'.*decimal point"):
        given(text, decimal="point")


def kept(library: Library, path: Path, text: str) -> tuple[Import, RunDetail]:
    path.write_text(text)
    document, run = import_file(path, ImportOptions(), library=library, name="rig 7")
    assert run is not None
    assert document.run == run.id
    return document, library.get(run.id)


def test_a_measurement_is_a_run(library: Library, tmp_path: Path) -> None:
    _, run = kept(library, tmp_path / "x.csv", CLEAN)
    assert (run.kind, run.state, run.scenario, run.name) == ("measurement", "complete", "", "rig 7")
    assert (run.variants, run.ticks, run.period) == (["M"], ROWS, PERIOD)
    assert run.duration == pytest.approx(0.2)
    assert run.metrics["M.x.max_abs_following_error"] == pytest.approx(2e-6, rel=1e-3)
    assert run.metrics["M.x.rms_following_error"] == pytest.approx(2e-6 / np.sqrt(2), rel=1e-3)
    assert set(run.thumbnail) == {"reference", "M"}
    assert len(run.thumbnail["M"]) == len(run.thumbnail["reference"]) > 20
    assert run.result["import"]["rate"] == 2000
    with library.files.open(run.id) as file:
        table = file.read()
    assert table["tick"].to_pylist() == list(range(ROWS))
    near(table["time"].to_numpy(), TIMES)
    near(table["x.position_reference"].to_numpy(), REFERENCE)
    assert [column["name"] for column in run.columns] == table.column_names[2:]


def test_gaps_are_events_and_nulls(library: Library, tmp_path: Path) -> None:
    rows = CLEAN.splitlines()
    del rows[101:151]
    _, run = kept(library, tmp_path / "x.csv", "\n".join(rows))
    assert (run.state, run.reason) == ("partial", "0.025 s are missing in the file")
    (event,) = run.events
    assert (event.kind, event.tick, event.ticks) == ("gap", 100, 50)
    with library.files.open(run.id) as file:
        assert file.read()["x.position_reference"].null_count == 50


def test_a_run_without_positions(library: Library, tmp_path: Path) -> None:
    text = lines(*(f"{t:.4f},{t}" for t in TIMES), header="t [s],Temp")
    _, run = kept(library, tmp_path / "x.csv", text)
    assert (run.thumbnail, run.metrics) == ({}, {})


def test_a_preview_and_a_problem_keep_nothing(library: Library, tmp_path: Path) -> None:
    from motionlab.library.search import Search

    path = tmp_path / "x.csv"
    path.write_text(CLEAN)
    assert import_file(path, ImportOptions(), library=None, name="x")[1] is None
    path.write_text(CLEAN.replace("time [s]", "foo"))
    document, run = import_file(path, ImportOptions(), library=library, name="x")
    assert run is None
    assert document.problems
    assert library.index.page(Search()).total == 0


# -- files that would take far more memory than they have bytes -----------------------------------


@pytest.mark.parametrize("resample", [None, 900.0])
def test_a_measurement_is_held_once_beside_its_file(resample: float | None) -> None:
    """Columns become samples one after the other; a hundred of 80 kB would be 8 MB at once."""
    rows, count = 10_000, 100
    columns = [FileColumn("time [s]", "s", np.arange(rows) / 1000)]
    columns += [FileColumn(f"extra {i} [m]", "m", np.full(rows, 1.0 * i)) for i in range(count)]
    file = MeasuredFile("csv", columns)
    tracemalloc.start()
    try:
        made = read_measurement(file, ImportOptions(resample=resample))
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert len(made.values) == count
    assert peak < 1.5 * count * rows * np.dtype(np.float32).itemsize


def test_gaps_count_as_numbers(given: Given) -> None:
    times = np.arange(500_000) / 1000
    times[250_000:] += 5000.0
    header = ",".join(["t [s]", *(f"c{i} [m]" for i in range(8))])
    text = lines(*(f"{t:.3f},1,1,1,1,1,1,1,1" for t in times), header=header)
    with pytest.raises(ConfigError, match="too many samples with its gaps"):
        given(text)


def element(kind: int, content: bytes) -> bytes:
    """Return an element of a MAT file of level 5."""
    return struct.pack("<II", kind, len(content)) + content + b"\0" * (-len(content) % 8)


def matrix(what: int, shape: tuple[int, ...], *parts: bytes) -> bytes:
    flags = element(6, struct.pack("<II", what, 0))
    size = element(5, struct.pack(f"<{len(shape)}i", *shape))
    return element(14, b"".join([flags, size, element(1, b"v"), *parts]))


def nested(depth: int) -> bytes:
    content = matrix(6, (1, 1), element(9, struct.pack("<d", 1.0)))
    for _ in range(depth):
        content = matrix(1, (1, 1), content)
    return content


def mat_file(path: Path, *variables: bytes) -> Path:
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H2s", 0x0100, b"IM")
    path.write_bytes(head + b"".join(variables))
    return path


def compressed(variable: bytes) -> bytes:
    content = zlib.compress(variable)
    return struct.pack("<II", 15, len(content)) + content


MAT_BOMBS = {
    "large when uncompressed": (
        compressed(matrix(6, (1, 1 << 17), element(9, b"\0" * (1 << 20)))),
        "too large uncompressed",
    ),
    "many cells claimed": (matrix(1, (1 << 30, 1)), "1073741824 x 1 entries"),
    "many structs claimed": (
        matrix(2, (40000, 40000), struct.pack("<HHi", 5, 4, 32), element(1, b"")),
        "40000 x 40000 entries",
    ),
    "long text claimed": (compressed(matrix(4, (1, 1 << 30), element(16, b""))), "1 x 1073741824"),
    "many empty cells": (
        compressed(matrix(1, (1 << 19, 1), (1 << 19) * struct.pack("<II", 14, 0))),
        "texts of more than 300000 entries",
    ),
    "many structs without fields": (
        compressed(matrix(2, (1 << 19, 1), element(9, b"\0" * (1 << 23)))),
        "texts of more than 300000 entries",
    ),
    "a claimed size": (struct.pack("<II", 15, 0xFFFFFFF0) + b"short", "too large uncompressed"),
    "negative": (matrix(6, (-1, -5), element(9, b"\0" * 16)), "-1 x -5 entries"),
    "deep": (nested(3000), "deep"),
    "no zlib": (struct.pack("<II", 15, 8) + b"nonsense", "no MAT file that can be read"),
}


@pytest.mark.parametrize(("content", "why"), MAT_BOMBS.values(), ids=MAT_BOMBS)
def test_a_mat_file_that_is_larger_than_it_looks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, content: bytes, why: str
) -> None:
    small = 100_000 if "uncompressed" in why else 1_000_000
    monkeypatch.setattr(measured_file, "VALUES_MAX", small)
    with pytest.raises(ConfigError, match=why):
        read_file(mat_file(tmp_path / "bomb.mat", content))


def mcap_file(path: Path, messages: Iterable[object], *, size: int = 1 << 20) -> Path:
    """Write messages as JSON, each 1 ms after the one before; a text is written as it is."""
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=size)
        writer.start()
        schema = writer.register_schema("rig", "jsonschema", b"{}")
        channel = writer.register_channel("/rig", "json", schema)
        for number, message in enumerate(messages):
            text = message if isinstance(message, str) else json.dumps(message)
            instant = number * 1_000_000
            writer.add_message(channel, instant, text.encode(), instant)
        writer.finish()
    return path


MCAP_BOMBS = {
    "a large chunk": ([{"a": 1}, " " * (65 << 20)], "67108864 bytes uncompressed"),
    "a large message": ([{"a": 1}, " " * (9 << 20)], "message of more than 8388608 bytes"),
    "deep": ([{"a": 1}, "[" * 100_000], "no MCAP file that can be read"),
    "a number too large": ([{"a": 1}, {"a": 10**400}], "no MCAP file that can be read"),
    "another name each": ([{f"name {i}": 1} for i in range(1001)], "more than 1000 columns"),
    "few numbers, many rows": ([{"a": 1, "b": 2, "c": 3}] + [{}] * 3999, "more than 9000 numbers"),
}


@pytest.mark.parametrize(("messages", "why"), MCAP_BOMBS.values(), ids=MCAP_BOMBS)
def test_an_mcap_file_that_is_larger_than_it_looks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, messages: list[object], why: str
) -> None:
    if "9000" in why:
        monkeypatch.setattr(measured_file, "VALUES_MAX", 9000)
    with pytest.raises(ConfigError, match=why):
        read_file(mcap_file(tmp_path / "bomb.mcap", messages, size=128 << 20))


def test_a_damaged_mcap_file_is_refused_in_words(tmp_path: Path) -> None:
    path = mcap_file(tmp_path / "damaged.mcap", [{"a": i} for i in range(30)])
    content = bytearray(path.read_bytes())
    for place in range(40, len(content) - 40, 53):
        damaged = content.copy()
        damaged[place] ^= 0xFF
        path.write_bytes(damaged)
        with contextlib.suppress(ConfigError):
            read_file(path)
        path.write_bytes(content[:place])
        try:
            notes = read_file(path).notes
        except ConfigError as error:
            assert "MCAP" in str(error)
        else:
            assert "cut off" in notes[0]


def test_columns_that_begin_late_or_end_early(tmp_path: Path) -> None:
    messages = [{"a": 0}, {"a": 1, "b": 1}, {"b": 2}, {"a": 3, "b": 3}, {"a": 4}]
    file = read_file(mcap_file(tmp_path / "sparse.mcap", messages))
    found = {column.header: column.values for column in file.columns}
    nan = np.nan
    np.testing.assert_array_equal(found["rig.a"], [0, 1, nan, 3, 4])
    np.testing.assert_array_equal(found["rig.b"], [nan, 1, 2, 3, nan])


def test_a_unit_with_a_factor(given: Given) -> None:
    """Volts of a drive as newtons, turned around; rotation as a length."""
    text = lines("0,1,2,10,7", "0.001,1.5,2.5,20,7", header="t [s],vir,cell [V],rpm,F_y [N]")
    found = given(
        text,
        "vir=M.x.thrust[35.15 N]",
        "cell=x.load_force[-2e2 N]",
        "rpm=M.x.velocity_measured[0.333 mm/s]",
    )
    near(found.values["M.x.thrust"], [35.15, 52.725])
    near(found.values["x.load_force"], [-400.0, -500.0])
    near(found.values["M.x.velocity_measured"], [3.33e-3, 6.66e-3])
    near(found.values["M.y.thrust"], [7.0, 7.0])
    assert [c.factor for c in found.document.columns][1:4] == [35.15, -200.0, 0.333e-3]
    bare = lines("0,1,2", "0.001,1.5,2.5", header="t [s],vir,F_y")  # F_y does not take its factor
    near(given(bare, "vir=M.x.thrust[35.15 N]").values["M.y.thrust"], [2.0, 2.5])
    for unit in ("0 N", "1e999 N", "35.15 V", "nan N", "3 4 N"):
        with pytest.raises(ConfigError, match="is no unit of that channel"):
            given(text, f"vir=M.x.thrust[{unit}]")
