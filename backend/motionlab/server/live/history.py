"""The latest seconds of a session: every sample of every channel."""

from __future__ import annotations

import json

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.contouring import AROUND
from motionlab.analysis.latest_metrics import ReferencePath
from motionlab.config.planar import AXES
from motionlab.simulation.machine import Machine
from motionlab.simulation.record import record
from motionlab.simulation.simulation import sample_page
from motionlab.telemetry.channels import REFERENCES
from motionlab.telemetry.law_channels import all_columns, any_law, state_columns
from motionlab.telemetry.recording import Recording, as_recording
from motionlab.telemetry.ring import Ring
from motionlab.telemetry.thinning import thinned
from motionlab.timing import to_ticks

RING_SECONDS = 30.0
_SHARED = len(AXES) * len(REFERENCES)


def path_of(recording: Recording, simulation: Machine) -> ReferencePath:
    """Return the reference of a recording and around it, in what is still to come too."""
    first, end = recording.first_tick, recording.first_tick + recording.ticks
    begin = max(0, first - AROUND)
    position, *_ = simulation.timeline.at(begin, end + AROUND)
    return ReferencePath(position, first - begin)


class History:
    """Recent samples and metrics of a session.

    Attributes
    ----------
    columns, states : list of (str, Channel)
        Every column, and the last of them: those of the states of laws of one's own.
    """

    def __init__(self, variants: list[str]) -> None:
        self._states = state_columns(any_law(variants))
        self.columns = all_columns(any_law(variants))
        self.states = self.columns[len(self.columns) - len(self._states) :]
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
        self._payloads: dict[tuple[tuple[int, ...], int, int, int], bytes] = {}
        self._page = sample_page(len(variants), states=bool(self._states))

    def laws_changed(self) -> None:
        """Find states in the rows in which laws have them now; columns stay what they are."""
        rows = {each.name: each.rows for each in state_columns(any_law(self._variants), most=None)}
        self._states = [each._replace(rows=rows.get(each.name, {})) for each in self._states]

    def record(self, simulation: Machine, ticks: int) -> None:
        """Advance a simulation by some ticks, or to its end, and keep every sample."""
        until = simulation.tick + ticks
        while simulation.tick < until:
            count = record(
                simulation, self._page, self.ring.room(until - simulation.tick), self._states
            )
            if count == 0:
                break
            self.ring.fill(count)

    def payload(self, rows: tuple[int, ...], start: int, stop: int, stride: int = 1) -> bytes:
        """Return ticks [start, stop) of some rows as a frame holds them; clients share them.

        Parameters
        ----------
        rows : tuple of int
            Which columns.
        start, stop : int
            Ticks; whole bins of `2 * stride` where `stride` is above 1.
        stride : int
            Ticks that a sample stands for.

        Raises
        ------
        IndexError
            If the ring does not hold them.
        """
        key = (rows, start, stop, stride)
        if stop != self._payload_end:
            self._payloads.clear()
            self._payload_end = stop
        if key not in self._payloads:
            columns = self.ring.read(np.array(rows, np.intp), start, stop)
            if stride > 1:
                columns = thinned(columns, stride)
            self._payloads[key] = np.ascontiguousarray(columns, dtype="<f4").tobytes()
        return self._payloads[key]

    def recording(
        self,
        simulation: Machine,
        length: int | None = None,
        *,
        braked: bool,
        end: int | None = None,
    ) -> Recording:
        """Return the latest ticks; safe while another thread records.

        Parameters
        ----------
        simulation : Machine
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
        return as_recording(start, data, failed, references, self.states)

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
