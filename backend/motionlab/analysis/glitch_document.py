"""Quadrant glitches of a recording: every reversal of every axis, variant by variant."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from motionlab.analysis.glitches import BEFORE, Glitch, aligned, glitches, reversals
from motionlab.config.planar import AXES

AFTER_MAX = 0.2
"""Most time after a reversal of the aligned curves, s."""

POINTS = 500
"""Most points of an aligned curve."""

_DIGITS = 12  # of a length in m: a picometre


class GlitchRow(BaseModel):
    """One reversal under one variant."""

    time: float = Field(description="When the reference turns, s")
    direction: int = Field(description="1 or -1: the direction from then on")
    height: float = Field(description="From before the reversal to the peak after it, signed, m")
    delay: float | None = Field(description="From the reversal to a tenth of the height, s")
    rise: float | None = Field(description="From a tenth to nine tenths of the height, s")
    duration: float | None = Field(description="From the reversal until the error settles, s")


class GlitchMean(BaseModel):
    """Means over the reversals; of times, over those that have one."""

    height: float = Field(description="Of the heights without their signs, m")
    delay: float | None = Field(description="s")
    rise: float | None = Field(description="s")
    duration: float | None = Field(description="s")


class AlignedError(BaseModel):
    """The error of all reversals, each from its value before and in the new direction, m."""

    start: float = Field(description="Time of the first point after the reversal, s; below 0")
    step: float = Field(description="Time between points, s")
    mean: list[float]
    low: list[float] = Field(description="Least of all reversals")
    high: list[float] = Field(description="Largest of all reversals")


class VariantGlitches(BaseModel):
    """What one variant does at the reversals of one axis."""

    rows: list[GlitchRow]
    mean: GlitchMean
    aligned: AlignedError = Field(repr=False)


class AxisGlitches(BaseModel):
    """The reversals of one axis."""

    count: float = Field(description="Of the encoder, m; 0 where it is not known or has no steps")
    variants: dict[str, VariantGlitches]


class RunGlitches(BaseModel):
    """The quadrant glitches of a run; an axis that never reverses is left out."""

    axes: dict[str, AxisGlitches]


def glitches_of(
    variants: Sequence[str],
    column: Callable[[str], NDArray[np.float64] | None],
    *,
    counts: Mapping[str, float],
    period: float,
) -> RunGlitches:
    """Return what the following errors of a recording do at its reversals.

    Parameters
    ----------
    variants : sequence of str
        Its variants.
    column : callable
        Returns a whole column by its name, or None where there is none.
    counts : mapping of str to float
        The resolution of each axis's encoder, m, or 0.
    period : float
        Time between samples, s.
    """
    axes = {}
    for axis in AXES:
        velocity = column(f"{axis}.velocity_reference")
        if velocity is None:
            position = column(f"{axis}.position_reference")
            velocity = None if position is None else np.gradient(position, period)
        if velocity is None or not reversals(velocity):
            continue
        by_variant = {}
        for name in variants:
            error = column(f"{name}.{axis}.following_error")
            if error is None:
                continue
            if peaks := glitches(velocity, error, count=counts[axis], period=period):
                by_variant[name] = _variant(peaks, error, velocity, period)
        if by_variant:
            axes[axis] = AxisGlitches(count=counts[axis], variants=by_variant)
    return RunGlitches(axes=axes)


def _variant(
    peaks: list[Glitch],
    error: NDArray[np.float64],
    velocity: NDArray[np.float64],
    period: float,
) -> VariantGlitches:
    shortest = min(turn.end - turn.tick for turn in reversals(velocity))
    after = min(shortest, round(AFTER_MAX / period))
    curves = aligned(error, peaks, before=round(BEFORE / period), after=after)
    every = max(1, -(-curves.shape[1] // POINTS))
    bins = np.arange(0, curves.shape[1], every)
    low = np.minimum.reduceat(curves.min(axis=0), bins)
    high = np.maximum.reduceat(curves.max(axis=0), bins)
    middle = np.add.reduceat(curves.mean(axis=0), bins) / np.diff([*bins, curves.shape[1]])

    def mean(name: str) -> float | None:
        values = [getattr(one, name) for one in peaks if getattr(one, name) is not None]
        return float(np.mean(values)) if values else None

    return VariantGlitches(
        rows=[
            GlitchRow(
                time=one.tick * period,
                direction=one.direction,
                height=one.height,
                delay=one.delay,
                rise=one.rise,
                duration=one.duration,
            )
            for one in peaks
        ],
        mean=GlitchMean(
            height=float(np.mean([abs(one.height) for one in peaks])),
            delay=mean("delay"),
            rise=mean("rise"),
            duration=mean("duration"),
        ),
        aligned=AlignedError(
            start=-round(BEFORE / period) * period,
            step=every * period,
            mean=np.round(middle, _DIGITS).tolist(),
            low=np.round(low, _DIGITS).tolist(),
            high=np.round(high, _DIGITS).tolist(),
        ),
    )
