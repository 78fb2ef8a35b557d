"""The latest seconds of a session: every sample of every channel."""

from __future__ import annotations

import json
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.config.timing import to_ticks
from motionlab.simulation.simulation import Simulation, sample_page, variant_columns
from motionlab.telemetry.channels import CHANNELS, REFERENCES, stream_columns
from motionlab.telemetry.recording import Divergence, Recording, VariantRecord
from motionlab.telemetry.ring import Ring

RING_SECONDS = 30.0
_SHARED = len(AXES) * len(REFERENCES)


class History:
    """Recent samples and metrics of a session.

    Parameters
    ----------
    variants : list of str
        Their names.

    Attributes
    ----------
    columns : list of (str, Channel)
        Name and channel of each column of the ring.
    rows : dict of str to int
        Row of each column, by its name.
    columns_json : str
        The columns as a stream announces them.
    ring : Ring
        The samples.
    """

    def __init__(self, variants: list[str]) -> None:
        self.columns = stream_columns(variants)
        self.ring = Ring(len(self.columns), to_ticks(RING_SECONDS))
        self.rows = {name: row for row, (name, _) in enumerate(self.columns)}
        self.columns_json = json.dumps(
            [
                {"name": name, "unit": channel.unit, "meaning": channel.meaning}
                for name, channel in self.columns
            ],
            separators=(",", ":"),
        )
        self._variants = variants
        self._payload_end = -1
        self._payloads: dict[tuple[tuple[int, ...], int, int], bytes] = {}
        self._page = sample_page(len(variants))

    def record(self, simulation: Simulation, ticks: int) -> None:
        """Advance a simulation by some ticks, or to its end, and keep every sample."""
        until = simulation.tick + ticks
        while simulation.tick < until:
            start = simulation.tick
            room = self.ring.room(until - start)
            count = simulation.advance(self._page[:, : room.shape[1]])
            if count == 0:
                break
            room[:_SHARED, :count] = simulation.asked(start, start + count)
            own = room[_SHARED:, :count].reshape(-1, len(AXES), len(CHANNELS), count)
            for variant, failed in enumerate(simulation.failed_ticks):
                rows = own[variant]
                rows[:] = variant_columns(self._page, variant, count).transpose(1, 0, 2)
                if failed is not None:
                    rows[..., max(0, failed - start) :] = np.nan
            self.ring.fill(count)

    def payload(self, rows: tuple[int, ...], start: int, stop: int) -> bytes:
        """Return ticks [start, stop) of some rows as a frame holds them; clients share them.

        Raises
        ------
        IndexError
            If the ring does not hold them.
        """
        key = (rows, start, stop)
        if stop != self._payload_end:
            self._payloads.clear()
            self._payload_end = stop
        if key not in self._payloads:
            columns = self.ring.read(np.array(rows, np.intp), start, stop)
            self._payloads[key] = np.ascontiguousarray(columns, dtype="<f4").tobytes()
        return self._payloads[key]

    def recording(
        self,
        simulation: Simulation,
        length: int | None = None,
        *,
        braked: bool,
        end: int | None = None,
    ) -> Recording:
        """Return the latest ticks; safe while another thread records.

        Parameters
        ----------
        simulation : Simulation
            What was recorded.
        length : int, optional
            Ticks at most; all that the ring holds when left out.
        braked : bool
            Whether a stop has left the trajectory, which otherwise gives the reference in float64.
        end : int, optional
            Tick before which they end; the newest one when left out.
        """
        start, data = self.latest(length, end)
        references = None
        if not braked:
            position, velocity, acceleration, _ = simulation.timeline.at(
                start, start + data.shape[1]
            )
            load = data[:_SHARED].reshape(len(AXES), len(REFERENCES), -1)[:, -1]
            references = np.stack([position.T, velocity.T, acceleration.T, load.astype(np.float64)])
        failed = dict(zip(self._variants, simulation.failed_ticks, strict=True))
        return as_recording(start, data, failed, references)

    def latest(
        self, length: int | None, before: int | None = None
    ) -> tuple[int, NDArray[np.float32]]:
        """Return the first tick and the columns of the latest ticks, or of those before a tick.

        The oldest ticks may be overwritten while they are copied: then fewer are taken.
        """
        length = self.ring.capacity if length is None else length
        while True:
            first = self.ring.first
            end = self.ring.end if before is None else max(before, first)
            start = max(first, end - length)
            try:
                return start, self.ring.read(slice(None), start, end)
            except IndexError:
                length -= -(-length // 16)


def as_recording(
    start: int,
    data: NDArray[np.float32],
    failed: Mapping[str, int | None],
    references: NDArray[np.float64] | None = None,
) -> Recording:
    """Return columns of a ring as a recording.

    Parameters
    ----------
    start : int
        Tick of the first sample.
    data : ndarray of float32, shape (columns, ticks)
        All columns.
    failed : mapping of str to int or None
        Of each variant the tick at which it diverged.
    references : ndarray, shape (references, 2, ticks), optional
        The references in full precision; those of the ring when left out.
    """
    shared = data[:_SHARED].reshape(len(AXES), len(REFERENCES), -1).transpose(1, 0, 2)
    own = data[_SHARED:].reshape(len(failed), len(AXES), len(CHANNELS), -1)
    records = {
        name: VariantRecord(
            samples.transpose(1, 0, 2),
            # When and how matters to reports of whole runs only.
            None if tick is None else Divergence(tick, "", ()),
        )
        for (name, tick), samples in zip(failed.items(), own, strict=True)
    }
    return Recording(
        shared.astype(np.float64) if references is None else references, records, start
    )
