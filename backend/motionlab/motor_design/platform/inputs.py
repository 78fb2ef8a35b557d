"""Inputs of a platform: shape, supports, normal forces of the movers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from motionlab.config.quantity import Config, choices, quantity
from motionlab.config.validation_errors import checked

PAPER = "Huang et al., IEEE Access 2019, section II-B"
OURS = "this project's assumption; the paper's shapes are only in its Fig. 3"

Support = Literal["carriages", "guides", "edges", "clamped"]
Axis = Literal["x", "y"]
DesignName = Literal["previous", "new"]


AXES = choices(
    ("x", "x axis", "The light, inner one"),
    ("y", "y axis", "The sliding plate of the heavy, outer one"),
)
SUPPORTS = choices(
    ("carriages", "four carriages", "Four points"),
    ("guides", "two guides along x", "Two lines along x"),
    ("edges", "all edges, simply", "All four edges, simply supported"),
    ("clamped", "all edges, built in", "All four edges, built in"),
)
"""Supports of a platform, as the screen calls them."""


class Shape(Config):
    """A rectangular plate with ribs below, its middle at x = y = 0."""

    length: float = quantity(
        "Along x",
        label="length along x",
        shown="mm",
        unit="m",
        source=OURS,
        default=0.46,
        ge=0.02,
        le=5,
    )
    width: float = quantity(
        "Along y",
        label="width along y",
        shown="mm",
        unit="m",
        source=OURS,
        default=0.36,
        ge=0.02,
        le=5,
    )
    thickness: float = quantity(
        "Of the plate without ribs",
        symbol="t",
        shown="mm",
        unit="m",
        source=OURS,
        default=16e-3,
        ge=1e-4,
        le=0.2,
    )
    ribs_x: int = quantity(
        "Ribs along x", label="ribs along x", unit="1", source=OURS, default=3, ge=0, le=20
    )
    ribs_y: int = quantity(
        "Ribs along y", label="ribs along y", unit="1", source=OURS, default=3, ge=0, le=20
    )
    rib_width: float = quantity(
        "Of each rib", symbol="w", shown="mm", unit="m", source=OURS, default=12e-3, ge=1e-4, le=1
    )
    rib_height: float = quantity(
        "Of each rib, below the plate",
        symbol="h",
        shown="mm",
        unit="m",
        source=OURS,
        default=10e-3,
        ge=0,
        le=0.5,
    )
    E: float = quantity(
        "Young's modulus; aluminium",
        label="Young's modulus",
        symbol="E",
        shown="GPa",
        unit="Pa",
        source=OURS,
        default=70e9,
        ge=1e8,
        le=1e12,
    )
    nu: float = quantity("Poisson's ratio", unit="1", source=OURS, default=0.33, ge=0, le=0.49)
    rho: float = quantity("Density", unit="kg/m^3", source=OURS, default=2700.0, ge=100, le=3e4)
    support: Support = Field(
        default="carriages",
        title="supports",
        json_schema_extra=SUPPORTS,
        description="carriages: four points; guides: two lines along x; edges: all four, simply "
        "supported; clamped: all four, built in",
    )
    span_x: float = quantity(
        "Distance of carriages along x",
        label="span of supports, x",
        shown="mm",
        unit="m",
        source=OURS,
        default=0.4,
        ge=0.01,
        le=5,
    )
    span_y: float = quantity(
        "Distance of carriages, or of guides, along y",
        label="span of supports, y",
        shown="mm",
        unit="m",
        source=OURS,
        default=0.32,
        ge=0.01,
        le=5,
    )

    @model_validator(mode="after")
    def _fits(self) -> Self:
        for count, along, across in (
            (self.ribs_x, "x", self.width),
            (self.ribs_y, "y", self.length),
        ):
            if count * self.rib_width > across:
                raise ValueError(
                    f"ribs overlap: {count} ribs along {along} of {self.rib_width:g} m take more "
                    f"than the {across:g} m across"
                )
        spans = [("span_y", self.span_y, "width", self.width)]
        if self.support == "carriages":
            spans.append(("span_x", self.span_x, "length", self.length))
        if self.support in {"carriages", "guides"}:
            for name, span, of, size in spans:
                if span > size:
                    raise ValueError(
                        f"{name} = {span:g} m must be at most the {of}, {size:g} m: the supports "
                        "would lie outside of the plate"
                    )
        return self

    @property
    def mass(self) -> float:
        """Return the mass of plate and ribs, kg."""
        crossings = self.ribs_x * self.ribs_y * self.rib_width**2
        below = self.rib_width * (self.ribs_x * self.length + self.ribs_y * self.width) - crossings
        return self.rho * (self.length * self.width * self.thickness + below * self.rib_height)


class Load(Config):
    """Four normal forces at the corners of a rectangle, each over the footprint of a mover."""

    forces: Annotated[tuple[float, float, float, float], Field(strict=False)] = quantity(
        "At (-x, -y), (x, -y), (-x, y), (x, y), towards the stator; not used with a map",
        label="each normal force",
        unit="N",
        source=f"{PAPER}: four normal forces of 400 N",
        default=(400.0, 400.0, 400.0, 400.0),
    )
    spacing_x: float = quantity(
        "Distance of the movers' middles along x",
        label="spacing along x",
        shown="mm",
        unit="m",
        source=OURS,
        default=0.24,
        ge=0,
        le=5,
    )
    spacing_y: float = quantity(
        "The same along y",
        label="spacing along y",
        shown="mm",
        unit="m",
        source=OURS,
        default=0.2,
        ge=0,
        le=5,
    )
    length: float = quantity(
        "Of a mover's footprint along x; 0 in both directions for a point",
        unit="m",
        source="Huang et al., IEEE Access 2019, section II-A: a mover's width",
        default=39.6e-3,
        ge=0,
        le=1,
    )
    width: float = quantity(
        "The same along y",
        unit="m",
        source="Huang et al., IEEE Access 2019, section II-A: the stack",
        default=42.3e-3,
        ge=0,
        le=1,
    )

    @model_validator(mode="after")
    def _is_a_load(self) -> Self:
        if max(abs(force) for force in self.forces) > 1e6:
            raise ValueError("forces must be at most 1e6 N")
        if (self.length == 0) != (self.width == 0):
            raise ValueError(
                f"a footprint of {self.length:g} m by {self.width:g} m is a line: give both, or 0 "
                "in both for a point"
            )
        return self

    @property
    def places(self) -> tuple[tuple[float, float], ...]:
        """Return the movers' middles, m."""
        x, y = self.spacing_x / 2, self.spacing_y / 2
        return (-x, -y), (x, -y), (-x, y), (x, y)


class MapLoad(Config):
    """Normal forces of a force map, which grow as the platform bends into the gap."""

    name: str = Field(title="forces", description="Of the map, among those of GET /maps")
    current: float = quantity(
        "Of the phase", unit="A", source=f"{PAPER}, its largest", default=10.0, ge=0, le=1000
    )
    position: float = quantity(
        "x, 0 where teeth are aligned and the force is largest",
        unit="m",
        source=OURS,
        default=0.0,
        ge=-1,
        le=1,
    )


class PlatformRequest(Config):
    """Two designs of one platform under the same normal forces."""

    model_config = ConfigDict(json_schema_extra={"required": []})  # the axis has defaults

    axis: Axis = Field(
        default="y",
        description="Which platform's shapes are the defaults",
        json_schema_extra=AXES,
    )
    previous: Shape
    new: Shape
    load: Load = Field(default_factory=Load)
    map: MapLoad | None = Field(default=None, description="Take the forces from a force map")
    cells: int = quantity(
        "Elements along the longer edge, at least; more where edges ask for it",
        unit="1",
        source=OURS,
        default=16,
        ge=4,
        le=32,
    )

    @model_validator(mode="after")
    def _load_is_on_the_plates(self) -> Self:
        load = self.load
        for name in ("previous", "new"):
            shape: Shape = getattr(self, name)
            for of, size, spacing, foot in (
                ("length", shape.length, load.spacing_x, load.length),
                ("width", shape.width, load.spacing_y, load.width),
            ):
                if spacing + foot > size:
                    raise ValueError(
                        f"forces outside of the plate: {name}.{of} = {size:g} m, the movers "
                        f"reach over {spacing + foot:g} m"
                    )
        return self

    @property
    def shapes(self) -> dict[DesignName, Shape]:
        """Return both designs by name."""
        return {"previous": self.previous, "new": self.new}


_X: dict[str, Any] = {"length": 0.3, "width": 0.26, "span_x": 0.24, "span_y": 0.22}
_DEFAULTS: dict[str, dict[str, dict[str, Any]]] = {
    "x": {
        "previous": _X | {"thickness": 16e-3, "ribs_x": 0, "ribs_y": 0, "rib_height": 0.0},
        "new": _X | {"thickness": 12e-3, "rib_height": 24e-3},
        "load": {"spacing_x": 0.12, "spacing_y": 0.1},
    },
    "y": {"previous": {"rib_height": 10e-3}, "new": {"rib_height": 30e-3}, "load": {}},
}
"""Plausible shapes, one stiffened by higher ribs: this project's assumption, fitted to nothing."""


def read_platform_request(request: Mapping[str, Any]) -> PlatformRequest:
    """Return a validated request; omitted fields have the axis's defaults.

    Raises
    ------
    ConfigError
        Naming every field that is wrong, its value, range and unit.
    """
    tables = dict(request)
    axis = tables.setdefault("axis", "y")
    for name, default in _DEFAULTS.get(axis if isinstance(axis, str) else "y", {}).items():
        table = tables.get(name, {})
        tables[name] = {**default, **table} if isinstance(table, Mapping) else table
    return checked(PlatformRequest, tables, "platform")
