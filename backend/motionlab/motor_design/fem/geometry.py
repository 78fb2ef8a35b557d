"""The cross-section of one phase: a U-core of two toothed limbs over a toothed plane."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

from pydantic import model_validator

from motionlab.config.quantity import Config, quantity
from motionlab.config.validation_errors import checked

PAPER = "Huang et al., IEEE Access 2019, section II-A"
OURS = "this project's choice; the paper leaves it open"
_FITS = f"{OURS}, fits its mover height of 36 mm and its mean iron path of 145.1 mm"


class Geometry(Config):
    """Lengths of one phase's magnetic circuit, its turns and its largest current."""

    tau: float = quantity(
        "Pole pitch",
        label="pole pitch",
        symbol="tau",
        shown="mm",
        unit="m",
        source=PAPER,
        default=7.2e-3,
        ge=1e-3,
        le=0.1,
    )
    p: float = quantity(
        "Tooth width, below the pitch",
        label="tooth",
        symbol="p",
        shown="mm",
        unit="m",
        source=PAPER,
        default=3.6e-3,
        ge=2e-4,
        le=0.1,
    )
    g: float = quantity(
        "Air gap",
        label="air gap",
        symbol="g",
        shown="mm",
        unit="m",
        source=PAPER,
        default=0.3e-3,
        ge=2e-5,
        le=5e-3,
    )
    n: int = quantity(
        "Teeth on each of the two limbs",
        label="teeth per limb",
        symbol="n",
        unit="1",
        source=PAPER,
        default=3,
        ge=1,
        le=8,
    )
    l_m: float = quantity(
        "Stack length",
        label="stack length",
        symbol="l_m",
        shown="mm",
        unit="m",
        source=PAPER,
        default=42.3e-3,
        ge=1e-3,
        le=1.0,
    )
    N: int = quantity(
        "Turns of a phase",
        label="turns",
        symbol="N",
        unit="1",
        source=PAPER,
        default=145,
        ge=1,
        le=10_000,
    )
    i: float = quantity(
        "Largest current",
        label="largest current",
        symbol="i",
        unit="A",
        source=PAPER,
        default=10.0,
        ge=0.1,
        le=1000,
    )
    tooth_depth: float = quantity(
        "Depth of the mover's teeth",
        shown="mm",
        unit="m",
        source=_FITS,
        default=3.6e-3,
        ge=2e-4,
        le=0.1,
    )
    shoe: float = quantity(
        "Height of the shoe that carries a limb's teeth",
        label="shoe height",
        shown="mm",
        unit="m",
        source=_FITS,
        default=5.4e-3,
        ge=2e-4,
        le=0.1,
    )
    limb: float = quantity(
        "Width of a limb, flush with the outer edge of its shoe",
        label="limb width",
        shown="mm",
        unit="m",
        source=_FITS,
        default=9e-3,
        ge=5e-4,
        le=0.5,
    )
    yoke: float = quantity(
        "Height of the yoke",
        label="yoke height",
        shown="mm",
        unit="m",
        source=_FITS,
        default=9e-3,
        ge=5e-4,
        le=0.5,
    )
    window: float = quantity(
        "Height of the window between shoes and yoke",
        label="window height",
        shown="mm",
        unit="m",
        source=_FITS,
        default=18e-3,
        ge=5e-4,
        le=0.5,
    )
    coil: float = quantity(
        "Width of a coil side beside its limb",
        label="coil width",
        shown="mm",
        unit="m",
        source=OURS,
        default=9e-3,
        ge=2e-4,
        le=0.5,
    )
    stator_tooth_depth: float = quantity(
        "Depth of the stator's teeth",
        shown="mm",
        unit="m",
        source=_FITS,
        default=5.4e-3,
        ge=2e-4,
        le=0.1,
    )
    stator_back: float = quantity(
        "Height of the stator below its teeth",
        label="stator back",
        shown="mm",
        unit="m",
        source=_FITS,
        default=10.1e-3,
        ge=5e-4,
        le=0.5,
    )
    stacking: float = quantity(
        "Share of iron in the stack",
        label="iron in the stack",
        unit="1",
        source=OURS,
        default=0.96,
        ge=0.5,
        le=1,
    )
    post: float = quantity(
        "Share of the stack that stator teeth face; square posts half of it, bars all",
        label="share of stator posts",
        unit="1",
        source=f"{PAPER}, as (4) is read",
        default=0.5,
        ge=0.1,
        le=1,
    )

    @model_validator(mode="after")
    def _teeth_leave_slots(self) -> Self:
        if self.p >= self.tau:
            raise ValueError(
                f"teeth overlap: p = {self.p:g} m must be below the pitch tau = {self.tau:g} m"
            )
        if not 0.1 <= self.p / self.tau <= 0.9:
            raise ValueError(
                f"p/tau = {self.p / self.tau:.3g} is out of range (p = {self.p:g} m, "
                f"tau = {self.tau:g} m); allowed >= 0.1 and <= 0.9"
            )
        if self.g > self.s / 2:
            raise ValueError(f"g = {self.g:g} m must be at most half of a slot, {self.s / 2:g} m")
        return self

    @model_validator(mode="after")
    def _window_holds_the_coils(self) -> Self:
        if self.limb > self.shoe_width:
            raise ValueError(
                f"limb = {self.limb:g} m must be at most its shoe's width, {self.shoe_width:g} m"
            )
        if 2 * self.coil > self.window_width:
            raise ValueError(
                f"coils overlap: coil = {self.coil:g} m must be at most half of the window, "
                f"{self.window_width / 2:g} m"
            )
        return self

    @property
    def s(self) -> float:
        """Return the slot width, m."""
        return self.tau - self.p

    @property
    def shoe_width(self) -> float:
        """Return the width of one limb's shoe, n tau - s, m."""
        return self.n * self.tau - self.s

    @property
    def width(self) -> float:
        """Return the mover's width, 2 n tau - s, m."""
        return 2 * self.n * self.tau - self.s

    @property
    def window_width(self) -> float:
        """Return the clear width between the limbs, m."""
        return self.width - 2 * self.limb

    @property
    def gap_length(self) -> float:
        """Return the stack length that the gap acts with, m.

        ``l_g = l_m (1 - gamma g/tau)``, ``gamma = (z/g)^2/(5 + z/g)`` (Carter) with the slots
        ``z = (1 - post) tau`` that posts leave along the stack; bars leave none.
        """
        ratio = (1 - self.post) * self.tau / self.g
        return self.l_m * (1 - ratio**2 / (5 + ratio) * self.g / self.tau)


def geometry(fields: Mapping[str, Any]) -> Geometry:
    """Return a geometry with some fields changed.

    Raises
    ------
    ConfigError
        Naming every field that is wrong, its value, range and unit.
    """
    return checked(Geometry, fields, "geometry")
