"""The field of one phase as a picture: flux density on a grid, flux lines, outlines."""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from motionlab.config.quantity import Config, quantity
from motionlab.motor_design.fem.contour import Triangles, contour
from motionlab.motor_design.fem.field import FieldModel, FieldSystem
from motionlab.motor_design.fem.geometry import OURS, Geometry
from motionlab.motor_design.fem.mesh import Resolution
from motionlab.motor_design.fem.outline import Outline, Polyline, outlines, rounded

RESOLUTION = Resolution(48, 1)
"""Linear elements, a line is a chord of each: nodes stand every 0.15 mm on the paper's gap."""

_TOLERANCE = 0.1  # of a cell of the grid, of a flux line
_TESLA_DIGITS = 4

Array = NDArray[np.float64]


class FieldRequest(Config):
    """Which field is drawn."""

    geometry: Geometry = Field(default_factory=Geometry, description="Of one phase; {} is ours")
    position: float = quantity(
        "x, 0 where teeth are aligned; the nearest node of the mesh is taken",
        unit="m",
        source=OURS,
        default=-2.1e-3,
        ge=-1.0,
        le=1.0,
    )
    current: float = quantity(
        "Current, up to the geometry's i", unit="A", source=OURS, default=10.0, ge=0, le=1000
    )
    columns: int = quantity(
        "Columns of the grid; its cells are square",
        unit="1",
        source=OURS,
        default=192,
        ge=32,
        le=384,
    )
    lines: int = quantity("Flux lines", unit="1", source=OURS, default=24, ge=0, le=100)

    @model_validator(mode="after")
    def _current_is_within(self) -> Self:
        if self.current > self.geometry.i:
            raise ValueError(
                f"current = {self.current:g} A must be at most geometry.i = {self.geometry.i:g} A"
            )
        return self


class Steps(Config):
    """Evenly spaced coordinates."""

    start: float = Field(description="First, m")
    step: float = Field(description="m")
    count: int


class FluxLine(Config):
    """A flux line; neighbouring lines enclose one step of flux."""

    flux: float = Field(description="Flux between this line and the outer edge, Wb")
    points: Polyline = Field(description="x and y, m")


class FieldPicture(Config):
    """The field in the mover's frame: y = 0 in the middle of the gap, x = 0 of the mover."""

    geometry: Geometry
    position: float = Field(description="x that was taken, m, within half a pitch of aligned")
    current: float = Field(description="A")
    method: str
    thrust: float = Field(description="By the stress tensor on this mesh, N")
    normal_force: float = Field(description="N, positive where mover and stator attract")
    linkage: float = Field(description="Flux linkage, Wb")
    coenergy: float = Field(description="J")
    x: Steps
    y: Steps
    flux_density: list[list[float]] = Field(description="abs(B), T: a row for each y, from below")
    flux_density_max: float = Field(description="Largest of the grid, T")
    flux_step: float = Field(description="Flux between neighbouring lines, Wb; 0 without any")
    lines: list[FluxLine]
    outlines: list[Outline]


class _Window(NamedTuple):
    """Visible region, m."""

    half_width: float
    bottom: float
    top: float


def picture(request: FieldRequest) -> FieldPicture:
    """Return the field of one phase at a position and a current.

    Parameters
    ----------
    request : FieldRequest
        Geometry, position, current; how finely to draw.

    Returns
    -------
    FieldPicture
        In the mover's frame, where the stator lies at -x.

    Raises
    ------
    NoConvergence
        If the field is not found.
    """
    g = request.geometry
    model = FieldModel(g, RESOLUTION)
    cell = g.tau / model.cells_per_pitch
    shift = round(request.position / cell) % model.cells_per_pitch
    if shift > model.cells_per_pitch // 2:
        shift -= model.cells_per_pitch
    position = model.at(shift)
    solution = position.solve(request.current)
    flux, density = position.triangles()
    triangles = _in_the_movers_frame(model, position, flux, shift * cell)
    window = _Window(
        (model.length - g.tau) / 2,
        -(g.g / 2 + g.stator_tooth_depth + g.stator_back),
        g.g / 2 + g.tooth_depth + g.shoe + g.window + g.yoke * 4 / 3,
    )
    step = 2 * window.half_width / request.columns
    count = max(1, round((window.top - window.bottom) / step))
    x: Array = -window.half_width + step * (np.arange(request.columns, dtype=float) + 0.5)
    y: Array = window.bottom + step * (np.arange(count, dtype=float) + 0.5)
    grid = sampled(triangles.corners, density, x, y)
    low, high = float(flux.min()), float(flux.max())
    apart = (high - low) / (request.lines + 1) if request.lines else 0.0
    seen = _within(triangles, window)
    lines = [
        FluxLine(flux=level, points=rounded(line))
        for level in low + apart * np.arange(1, request.lines + 1)
        if apart > 0
        for line in contour(seen, float(level), tolerance=_TOLERANCE * step)
    ]
    return FieldPicture(
        geometry=g,
        position=shift * cell,
        current=request.current,
        method=f"finite elements, linear, {RESOLUTION.cells} cells a pitch",
        thrust=solution.thrust,
        normal_force=solution.normal_force,
        linkage=solution.linkage,
        coenergy=solution.coenergy,
        x=Steps(start=float(x[0]), step=step, count=len(x)),
        y=Steps(start=float(y[0]), step=step, count=len(y)),
        flux_density=np.round(grid, _TESLA_DIGITS).tolist(),
        flux_density_max=float(grid.max()),
        flux_step=apart,
        lines=lines,
        outlines=outlines(g, shift * cell, window.half_width),
    )


def _in_the_movers_frame(
    model: FieldModel, position: FieldSystem, flux: Array, x: float
) -> Triangles:
    """Return the triangles with the stator's moved back by `x`, and round the end they leave."""
    corners = model.corners.copy()
    stator = corners[0, :, : model.stator_triangles]
    stator -= x
    stator -= model.length * np.round(stator.mean(axis=0) / model.length)
    return Triangles(corners, position.nodes[:3], flux)


def _within(triangles: Triangles, window: _Window) -> Triangles:
    """Return the triangles that reach into the window."""
    x, y = triangles.corners
    kept = np.flatnonzero(
        (np.abs(x).min(axis=0) < window.half_width)
        & (y.max(axis=0) > window.bottom)
        & (y.min(axis=0) < window.top)
    )
    corners, nodes, values = triangles
    return Triangles(corners[:, :, kept], nodes[:, kept], values[:, kept])


def sampled(corners: Array, values: Array, x: Array, y: Array) -> Array:
    """Return piecewise constant values of triangles at the points of a grid.

    The triangles stand in strips between horizontal lines: at one height those of a strip follow
    each other from left to right.

    Parameters
    ----------
    corners : array, shape (2, 3, triangles)
        x and y, m; together without holes over the grid.
    values : array, shape (triangles,)
        One for each.
    x, y : array
        Columns and rows, m, within the mesh.

    Returns
    -------
    array, shape (rows, columns)
        Of the triangle at each point.
    """
    low, high = corners[1].min(axis=0), corners[1].max(axis=0)
    grid = np.empty((len(y), len(x)))
    for row, height in enumerate(y):
        strip = np.flatnonzero((low <= height) & (height < high))
        left = _left_end(corners[:, :, strip], height)
        order = np.argsort(left)
        at = np.searchsorted(left[order], x, side="right") - 1
        grid[row] = values[strip[order[np.maximum(at, 0)]]]
    return grid


def _left_end(corners: Array, height: float) -> Array:
    """Return where triangles begin at a height that each of them reaches."""
    (x, y), (x_next, y_next) = corners, np.roll(corners, -1, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (height - y) / (y_next - y)
        crossing = x + share * (x_next - x)
    return np.where((share >= 0) & (share <= 1), crossing, np.inf).min(axis=0)
