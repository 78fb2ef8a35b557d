"""Linear encoder: noise, sub-divisional error and quantisation."""

from __future__ import annotations

from typing import NamedTuple

from motionlab.lanes import Lanes, compiled, round_nearest, select
from motionlab.lanes.functions import sine_cosine


class Encoder(NamedTuple):
    """Encoder parameters of each lane."""

    resolution: Lanes  # size of one count, m; 0 for an exact encoder
    sde_amplitude: Lanes  # amplitude of the sub-divisional error, m
    sde_period: Lanes  # period of the scale that is subdivided, m


@compiled
def measure(encoder: Encoder, position: Lanes, noise: Lanes) -> Lanes:
    """Return the reading, m, at the true `position`, m, with additive `noise`, m.

    ``resolution round((p + A sin(2 pi p/period) + noise)/resolution)``
    """
    sine, _ = sine_cosine(position * (1.0 / encoder.sde_period))
    seen = position + encoder.sde_amplitude * sine + noise
    exact = encoder.resolution == 0.0
    counts = round_nearest(seen * (1.0 / select(exact, 1.0, encoder.resolution)))
    return select(exact, seen, encoder.resolution * counts)
