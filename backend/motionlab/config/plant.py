"""The motor and its imperfections: the truth, not what a controller believes."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from motionlab.config.quantity import Config, quantity
from motionlab.config.timing import PLANT_STEP

PAPER = "Huang et al., IEEE Access 2019"
OURS = "this project's choice"

_Gain = Annotated[float, Field(ge=0.0, le=2.0)]
_Offset = Annotated[float, Field(ge=-10.0, le=10.0)]
Gains = Annotated[tuple[_Gain, _Gain, _Gain], Field(strict=False)]
"""A gain for each of the phases a, b, c."""
Offsets = Annotated[tuple[_Offset, _Offset, _Offset], Field(strict=False)]
"""An offset, A, for each of the phases a, b, c."""


class FrictionConfig(Config):
    """LuGre friction, eqs (20) to (22); the paper identifies its values in eqs (43) to (48)."""

    enabled: bool = Field(
        default=True, description="Friction acts at all; off is a frictionless axis"
    )
    sigma_0: float = quantity(
        "Bristle stiffness", unit="N/m", source=f"{PAPER}, eqs (43), (46)", ge=1, le=1e8
    )
    sigma_1: float = quantity(
        "Bristle damping", unit="N s/m", source=f"{PAPER}, eqs (43), (46)", ge=0, le=1e6
    )
    sigma_2: float = quantity(
        "Viscous friction", unit="N s/m", source=f"{PAPER}, eqs (43), (46)", ge=0, le=1e4
    )
    F_c: float = quantity(
        "Coulomb friction", unit="N", source=f"{PAPER}, eqs (45), (48)", ge=1e-6, le=100
    )
    F_s: float = quantity("Stiction", unit="N", source=f"{PAPER}, eqs (45), (48)", ge=1e-6, le=100)
    v_s: float = quantity(
        "Stribeck velocity", unit="m/s", source=f"{PAPER}, eqs (45), (48)", gt=1e-5, le=10
    )

    @model_validator(mode="after")
    def _stiction_is_the_larger(self) -> Self:
        if self.F_s < self.F_c:
            raise ValueError(f"F_s = {self.F_s:g} N is below F_c = {self.F_c:g} N")
        return self


class ForceMapConfig(Config):
    """Analytic thrust F(i) S(theta) of each phase; see docs/symbols.md."""

    tau: float = quantity("Pole pitch", unit="m", source=f"{PAPER}, eq. (2)", gt=1e-4, le=0.1)
    offset: float = quantity(
        "Commutation offset: by how much the map is shifted against the encoder",
        unit="m",
        source=OURS,
        default=0.0,
        ge=-0.1,
        le=0.1,
    )
    F_pk: float = quantity(
        "Thrust of one phase at the peak current",
        unit="N",
        source=f"{PAPER}: finite elements 34.1 N, measured 38.4 N",
        gt=1e-3,
        le=1000,
    )
    N_pk: float = quantity(
        "Normal force of one phase at the peak current, aligned",
        unit="N",
        source=f"{PAPER}: finite elements 380.1 N, measured 427.4 N",
        ge=0,
        le=1e5,
    )
    I_pk: float = quantity("Peak current", unit="A", source=f"{PAPER}, section II", gt=1e-3, le=100)
    I_knee: float = quantity(
        "Current at which saturation sets in",
        unit="A",
        source=f"{OURS}, from a finite-element model of the paper's geometry",
        gt=1e-3,
        le=1000,
    )
    h_2: float = quantity(
        "Second harmonic of thrust over position",
        unit="1",
        source=OURS,
        default=0.0,
        ge=-0.3,
        le=0.3,
    )
    h_3: float = quantity(
        "Third harmonic of thrust over position",
        unit="1",
        source="0.039 follows from the paper's 43.1 N over 38.4 N = (1 + 2 h_3)/(1 - h_3)",
        default=0.0,
        ge=-0.3,
        le=0.3,
    )


class AmplifierConfig(Config):
    """Three current amplifiers: ``di/dt = omega (gain command + offset + ripple + noise - i)``."""

    bandwidth: float | None = quantity(
        "Bandwidth of the current loops; left out: currents follow at once",
        unit="Hz",
        source=f"{OURS}; the paper prints none",
        default=None,
        gt=0,
        le=100_000,
    )
    gain: Gains = quantity(
        "Current per commanded current, phases a, b, c",
        unit="1",
        source=OURS,
        default=(1.0, 1.0, 1.0),
    )
    offset: Offsets = quantity(
        "Current at zero command, phases a, b, c", unit="A", source=OURS, default=(0.0, 0.0, 0.0)
    )
    ripple_amplitude: float = quantity(
        "Amplitude of a sinusoidal ripple; the phases are a third of its period apart",
        unit="A",
        source=OURS,
        default=0.0,
        ge=0,
        le=10,
    )
    ripple_frequency: float = quantity(
        "Frequency of the ripple, held over each control period",
        unit="Hz",
        source=f"{OURS}: six pulses of a 50 Hz supply",
        default=300.0,
        gt=0,
        le=1000,
    )
    noise: float = quantity(
        "White noise of each current, held over each control period, rms",
        unit="A",
        source=OURS,
        default=0.0,
        ge=0,
        le=10,
    )
    limit: float = quantity(
        "Largest current either way",
        unit="A",
        source=f"{PAPER}, section IV-A",
        default=10.0,
        gt=0,
        le=100,
    )


class EncoderConfig(Config):
    """Linear encoder."""

    resolution: float = quantity(
        "Size of one count; 0 is an exact encoder",
        unit="m",
        source=f"{PAPER}, section IV-A",
        default=50e-9,
        ge=0,
        le=1e-3,
    )
    sde_amplitude: float = quantity(
        "Amplitude of the sub-divisional error", unit="m", source=OURS, default=0.0, ge=0, le=1e-5
    )
    sde_period: float = quantity(
        "Period of the subdivided scale",
        unit="m",
        source="20 um scales are usual for optical encoders of this class",
        default=20e-6,
        gt=1e-7,
        le=1e-2,
    )
    noise: float = quantity(
        "White noise of the reading, rms", unit="m", source=OURS, default=0.0, ge=0, le=1e-4
    )
    interface_rate: float = quantity(
        "Largest frequency the interface counts; a note warns above 4 rate resolution",
        unit="Hz",
        source=f"{PAPER}, section IV-A",
        default=1.25e6,
        gt=0,
        le=1e9,
    )


class AxisConfig(Config):
    """One axis of the motor."""

    mass: float = quantity(
        "Moving mass", unit="kg", source=f"{PAPER}, section IV-A", ge=1e-3, le=1000
    )
    stroke: float = quantity(
        "Largest distance from mid-stroke, inclusive",
        unit="m",
        source=f"{PAPER}: 170 mm by 290 mm",
        gt=0,
        le=1,
    )
    velocity_max: float = quantity(
        "Largest velocity of a trajectory",
        unit="m/s",
        source=f"{PAPER}, section II: specified 1 m/s",
        gt=0,
        le=10,
    )
    acceleration_max: float = quantity(
        "Largest acceleration of a trajectory",
        unit="m/s^2",
        source=f"{PAPER}, section IV-A: 43.1 N over the mass",
        gt=0,
        le=100,
    )
    stop_distance: float = quantity(
        "Distance of the end stops beyond the stroke",
        unit="m",
        source=OURS,
        default=1e-3,
        gt=0,
        le=0.1,
    )
    stop_stiffness: float = quantity(
        "Stiffness of the end stops", unit="N/m", source=OURS, default=2e6, gt=0, le=1e7
    )
    stop_damping: float = quantity(
        "Damping of the end stops", unit="N s/m", source=OURS, default=2e3, ge=0, le=1e4
    )
    friction: FrictionConfig
    force_map: ForceMapConfig
    amplifiers: AmplifierConfig = AmplifierConfig()
    encoder: EncoderConfig = EncoderConfig()

    @model_validator(mode="after")
    def _can_be_stepped(self) -> Self:
        """Refuse a mass that friction or end stops would throw about within one step."""
        h = PLANT_STEP
        friction = self.friction if self.friction.enabled else None
        needs = {
            "stop_damping": h * self.stop_damping,
            "stop_stiffness": h * h * self.stop_stiffness,
            "friction.sigma_0": 0.0 if friction is None else h * h * friction.sigma_0,
            "friction.sigma_1": 0.0 if friction is None else h * friction.sigma_1,
        }
        cause, least = max(needs.items(), key=lambda item: item[1])
        if self.mass < least:
            raise ValueError(
                f"mass = {self.mass:g} kg is too small for {cause}: steps of {h * 1e6:g} us need "
                f">= {least:.4g} kg"
            )
        return self


class PlantConfig(Config):
    """The planar motor: two decoupled axes."""

    name: str = Field(default="custom", description="Name of the shipped motor it started from")
    description: str = Field(default="", description="What this motor stands for")
    force: Literal["phases", "ideal"] = Field(
        default="phases",
        description="phases: three phases with currents; ideal: any force commanded acts at once",
    )
    x: AxisConfig
    y: AxisConfig
