"""Requests of identifications."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from motionlab.config.plant import OURS, PAPER
from motionlab.config.quantity import Config, quantity
from motionlab.config.scenario import VariantName
from motionlab.config.validation_errors import checked
from motionlab.library.run import ID as RUN_ID

SPEEDS = tuple(float(f"{v:.4g}") for v in np.geomspace(0.5e-3, 0.15, 32))
"""Speeds of the uniform motions, m/s: 0.5 to 150 mm/s, each as far from the next in ratio."""

FEWEST_SPEEDS = 5
_BLIND = 6
_COLUMN_MAX = 120
RAMPS_MAX = 8
"""Rates of force ramps in one experiment: they are simulated side by side."""

_Speed = Annotated[float, Field(ge=1e-4, le=1.0)]
_Rate = Annotated[float, Field(ge=0.1, le=1000.0)]


class ForceRamps(Config):
    """Open-loop force ramps below stiction."""

    enabled: bool = Field(default=True, description="Identify sigma_0 and sigma_1 too")
    rates: Annotated[tuple[_Rate, ...], Field(strict=False, min_length=1, max_length=RAMPS_MAX)] = (
        quantity(
            "Rates of the force ramps; a warning below 20 N/s, where ripple spoils them",
            label="rates of the ramps",
            unit="N/s",
            source=OURS,
            default=(20.0, 50.0, 100.0),
        )
    )
    share: float = quantity(
        "Largest force of a ramp, as a share of the stiction just identified",
        label="share of F_s",
        unit="1",
        shown="%",
        source=OURS,
        default=0.5,
        ge=0.05,
        le=0.5,
    )
    places: int = quantity(
        "Places in one pole pitch at which the ramps are repeated",
        unit="1",
        source=OURS,
        default=7,
        ge=4,
        le=25,
    )

    @model_validator(mode="after")
    def _sees_the_ripple(self) -> Self:
        if self.places == _BLIND:
            raise ValueError(
                "places = 6 all see the same part of a ripple that repeats six times a pole "
                "pitch: take 5 or 7"
            )
        return self


class RecordOptions(Config):
    """What of a run is read; all but the run itself is found where it is left out."""

    variant: VariantName | None = Field(
        default=None,
        title="variant of the run",
        description="Variant of the run whose channels are read; left out: its first",
    )
    position: str | None = Field(
        default=None,
        max_length=_COLUMN_MAX,
        description="Column of the position; left out: position_measured of the variant",
    )
    force: str | None = Field(
        default=None,
        max_length=_COLUMN_MAX,
        description="Column of the force, or currents: thrust of the three currents by the force "
        "map of the driving variant; left out: currents, force_realised, force_command or thrust, "
        "the first that the run has",
    )
    mass: float | None = quantity(
        "Moving mass; left out: identified too",
        unit="kg",
        source=OURS,
        default=None,
        ge=1e-3,
        le=1e4,
    )
    bandwidth: float | None = quantity(
        "Bandwidth of the filter at -3 dB; left out: 50 Hz, or 0.075 of the sample rate where that "
        "is less",
        unit="Hz",
        source=OURS,
        default=None,
        ge=0.1,
        le=1000.0,
    )
    start: float = quantity(
        "Where the part of the run that is used begins",
        label="from",
        unit="s",
        source=OURS,
        default=0.0,
        ge=0.0,
        le=1e9,
    )
    end: float | None = quantity(
        "Where it ends; left out: the end of the run",
        label="to",
        unit="s",
        source=OURS,
        default=None,
        gt=0.0,
        le=1e9,
    )


class IdentifyRequest(Config):
    """Request of an identification."""

    scenario: str | dict[str, Any] = Field(
        default="circle", description="Name of a shipped scenario, or its tables: motor and loop"
    )
    set: dict[str, Any] = Field(
        default_factory=dict, max_length=4096, description="Dotted path to value, SI"
    )
    axis: Literal["x", "y", "both"] = Field(default="both", description="Axes to identify")
    speeds: Annotated[
        tuple[_Speed, ...], Field(strict=False, min_length=FEWEST_SPEEDS, max_length=200)
    ] = quantity(
        "Speeds of the uniform motions; each is run both ways",
        shown="mm/s",
        unit="m/s",
        source=f"{PAPER}, section IV: many; the list is this project's choice",
        default=SPEEDS,
    )
    time_max: float = quantity(
        "Time after which a uniform motion takes no further pole pitch; one is always taken",
        label="time of each",
        unit="s",
        source=OURS,
        default=20.0,
        gt=0,
        le=3600,
    )
    pitches_max: int | None = quantity(
        "Most pole pitches that a force is averaged over; left out: as many as time and stroke "
        "allow",
        label="most pole pitches",
        unit="1",
        source=OURS,
        default=None,
        ge=1,
        le=1000,
    )
    presliding: ForceRamps = Field(default=ForceRamps(), title="force ramps")
    variant: VariantName | None = Field(
        default=None,
        title="driven by",
        description="Variant whose gains and force map drive the motor; left out: the first",
    )
    apply_to: VariantName | None = Field(
        default=None,
        title="model of",
        description="Variant whose model the result is for; left out: the second, or the only one",
    )
    run: Annotated[str, Field(pattern=RUN_ID)] | None = Field(
        default=None,
        title="measured run",
        description="Run to identify from; nothing moves then, and speeds, times and ramps do not "
        "matter",
    )
    record: RecordOptions = Field(default=RecordOptions(), title="of the run")
    compare: bool = Field(
        default=False,
        description="Run the circle under that variant with its old model (A) and the new one (B)",
    )

    @model_validator(mode="after")
    def _speeds_differ(self) -> Self:
        if len(set(self.speeds)) < len(self.speeds):
            raise ValueError("speeds must differ from one another")
        if len(set(self.presliding.rates)) < len(self.presliding.rates):
            raise ValueError("presliding.rates must differ from one another")
        return self

    @property
    def axes(self) -> tuple[str, ...]:
        """The axes, in order."""
        return ("x", "y") if self.axis == "both" else (self.axis,)


def read_request(request: Mapping[str, Any]) -> IdentifyRequest:
    """Return a request, checked; raise ConfigError naming every field that is wrong."""
    return checked(IdentifyRequest, request, "identify")
