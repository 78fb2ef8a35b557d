"""The paper's printed forces, and the stated uncertainty of this model."""

from __future__ import annotations

from pydantic import Field

from motionlab.config.quantity import Config
from motionlab.motor_design.fem.force_map import PresetName
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.motor_design.fem.steel import MU_0

_PAPERS = ("tau", "p", "g", "n", "l_m", "N", "i")
"""Fields of the geometry that the paper prints; its peaks are those of a motor that has them."""


class Published(Config):
    """A pair of peaks that the paper prints, at 10 A."""

    method: str
    thrust: float = Field(description="N")
    normal_force: float = Field(description="N")
    not_comparable: str = Field(
        default="", description="Why no model is judged by it; empty where one is"
    )


class Uncertainty(Config):
    """Uncertainty of the model, as a share; the mesh's part is far smaller."""

    thrust: float = Field(description="1")
    normal_force: float = Field(description="1")
    reason: str


MEASURED_NOT_COMPARABLE = (
    "not all of the measured cross-section is printed, nor how it was measured"
)

PUBLISHED = (
    Published(method="finite elements in three dimensions", thrust=34.1, normal_force=380.1),
    Published(
        method="measured",
        thrust=38.4,
        normal_force=427.4,
        not_comparable=MEASURED_NOT_COMPARABLE,
    ),
)
"""Peaks at 10 A, of the abstract and section II-A of the paper, DOI 10.1109/ACCESS.2019.2899038."""

UNCERTAINTY = Uncertainty(
    thrust=0.15,
    normal_force=0.10,
    reason="the paper leaves the cross-section partly open, and the model is two-dimensional",
)
PREVIEW_UNCERTAINTY = Uncertainty(
    thrust=0.4,
    normal_force=0.3,
    reason="a magnetic circuit: against finite elements up to 15 N of thrust off, near unaligned",
)

CROWDED_PREVIEW_UNCERTAINTY = Uncertainty(
    thrust=0.6,
    normal_force=1.2,
    reason="a magnetic circuit, which does not saturate corners: with teeth narrower than half a "
    "pitch, or a gap as thin for its ampere-turns as this one, near unaligned even its sign is "
    "not to be trusted",
)

_CROWDED = 3.5
"""Flux density that the ampere-turns would drive through two gaps alone, T; the paper's: 3.0."""


def published(geometry: Geometry) -> list[Published]:
    """Return the paper's peaks if a geometry has everything that the paper prints of it."""
    default = Geometry()
    same = all(getattr(geometry, name) == getattr(default, name) for name in _PAPERS)
    return list(PUBLISHED) if same else []


def uncertainty(preset: PresetName, geometry: Geometry) -> Uncertainty:
    """Return the uncertainty of a preset's map of a geometry."""
    if preset != "preview":
        return UNCERTAINTY
    g = geometry
    narrow = g.p < (1 - 1e-9) * g.tau / 2
    crowded = MU_0 * g.N * g.i / (2 * g.g) > _CROWDED
    return CROWDED_PREVIEW_UNCERTAINTY if narrow or crowded else PREVIEW_UNCERTAINTY
