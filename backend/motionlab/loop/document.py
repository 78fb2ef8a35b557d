"""The loops of a scenario: margins, and how far each gain is from instability."""

from __future__ import annotations

import functools
import math
from typing import Any, ClassVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.planar import AXES
from motionlab.config.quantity import si
from motionlab.config.scenario import Scenario
from motionlab.kernel.force_maps import map_digests
from motionlab.lanes.bank import TABLES
from motionlab.laws import SOURCES
from motionlab.loop.family import Figures, GainLimits, LoopFamily, LoopKey, family_of
from motionlab.loop.linearise import SLIDING, NoLinearisation, linearise, parameters
from motionlab.loop.margins import margins


class LoopAt(BaseModel):
    """The loop of one axis at one velocity; null where there is no such crossing."""

    velocity: float = Field(description="Sliding velocity, m/s; 0 at standstill")
    stable: bool = Field(description="Whether every pole lies inside the unit circle")
    k_p_limit: float | None = Field(description="Nearest k_p at which stability changes, N/m")
    k_d_limit: float | None = Field(description="Nearest k_d at which stability changes, N s/m")
    crossover: float | None = Field(description="Highest frequency at which abs(L) = 1, Hz")
    phase_margin: float | None = si("Distance of arg L from -180 degrees", "rad", "deg")
    gain_margin: float | None = Field(description="Factor > 1 up to the stability boundary")
    gain_reduction: float | None = Field(description="Factor < 1 down to the stability boundary")
    Ms: float = Field(description="Peak of the sensitivity")
    bandwidth: float | None = Field(description="-3 dB of L/(1 + L), Hz")


class WorstMargin(BaseModel):
    """The worst value of a margin, and where it is."""

    model_config = ConfigDict(extra="forbid")

    value: float
    velocity: float = Field(
        description="Sliding velocity; 0 at standstill", json_schema_extra={"unit": "m/s"}
    )


class WorstOfAxis(BaseModel):
    """The worst margins of one axis, at standstill and from 0.5 to 4 Stribeck velocities.

    Tuning and explanations hold their limits against these. Null where the loop is unstable, and
    where there is no such crossing.
    """

    stable: bool = Field(description="Whether the loop is stable at each of these velocities")
    velocity: float = Field(description="Where it is nearest to instability, m/s; 0 at standstill")
    gain_margin: WorstMargin | None = Field(
        description="Smallest factor, up or down, to the stability boundary"
    )
    phase_margin: WorstMargin | None = si("Distance of arg L from -180 degrees", "rad", "deg")
    Ms: WorstMargin | None = Field(description="Peak of the sensitivity")


class LoopOfAxis(LoopAt):
    """The loop of one axis while it slides, at standstill, and where it is worst."""

    standstill: LoopAt = Field(
        description="Stuck: the bristle is a spring, and the thrust is about that of breakaway"
    )
    worst: WorstOfAxis


class LoopOfVariant(BaseModel):
    """The loops of one variant."""

    axes: dict[str, LoopOfAxis] = Field(description="Empty where the law has no linearisation")
    note: str | None = Field(description="Why there are none, or what they leave out")


class LoopDocument(BaseModel):
    """The loops of a scenario."""

    foot: ClassVar[str] = (
        "Figures hold while sliding at four Stribeck velocities; worst: the worst at rest and from "
        "0.5 to 4 of them, the gain margin up or down, as tune and why judge."
    )

    variants: dict[str, LoopOfVariant]


def loop_document(scenario: Scenario) -> LoopDocument:
    """Return margins and limits of stability of every loop of a scenario."""
    return LoopDocument(variants={name: _variant(scenario, name) for name in scenario.variants})


def _variant(scenario: Scenario, variant: str) -> LoopOfVariant:
    try:
        axes = {axis: _axis(scenario, variant, axis) for axis in AXES}
    except NoLinearisation as error:
        return LoopOfVariant(axes={}, note=error.errors[0].message)
    return LoopOfVariant(axes=axes, note=_left_out(scenario))


def _left_out(scenario: Scenario) -> str | None:
    """Return which effects of the plant the linearised loops do not have."""
    names = sorted({each.effect for axis in AXES for each in getattr(scenario.plant, axis).effects})
    return f"without the plant's effects: {', '.join(names)}" if names else None


@TABLES.lease()
def _axis(scenario: Scenario, variant: str, axis: str) -> LoopOfAxis:
    """Return the loop of one axis; a slider moves one loop, and the others are kept."""
    versions = (*map_digests([(0, scenario)]), *SOURCES.values())
    numbers = parameters(scenario, variant, axis), versions
    return _loop_of_axis(LoopKey(numbers, scenario, variant, axis))


@functools.lru_cache(maxsize=64)
def _loop_of_axis(key: LoopKey) -> LoopOfAxis:
    loop = key.scenario, key.variant, key.axis
    family = family_of(*loop)
    gains = getattr(key.scenario.variants[key.variant].controller, key.axis)
    stuck, sliding = family.limits(gains.k_p, gains.k_d)
    return LoopOfAxis(
        **_at(*loop, SLIDING, sliding),
        standstill=LoopAt(**_at(*loop, 0.0, stuck)),
        worst=_worst(family, gains.k_p, gains.k_d),
    )


def _worst(family: LoopFamily, k_p: float, k_d: float) -> WorstOfAxis:
    radii = family.radii(np.array(k_p), np.array(k_d))
    stable = bool(radii.max() < 1.0)
    figures = family.figures(k_p, k_d)._asdict() if stable else {}
    return WorstOfAxis(
        stable=stable,
        velocity=float(family.velocity[radii.argmax()]),
        **{
            name: WorstMargin(value=at.value, velocity=at.velocity)
            if (at := figures.get(name)) and math.isfinite(at.value)
            else None
            for name in Figures._fields
        },
    )


def _at(
    scenario: Scenario, variant: str, axis: str, speed: float, limits: GainLimits
) -> dict[str, Any]:
    """Return the figures of a loop at a velocity in Stribeck velocities."""
    v = speed * getattr(scenario.plant, axis).friction.v_s
    loop = linearise(scenario, variant, axis, v=v)
    return {
        "velocity": v,
        "stable": loop.stable,
        **{f"{gain}_limit": limit for gain, limit in limits._asdict().items()},
        **vars(margins(loop.open)),
    }
