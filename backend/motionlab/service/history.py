"""The latest seconds of a session: every sample of every channel."""

from __future__ import annotations

import numpy as np

from motionlab.config.planar import AXES
from motionlab.config.timing import to_ticks
from motionlab.simulation.simulation import Simulation, sample_page, variant_columns
from motionlab.telemetry.channels import CHANNELS, REFERENCES, stream_columns
from motionlab.telemetry.recording import Divergence, Recording, VariantRecord
from motionlab.telemetry.ring import Ring

RING_SECONDS = 30.0
_SHARED = len(AXES) * len(REFERENCES)


class History:
    """What a session has done of late.

    Parameters
    ----------
    variants : list of str
        Their names.

    Attributes
    ----------
    columns : list of (str, Channel)
        Name and channel of each column of the ring.
    ring : Ring
        The samples.
    """

    def __init__(self, variants: list[str]) -> None:
        self.columns = stream_columns(variants)
        self.ring = Ring(len(self.columns), to_ticks(RING_SECONDS))
        self._variants = variants
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

    def recording(self, simulation: Simulation, start: int, *, braked: bool) -> Recording:
        """Return what there is from tick `start` on.

        Parameters
        ----------
        simulation : Simulation
            What was recorded.
        start : int
            A tick that the ring holds.
        braked : bool
            Whether a stop has left the trajectory, which else tells the reference in float64.
        """
        data = self.ring.read(slice(None), start, self.ring.end)
        shared = data[:_SHARED].reshape(len(AXES), len(REFERENCES), -1).transpose(1, 0, 2)
        position, velocity, acceleration, _ = simulation.timeline.at(start, self.ring.end)
        exact = np.stack([position.T, velocity.T, acceleration.T, shared[-1]])
        own = data[_SHARED:].reshape(len(self._variants), len(AXES), len(CHANNELS), -1)
        records = {
            name: VariantRecord(
                samples.transpose(1, 0, 2),
                # Of when and how, metrics need to know nothing.
                None if failed is None else Divergence(failed, "", ()),
            )
            for name, samples, failed in zip(
                self._variants, own, simulation.failed_ticks, strict=True
            )
        }
        return Recording(exact if not braked else shared.astype(np.float64), records, start)
