"""Circular test, ISO 230-4 style, on the encoder of a motor that follows a circle.

The reference is p_r = c + R u(phi), u = (cos phi, sin phi), and the measured position p_r - e. The
radial deviation at the angle theta of the measured position about c is::

    F = abs(R u - e) - R = (abs(e)^2 - 2 R u.e) / (abs(R u - e) + R)

whose second form loses no digit of e. ISO 230-4 defines F, the circular deviation G of one
direction, that of both, G(b), and the circular hysteresis H. Here circles are fitted by least
squares, F is about the centre of the reference, and the instrument is the encoder: the style of a
test, not a test of a machine.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.glitches import glitches
from motionlab.config.planar import AXES
from motionlab.errors import ConfigError, FieldError

Array = NDArray[np.float64]
Direction = Literal["ccw", "cw"]

GRID = 720
"""Points of a drawn lap: half a degree apart."""

ROUND = 1e-6
"""How far a circle may be from one, of its radius, beside `ROUNDING`."""

ROUNDING = 30e-9
"""What recorded references of the stroke are rounded by at most, and some, m."""

_WHOLE = 1e-6
"""How much a lap may miss of 2 pi, rad."""
_SHORTEST = 64
"""Least samples of a lap."""


class Circle(NamedTuple):
    """A circle: centre and radius, m."""

    x: float
    y: float
    radius: float


class Lap(NamedTuple):
    """The last whole lap in one direction, and the stretch in that direction that it ends.

    Samples [start, stop) are the lap; [begin, stop) goes in its direction.
    """

    circle: Circle
    direction: Direction
    begin: int
    start: int
    stop: int


@dataclass(frozen=True)
class Harmonics:
    """F = mean + offset_x cos + offset_y sin + cos_2 cos 2 theta + sin_2 sin 2 theta, m."""

    mean: float
    offset_x: float
    offset_y: float
    cos_2: float
    sin_2: float


@dataclass(frozen=True)
class DirectionFigures:
    """Figures of one lap in one direction.

    Attributes
    ----------
    F_max, F_min : float
        Largest and least radial deviation about the centre of the reference, m.
    G : float
        Circular deviation: largest less least distance from the centre of the least-squares
        circle, m.
    harmonics : Harmonics
        Fitted together by least squares.
    quadrants : tuple of float or None
        At 0, 90, 180 and 270 degrees: by how much F changes where an axis reverses, outwards
        positive, measured as `results.glitches` does, m; None where the record is too short.
    """

    F_max: float
    F_min: float
    G: float
    harmonics: Harmonics
    quadrants: tuple[float | None, ...]


@dataclass(frozen=True)
class BothFigures:
    """Figures of both directions together.

    Attributes
    ----------
    G : float
        Bi-directional circular deviation G(b): as G, both laps about one least-squares circle, m.
    H : float
        Circular hysteresis: largest difference of both radial deviations at one angle, of means
        over half a degree, m.
    radius_error : float
        Mean radius less R, m.
    offset_x, offset_y : float
        Centre of the least-squares circle less that of the reference, m.
    squareness : float
        By how much the angle between the axes is less than a right angle, rad: F has the term
        R squareness/2 sin 2 theta in both directions.
    scale_mismatch : float
        Scale of x less that of y, 1: the term R mismatch/2 cos 2 theta in both directions.
    servo_mismatch : float
        By how much x lags more than y, s: R w mismatch/2 sin 2 theta, whose sign is that of the
        direction, positive counter-clockwise.
    """

    G: float
    H: float
    radius_error: float
    offset_x: float
    offset_y: float
    squareness: float
    scale_mismatch: float
    servo_mismatch: float


def circle_of(x: Array, y: Array) -> Circle:
    """Return the circle that a reference lies on.

    Parameters
    ----------
    x, y : ndarray, shape (samples,)
        Reference position, m.

    Raises
    ------
    ConfigError
        If it lies on none; by how much it does not is named.
    """
    circle = _fitted(x, y)
    off = math.inf if circle is None else _off(circle, x, y)
    if circle is None or off > ROUNDING + ROUND * circle.radius:
        message = (
            "is no circle: a circular test needs a reference that is one, such as kind = 'circle'"
        )
        raise ConfigError(
            FieldError(
                "trajectory",
                message,
                "a line or a point" if circle is None else f"{1e6 * off:.3g} um off the nearest",
            )
        )
    return circle


def _fitted(x: Array, y: Array) -> Circle | None:
    if len(x) < 3 or not (np.isfinite(x).all() and np.isfinite(y).all()):
        return None
    middle_x, middle_y = float(x.mean()), float(y.mean())
    own_x, own_y = x - middle_x, y - middle_y
    size = float(np.hypot(own_x, own_y).max())
    if size < ROUNDING:
        return None
    own_x, own_y = own_x / size, own_y / size
    terms = np.stack([2 * own_x, 2 * own_y, np.ones_like(own_x)], axis=1)
    (a, b, c), _, rank, _ = np.linalg.lstsq(terms, own_x**2 + own_y**2, rcond=1e-6)
    if rank < 3 or c + a * a + b * b <= 0.0:
        return None
    radius = size * math.sqrt(c + a * a + b * b)
    return Circle(middle_x + size * float(a), middle_y + size * float(b), radius)


def _off(circle: Circle, x: Array, y: Array) -> float:
    distance = np.hypot(x - circle.x, y - circle.y)
    return float(np.abs(distance - circle.radius).max())


def last_laps(circle: Circle, x: Array, y: Array) -> dict[Direction, Lap]:
    """Return the last whole lap of each direction in which there is one.

    Parameters
    ----------
    circle : Circle
        What the reference lies on.
    x, y : ndarray, shape (samples,)
        Reference position, m.
    """
    angle = np.unwrap(np.arctan2(y - circle.y, x - circle.x))
    step = np.diff(angle)
    moving = np.flatnonzero(np.abs(step) > ROUNDING / circle.radius)
    laps: dict[Direction, Lap] = {}
    if len(moving) == 0:
        return laps
    ways = np.sign(step[moving])
    cuts = np.flatnonzero(np.diff(ways)) + 1
    for first, last in zip([0, *cuts], [*cuts, len(moving)], strict=True):
        begin, stop = int(moving[first]), int(moving[last - 1]) + 2
        turned = np.abs(angle[stop - 1] - angle[begin:stop])
        own = abs(float(step[stop - 2]))
        if turned[0] + own < 2 * math.pi - _WHOLE:
            continue
        start = begin + int(np.argmax(turned < 2 * math.pi - max(_WHOLE, own / 2)))
        if stop - start >= _SHORTEST:
            direction: Direction = "ccw" if ways[first] > 0 else "cw"
            laps[direction] = Lap(circle, direction, begin, start, stop)
    return laps


def deviation(
    circle: Circle, x: Array, y: Array, error_x: Array, error_y: Array
) -> tuple[Array, Array]:
    """Return angle, 0 to 2 pi, and radial deviation of the measured position, rad and m.

    Parameters
    ----------
    circle : Circle
        What the reference lies on.
    x, y : ndarray, shape (samples,)
        Reference position, m.
    error_x, error_y : ndarray, shape (samples,)
        Following error, m.
    """
    angle = np.arctan2(y - circle.y, x - circle.x)
    radius = circle.radius
    across, along = np.cos(angle), np.sin(angle)
    there_x, there_y = radius * across - error_x, radius * along - error_y
    squared = error_x**2 + error_y**2 - 2 * radius * (across * error_x + along * error_y)
    deviation = squared / (np.hypot(there_x, there_y) + radius)
    return np.arctan2(there_y, there_x) % (2 * math.pi), deviation


def figures_of(theta: Array, F: Array, quadrants: tuple[float | None, ...]) -> DirectionFigures:
    """Return the figures of a lap from its angles, rad, and radial deviations, m."""
    values, _ = _least_squares(theta, F, 5)
    return DirectionFigures(
        F_max=float(F.max()),
        F_min=float(F.min()),
        G=_out_of_round(theta, F),
        harmonics=Harmonics(*values.tolist()),
        quadrants=quadrants,
    )


def both_figures(
    radius: float, rate: float, ccw: tuple[Array, Array], cw: tuple[Array, Array]
) -> BothFigures:
    """Return the figures of both directions.

    Parameters
    ----------
    radius : float
        Of the reference, m.
    rate : float
        Angular speed, rad/s, larger than 0.
    ccw, cw : tuple of ndarray
        Angles, rad, and radial deviations, m, of a lap in each direction.
    """
    each = [_least_squares(*lap, 5)[0] for lap in (ccw, cw)]
    mean, half = (each[0] + each[1]) / 2, (each[0] - each[1]) / 2
    theta, F = (np.concatenate(pair) for pair in zip(ccw, cw, strict=True))
    return BothFigures(
        G=_out_of_round(theta, F),
        H=float(np.abs(on_grid(*ccw) - on_grid(*cw)).max()),
        radius_error=float(mean[0]),
        offset_x=float(mean[1]),
        offset_y=float(mean[2]),
        squareness=float(2 * mean[4] / radius),
        scale_mismatch=float(2 * mean[3] / radius),
        servo_mismatch=float(2 * half[4] / (radius * rate)),
    )


def _least_squares(theta: Array, F: Array, terms: int) -> tuple[Array, Array]:
    """Return the first of 1, cos, sin, cos 2 theta, sin 2 theta that fit F, and what is left."""
    shapes = [np.ones_like(theta), np.cos(theta), np.sin(theta)]
    shapes += [np.cos(2 * theta), np.sin(2 * theta)]
    matrix = np.stack(shapes[:terms], axis=1)
    values: Array = np.linalg.lstsq(matrix, F, rcond=None)[0].astype(np.float64)
    left: Array = (F - matrix @ values).astype(np.float64)
    return values, left


def _out_of_round(theta: Array, F: Array) -> float:
    _, left = _least_squares(theta, F, 3)
    return float(left.max() - left.min())


def grid() -> Array:
    """Return the angles of a drawn lap, rad."""
    return ((np.arange(GRID) + 0.5) * (2 * math.pi / GRID)).astype(np.float64)


def on_grid(theta: Array, F: Array) -> Array:
    """Return the mean of F over each half degree; straight lines over those without a sample."""
    place = np.minimum((theta * (GRID / (2 * math.pi))).astype(int), GRID - 1)
    count = np.bincount(place, minlength=GRID)
    total = np.bincount(place, weights=F, minlength=GRID)
    known = count > 0
    mean: Array = (total[known] / count[known]).astype(np.float64)
    return np.interp(grid(), grid()[known], mean, period=2 * math.pi).astype(np.float64)


def quadrant_heights(
    lap: Lap,
    reference: tuple[Array, Array],
    F: Array,
    *,
    counts: tuple[float, float],
    period: float,
) -> tuple[float | None, ...]:
    """Return by how much the radial deviation changes where an axis reverses.

    Parameters
    ----------
    lap : Lap
        Which lap; what goes before it in the same direction is looked at, too.
    reference : tuple of ndarray, each of shape (samples,)
        Reference position x and y, m.
    F : ndarray, shape (samples,)
        Radial deviation, m.
    counts : tuple of float
        Of both encoders, m.
    period : float
        Of the samples, s.

    Returns
    -------
    tuple of float or None
        At 0, 90, 180 and 270 degrees, m, the last that is there; outwards positive.
    """
    own = slice(lap.begin, lap.stop)
    x, y = (each[own] for each in reference)
    angle = np.arctan2(y - lap.circle.y, x - lap.circle.x)
    sense = 1.0 if lap.direction == "ccw" else -1.0
    velocities = (-sense * np.sin(angle), sense * np.cos(angle))
    least = (lap.stop - lap.start) // 8  # of the lap after a reversal
    heights: list[float | None] = [None] * 4
    for velocity, count, _ in zip(velocities, counts, AXES, strict=True):
        moved = np.where(np.abs(velocity) < 1e-9, 0.0, velocity)
        for one in glitches(moved, F[own], count=count, period=period):
            if len(moved) - one.tick >= least:
                heights[round(angle[one.tick] / (math.pi / 2)) % 4] = one.height
    return tuple(heights)
