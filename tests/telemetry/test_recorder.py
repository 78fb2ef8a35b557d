"""Recordings written and read back: the same bits, units in the schema, nothing left half done."""

import re

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from pyarrow import parquet

from motionlab.errors import ConfigError, StoreError
from motionlab.telemetry import recorder
from motionlab.telemetry.channels import CHANNELS, REFERENCES, Sample
from motionlab.telemetry.recording import Divergence
from motionlab.timing import CONTROL_PERIOD
from tests.paths import DOCS
from tests.recordings import make_recording, noise

PAGE = DOCS / "recording.md"
UNITS = {"m", "m/s", "m/s^2", "N", "A", "1"}
METADATA = {"scenario": '{"name": "circle"}', "seed": "7", "version": "1.2.3"}
SUFFIXES = pytest.mark.parametrize("suffix", [".parquet", ".csv"])


def write(recording, path, metadata=METADATA):
    recorder.write(recording, str(path), metadata=metadata)
    return recorder.read(str(path))


def test_channels_are_the_samples_in_their_order_and_documented():
    assert tuple(channel.name for channel in CHANNELS) == Sample._fields
    channels = (*REFERENCES, *CHANNELS)
    assert len({channel.name for channel in channels}) == len(channels)
    assert {channel.unit for channel in channels} <= UNITS
    assert all(channel.meaning for channel in channels)


def test_the_page_lists_every_channel():
    rows = re.findall(r"^\| `(\w+)` \| (.+?) \| (.+?) \|$", PAGE.read_text(), re.MULTILINE)
    assert rows == [(c.name, c.unit, c.meaning) for c in (*REFERENCES, *CHANNELS)]


@SUFFIXES
def test_every_column_comes_back_with_its_unit(tmp_path, suffix):
    recording = noise(500)
    back = write(recording, tmp_path / f"run{suffix}")
    expected = list(recorder.columns(recording))
    assert list(back) == ["tick", "time", *(name for name, _, _ in expected)]
    assert len(back) == 2 + 2 * len(REFERENCES) + 2 * 2 * len(CHANNELS)
    for name, channel, values in expected:
        assert back[name].unit == channel.unit
        assert back[name].values.dtype == np.float32
        assert back[name].values.tobytes() == values.tobytes()
    for name, variant, channel, axis in [
        ("A.x.following_error", "A", "following_error", "x"),
        ("B.y.current_c", "B", "current_c", "y"),
    ]:
        expected_values = recording.variants[variant].channel(channel, axis)
        assert np.array_equal(back[name].values, expected_values)
    y_reference = recording.references[0, 1].astype(np.float32)
    assert np.array_equal(back["y.position_reference"].values, y_reference)
    assert np.array_equal(back["tick"].values, np.arange(500))
    assert np.array_equal(back["time"].values, np.arange(500) * CONTROL_PERIOD)
    assert (back["tick"].unit, back["time"].unit) == ("1", "s")
    assert (back["tick"].values.dtype, back["time"].values.dtype) == (np.int64, np.float64)


anything = arrays.arrays(np.float32, 6, elements=st.floats(width=32, allow_nan=False))


@SUFFIXES
@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(values=anything)
def test_any_float32_comes_back(tmp_path, suffix, values):
    back = write(make_recording(6, {"A": {"x.K": values}}), tmp_path / f"run{suffix}")
    assert back["A.x.K"].values.tobytes() == values.tobytes()


@SUFFIXES
def test_whole_numbers_beyond_24_bits_and_signed_zeros_come_back(tmp_path, suffix):
    values = np.array([3e9, -0.0, 16777216, 0.0], dtype=np.float32)
    back = write(make_recording(4, {"A": {"x.K": values}}), tmp_path / f"run{suffix}")
    assert back["A.x.K"].values.tobytes() == values.tobytes()


def diverged():
    """Return a recording whose variant B ended at tick 3, A at tick 0."""
    recording = make_recording(
        5,
        {"A": {}, "B": {}},
        {name: Divergence(t, "x.thrust", ()) for name, t in (("A", 0), ("B", 3))},
    )
    recording.variants["A"].samples[:] = np.nan
    recording.variants["B"].samples[..., 3:] = np.nan
    return recording


@SUFFIXES
def test_after_a_divergence_there_is_nothing(tmp_path, suffix):
    back = write(diverged(), tmp_path / f"run{suffix}")
    assert np.isnan(back["B.y.thrust"].values).tolist() == [False] * 3 + [True] * 2
    assert np.isnan(back["A.y.thrust"].values).all()
    assert not np.isnan(back["x.position_reference"].values).any()


def test_nothing_is_null_in_parquet_and_empty_in_csv(tmp_path):
    write(diverged(), tmp_path / "run.parquet")
    column = parquet.read_table(tmp_path / "run.parquet")["B.x.thrust"]
    assert column.null_count == 2
    write(diverged(), tmp_path / "run.csv")
    last = (tmp_path / "run.csv").read_text().splitlines()[-1]
    assert last.endswith("," * 100)


def test_parquet_says_what_it_holds_and_how(tmp_path):
    path = tmp_path / "run.parquet"
    write(noise(100), path)
    file = parquet.ParquetFile(path)
    schema = file.schema_arrow
    kept = {key.decode(): value.decode() for key, value in schema.metadata.items()}
    assert kept == METADATA
    field = schema.field("B.y.force_realised")
    assert field.type == pa.float32()
    assert field.metadata[b"unit"] == b"N"
    assert b"after all limits" in field.metadata[b"meaning"]
    for column in range(file.metadata.num_columns):
        chunk = file.metadata.row_group(0).column(column)
        assert chunk.compression == "ZSTD"
        assert not chunk.has_dictionary_page
        if chunk.path_in_schema != "tick":
            assert "BYTE_STREAM_SPLIT" in chunk.encodings


@SUFFIXES
def test_long_recordings_are_written_in_pieces(tmp_path, suffix, monkeypatch):
    monkeypatch.setattr(recorder, "ROWS", 64)
    recording = noise(200)
    back = write(recording, tmp_path / f"run{suffix}")
    for name, _, values in recorder.columns(recording):
        assert back[name].values.tobytes() == values.tobytes()
    assert np.array_equal(back["tick"].values, np.arange(200))
    if suffix == ".parquet":
        assert parquet.ParquetFile(tmp_path / "run.parquet").metadata.num_row_groups == 4


def test_csv_is_plain_text_with_units_points_and_shortest_digits(tmp_path):
    values = [0.1, 1.5, 2.0]
    write(make_recording(3, {"A": {"x.thrust": values}}), tmp_path / "run.csv")
    header, *rows = (tmp_path / "run.csv").read_text().splitlines()
    names = header.replace('"', "").split(",")
    assert names[:3] == ["tick [1]", "time [s]", "x.position_reference [m]"]
    thrust = names.index("A.x.thrust [N]")
    assert [row.split(",")[thrust] for row in rows] == ["0.1", "1.5", "2"]
    assert [row.split(",")[:2] for row in rows] == [["0", "0"], ["1", "0.0005"], ["2", "0.001"]]


@SUFFIXES
def test_identical_recordings_give_identical_bytes(tmp_path, suffix):
    for name in ("one", "two"):
        write(noise(300), tmp_path / f"{name}{suffix}")
    one, two = ((tmp_path / f"{name}{suffix}").read_bytes() for name in ("one", "two"))
    assert one == two
    write(noise(300, seed=2), tmp_path / f"two{suffix}")
    assert one != (tmp_path / f"two{suffix}").read_bytes()


@pytest.mark.parametrize("name", ["run.txt", "run", "run.parquet.gz", "run.CSV"])
def test_other_kinds_of_file_are_refused(tmp_path, name):
    path = str(tmp_path / name)
    with pytest.raises(ConfigError, match=r"out.*\.parquet or \.csv") as caught:
        recorder.write(noise(1), path, metadata={})
    assert caught.value.errors[0].value == path
    assert not list(tmp_path.iterdir())


@SUFFIXES
def test_a_missing_folder_and_a_folder_of_that_name_are_refused(tmp_path, suffix):
    with pytest.raises(ConfigError, match="folder does not exist"):
        recorder.write(noise(1), str(tmp_path / "none" / f"run{suffix}"), metadata={})
    folder = tmp_path / f"run{suffix}"
    folder.mkdir()
    with pytest.raises(ConfigError, match="no regular file"):
        recorder.write(noise(1), str(folder), metadata={})


@SUFFIXES
@pytest.mark.parametrize(
    ("failure", "seen"),
    [
        (OSError(28, "No space left on device"), StoreError),
        (KeyboardInterrupt(), KeyboardInterrupt),
    ],
)
def test_a_write_that_fails_leaves_what_was_there(tmp_path, suffix, monkeypatch, failure, seen):
    path = tmp_path / f"run{suffix}"
    path.write_text("before")

    def fail(*_):
        raise failure

    monkeypatch.setattr(recorder, "_batch", fail)
    with pytest.raises(seen) as caught:
        recorder.write(noise(10), str(path), metadata={})
    if seen is StoreError:
        assert str(path) in str(caught.value) and "No space left" in str(caught.value)
    assert list(tmp_path.iterdir()) == [path]
    assert path.read_text() == "before"


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("absent.csv", None),
        ("absent.parquet", None),
        ("empty.csv", b""),
        ("text.csv", b'"tick [1]","a [m]"\n0,hello\n'),
        ("ragged.csv", b'"tick [1]","a [m]"\n0\n'),
        ("text.parquet", b"not a table"),
    ],
)
def test_what_cannot_be_read_says_so(tmp_path, name, content):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(StoreError, match=rf"{name}: cannot be read"):
        recorder.read(str(tmp_path / name))


def examples():
    found = re.findall(r"```python\n(.+?)```", PAGE.read_text(), re.DOTALL)
    return [text for text in found if "pandas" not in text]  # not a dependency


@pytest.mark.parametrize("example", examples())
def test_the_examples_of_the_page_work(tmp_path, monkeypatch, example):
    monkeypatch.chdir(tmp_path)
    recording = noise(20)
    for suffix in recorder.SUFFIXES:
        write(recording, f"run{suffix}")
    names: dict[str, object] = {}
    exec(example, names)
    expected = recording.variants["A"].channel("following_error", "x")
    assert np.array_equal(np.asarray(names["error"], dtype=np.float32), expected)
