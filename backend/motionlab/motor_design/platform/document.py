"""Document of two bent platform designs, as ``motionlab platform --json`` and the API return."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from motionlab.config.quantity import Config, si
from motionlab.errors import ConfigError, FieldError
from motionlab.motor_design.fem.force_map import ForceMap
from motionlab.motor_design.platform.gap import Gaps, Ratio, closing, ratio
from motionlab.motor_design.platform.inputs import Axis, DesignName, Load, PlatformRequest, Shape

_GRID = 48  # columns of the picture
_FINE = 4  # points of the search for the largest, for each of the picture
_LEAST_CURRENT = 1e-3  # A; the forces of far smaller ones have no ratio in floating point

_NAMES: tuple[DesignName, ...] = ("previous", "new")
_PAPERS = {"x": (16.12e-6, 4.05e-6, -0.749), "y": (126.36e-6, 34.18e-6, -0.725)}
"""Previous and new, m, and the change as printed; the y platform's figures give -0.730."""

_REASON = (
    "the paper gives the shapes only in its Fig. 3 and no supports: the method is the same, "
    "the plates are not"
)


class MoverPlace(Config):
    """One mover below the platform."""

    x: float = Field(description="Its middle, m")
    y: float = Field(description="m")
    force: float = Field(description="Normal force, N, towards the stator")
    gap_change: float = Field(description="Mean deflection of its footprint: the gap's loss, m")
    gap: float | None = Field(description="What is left of the map's gap, m; null without a map")


class Deflection(Config):
    """One design, bent."""

    labels: ClassVar[dict[str, str]] = {"thrust_ratio": "thrust there"}

    shape: Shape
    mass: float = Field(description="Of plate and ribs, kg")
    largest: float = Field(description="Largest deflection, either way, m")
    largest_x: float = Field(description="Where, m")
    largest_y: float = Field(description="m")
    mesh_error: float = Field(
        description="Change of the largest against a mesh half as fine, m; the error is smaller"
    )
    movers: list[MoverPlace]
    mean_gap: float | None = Field(description="Of the four movers, m; null without a map")
    thrust_ratio: float | None = Field(
        description="Largest thrust at the mean gap over that at the full one, by the magnetic "
        "circuit, 1; null without a map",
    )
    steps: int | None = Field(description="Of the iteration; null without a map")
    x: list[float] = Field(description="Columns of the picture, m")
    y: list[float] = Field(description="Rows, m")
    deflection: list[list[float]] = Field(description="Towards the stator, m: a row for each y")

    def derived(self) -> dict[str, str]:
        """Return the command that computes the thrust at the mean gap."""
        if self.mean_gap is None:
            return {}
        return {"computed by": f"motionlab map --set g={self.mean_gap:.4g}"}


class PaperDeformation(Config):
    """The paper's printed deformations of the platform."""

    previous: float = Field(description="m")
    new: float = Field(description="m")
    change: float = si("new over previous less 1", "1", "%")
    change_printed: float = si("The same as the paper prints it", "1", "%")
    status: Literal["not_comparable"] = "not_comparable"
    reason: str = _REASON


class PlatformDocument(Config):
    """Two designs of one platform under the same movers."""

    axis: Axis
    map: str | None = Field(description="Of the forces; null where they are given")
    load: Load = Field(description="As asked for; with a map its forces are not used")
    designs: dict[DesignName, Deflection]
    change: float | None = si(
        "Largest deflection, new over previous less 1; null without any deflection", "1", "%"
    )
    paper: PaperDeformation


def platform(request: PlatformRequest, force_map: ForceMap | None = None) -> PlatformDocument:
    """Return both designs of a platform, bent by the movers.

    Parameters
    ----------
    request : PlatformRequest
        Shapes, supports and forces.
    force_map : ForceMap, optional
        The map named in the request.

    Raises
    ------
    ConfigError
        If the map does not reach the current, or a platform is so soft that the gap closes.
    """
    grows = None
    if request.map is not None and force_map is not None:
        if not _LEAST_CURRENT <= request.map.current <= force_map.i_max:
            raise ConfigError(
                FieldError(
                    "map.current",
                    "is not on the map",
                    request.map.current,
                    unit="A",
                    bounds={"minimum": _LEAST_CURRENT, "maximum": force_map.i_max},
                )
            )
        grows = ratio(force_map.document.geometry, request.map.position, request.map.current)
    deflections: dict[DesignName, Deflection] = {
        name: _bent(request, name, force_map, grows) for name in _NAMES
    }
    before, after = deflections["previous"].largest, deflections["new"].largest
    previous, new, printed = _PAPERS[request.axis]
    return PlatformDocument(
        axis=request.axis,
        map=request.map.name if request.map else None,
        load=request.load,
        designs=deflections,
        change=after / before - 1 if before > 0 else None,
        paper=PaperDeformation(
            previous=previous, new=new, change=new / previous - 1, change_printed=printed
        ),
    )


def _bent(
    request: PlatformRequest, name: DesignName, force_map: ForceMap | None, grows: Ratio | None
) -> Deflection:
    from motionlab.motor_design.platform.bending import Plate

    shape, load = request.shapes[name], request.load
    plate = Plate(shape, load, cells=request.cells)
    forces = np.array(load.forces)
    gaps = Gaps(forces, plate.compliance @ forces, 0)
    gap = None
    if request.map is not None and force_map is not None and grows is not None:
        gap = force_map.document.geometry.g
        where = {"position": request.map.position, "current": request.map.current}
        gaps = closing(plate, force_map, grows, name=name, **where)
    surface = plate.surface(gaps.forces)
    rows = max(2, round(_GRID * shape.width / shape.length))
    x = np.linspace(-shape.length / 2, shape.length / 2, _GRID * _FINE + 1)
    y = np.linspace(-shape.width / 2, shape.width / 2, rows * _FINE + 1)
    fine = surface.at(x, y)
    row, column = np.unravel_index(np.argmax(np.abs(fine)), fine.shape)
    coarse = Plate(shape, load, cells=request.cells // 2).surface(gaps.forces).at(x, y)
    largest = float(np.max(np.abs(fine)))
    closed = float(np.mean(gaps.closed))
    return Deflection(
        shape=shape,
        mass=shape.mass,
        largest=largest,
        largest_x=float(x[column]),
        largest_y=float(y[row]),
        mesh_error=abs(largest - float(np.max(np.abs(coarse)))),
        movers=[
            MoverPlace(
                x=place[0],
                y=place[1],
                force=float(force),
                gap_change=float(change),
                gap=None if gap is None else gap - float(change),
            )
            for place, force, change in zip(load.places, gaps.forces, gaps.closed, strict=True)
        ],
        mean_gap=None if gap is None else gap - closed,
        thrust_ratio=None
        if gap is None or grows is None
        else float(np.polyval(grows.thrust, closed / gap)),
        steps=None if gap is None else gaps.steps,
        x=x[::_FINE].tolist(),
        y=y[::_FINE].tolist(),
        deflection=np.round(fine[::_FINE, ::_FINE], 12).tolist(),
    )
