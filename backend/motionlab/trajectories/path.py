"""Path geometry as a function of a parameter q, supplied by a motion profile.

A path maps q of shape (n,) to the position (n, 2) in m and its first two derivatives with respect
to q. It is independent of time; `motionlab.trajectories.motion_profile` is independent of the path.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Vector = tuple[float, float]
Path = Callable[[Array], tuple[Array, Array, Array]]


def ray(start: Vector, direction: Vector) -> Path:
    """Return the path start + direction q.

    Parameters
    ----------
    start : tuple of float
        Position at q = 0, m.
    direction : tuple of float
        Displacement per unit of q, m.
    """
    origin, slope = np.array(start), np.array(direction)

    def at(q: Array) -> tuple[Array, Array, Array]:
        place = origin + slope * q[:, None]
        return place, np.broadcast_to(slope, place.shape), np.zeros_like(place)

    return at


def line(start: Vector, end: Vector) -> Path:
    """Return the straight path from `start` (q = 0) to `end` (q = 1), both in m."""
    return ray(start, (end[0] - start[0], end[1] - start[1]))


def parabola(start: Vector, coefficient: Vector) -> Path:
    """Return the path start + R q^2 of eq (40).

    Parameters
    ----------
    start : tuple of float
        Position at q = 0, m.
    coefficient : tuple of float
        R per axis, half of the second derivative.
    """
    origin, half_second = np.array(start), np.array(coefficient)

    def at(q: Array) -> tuple[Array, Array, Array]:
        column = q[:, None]
        place = origin + half_second * column**2
        return place, 2 * half_second * column, np.broadcast_to(2 * half_second, place.shape)

    return at


def sinusoid(center: Vector, amplitude: Vector, phase: Vector) -> Path:
    """Return the path center + B sin(q + phase) of eqs (41) and (42).

    Parameters
    ----------
    center : tuple of float
        Middle of the oscillation, m.
    amplitude : tuple of float
        B per axis, m.
    phase : tuple of float
        Phase per axis at q = 0, rad.
    """
    middle, size, shift = np.array(center), np.array(amplitude), np.array(phase)

    def at(q: Array) -> tuple[Array, Array, Array]:
        angle = q[:, None] + shift
        sine, cosine = size * np.sin(angle), size * np.cos(angle)
        return middle + sine, cosine, -sine

    return at


def circle(center: Vector, radius: float, start_angle: float) -> Path:
    """Return the circle that starts at `start_angle` and turns counter-clockwise as q grows.

    Parameters
    ----------
    center : tuple of float
        Centre, m.
    radius : float
        Radius, m.
    start_angle : float
        Angle from the x axis at q = 0, rad.
    """
    return sinusoid(center, (radius, radius), (start_angle + math.pi / 2, start_angle))


def star_vertices(
    *, center: Vector, circumradius: float, points: int, density: int, start_angle: float
) -> tuple[Vector, ...]:
    """Return the vertices of the star polygon {points/density} in the order they are drawn.

    Each edge is a chord 2 R sin(pi density/points) long: 57.06 mm for the pentagram {5/2} with
    R = 30 mm.

    Parameters
    ----------
    center : tuple of float
        Centre, m.
    circumradius : float
        Distance of every vertex from the centre, m.
    points : int
        Number of vertices.
    density : int
        Each edge leads to the vertex this many places further round.
    start_angle : float
        Angle of the first vertex from the x axis, rad.
    """
    angles = [start_angle + 2 * math.pi * (k * density % points) / points for k in range(points)]
    return tuple(
        (
            center[0] + circumradius * math.cos(angle),
            center[1] + circumradius * math.sin(angle),
        )
        for angle in angles
    )
