"""Variables of MAT files of level 5: vectors, matrices, and structs of them, however nested."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.measurements.arrays import (
    ArrayTable,
    Vector,
    columns_of,
    note,
    of_one_length,
)
from motionlab.exchange.measurements.mat_check import check_mat

_DEPTH_MAX = 8  # structs within structs
_LABEL_MAX = 100  # characters
_OBJECT = (
    "is an object of MATLAB, such as a timeseries or a table: save its numbers as arrays, or as a "
    "structure with time"
)


def read_mat(path: Path, bytes_max: int, check: Callable[[int], None]) -> ArrayTable:
    """Read the vectors and matrices of a MAT file.

    Fields of structs are named with dots, elements of struct arrays with their number, signals of a
    structure with time by their labels. A single struct leaves its own name out.

    Parameters
    ----------
    path : Path
        The file.
    bytes_max : int
        Most bytes of all variables, uncompressed.
    check : callable
        Takes how many numbers are to be converted; refuses too many.

    Raises
    ------
    ConfigError
        If it cannot be read, is of version 7.3, or has no vector of numbers.
    """
    from scipy.io import loadmat  # noqa: PLC0415 - a server starts without it

    check_mat(path, bytes_max)
    try:
        content = loadmat(path, squeeze_me=True, struct_as_record=False)
    except NotImplementedError:
        raise _refused("is a MAT file of version 7.3: save it with -v7 in MATLAB") from None
    except MemoryError:
        raise
    except Exception as error:  # whatever a damaged file makes of the reader
        raise _refused(f"is no MAT file that can be read: {error}") from None
    roots = {name: value for name, value in content.items() if not name.startswith("__")}
    single = next(iter(roots.values())) if len(roots) == 1 else None
    ignored: dict[str, str] = {}
    vectors = list(_members("", vars(single) if _is_struct(single) else roots, 0, ignored))
    units, names = _described(single)
    if not vectors:
        reasons = "".join(f"; {name} {why}" for name, why in list(ignored.items())[:5])
        raise _refused(f"has no vector of numbers{reasons}")
    if names:
        ignored.clear()  # texts that describe the run
    kept = of_one_length(vectors, ignored)
    check(len(kept) * len(kept[0][1]))
    columns = [
        (names.get(name, name), units.get(name, ""), values.astype(np.float64), False)
        for name, values in kept
    ]
    return ArrayTable(columns, ignored, own=bool(names))


def _is_struct(value: Any) -> bool:
    return hasattr(value, "_fieldnames")


def _is_structs(value: Any) -> bool:
    """Return whether a value is an array of structs, which all have the same fields."""
    array = isinstance(value, np.ndarray) and value.dtype == object and value.size > 0
    return array and _is_struct(value.flat[0])


def _members(
    prefix: str, members: dict[str, Any], depth: int, ignored: dict[str, str]
) -> Iterator[Vector]:
    """Yield the vectors of structs, and the columns of matrices; note the others."""
    for name, value in members.items():
        if name == "_fieldnames":
            continue
        full = f"{prefix}{name}"
        if _is_struct(value) or _is_structs(value):
            if depth == _DEPTH_MAX:
                note(ignored, full, f"lies more than {_DEPTH_MAX} structs deep")
            else:
                yield from _structs(full, value, depth + 1, ignored)
        elif getattr(value, "dtype", None) is not None and value.dtype.names:
            note(ignored, full, _OBJECT)
        elif isinstance(value, np.ndarray) and value.dtype == object:
            note(ignored, full, "is a cell array")
        else:
            yield from columns_of(full, value, ignored, "{}({})")


def _structs(name: str, value: Any, depth: int, ignored: dict[str, str]) -> Iterator[Vector]:
    """Yield the vectors of a struct, or of each one of an array of structs."""
    if _is_struct(value):
        elements = [(name, value)]
    else:
        numbered = enumerate(value.flat, start=1)
        elements = [(f"{name}({number})", each) for number, each in numbered]
    labels: set[str] = set()
    for path, element in elements:
        label = _label(element)
        if label and label not in labels:
            labels.add(label)
            yield from columns_of(label, element.values, ignored, "{}({})")
        elif _is_signal(element):
            yield from columns_of(path, element.values, ignored, "{}({})")
        else:
            yield from _members(f"{path}.", vars(element), depth, ignored)


def _is_signal(struct: Any) -> bool:
    """Return whether a struct is a signal of a structure with time, as Simulink writes it."""
    fields = set(getattr(struct, "_fieldnames", ()))
    return {"values", "dimensions"} <= fields <= {
        "values", "dimensions", "label", "title", "plotStyle", "blockName", "stateName",
        "inReferencedModel", "valueDimensions",
    }  # fmt: skip


def _label(struct: Any) -> str:
    """Return the label of a signal; empty where it has none."""
    label = getattr(struct, "label", "") if _is_signal(struct) else ""
    return label.strip()[:_LABEL_MAX] if isinstance(label, str) else ""


def _described(struct: Any) -> tuple[dict[str, str], dict[str, str]]:
    """Return units and channels of the fields of a struct that an export wrote."""
    units = getattr(struct, "units", None)
    fields, channels = (np.atleast_1d(getattr(struct, n, [])) for n in ("fields", "channels"))
    named = {n: u for n, u in vars(units).items() if isinstance(u, str)} if units else {}
    return named, {str(f): str(c) for f, c in zip(fields, channels, strict=False)}


def _refused(message: str) -> ConfigError:
    return ConfigError(FieldError("file", message))
