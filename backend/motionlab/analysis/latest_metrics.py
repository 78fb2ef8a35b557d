"""Metrics of the latest part of a motion that goes on."""

from __future__ import annotations

import dataclasses
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.metrics import variant_metrics
from motionlab.analysis.variant_comparison import compare
from motionlab.telemetry.recording import Recording
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.reference import Reference


class ReferencePath(NamedTuple):
    """Reference positions of a recording and of what is around it, in which contours are nearest.

    Attributes
    ----------
    position : ndarray of float64, shape (ticks, 2)
        m.
    first : int
        Which of them is that of the first sample of the recording.
    """

    position: NDArray[np.float64]
    first: int


def latest_metrics(
    recording: Recording, reference: Reference, path: ReferencePath, *, settling_band: float
) -> dict[str, Any]:
    """Return the metrics of everything that a recording holds; of no variant where it is empty.

    Holds and edges of the reference are left out: a motion that goes on has them elsewhere.

    Parameters
    ----------
    recording : Recording
        The latest past of a session.
    reference : Reference
        The motion that it was created with.
    path : ReferencePath
        The reference around the recording.
    settling_band : float
        Following error below which a move counts as settled, m.

    Returns
    -------
    dict
        ``window``, ``variants`` and ``comparison``, as in a result document.
    """
    start, end = recording.first_tick, recording.first_tick + recording.ticks
    window = {"start": start * CONTROL_PERIOD, "end": end * CONTROL_PERIOD}
    if recording.ticks == 0:
        return {"window": window, "variants": {}, "comparison": {}}
    position, ticks = path.position, (path.first, path.first + recording.ticks)
    followed = dataclasses.replace(
        reference,
        position=position,
        velocity=np.zeros_like(position),
        acceleration=np.zeros_like(position),
        holds=(),
        edges=(),
        window=ticks,
    )
    shifted = dataclasses.replace(recording, first_tick=ticks[0])
    variants = {
        name: variant_metrics(shifted, name, followed, ticks, settling_band=settling_band)
        for name in recording.variants
    }
    first, *others = variants
    comparison = compare(variants[first], variants[others[0]]) if others else {}
    return {"window": window, "variants": variants, "comparison": comparison}
