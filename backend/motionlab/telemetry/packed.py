"""A JSON head and arrays of numbers in one piece, as the page reads them without a copy."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

_ALIGNMENT = 8


def packed(head: dict[str, Any], curves: Sequence[ArrayLike], kind: str = "<f4") -> bytes:
    """Return the length of the head, 0, the head padded to a multiple of 8, and the curves.

    Parameters
    ----------
    head : dict
        What JSON can hold, without NaN and infinity.
    curves : sequence of array
        Put one after another.
    kind : str
        Type that their numbers are rounded to.
    """
    text = json.dumps(head, allow_nan=False, separators=(",", ":")).encode()
    text += b" " * (-len(text) % _ALIGNMENT)
    values = [np.ascontiguousarray(curve, dtype=kind).tobytes() for curve in curves]
    return b"".join((struct.pack("<II", len(text), 0), text, *values))
