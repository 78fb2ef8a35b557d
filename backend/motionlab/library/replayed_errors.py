"""Following errors of a run as recorded and as simulated again."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

_ERROR = ".following_error"


class ErrorChange(BaseModel):
    """Following error of an axis as recorded and as simulated again; null where it diverged."""

    variant: str
    axis: str
    max_recorded: float | None = Field(description="Largest following error, m")
    max_simulated: float | None = Field(description="m")
    max_change: float | None = Field(description="Simulated minus recorded, m")
    rms_recorded: float | None = Field(description="RMS following error, m")
    rms_simulated: float | None = Field(description="m")
    rms_change: float | None = Field(description="Simulated minus recorded, m")

    @property
    def size(self) -> float:
        """Larger change of the two, m; infinite where one side alone diverged, or another did."""
        if self.max_recorded is None and self.max_simulated is None:
            return 0.0
        changes = [self.max_change, self.rms_change]
        return max(np.inf if change is None else abs(change) for change in changes)


class ErrorChanges:
    """Sums and extremes of the following errors of a record and of its replay.

    Parameters
    ----------
    names : sequence of str
        Channels, in the order of the rows of `add`.
    window : tuple of int
        First tick that counts, and the one after the last.
    """

    def __init__(self, names: Sequence[str], window: tuple[int, int]) -> None:
        self._rows = [row for row, name in enumerate(names) if name.endswith(_ERROR)]
        self._names = [names[row].removesuffix(_ERROR) for row in self._rows]
        self._window = window
        self._peaks = np.zeros((2, len(self._rows)))
        self._squares = np.zeros((2, len(self._rows)))
        self._count = 0

    def add(
        self, start: int, recorded: NDArray[np.float32], simulated: NDArray[np.float32]
    ) -> None:
        """Add consecutive ticks, (channels, ticks); a missing sample makes its axis missing."""
        first, stop = (min(max(tick - start, 0), recorded.shape[1]) for tick in self._window)
        if first == stop:
            return
        for side, samples in enumerate((recorded, simulated)):
            errors = np.abs(samples[self._rows, first:stop].astype(np.float64))
            self._peaks[side] = np.maximum(self._peaks[side], errors.max(axis=1))
            self._squares[side] += np.square(errors).sum(axis=1)
        self._count += stop - first

    def changes(self) -> list[ErrorChange]:
        """Return them of each axis of each variant; none where no tick counts."""
        if not self._count:
            return []
        rms = np.sqrt(self._squares / self._count)
        return [
            self._change(name, self._peaks[:, row], rms[:, row])
            for row, name in enumerate(self._names)
        ]

    @staticmethod
    def _change(name: str, peaks: NDArray[np.float64], rms: NDArray[np.float64]) -> ErrorChange:
        variant, axis = name.rsplit(".", 1)
        values = (*peaks, peaks[1] - peaks[0], *rms, rms[1] - rms[0])
        finite = [float(value) if np.isfinite(value) else None for value in values]
        return ErrorChange(
            variant=variant,
            axis=axis,
            max_recorded=finite[0],
            max_simulated=finite[1],
            max_change=finite[2],
            rms_recorded=finite[3],
            rms_simulated=finite[4],
            rms_change=finite[5],
        )
