"""Inputs of sizing: requirements, or the dimensions of a machine."""

from __future__ import annotations

import math
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from motionlab.config.quantity import Config, Whole, choices, quantity
from motionlab.motor_design.presets import PresetName

PAPER = "Huang et al., IEEE Access 2019"
SECTION = f"{PAPER}, section II-A"
OURS = "this project's choice"

_NARROWEST = 1e-6
_SIGMA = (0.05, 20.0)


class Choices(Config):
    """Inputs common to both directions: specification and design choices."""

    f_max: float = quantity(
        "Largest thrust that one phase is specified for",
        label="thrust",
        symbol="f_max",
        unit="N",
        source=SECTION,
        default=32.0,
        ge=1e-3,
        le=1e5,
    )
    v_max: float = quantity(
        "Largest velocity specified",
        label="velocity",
        symbol="v_max",
        unit="m/s",
        source=SECTION,
        default=1.0,
        ge=1e-3,
        le=100,
    )
    i: float = quantity(
        "Largest current of a phase",
        label="current",
        symbol="i",
        unit="A",
        source=SECTION,
        default=10.0,
        ge=1e-3,
        le=1000,
    )
    tau: float = quantity(
        "Pole pitch, p + s",
        label="pole pitch",
        symbol="tau",
        shown="mm",
        unit="m",
        source=SECTION,
        default=7.2e-3,
        ge=1e-4,
        le=0.1,
    )
    p: float | None = quantity(
        "Tooth width; left out: from tau and s or sigma",
        label="tooth",
        symbol="p",
        shown="mm",
        unit="m",
        source=f"{SECTION}: 3.6 mm",
        default=None,
        ge=_NARROWEST,
        le=0.1,
    )
    s: float | None = quantity(
        "Slot width; left out: from tau and p or sigma",
        label="slot",
        symbol="s",
        shown="mm",
        unit="m",
        source=f"{SECTION}: 3.6 mm",
        default=None,
        ge=_NARROWEST,
        le=0.1,
    )
    sigma: float | None = quantity(
        "Tooth over slot, p/s; left out with p and s: 1",
        label="tooth over slot",
        symbol="sigma",
        unit="1",
        source=f"{SECTION}: 1",
        default=None,
        ge=_SIGMA[0],
        le=_SIGMA[1],
    )
    n: Whole = quantity(
        "Tooth pairs of a mover: teeth on each limb",
        label="teeth per limb",
        symbol="n",
        unit="1",
        source=SECTION,
        default=3,
        ge=1,
        le=100,
    )
    limbs: Whole = quantity(
        "Limbs of the mover's core; the paper's (3) has one, its 39.6 mm two",
        unit="1",
        source=f"{SECTION}, from w = 39.6 mm",
        default=2,
        ge=1,
        le=2,
    )
    g: float = quantity(
        "Air gap",
        symbol="g",
        label="air gap",
        shown="mm",
        unit="m",
        source=SECTION,
        default=0.3e-3,
        ge=1e-6,
        le=0.01,
    )
    B_g: float = quantity(
        "Mean flux density in the gap",
        label="flux density",
        symbol="B_g",
        unit="T",
        source=SECTION,
        default=1.5,
        ge=0.01,
        le=2.5,
    )
    H_a: float = quantity(
        "Mean field strength in the iron",
        label="field in the iron",
        symbol="H_a",
        shown="kA/m",
        unit="A/m",
        source=SECTION,
        default=5000.0,
        ge=0,
        le=1e6,
    )
    l_a: float = quantity(
        "Mean path in the iron",
        label="path in the iron",
        symbol="l_a",
        shown="mm",
        unit="m",
        source=SECTION,
        default=0.1451,
        ge=1e-3,
        le=10,
    )
    K_e: float = quantity(
        "Efficiency",
        label="efficiency",
        symbol="K_e",
        unit="1",
        source=SECTION,
        default=0.7,
        ge=0.01,
        le=1,
    )
    K_d: float = quantity(
        "Duty cycle",
        label="duty cycle",
        symbol="K_d",
        unit="1",
        source=SECTION,
        default=1.0,
        ge=0.01,
        le=1,
    )
    lambda_: Annotated[float, Field(alias="lambda")] = quantity(
        "Aligned over unaligned inductance, L_a/L_u",
        label="inductance ratio",
        symbol="lambda",
        unit="1",
        source=f"{OURS}: the paper states none; this one follows from its l_m = 42.3 mm",
        default=1.49534,
        gt=1,
        le=1000,
    )
    loading_min: float = quantity(
        "Electric loading below which a warning is given",
        label="least loading",
        shown="kA/m",
        unit="A/m",
        source=SECTION,
        default=25e3,
        ge=0,
        le=1e7,
    )
    loading_max: float = quantity(
        "Electric loading above which a warning is given",
        label="most loading",
        shown="kA/m",
        unit="A/m",
        source=SECTION,
        default=90e3,
        ge=0,
        le=1e7,
    )

    @model_validator(mode="after")
    def _pitch_is_tooth_and_slot(self) -> Self:
        p, s = self.teeth
        if min(p, s) < _NARROWEST:
            kept, lost = ("slot s", "tooth") if p < s else ("tooth p", "slot")
            raise ValueError(
                f"tau = {self.tau:g} m leaves no {lost} beside a {kept} = {max(p, s):g} m: "
                f"p + s must equal tau, both >= {_NARROWEST:g} m"
            )
        if not math.isclose(p + s, self.tau, rel_tol=1e-9):
            raise ValueError(f"p + s = {p + s:g} m must equal tau = {self.tau:g} m")
        if self.sigma is None and not _SIGMA[0] <= p / s <= _SIGMA[1]:
            raise ValueError(
                f"p/s = {p / s:g} must be >= {_SIGMA[0]:g} and <= {_SIGMA[1]:g}, as sigma"
            )
        if self.sigma is not None and not math.isclose(p / s, self.sigma, rel_tol=1e-9):
            raise ValueError(f"p/s = {p / s:g} must equal sigma = {self.sigma:g}")
        return self

    @model_validator(mode="after")
    def _loading_has_a_range(self) -> Self:
        if self.loading_min >= self.loading_max:
            raise ValueError(
                f"loading_min = {self.loading_min:g} A/m must be below "
                f"loading_max = {self.loading_max:g} A/m"
            )
        return self

    @property
    def teeth(self) -> tuple[float, float]:
        """Return tooth and slot width p and s, m, as far as given, the rest from ``tau``."""
        match self.p, self.s:
            case None, None:
                sigma = 1.0 if self.sigma is None else self.sigma
                return self.tau * sigma / (1 + sigma), self.tau / (1 + sigma)
            case None, float(s):
                return self.tau - s, s
            case float(p), None:
                return p, self.tau - p
        return float(self.p or 0.0), float(self.s or 0.0)

    def resolved(self) -> Self:
        """Return a copy with ``p``, ``s`` and ``sigma`` filled in."""
        p, s = self.teeth
        sigma = p / s if self.sigma is None else self.sigma
        return self.model_copy(update={"p": p, "s": s, "sigma": sigma})


class Requirements(Choices):
    """Requirements of a motor; defaults from the paper."""


class SizedDimensions(Choices):
    """Results of sizing in addition to the choices: stack length and turns."""

    l_m: float = quantity(
        "Stack length of the mover",
        label="stack length",
        symbol="l_m",
        shown="mm",
        unit="m",
        source=SECTION,
        default=42.3e-3,
        ge=1e-5,
        le=100,
    )
    N: Whole = quantity(
        "Turns of a phase",
        label="turns",
        symbol="N",
        unit="1",
        source=SECTION,
        default=145,
        ge=1,
        le=10_000_000,
    )


def _mass(default: float) -> Any:
    source = f"{PAPER}, section IV-A"
    return quantity(
        "Moving mass",
        label="moving mass",
        unit="kg",
        source=source,
        default=default,
        ge=1e-3,
        le=1e4,
    )


def _platform_mass(default: float | None, source: str) -> Any:
    return quantity(
        "Mass that the velocity of one phase is computed with; left out where mass is given: mass",
        unit="kg",
        source=source,
        default=default,
        ge=1e-3,
        le=1e4,
    )


def _stroke(default: float) -> Any:
    source = f"{PAPER}, section V"
    return quantity(
        "Stroke, from end to end",
        shown="mm",
        unit="m",
        source=source,
        default=default,
        ge=1e-4,
        le=100,
    )


class Axis(Config):
    """Masses and stroke of one axis."""

    mass: float
    platform_mass: float | None
    stroke: float

    @model_validator(mode="before")
    @classmethod
    def _platform_follows_mass(cls, tables: Any) -> Any:
        if isinstance(tables, dict) and "mass" in tables:
            return {"platform_mass": None, **tables}
        return tables

    def resolved(self) -> Self:
        """Return a copy with ``platform_mass`` filled in."""
        platform = self.mass if self.platform_mass is None else self.platform_mass
        return self.model_copy(update={"platform_mass": platform})


class AxisX(Axis):
    """The light, inner axis."""

    mass: float = _mass(5.9)
    platform_mass: float | None = _platform_mass(5.7, f"{PAPER}, section II-B")
    stroke: float = _stroke(0.170)


class AxisY(Axis):
    """The heavy, outer axis."""

    mass: float = _mass(13.9)
    platform_mass: float | None = _platform_mass(None, f"{OURS}: the paper prints none")
    stroke: float = _stroke(0.290)


class Dimensions(SizedDimensions):
    """A machine as it is; the defaults are the paper's example."""

    single_phase_force: float = quantity(
        "Largest thrust of one phase",
        label="thrust, one phase",
        unit="N",
        source=f"{PAPER}: finite elements 34.1 N, measured 38.4 N",
        default=34.1,
        ge=1e-3,
        le=1e5,
    )
    two_phase_force: float = quantity(
        "Largest thrust of two phases together",
        label="thrust, two phases",
        unit="N",
        source=f"{PAPER}, section IV-A, measured",
        default=43.1,
        ge=1e-3,
        le=1e5,
    )
    x: AxisX = Field(default=AxisX(), description="The light, inner axis")
    y: AxisY = Field(default=AxisY(), description="The heavy, outer axis")

    def resolved(self) -> Self:
        """Return a copy with everything that follows from other fields filled in."""
        axes = {"x": self.x.resolved(), "y": self.y.resolved()}
        return super().resolved().model_copy(update=axes)


class DesignRequest(Config):
    """Request of a design; omitted fields have the preset's values."""

    preset: PresetName = Field(
        default="paper",
        json_schema_extra=choices(
            ("paper", "paper", "The motor of the paper"),
            ("previous", "previous", "The design before it: tau = 9 mm, n = 2"),
        ),
        description="paper: the example of the paper; previous: the design before it, of which the "
        "paper gives tau and n only",
    )
    requirements: Requirements = Field(
        default=Requirements(), description="From these follow dimensions"
    )
    dimensions: Dimensions | None = Field(
        default=None,
        description="From these follow limits; left out: the preset's, as far as it has any",
    )
