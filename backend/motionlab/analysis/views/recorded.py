"""A stretch of a recording, the input of every view."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError

Array = NDArray[np.float64]

SAMPLES_MAX = 1_000_000
"""Most samples that a view is of: 500 s."""


@dataclass(frozen=True)
class Recorded:
    """A stretch of a recording.

    Attributes
    ----------
    variants : tuple of str
        Its variants.
    period : float
        Time between samples, s.
    first, stop : int
        Samples [first, stop) of the recording.
    column : callable
        Returns a column over the stretch in double precision, or None where there is none.
    path : callable
        Returns the reference positions, shape (samples, 2), of the stretch and of up to `AROUND`
        samples before and after it, and which of them is its first, m.
    scenario : Scenario or str
        As it was over the stretch, without schedule, or why it is not known.
    simulate : callable or None
        Returns the whole recording of a scenario, where this one was simulated, too.
    simulated : bool
        Whether it was simulated for this, and is no kept run.
    """

    variants: tuple[str, ...]
    period: float
    first: int
    stop: int
    column: Callable[[str], Array | None]
    path: Callable[[], tuple[Array, int]]
    scenario: Scenario | str
    simulate: Callable[[Scenario], Recorded] | None = None
    simulated: bool = False

    @property
    def start(self) -> float:
        """Time of the first sample, s."""
        return self.first * self.period

    @property
    def end(self) -> float:
        """Time after the last sample, s."""
        return self.stop * self.period

    @property
    def column_size(self) -> int:
        """Size of one column over the stretch, bytes."""
        return (self.stop - self.first) * np.float64().itemsize

    def needed(self, name: str) -> Array:
        """Return a column.

        Raises
        ------
        ConfigError
            If there is none of that name.
        """
        values = self.column(name)
        if values is None:
            raise absent(name)
        return values

    def reference(self) -> tuple[Array, Array]:
        """Return the reference position of both axes, m."""
        x, y = (self.needed(f"{axis}.position_reference") for axis in AXES)
        return x, y

    def whole(self, names: list[str]) -> list[Array] | None:
        """Return some columns, or None where one is not there or has a missing sample."""
        columns = [self.column(name) for name in names]
        known = [values for values in columns if values is not None and np.isfinite(values).all()]
        return known if len(known) == len(names) else None

    def count(self, axis: str) -> float:
        """Return the resolution of an encoder, m, or 0 where it is not known."""
        if isinstance(self.scenario, str):
            return 0.0
        return getattr(self.scenario.plant, axis).encoder.resolution


def absent(name: str) -> ConfigError:
    """Return the error about a channel that a recording does not have."""
    return ConfigError(FieldError("run", f"has no channel {name}", "absent"))


def stretch(start: float | None, end: float | None, ticks: int, period: float) -> tuple[int, int]:
    """Return samples [first, stop) of times; all, or the latest, where there are none.

    Raises
    ------
    ConfigError
        If the stretch is not in the recording, or too long.
    """
    last = ticks * period
    bounds: dict[str, float] = {"minimum": 0.0, "maximum": last}
    for name, time in (("start", start), ("end", end)):
        if time is not None and not 0.0 <= time <= last * (1 + 1e-9):
            raise ConfigError(FieldError(name, "is not in the recording", time, "", "s", bounds))
    stop = ticks if end is None else min(ticks, round(end / period))
    first = max(0, stop - SAMPLES_MAX) if start is None else round(start / period)
    if not 0 < stop - first <= SAMPLES_MAX:
        ends = {"exclusive_minimum": first * period, "maximum": (first + SAMPLES_MAX) * period}
        raise ConfigError(FieldError("end", "too few or too many samples", end, "", "s", ends))
    return first, stop
