"""Force maps, thrust over position and current: a formula, or a computed table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from motionlab.config.quantity import Config, quantity
from motionlab.declarations import OURS, PAPER

MapName = Annotated[str, Field(pattern="^[a-z0-9-]{1,64}$")]


class ForceMapConfig(Config):
    """Analytic thrust F(i) S(theta) of each phase; see docs/symbols.md."""

    kind: Literal["analytic"] = Field(default="analytic", description="A formula")
    tau: float = quantity(
        "Pole pitch", shown="mm", unit="m", source=f"{PAPER}, eq. (2)", gt=1e-4, le=0.1
    )
    offset: float = quantity(
        "Commutation offset: by how much the map is shifted against the encoder",
        label="commutation",
        shown="µm",
        unit="m",
        source=OURS,
        default=0.0,
        ge=-0.1,
        le=0.1,
    )
    F_pk: float = quantity(
        "Thrust of one phase at the peak current",
        label="peak thrust",
        unit="N",
        source=f"{PAPER}: finite elements 34.1 N, measured 38.4 N",
        gt=1e-3,
        le=1000,
    )
    N_pk: float = quantity(
        "Normal force of one phase at the peak current, aligned",
        label="peak normal force",
        unit="N",
        source=f"{PAPER}: finite elements 380.1 N, measured 427.4 N",
        ge=0,
        le=1e5,
    )
    I_pk: float = quantity(
        "Peak current",
        label="peak current",
        unit="A",
        source=f"{PAPER}, section II",
        gt=1e-3,
        le=100,
    )
    I_knee: float = quantity(
        "Current at which saturation sets in",
        label="saturation I_knee",
        unit="A",
        source=f"{OURS}, from a finite-element model of the paper's geometry",
        gt=1e-3,
        le=1000,
    )
    h_2: float = quantity(
        "Second harmonic of thrust over position",
        label="harmonic h_2",
        unit="1",
        source=OURS,
        default=0.0,
        ge=-0.3,
        le=0.3,
    )
    h_3: float = quantity(
        "Third harmonic of thrust over position",
        label="harmonic h_3",
        unit="1",
        source="0.039 follows from the paper's 43.1 N over 38.4 N = (1 + 2 h_3)/(1 - h_3)",
        default=0.0,
        ge=-0.3,
        le=0.3,
    )


class TableMapConfig(Config):
    """A force map by finite elements, named; see docs/maps.md."""

    kind: Literal["table"] = Field(default="table", description="A table")
    name: MapName = Field(
        title="force map",
        description="A shipped map, or the file name without .json of one below "
        "MOTIONLAB_DATA/maps",
    )
    offset: float = quantity(
        "Commutation offset: by how much the map is shifted against the encoder",
        label="commutation",
        shown="µm",
        unit="m",
        source=OURS,
        default=0.0,
        ge=-0.1,
        le=0.1,
    )
    gain: float = quantity(
        "Factor on thrust and normal force, such as 34.1/38.6 for the paper's own finite elements",
        label="map gain",
        unit="1",
        source=OURS,
        default=1.0,
        ge=0.1,
        le=10,
    )


def _kind(value: Any) -> Any:
    """Return the kind of map of a value; the formula without ``kind``."""
    if isinstance(value, Mapping):
        return value.get("kind", "analytic")
    return getattr(value, "kind", "analytic")


AnyForceMapConfig = Annotated[
    Annotated[ForceMapConfig, Tag("analytic")] | Annotated[TableMapConfig, Tag("table")],
    Discriminator(_kind),
]
