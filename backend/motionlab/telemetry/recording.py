"""Recording of a run: every channel of every variant, tick by tick."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.telemetry.channels import CHANNELS, REFERENCES, Channel
from motionlab.timing import CONTROL_PERIOD

_SHARED = len(AXES) * len(REFERENCES)
LAW_PREFIX = "law_"
"""Of names of channels of laws of one's own, which no other has."""
_INDEX = {channel.name: i for i, channel in enumerate(CHANNELS)}


@dataclass(frozen=True)
class Divergence:
    """Where and how a variant diverged.

    Attributes
    ----------
    tick : int
        First tick whose sample is invalid.
    channel : str
        Axis and channel that failed, such as ``x.following_error``.
    last_states : tuple of dict
        Samples of the last ticks up to and including `tick`: channel name to value.
    """

    tick: int
    channel: str
    last_states: tuple[dict[str, float], ...]

    @property
    def time(self) -> float:
        """Time of `tick`, s."""
        return self.tick * CONTROL_PERIOD


@dataclass(frozen=True)
class VariantRecord:
    """Samples of one variant.

    Attributes
    ----------
    samples : ndarray of float32, shape (channels, axes, ticks)
        In the order of CHANNELS and AXES; NaN from the tick of divergence on.
    diverged : Divergence or None
        None for a variant that reached the end.
    states : mapping of Channel to ndarray of float32, shape (axes, ticks)
        Numbers of the states of laws of one's own; NaN where another law was in effect.
    """

    samples: NDArray[np.float32]
    diverged: Divergence | None = None
    states: Mapping[Channel, NDArray[np.float32]] = field(default_factory=dict)

    def channel(self, name: str, axis: str) -> NDArray[np.float32]:
        """Return one channel of one axis, shape (ticks,); NaN of a law that it does not have."""
        if name.startswith(LAW_PREFIX):
            for channel, values in self.states.items():
                if channel.name == name:
                    return values[AXES.index(axis)]
            return np.full(self.samples.shape[2], np.nan, dtype=np.float32)
        return self.samples[_INDEX[name], AXES.index(axis)]

    def cut(self, start: int, stop: int) -> VariantRecord:
        """Return samples [start, stop), counted from the first that there is; a view."""
        states = {channel: values[:, start:stop] for channel, values in self.states.items()}
        return replace(self, samples=self.samples[:, :, start:stop], states=states)


@dataclass(frozen=True)
class Recording:
    """Every channel of a run.

    Attributes
    ----------
    references : ndarray, shape (4, axes, ticks)
        Position, velocity and acceleration reference and load force: REFERENCES, in float64.
    variants : dict of str to VariantRecord
        In the order of the scenario.
    first_tick : int
        Tick of the first sample; not 0 in a recording cut out of a longer run.
    """

    references: NDArray[np.float64]
    variants: dict[str, VariantRecord]
    first_tick: int = 0

    @property
    def ticks(self) -> int:
        """Number of recorded ticks."""
        return self.references.shape[2]

    def holds(self, window: tuple[int, int]) -> bool:
        """Return whether all ticks of [start, end) are recorded."""
        return self.first_tick <= window[0] and window[1] <= self.first_tick + self.ticks


def as_recording(
    start: int,
    data: NDArray[np.float32],
    failed: Mapping[str, int | None],
    references: NDArray[np.float64] | None = None,
    states: Sequence[tuple[str, Channel]] = (),
) -> Recording:
    """Return columns side by side, as `stream_columns` orders them, as a recording.

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
    states : sequence of (str, Channel)
        Name and channel of the columns after those: numbers of laws' states.
    """
    first = len(data) - len(states)
    named = dict(zip((name for name, _ in states), data[first:], strict=True))
    channels = {name: channel for name, channel in states if not np.isnan(named[name]).all()}
    shared = data[:_SHARED].reshape(len(AXES), len(REFERENCES), -1).transpose(1, 0, 2)
    own = data[_SHARED:first].reshape(len(failed), len(AXES), len(CHANNELS), -1)
    records = {
        name: VariantRecord(
            samples.transpose(1, 0, 2),
            # When and how matters to reports of whole runs only.
            None if tick is None else Divergence(tick, "", ()),
            states_of(name, named, channels),
        )
        for (name, tick), samples in zip(failed.items(), own, strict=True)
    }
    return Recording(
        shared.astype(np.float64) if references is None else references, records, start
    )


def states_of(
    variant: str, named: Mapping[str, NDArray[np.float32]], channels: Mapping[str, Channel]
) -> dict[Channel, NDArray[np.float32]]:
    """Return the states of a variant's law, (axes, ticks), that are there."""
    own = [channel for name, channel in channels.items() if name.startswith(f"{variant}.")]
    return {
        channel: np.stack([named[f"{variant}.{axis}.{channel.name}"] for axis in AXES])
        for channel in dict.fromkeys(own)
    }
