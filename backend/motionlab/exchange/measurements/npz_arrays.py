"""Arrays of NumPy's files, NPY and NPZ: read without pickle, and no more than they claim."""

from __future__ import annotations

import lzma
import math
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.measurements.arrays import (
    ArrayTable,
    Vector,
    columns_of,
    note,
    of_one_length,
)

ZIP = b"PK\x03\x04"
NPY = b"\x93NUM"

_ENTRIES_MAX = 10_000
_ENDING = ".npy"
_DAMAGED = (
    tokenize.TokenError,  # of a header
    OSError,
    EOFError,
    ValueError,
    zipfile.BadZipFile,
    zlib.error,
    lzma.LZMAError,
    NotImplementedError,
    RuntimeError,
    SyntaxError,
    TypeError,
    KeyError,
    OverflowError,
)
"""What damaged archives and headers raise; RuntimeError those with a password."""


def read_npz(path: Path, bytes_max: int, check: Callable[[int], None]) -> ArrayTable:
    """Read the vectors and matrices of a file of NumPy; nothing in it is unpickled.

    Structured arrays are read as one array for each field, ``name.field``.

    Parameters
    ----------
    path : Path
        An NPY file, or an NPZ file: a zip archive of them.
    bytes_max : int
        Most bytes of all arrays, uncompressed.
    check : callable
        Takes how many numbers are to be converted; refuses too many.

    Raises
    ------
    ConfigError
        If it is damaged, holds no vector of numbers, or its arrays are larger than that.
    """
    ignored: dict[str, str] = {}
    vectors: list[Vector] = []
    for name, value in _arrays(path, bytes_max):
        if value is None:
            note(ignored, name, "is an array of Python objects, which only pickle reads")
        elif isinstance(value, str):
            note(ignored, name, value)
        elif value.dtype.kind in "mM" and value.ndim == 1 and value.size:
            vectors.append((name, value))
        else:
            vectors += columns_of(name, value, ignored, "{}[{}]")
    kept = of_one_length(vectors, ignored)
    if not kept:
        reasons = "".join(f"; {name} {why}" for name, why in list(ignored.items())[:5])
        raise _refused(f"has no vector of numbers{reasons}")
    check(len(kept) * len(kept[0][1]))
    table = ArrayTable([], ignored)
    for name, values in kept:
        if values.dtype.kind not in "mM":
            table.columns.append((name, "", values.astype(np.float64), False))
            continue
        read = _seconds(values)
        if read is None:
            note(ignored, name, "has times before 1677 or after 2262")
            continue
        seconds, begun = read
        table.begun = begun if table.begun is None else table.begun
        table.columns.append((name, "s", seconds, True))
    return table


def numbers_in(path: Path) -> int:
    """Return how many numbers the headers of a file say that it holds; 0 where they cannot be read.

    Nothing but headers is unpacked.
    """
    count = 0
    try:
        with zipfile.ZipFile(path) as archive:
            for entry in archive.infolist()[:_ENTRIES_MAX]:
                if entry.filename.endswith(_ENDING):
                    with archive.open(entry) as stream:
                        shape, _, dtype = _header(stream)
                        count += math.prod(shape) * max(1, len(dtype.names or ()))
    except _DAMAGED:  # said by `read_npz`
        return count
    return count


def _seconds(values: NDArray[Any]) -> tuple[NDArray[np.float64], float | None] | None:
    """Return times in s; instants count from the first one, which comes second, s since 1970.

    None where 64 bits of nanoseconds do not hold them.
    """
    whole, missing = values.astype(f"{values.dtype.kind}8[ns]"), np.isnat(values)
    finer = np.datetime_data(values.dtype)[0] in {"ns", "ps", "fs", "as"}
    if not (finer or np.array_equal(whole.astype(values.dtype)[~missing], values[~missing])):
        return None
    nanoseconds = whole.astype(np.int64)
    begun = None
    if values.dtype.kind == "M" and not missing.all():
        first = int(nanoseconds[np.argmin(missing)])
        nanoseconds, begun = nanoseconds - first, first / 1e9
    return np.where(missing, np.nan, nanoseconds / 1e9), begun


def _arrays(path: Path, bytes_max: int) -> Iterator[tuple[str, Any]]:
    """Yield name and array of all; None for Python objects, a reason for what is no array."""
    try:
        with path.open("rb") as stream:
            if stream.read(4) == NPY:
                stream.seek(0)
                array = _read(stream, path.stem, path.stat().st_size, bytes_max)
                yield from _fields("array", array)
                return
        with zipfile.ZipFile(path) as archive:
            yield from _archived(archive, bytes_max)
    except _DAMAGED as error:
        raise _refused(f"is no file of NumPy that can be read: {error}") from None


def _archived(archive: zipfile.ZipFile, bytes_max: int) -> Iterator[tuple[str, Any]]:
    entries = archive.infolist()
    if len(entries) > _ENTRIES_MAX:
        bounds: dict[str, float] = {"maximum": _ENTRIES_MAX}
        raise ConfigError(FieldError("file", "has too many entries", len(entries), bounds=bounds))
    if not any(entry.filename.endswith(_ENDING) for entry in entries):
        raise _refused("is a zip archive without arrays of NumPy: unpack it, import a file of it")
    left = bytes_max
    for entry in entries:
        name = " ".join(entry.filename.removesuffix(_ENDING).replace("/", ".").split())
        if not entry.filename.endswith(_ENDING) or entry.is_dir():
            yield name, "is no array of NumPy"
            continue
        with archive.open(entry) as stream:
            array = _read(stream, name, entry.file_size, left)
        left -= 0 if array is None else array.nbytes
        yield from _fields(name, array)


def _read(stream: IO[bytes], name: str, size: int, bytes_max: int) -> Any:
    """Return an array; None if it holds Python objects.

    Its size is that of its header, and is checked before any of it is read.
    """
    shape, fortran, dtype = _header(stream)
    if dtype.hasobject:
        return None
    count = math.prod(shape)
    if min(shape, default=0) < 0 or count * max(dtype.itemsize, 1) > size:
        text = " x ".join(map(str, shape))
        raise _refused(f"array {name!r} claims {text} entries of {dtype} in {size} bytes")
    if count * dtype.itemsize > bytes_max:
        bounds: dict[str, float] = {"maximum": bytes_max}
        raise ConfigError(
            FieldError("file", "is too large uncompressed", unit="bytes", bounds=bounds)
        )
    content = stream.read(count * dtype.itemsize)
    if len(content) != count * dtype.itemsize:
        raise _refused(f"array {name!r} is cut off")
    values = np.frombuffer(content, dtype, count) if count else np.empty(0, dtype)
    return values.reshape(shape[::-1]).T if fortran else values.reshape(shape)


def _header(stream: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Return shape, order and type of an array."""
    version = npy.read_magic(stream)
    if version == (1, 0):
        return npy.read_array_header_1_0(stream)
    return npy.read_array_header_2_0(stream)  # version 3 differs in names of fields alone


def _fields(name: str, array: Any) -> Iterator[tuple[str, Any]]:
    if array is None or array.dtype.names is None:
        yield name, array
        return
    for field in array.dtype.names:
        yield from _fields(f"{name}.{field}", array[field])


def _refused(message: str) -> ConfigError:
    return ConfigError(FieldError("file", message))
