"""Files that hold arrays by name, NPZ and MAT: what becomes a column, and what is refused."""

from __future__ import annotations

import io
import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io

from motionlab.errors import ConfigError
from motionlab.exchange.measurements import npz_arrays
from motionlab.exchange.measurements.channels import Measurement, read_measurement
from motionlab.exchange.measurements.document import COLUMNS_MAX, ImportOptions
from motionlab.exchange.measurements.table_file import MeasuredFile, numbers_in, read_file

ROWS = 500
TIMES = np.arange(ROWS) * 1e-3
POSITION = 0.01 * np.sin(2 * np.pi * 3 * TIMES)


def npz(folder: Path, **arrays: Any) -> Path:
    path = folder / "measured.npz"
    np.savez(path, **arrays)
    return path


def mat(folder: Path, **variables: Any) -> Path:
    path = folder / "measured.mat"
    scipy.io.savemat(path, variables)
    return path


def headers(file: MeasuredFile) -> list[str]:
    return [column.header for column in file.columns]


def measured(path: Path, *mapping: str, **options: Any) -> Measurement:
    options = {"mapping": mapping, **options}
    return read_measurement(read_file(path, ImportOptions(**options)), ImportOptions(**options))


# -- NumPy ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_vectors_and_matrices_of_a_npz(tmp_path: Path, save: Any) -> None:
    joints = np.stack([POSITION, 2 * POSITION, -POSITION], axis=1)
    path = tmp_path / "arm.npz"
    save(
        path,
        time=TIMES,
        x_ist=POSITION.astype(np.float32),
        q=joints,
        across=np.asfortranarray(joints).T.astype(">f4"),
        mask=POSITION > 0,
        dt=1e-3,
        joint_names=np.array(["a", "b"]),
        volume=np.zeros((2, 3, 4)),
        other=np.zeros(7),
    )
    file = read_file(path)
    assert file.format == "npz"
    assert headers(file) == [
        "time", "x_ist", "q[0]", "q[1]", "q[2]", "across[0]", "across[1]", "across[2]", "mask"
    ]  # fmt: skip
    np.testing.assert_array_equal(file.columns[3].values, 2 * POSITION)
    np.testing.assert_array_equal(file.columns[7].values, (-POSITION).astype(np.float32))
    np.testing.assert_array_equal(file.columns[8].values, POSITION > 0)
    assert file.ignored == {
        "dt": "is a single number, 0.001",
        "joint_names": "is text",
        "volume": "has 3 dimensions",
        "other": "has 7 values instead of 500",
    }
    found = measured(path)
    assert (found.document.rate, found.document.ticks) == (1000.0, ROWS)
    assert "M.x.position_measured" in found.values


def test_a_single_array_and_structured_ones(tmp_path: Path) -> None:
    path = tmp_path / "one.npy"
    np.save(path, np.stack([TIMES, POSITION], axis=1))
    assert headers(read_file(path)) == ["array[0]", "array[1]"]
    records = np.zeros(ROWS, dtype=[("t", "f8"), ("x", "f4", (2,))])
    records["t"], records["x"] = TIMES, np.stack([POSITION, -POSITION], axis=1)
    file = read_file(npz(tmp_path, log=records))
    assert headers(file) == ["log.t", "log.x[0]", "log.x[1]"]
    np.testing.assert_array_equal(file.columns[0].values, TIMES)


def test_instants_of_numpy(tmp_path: Path) -> None:
    begin = np.datetime64("2026-03-01T12:00:00", "us")
    stamps = begin + (1e6 * TIMES).round().astype("timedelta64[us]")
    found = measured(npz(tmp_path, stamps=stamps, x_ist=POSITION))
    assert (found.document.rate, found.document.rate_from) == (1000.0, "stamps")
    assert found.begun == 1772366400.0


class Bad:
    def __reduce__(self) -> Any:
        return (pytest.fail, ("was unpickled",))


def test_python_objects_are_never_unpickled(tmp_path: Path) -> None:
    objects = np.array([Bad(), 1.0], dtype=object)
    file = read_file(npz(tmp_path, t=TIMES, x=POSITION, objects=objects))
    assert headers(file) == ["t", "x"]
    assert file.ignored == {"objects": "is an array of Python objects, which only pickle reads"}
    with pytest.raises(ConfigError, match="has no vector of numbers; objects is an array of Pyth"):
        read_file(npz(tmp_path, objects=objects))


def header(shape: str, descr: str = "'<f8'") -> bytes:
    """Return the header of an array with a shape that it claims."""
    text = f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode()


def zipped(folder: Path, *entries: tuple[str, bytes]) -> Path:
    path = folder / "hostile.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries:
            archive.writestr(name, content)
    return path


@pytest.mark.parametrize(
    ("entries", "why"),
    [
        ([("x.npy", header("(1000000000000, 1000000000000)") + b"\0" * 80)], "claims 10+ x 10+"),
        ([("x.npy", header("(4, -2)") + b"\0" * 80)], "claims 4 x -2"),
        ([("x.npy", header("(0, 0, 99999999999999999999)"))], "is no file of NumPy"),
        ([("x.npy", header("(9,)") + b"\0" * 64)], "array 'x' is cut off"),
        ([("x.npy", header("(2,)", "'|V0'"))], "itemsize cannot be zero|claims 2 entries"),
        ([("x.npy", header("(2,)", "'|O'") + b"cposix\nsystem\n")], "only pickle reads"),
        ([("x.npy", header("(__import__('os'),)"))], "is no file of NumPy that can be read"),
        ([("x.npy", header("(" + "(" * 3000 + ")" * 3000 + ",)"))], "is no file of NumPy"),
        ([("x.npy", b"\x93NUMPY\x09\x00")], "is no file of NumPy"),
        ([("x.npy", b"")], "is no file of NumPy"),
        ([("x.npy", b"\x93NUMPY\x02\x00\xff\xff\xff\xff")], "is no file of NumPy"),
        ([("x.csv", b"t,x\n1,2\n")], "is a zip archive without arrays"),
    ],
)
def test_hostile_headers(tmp_path: Path, entries: Any, why: str) -> None:
    with pytest.raises(ConfigError, match=why):
        read_file(zipped(tmp_path, *entries))


def test_a_zip_bomb_is_refused_before_it_is_unpacked(tmp_path: Path) -> None:
    size = 1 << 29
    claim = header(f"({size},)", "'|i1'")
    path = zipped(tmp_path, ("x.npy", claim + bytes(size)))
    assert path.stat().st_size < 1 << 20
    assert numbers_in(path) == size
    with pytest.raises(ConfigError, match="is too large uncompressed"):
        read_file(path)
    half = header(f"({size // 2},)", "'|i1'") + bytes(size // 2)
    several = zipped(tmp_path, *((f"x{k}.npy", half) for k in range(3)))
    with pytest.raises(ConfigError, match="is too large uncompressed"):
        read_file(several)


def test_more_numbers_than_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("motionlab.exchange.measurements.table_file.VALUES_MAX", 900)
    with pytest.raises(ConfigError, match="too many numbers; got 1000; allowed <= 900"):
        read_file(npz(tmp_path, t=TIMES.astype(np.float32), x=POSITION.astype(np.float32)))


def test_too_many_entries_and_columns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wide = np.zeros((COLUMNS_MAX + 5, COLUMNS_MAX + 1))
    file = read_file(npz(tmp_path, t=TIMES, x=POSITION, wide=wide))
    assert file.ignored["wide"] == f"has {COLUMNS_MAX + 5} x {COLUMNS_MAX + 1} values"
    monkeypatch.setattr(npz_arrays, "_ENTRIES_MAX", 3)
    with pytest.raises(ConfigError, match="too many entries; got 4; allowed <= 3"):
        read_file(npz(tmp_path, a=TIMES, b=TIMES, c=TIMES, d=TIMES))


def test_damaged_archives(tmp_path: Path) -> None:
    path = npz(tmp_path, t=TIMES, x=POSITION)
    whole = path.read_bytes()
    rng = np.random.default_rng(5)
    for _ in range(200):
        content = bytearray(whole)
        for place in rng.integers(4, len(content), size=6):
            content[place] = int(rng.integers(0, 256))
        path.write_bytes(content[: int(rng.integers(100, len(content) + 1))])
        try:
            read_file(path)
        except ConfigError as error:
            assert error.errors[0].loc == "file"
        numbers_in(path)


def test_an_encrypted_archive(tmp_path: Path) -> None:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("x.npy", header("(2,)") + b"\0" * 16)
    content = bytearray(buffer.getvalue())
    for signature, flags in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        content[content.index(signature) + flags] |= 1
    path = tmp_path / "locked.npz"
    path.write_bytes(content)
    with pytest.raises(ConfigError, match="password"):
        read_file(path)


@pytest.mark.parametrize("wrong", ["missing", "backwards", "equal"])
def test_times_that_are_none(tmp_path: Path, wrong: str) -> None:
    times = TIMES.copy()
    match wrong:
        case "missing":
            times[7], why = np.nan, "row 8: has no time"
        case "backwards":
            times[7], why = 0.0, "row 8: its time is before the one before it"
        case _:
            times[:], why = 1.5, "all its times are equal"
    with pytest.raises(ConfigError, match=why):
        measured(npz(tmp_path, time=times, x_ist=POSITION))


# -- MATLAB ---------------------------------------------------------------------------------------


def test_a_structure_with_time(tmp_path: Path) -> None:
    """As Simulink's To Workspace and Scope write it: signals by their labels."""
    signals = np.zeros((1, 3), dtype=[(n, "O") for n in ("values", "dimensions", "label")])
    pair = np.stack([POSITION, -POSITION], axis=1)
    signals[0, 0] = (POSITION[:, None], 1.0, "x_ref [m]")
    signals[0, 1] = (pair, 2.0, "")
    signals[0, 2] = (2 * POSITION[:, None], 1.0, "x_ref [m]")
    simout = {"time": TIMES[:, None], "signals": signals, "blockName": "model/Scope"}
    file = read_file(mat(tmp_path, simout=simout))
    assert headers(file) == [
        "time", "x_ref [m]", "signals(2)(1)", "signals(2)(2)", "signals(3)"
    ]  # fmt: skip
    np.testing.assert_array_equal(file.columns[4].values, 2 * POSITION)
    found = measured(mat(tmp_path, simout=simout))
    assert "x.position_reference" in found.values
    one = {"time": TIMES, "signals": {"values": POSITION, "dimensions": 1.0, "label": "x_ist"}}
    assert headers(read_file(mat(tmp_path, one=one))) == ["time", "x_ist"]
    assert headers(read_file(mat(tmp_path, one=one, k=3.0))) == ["one.time", "x_ist"]


def test_nested_structs_and_arrays_of_structs(tmp_path: Path) -> None:
    axes = np.zeros((1, 2), dtype=[("pos", "O"), ("name", "O")])
    axes[0, 0], axes[0, 1] = (POSITION, "x"), (-POSITION, "y")
    cells = np.empty((1, 2), dtype=object)
    cells[0, 0], cells[0, 1] = POSITION, TIMES
    log = {"t": TIMES, "arm": {"joint": {"drive": {"pos": POSITION}}}, "axes": axes, "c": cells}
    file = read_file(mat(tmp_path, log=log))
    assert headers(file) == ["t", "arm.joint.drive.pos", "axes(1).pos", "axes(2).pos"]
    assert file.ignored == {
        "axes(1).name": "is text", "axes(2).name": "is text", "c": "is a cell array"
    }  # fmt: skip
    deep: Any = {"pos": POSITION}
    for _ in range(10):
        deep = {"s": deep}
    file = read_file(mat(tmp_path, t=TIMES, x=POSITION, deep=deep))
    assert list(file.ignored.values()) == ["lies more than 8 structs deep"]


def test_what_is_no_mat_file_of_level_5(tmp_path: Path) -> None:
    path = tmp_path / "x.h5"
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100))
    with pytest.raises(ConfigError, match="is HDF5: save it as NPZ"):
        read_file(path)
    with pytest.raises(ConfigError, match="has no vector of numbers; k is a single number, 3"):
        read_file(mat(tmp_path, k=3.0))


def test_times_beyond_nanoseconds_and_names_of_two_lines(tmp_path: Path) -> None:
    t = np.arange(20) * 1e-3
    years = np.array([1500 + k for k in range(20)]).astype("datetime64[Y]")
    np.savez(tmp_path / "a.npz", **{"t": t, "age": years, "two\nlines": t})
    file = read_file(tmp_path / "a.npz", ImportOptions())
    assert file.ignored["age"] == "has times before 1677 or after 2262"
    assert "two lines" in [column.header for column in file.columns]
