"""Contour error beside tracking error of a recording; docs/views.md."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from motionlab.analysis import path_errors as numbers
from motionlab.analysis.ballbar import ROUNDING
from motionlab.analysis.contouring import prolonged
from motionlab.analysis.views.recorded import Recorded
from motionlab.config.planar import AXES
from motionlab.errors import ConfigError, FieldError

Array = NDArray[np.float64]

_DIGITS = 12  # of a length in m: a picometre
_PATH_POINTS = 2000


class ContourPeak(BaseModel):
    """A peak of the contour error, and where the reference is then."""

    time: float = Field(description="s")
    arc: float = Field(description="Length of the path from the beginning of the stretch, m")
    x: float = Field(description="m")
    y: float = Field(description="m")
    contour: float = Field(description="Positive to the left of the path, m")


class ContourFigures(BaseModel):
    """Figures over the stretch."""

    contour_max: float = Field(description="Largest distance from the path, m")
    contour_rms: float = Field(description="m")
    tracking_max: float = Field(description="Largest length of the following error, m")
    tracking_rms: float = Field(description="m")
    along_max: float = Field(description="Largest following error along the path, m")
    along_rms: float = Field(description="m")
    across_max: float = Field(description="Largest following error across the path, m")
    across_rms: float = Field(description="m")
    lag_distance: float = Field(description="Mean lag along the path while it is followed, m")
    lag_time: float = Field(description="The same over the mean speed, s")


class ContourPoints(BaseModel):
    """Samples that are drawn: every extreme of contour and tracking error is among them."""

    time: list[float] = Field(description="s")
    arc: list[float] = Field(description="m")
    x: list[float] = Field(description="Nearest point of the path, m")
    y: list[float] = Field(description="m")
    off_x: list[float] = Field(description="Measured position less the nearest point, m")
    off_y: list[float] = Field(description="m")
    contour: list[float] = Field(description="m")
    tracking: list[float] = Field(description="m")
    along: list[float] = Field(description="Positive where the mover is behind, m")
    across: list[float] = Field(description="Positive to the left, m")


class ContouringVariant(BaseModel):
    """One variant."""

    figures: ContourFigures
    peaks: list[ContourPeak] = Field(description="Largest first")
    points: ContourPoints


class Contouring(BaseModel):
    """Contour error beside tracking error."""

    start: float = Field(description="s")
    end: float = Field(description="s")
    length: float = Field(description="Of the path, m")
    path_x: list[float] = Field(description="Reference, some samples of it, m")
    path_y: list[float] = Field(description="m")
    variants: dict[str, ContouringVariant | None] = Field(
        description="null where a sample of the following error is missing"
    )


def contouring(recorded: Recorded) -> Contouring:
    """Return contour error and tracking error of a recording.

    Raises
    ------
    ConfigError
        If its reference moves along one axis only, or not at all.
    """
    known, first = recorded.path()
    path, window = prolonged(known, (first, first + recorded.stop - recorded.first))
    position = path[slice(*window)]
    _refuse_one_axis(position)
    tangent = numbers.tangents(_directions(recorded, position))
    shown = np.unique(np.linspace(0, len(position) - 1, _PATH_POINTS).astype(int))
    return Contouring(
        start=recorded.start,
        end=recorded.end,
        length=float(numbers.arc_length(position)[-1]),
        path_x=np.round(position[shown, 0], _DIGITS).tolist(),
        path_y=np.round(position[shown, 1], _DIGITS).tolist(),
        variants={
            name: _variant(recorded, name, path, window, tangent) for name in recorded.variants
        },
    )


def _refuse_one_axis(position: Array) -> None:
    resting = [
        axis for axis, size in zip(AXES, np.ptp(position, axis=0), strict=True) if size <= ROUNDING
    ]
    if not resting:
        return
    message = (
        "moves along one axis only: the contour error is across a path of two axes, and along one "
        "it is the following error, which the scopes show"
    )
    if len(resting) == len(AXES):
        message = "rests over the whole stretch: a contour error needs a path"
    raise ConfigError(FieldError("trajectory", message, f"{' and '.join(resting)} at rest"))


def _directions(recorded: Recorded, position: Array) -> Array:
    """Return the velocity of the reference, by differences where it was not recorded."""
    known = recorded.whole([f"{axis}.velocity_reference" for axis in AXES])
    if known is not None and any(values.any() for values in known):
        return np.stack(known, axis=1)
    return np.gradient(position, axis=0)


def _variant(
    recorded: Recorded, name: str, path: Array, window: tuple[int, int], tangent: Array
) -> ContouringVariant | None:
    known = recorded.whole([f"{name}.{axis}.following_error" for axis in AXES])
    if known is None:
        return None
    errors = numbers.path_errors(path, window, tangent, np.stack(known, axis=1))
    position = path[slice(*window)]
    drawn = numbers.drawn_samples(errors)
    foot = errors.foot[drawn]
    off = -np.stack(known, axis=1)[drawn] - foot
    on_path = position[drawn] + foot
    columns = {
        "time": recorded.start + drawn * recorded.period,
        "x": on_path[:, 0],
        "y": on_path[:, 1],
        "off_x": off[:, 0],
        "off_y": off[:, 1],
    } | {each: getattr(errors, each)[drawn] for each in ("arc", *_ERRORS)}
    return ContouringVariant(
        figures=ContourFigures(**asdict(numbers.figures_of(errors, recorded.period))),
        peaks=[
            ContourPeak(
                time=recorded.start + peak.sample * recorded.period,
                arc=float(errors.arc[peak.sample]),
                x=float(position[peak.sample, 0]),
                y=float(position[peak.sample, 1]),
                contour=peak.contour,
            )
            for peak in numbers.peaks_of(errors)
        ],
        points=ContourPoints(
            **{each: np.round(values, _DIGITS).tolist() for each, values in columns.items()}
        ),
    )


_ERRORS = ("contour", "tracking", "along", "across")
