"""Limits of the motor that a time-optimal motion profile has been planned for."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from motionlab.config.quantity import Config, quantity

_FILLED_IN = "filled in from the motor and the controllers when a scenario is prepared"

Thrusts = Annotated[
    tuple[Annotated[float, Field(ge=0.0, le=1e6)], ...],
    Field(strict=False, min_length=1, max_length=1024),
]
"""Thrust at evenly spaced positions of a pole pitch, N."""


class PlannedAxis(Config):
    """Limits of one axis, which a time-optimal profile keeps."""

    velocity_max: float = quantity(
        "Largest velocity", unit="m/s", source=_FILLED_IN, gt=0.0, le=1e3
    )
    acceleration_max: float = quantity(
        "Largest acceleration", unit="m/s^2", source=_FILLED_IN, gt=0.0, le=1e6
    )
    mass: float = quantity("Moving mass", unit="kg", source=_FILLED_IN, gt=0.0, le=1e6)
    F_c: float = quantity("Coulomb friction", unit="N", source=_FILLED_IN, ge=0.0, le=1e6)
    F_s: float = quantity("Static friction", unit="N", source=_FILLED_IN, ge=0.0, le=1e6)
    v_s: float = quantity("Stribeck velocity", unit="m/s", source=_FILLED_IN, gt=0.0, le=1e3)
    sigma_2: float = quantity("Viscous friction", unit="N s/m", source=_FILLED_IN, ge=0.0, le=1e6)
    pitch: float = quantity(
        "Pole pitch, over which the thrust repeats", unit="m", source=_FILLED_IN, gt=0.0, le=1.0
    )
    forward: Thrusts = quantity(
        "Available thrust in positive direction, from position 0 on over a pole pitch; between "
        "them it is interpolated linearly",
        unit="N",
        source=_FILLED_IN,
    )
    backward: Thrusts = quantity("The same in negative direction", unit="N", source=_FILLED_IN)

    @model_validator(mode="after")
    def _has_both_directions(self) -> Self:
        if len(self.forward) != len(self.backward):
            raise ValueError("forward and backward need equally many values")
        return self


class PlannedMotor(Config):
    """Limits of both axes, which a time-optimal profile keeps."""

    x: PlannedAxis = quantity("Limits of x", unit="", source=_FILLED_IN)
    y: PlannedAxis = quantity("Limits of y", unit="", source=_FILLED_IN)
