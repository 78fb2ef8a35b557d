"""Document of a force map: storage, peaks, stated uncertainty, tables."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic import Field

from motionlab.config.quantity import Config, choices
from motionlab.motor_design.fem.force_map import ForceMap, PresetName
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.motor_design.fem.report import summary
from motionlab.motor_design.fem.uncertainty import Published, Uncertainty, published, uncertainty

PRESETS = choices(
    ("preview", "preview", "Magnetic circuit, at once"),
    ("default", "default", "24 cells a pitch, about a minute"),
    ("reference", "reference", "48 cells a pitch, some minutes"),
)
"""Presets of a map as the screen calls them."""


class MapRequest(Config):
    """Which map is computed."""

    preset: PresetName = Field(
        default="default",
        title="accuracy",
        description="How well, and how long",
        json_schema_extra=PRESETS,
    )
    geometry: Geometry = Field(
        default_factory=Geometry, description="Fields to change; {} is the paper's with our reading"
    )


class Peaks(Config):
    """Figures by which maps are compared."""

    current: float = Field(description="At which, but for the ratio: the largest, A")
    peak_thrust: float = Field(description="Largest dW'/dx, N")
    peak_position: float = Field(description="Where, m; 0 where teeth are aligned")
    normal_force_aligned: float = Field(description="N")
    normal_force_unaligned: float = Field(description="N")
    inductance_ratio: float = Field(description="Aligned over unaligned, a tenth of the current")
    spline_error: float = Field(description="Largest difference of dW'/dx from the stress, N")


class MapEntry(Config):
    """A force map, without its tables."""

    name: str = Field(description="Of its file; a computed map's content hash")
    shipped: bool = Field(description="Whether it ships with the project and cannot be deleted")
    content_hash: str = Field(description="Of geometry, preset and method_version")
    preset: PresetName
    method: str
    motionlab_version: str
    geometry: Geometry
    peaks: Peaks
    uncertainty: Uncertainty
    published: list[Published] = Field(
        description="The paper's peaks, where the geometry has all that it prints; else empty"
    )


class MapTables(MapEntry):
    """A force map with tables of its splines: a row for each position."""

    positions: list[float] = Field(description="x, m, one pitch, 0 where teeth are aligned")
    currents: list[float] = Field(description="i, A, from 0")
    thrust: list[list[float]] = Field(description="dW'/dx, N, below 0 for 0 < x < tau/2")
    normal_force: list[list[float]] = Field(description="Attraction of mover and stator, N")


def entry(force_map: ForceMap, *, name: str, shipped: bool) -> MapEntry:
    """Return a map's entry without its tables."""
    return MapEntry(**_entry(force_map, name, shipped=shipped))


def tables(
    force_map: ForceMap, *, name: str, shipped: bool, positions: int, currents: int
) -> MapTables:
    """Return a map's entry with tables of its splines.

    Parameters
    ----------
    force_map : ForceMap
        Any.
    name : str
        Of its file.
    shipped : bool
        Whether it ships with the project.
    positions, currents : int
        How many of each, evenly spaced, ends included.
    """
    x = np.linspace(-force_map.tau / 2, force_map.tau / 2, positions)
    i = np.linspace(0.0, force_map.i_max, currents)
    where = x[:, None], i[None, :]
    return MapTables(
        **_entry(force_map, name, shipped=shipped),
        positions=x.tolist(),
        currents=i.tolist(),
        thrust=np.round(force_map.thrust(*where), 4).tolist(),
        normal_force=np.round(force_map.normal_force(*where), 4).tolist(),
    )


def _entry(force_map: ForceMap, name: str, *, shipped: bool) -> dict[str, Any]:
    d = force_map.document
    return {
        "name": name,
        "shipped": shipped,
        "content_hash": d.content_hash,
        "preset": d.preset,
        "method": d.method,
        "motionlab_version": d.motionlab_version,
        "geometry": d.geometry,
        "peaks": Peaks(current=force_map.i_max, **summary(force_map)),
        "uncertainty": uncertainty(d.preset, d.geometry),
        "published": published(d.geometry),
    }
