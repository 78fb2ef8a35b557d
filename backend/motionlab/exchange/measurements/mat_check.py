"""What a MAT file of level 5 would take in memory, before scipy reads it."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

from motionlab.errors import ConfigError, FieldError

_HEADER = 128  # bytes before the first variable
_LEVEL_5 = 0x0100
_MATRIX, _COMPRESSED = 14, 15  # types of elements
_CELL, _STRUCT, _OBJECT, _CHAR, _SPARSE, _OPAQUE = 1, 2, 3, 4, 5, 17  # classes of matrices
_DEPTH_MAX = 50  # arrays within arrays: scipy recurses in C
_OTHERS_MAX = 300_000  # entries of cells, structs and texts, which take more in memory than here


def check_mat(path: Path, bytes_max: int) -> None:
    """Refuse a file that would take far more memory than its numbers.

    Parameters
    ----------
    path : Path
        A MAT file; other levels than 5 are left to the reader.
    bytes_max : int
        Most bytes of all variables, uncompressed.

    Raises
    ------
    ConfigError
        If its variables are larger, an array claims more entries than it has bytes, arrays lie in
        one another more than 50 deep, or cells, structs and texts have more than 300,000 entries.
    """
    left, others = bytes_max, 0
    with path.open("rb") as stream:
        head = stream.read(_HEADER)
        order = "<" if head[126:128] == b"IM" else ">"
        if len(head) < _HEADER or struct.unpack(f"{order}H", head[124:126])[0] != _LEVEL_5:
            return
        while len(tag := stream.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", tag)
            if size > left:
                raise _too_large(bytes_max)
            content = stream.read(size)
            if kind == _COMPRESSED:
                try:
                    content = zlib.decompressobj().decompress(content, left + 1)
                except zlib.error as error:
                    raise _refused(f"is no MAT file that can be read: {error}") from None
                if len(content) > left:
                    raise _too_large(bytes_max)
                kind, content = struct.unpack(f"{order}I", content[:4].ljust(4))[0], content[8:]
            left -= len(content)
            if kind == _MATRIX:
                others = _counted(others, _check_matrix(memoryview(content), order, 1))


def _check_matrix(data: memoryview, order: str, depth: int) -> int:
    """Check an array and those within it; return the entries that are no numbers."""
    if depth > _DEPTH_MAX:
        raise _refused(f"has arrays within arrays, more than {_DEPTH_MAX} deep")
    what, others = 0, 0
    for number, (kind, content) in enumerate(_elements(data, order)):
        if number == 0:
            what = struct.unpack(f"{order}I", content[:4])[0] & 0xFF if len(content) >= 4 else 0
        elif number == 1 and what not in {_SPARSE, _OPAQUE}:
            shape = struct.unpack(f"{order}{len(content) // 4}i", content[: len(content) // 4 * 4])
            least = 8 if what in {_CELL, _STRUCT, _OBJECT} else 1  # bytes of an entry
            entries = math.prod(shape)
            if min(shape, default=0) < 0 or entries * least > len(data):
                size = " x ".join(map(str, shape))
                raise _refused(f"has an array of {size} entries in {len(data)} bytes")
            if what in {_CELL, _STRUCT, _OBJECT, _CHAR}:
                others = _counted(others, entries)
        elif kind == _MATRIX:
            others = _counted(others, 1 + _check_matrix(content, order, depth + 1))
    return others


def _counted(others: int, more: int) -> int:
    if others + more > _OTHERS_MAX:
        raise _refused(f"has cells, structs and texts of more than {_OTHERS_MAX} entries")
    return others + more


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Yield type and content of the elements of an array; short ones lie in their tag."""
    place = 0
    while place + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, place)
        if kind >> 16:
            yield kind & 0xFFFF, data[place + 4 : place + 4 + min(kind >> 16, 4)]
            place += 8
        else:
            yield kind, data[place + 8 : place + 8 + size]
            place += 8 + (size + 7) // 8 * 8


def _too_large(bytes_max: int) -> ConfigError:
    bounds: dict[str, float] = {"maximum": bytes_max}
    return ConfigError(FieldError("file", "is too large uncompressed", unit="bytes", bounds=bounds))


def _refused(message: str) -> ConfigError:
    return ConfigError(FieldError("file", message))
