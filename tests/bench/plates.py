"""Bending of plates against a textbook's table; a request as a whole."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator

from motionlab.motor_design.platform.document import platform
from motionlab.motor_design.platform.inputs import read_platform_request
from tests.bench.table import Row
from tests.motor_design.textbook_plates import TEXTBOOK, coefficient

_CLOSE = 5e-3  # relative, to a table of three figures
_WHOLE = 1.0  # s
_REPETITIONS = 5


def plates() -> Iterator[Row]:
    """Hold deflections against Timoshenko's tables, on two meshes, and time a request."""
    for case, (support, longer, load, expected) in TEXTBOOK.items():
        coarse, fine = (coefficient(support, longer, load, cells=n) for n in (8, 16))
        off = abs(fine / expected - 1)
        yield Row(
            f"plate, {case}",
            f"within {_CLOSE:.1%}",
            f"{fine:.6f}",
            f"table {expected:.5f}, half as fine {coarse:.6f}",
            f"{fine / expected:.4f}",
            off <= _CLOSE,
        )
    request, times = read_platform_request({}), []
    for _ in range(_REPETITIONS):
        before = time.perf_counter()
        platform(request)
        times.append(time.perf_counter() - before)
    taken = statistics.median(times)
    yield Row("two platforms bent", f"< {_WHOLE:g} s", f"{taken:.2f} s", "", "", taken < _WHOLE)
