"""Numbers of NamedTuples as C: initial values of structures, and of tables."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.declarations import field_comments
from motionlab.targets.c_comments import inside_comment
from motionlab.targets.c_expression import INDENT, WIDTH, number
from motionlab.targets.c_program import Program
from motionlab.targets.c_words import safe

_IN_A_LINE = 4


def initial_values(program: Program, value: Any, indent: str) -> Iterator[str]:
    """Yield the fields of a NamedTuple that a program reads, with their numbers."""
    kind = type(value)
    comments = field_comments(kind)
    for name in program.fields(kind):
        each = getattr(value, name)
        if isinstance(each, tuple):
            yield f"{indent}.{safe(name)} = {{"
            yield from initial_values(program, each, indent + INDENT)
            yield f"{indent}}},"
        else:
            about = [inside_comment(comments.get(name, "")), "none" if math.isinf(each) else ""]
            text = "; ".join(part for part in about if part)
            line = f"{indent}.{safe(name)} = {number(each)},"
            beside = f"{line} /* {text} */" if text else line
            yield from [beside] if len(beside) <= WIDTH else [f"{indent}/* {text} */", line]


def array_lines(numbers: NDArray[np.float64], indent: str) -> Iterator[str]:
    """Yield the numbers of an array, each line with a comma at its end."""
    texts = [repr(each) for each in numbers.ravel().tolist()]
    for first in range(0, len(texts), _IN_A_LINE):
        yield f"{indent}{', '.join(texts[first : first + _IN_A_LINE])},"
