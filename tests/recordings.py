"""Recordings and references made up by tests, without a simulation."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motionlab.config.planar import AXES
from motionlab.telemetry.channels import CHANNELS, REFERENCES
from motionlab.telemetry.recording import Divergence, Recording, VariantRecord
from motionlab.trajectories.reference import Interval, Reference

NAMES = [channel.name for channel in CHANNELS]

Channels = Mapping[str, ArrayLike]
"""Values by axis and channel, such as ``x.thrust``; all other channels are zero."""


def make_recording(
    ticks: int, variants: Mapping[str, Channels], diverged: Mapping[str, Divergence] | None = None
) -> Recording:
    """Return a recording whose references are zero and whose variants hold the given channels."""
    records = {}
    for variant, channels in variants.items():
        samples = np.zeros((len(CHANNELS), len(AXES), ticks), dtype=np.float32)
        for key, values in channels.items():
            axis, name = key.split(".")
            samples[NAMES.index(name), AXES.index(axis)] = values
        records[variant] = VariantRecord(samples, (diverged or {}).get(variant))
    return Recording(np.zeros((len(REFERENCES), len(AXES), ticks)), records)


def make_reference(
    position: NDArray[np.float64],
    *,
    holds: tuple[Interval, ...] = (),
    edges: tuple[Interval, ...] = (),
) -> Reference:
    """Return a reference with these positions, shape (ticks, 2); no derivatives."""
    nothing = np.zeros_like(position)
    return Reference(
        position=position,
        velocity=nothing,
        acceleration=nothing,
        end=(float(position[-1, 0]), float(position[-1, 1])),
        moving=tuple(axis for axis, way in zip(AXES, np.ptp(position, axis=0), strict=True) if way),
        window=(0, len(position)),
        holds=holds,
        edges=edges,
        period=0,
    )


def noise(ticks: int, seed: int = 1) -> Recording:
    """Return a recording of two variants full of numbers."""
    draw = np.random.default_rng(seed).normal
    shape = (len(CHANNELS), len(AXES), ticks)
    variants = {name: VariantRecord(draw(size=shape).astype(np.float32)) for name in "AB"}
    return Recording(draw(size=(len(REFERENCES), len(AXES), ticks)), variants)
