"""The instrument: the spectrum of a long record."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator

import numpy as np

from motionlab.analysis.spectrum import peaks, spectrum
from motionlab.timing import CONTROL_PERIOD
from tests.bench.table import Row

_SECONDS = 240.0
_FFT = 0.1  # s
_REPETITIONS = 9


def instrument() -> Iterator[Row]:
    """Measure the spectrum of a channel of 240 s with its peaks, beside numpy's transform alone."""
    count = round(_SECONDS / CONTROL_PERIOD)
    samples = np.random.default_rng(2019).normal(size=count)
    samples += np.sin(2 * np.pi * 40.0 * CONTROL_PERIOD * np.arange(count))
    reference = _median(lambda: np.fft.rfft(samples))
    for averages in (1, 16):

        def find(averages: int = averages) -> None:
            peaks(spectrum(samples, period=CONTROL_PERIOD, window="hann", averages=averages))

        taken = _median(find)
        yield Row(
            f"spectrum of {count:,} samples, {averages} averages",
            f"< {_FFT * 1e3:g} ms",
            f"{taken * 1e3:.0f} ms",
            f"numpy rfft: {reference * 1e3:.0f} ms",
            f"{taken / reference:.1f}",
            taken < _FFT,
        )


def _median(call: Callable[[], object]) -> float:
    taken = []
    for _ in range(_REPETITIONS):
        before = time.perf_counter()
        call()
        taken.append(time.perf_counter() - before)
    return statistics.median(taken)
