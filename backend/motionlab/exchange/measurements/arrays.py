"""Columns of files that hold arrays by name: vectors, and columns of matrices, of one length."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.exchange.measurements.document import COLUMNS_MAX

Vector = tuple[str, NDArray[Any]]


@dataclass
class ArrayTable:
    """Vectors of one length of a file.

    Attributes
    ----------
    columns : list of (str, str, ndarray of float64, bool)
        Name, unit, values, and whether they are times.
    ignored : dict of str to str
        What is not read, and why.
    begun : float or None
        Instant of the first row, seconds since 1970, where the file has it.
    own : bool
        Whether an export wrote the file.
    """

    columns: list[tuple[str, str, NDArray[np.float64], bool]]
    ignored: dict[str, str] = field(default_factory=dict)
    begun: float | None = None
    own: bool = False


def note(ignored: dict[str, str], name: str, why: str) -> None:
    """Note what is not read, as far as lists of columns go."""
    if len(ignored) < COLUMNS_MAX:
        ignored[name] = why


def columns_of(name: str, value: Any, ignored: dict[str, str], form: str) -> Iterator[Vector]:
    """Yield a vector of numbers, or the columns of a matrix; note what is neither.

    Parameters
    ----------
    name : str
        Of the array.
    value : object
        The array.
    ignored : dict of str to str
        What is not read, which grows.
    form : str
        How columns of a matrix are called: ``{}({})`` counts from 1, ``{}[{}]`` from 0.
    """
    if why := unread(value):
        note(ignored, name, why)
    elif value.ndim == 1:
        yield name, value
    else:
        table = value if value.shape[0] >= value.shape[1] else value.T
        if table.shape[1] > COLUMNS_MAX:
            note(ignored, name, f"has {table.shape[0]} x {table.shape[1]} values")
            return
        begin = 0 if "[" in form else 1
        for index, column in enumerate(table.T, start=begin):
            yield form.format(name, index), column


def unread(value: Any) -> str:
    """Return why a variable is no column; empty if it is some."""
    kind = value.dtype.kind if isinstance(value, np.ndarray | np.generic) else ""
    if isinstance(value, str) or (kind in "SU" and kind):
        return "is text"
    if isinstance(value, int | float | np.number) or (getattr(value, "size", 2) == 1 and kind):
        number = value.item() if isinstance(value, np.ndarray | np.generic) else value
        return f"is a single number, {number:.9g}" if isinstance(number, int | float) else "is one"
    if not isinstance(value, np.ndarray) or kind not in "fiub" or not value.size:
        return "is complex" if kind == "c" else "is no numbers"
    return "" if value.ndim in {1, 2} else f"has {value.ndim} dimensions"


def of_one_length(vectors: Sequence[Vector], ignored: dict[str, str]) -> list[Vector]:
    """Return the vectors of the length that most have, the longer one of two; note the others."""
    lengths = Counter(len(values) for _, values in vectors)
    rows = max(lengths, key=lambda length: (lengths[length] * (length > 1), length), default=0)
    for name, values in vectors:
        if len(values) != rows:
            note(ignored, name, f"has {len(values)} values instead of {rows}")
    return [(name, values) for name, values in vectors if len(values) == rows]
