"""Plant configuration: the simulated motor and its imperfections."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from motionlab.config.effects import EffectConfig
from motionlab.config.force_map import AnyForceMapConfig
from motionlab.config.quantity import Config, Text, quantity
from motionlab.declarations import OURS, PAPER
from motionlab.effects import EFFECTS, SLOTS
from motionlab.plant.friction import FRICTIONLESS, LuGre
from motionlab.timing import PLANT_STEP

_Gain = Annotated[float, Field(ge=0.0, le=2.0)]
_Offset = Annotated[float, Field(ge=-10.0, le=10.0)]
Gains = Annotated[tuple[_Gain, _Gain, _Gain], Field(strict=False)]
"""A gain for each of the phases a, b, c."""
Offsets = Annotated[tuple[_Offset, _Offset, _Offset], Field(strict=False)]
"""An offset, A, for each of the phases a, b, c."""


class FrictionConfig(Config):
    """LuGre friction, eqs (20) to (22); the paper identifies its values in eqs (43) to (48)."""

    enabled: bool = Field(
        title="friction",
        default=True,
        description="Friction acts at all; off is a frictionless axis",
    )
    sigma_0: float = quantity(
        "Bristle stiffness",
        label="stiffness \u03c3_0",
        shown="N/mm",
        unit="N/m",
        source=f"{PAPER}, eqs (43), (46)",
        ge=1,
        le=1e8,
    )
    sigma_1: float = quantity(
        "Bristle damping",
        label="damping \u03c3_1",
        shown="N s/mm",
        unit="N s/m",
        source=f"{PAPER}, eqs (43), (46)",
        ge=0,
        le=1e6,
    )
    sigma_2: float = quantity(
        "Viscous friction",
        label="viscous \u03c3_2",
        unit="N s/m",
        source=f"{PAPER}, eqs (43), (46)",
        ge=0,
        le=1e4,
    )
    F_c: float = quantity(
        "Coulomb friction",
        label="Coulomb F_c",
        unit="N",
        source=f"{PAPER}, eqs (45), (48)",
        ge=1e-6,
        le=100,
    )
    F_s: float = quantity(
        "Stiction",
        label="stiction F_s",
        unit="N",
        source=f"{PAPER}, eqs (45), (48)",
        ge=1e-6,
        le=100,
    )
    v_s: float = quantity(
        "Stribeck velocity",
        label="speed v_s",
        shown="mm/s",
        unit="m/s",
        source=f"{PAPER}, eqs (45), (48)",
        gt=1e-5,
        le=10,
    )

    @model_validator(mode="after")
    def _stiction_is_the_larger(self) -> Self:
        if self.F_s < self.F_c:
            raise ValueError(f"F_s = {self.F_s:g} N is below F_c = {self.F_c:g} N")
        return self

    def parameters(self) -> LuGre:
        """Return the parameters of a lane; none of the friction where it is off."""
        if not self.enabled:
            return FRICTIONLESS
        return LuGre(**self.model_dump(exclude={"enabled"}))


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
        label="amplifier gain",
        unit="1",
        source=OURS,
        default=(1.0, 1.0, 1.0),
    )
    offset: Offsets = quantity(
        "Current at zero command, phases a, b, c",
        label="amplifier offset",
        unit="A",
        source=OURS,
        default=(0.0, 0.0, 0.0),
    )
    ripple_amplitude: float = quantity(
        "Amplitude of a sinusoidal ripple; the phases are a third of its period apart",
        label="ripple",
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
        label="current limit",
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
        label="encoder count",
        shown="nm",
        unit="m",
        source=f"{PAPER}, section IV-A",
        default=50e-9,
        ge=0,
        le=1e-3,
    )
    sde_amplitude: float = quantity(
        "Amplitude of the sub-divisional error",
        label="encoder error",
        shown="nm",
        unit="m",
        source=OURS,
        default=0.0,
        ge=0,
        le=1e-5,
    )
    sde_period: float = quantity(
        "Period of the subdivided scale",
        shown="µm",
        unit="m",
        source="20 um scales are usual for optical encoders of this class",
        default=20e-6,
        gt=1e-7,
        le=1e-2,
    )
    noise: float = quantity(
        "White noise of the reading, rms",
        label="encoder noise",
        shown="nm",
        unit="m",
        source=OURS,
        default=0.0,
        ge=0,
        le=1e-4,
    )
    jitter: float = quantity(
        "White noise of the instant at which it samples, rms: of the reading, times the velocity",
        label="sampling jitter",
        shown="µs",
        unit="s",
        source=OURS,
        default=0.0,
        ge=0,
        le=1e-4,
        example=1e-6,
        usual=(1e-7, 2e-5),
    )
    interface_rate: float = quantity(
        "Largest frequency the interface counts; a note warns above 4 rate resolution",
        unit="Hz",
        source=f"{PAPER}, section IV-A",
        default=1.25e6,
        gt=0,
        le=1e9,
    )


class ResonanceConfig(Config):
    """One flexible mode between guides and encoder, excited by the thrust; see docs/physics.md."""

    frequency: float = quantity(
        "Undamped natural frequency of the mode",
        label="resonance",
        unit="Hz",
        source=f"{OURS}; the paper prints none",
        default=150.0,
        ge=1,
        le=2000,
    )
    damping: float = quantity(
        "Damping ratio of the mode",
        label="mode damping",
        unit="1",
        source=OURS,
        default=0.02,
        ge=0,
        le=0.9,
    )
    coupling: float = quantity(
        "Deflection seen by the encoder per deflection of the mode; 0 is no resonance, -1 the far "
        "end of two masses on a spring, > 0 an encoder that moves with the thrust",
        label="mode coupling",
        unit="1",
        source=OURS,
        default=0.0,
        ge=-10,
        le=10,
    )


class AxisConfig(Config):
    """One axis of the motor."""

    mass: float = quantity(
        "Moving mass", unit="kg", source=f"{PAPER}, section IV-A", ge=1e-3, le=1000
    )
    stroke: float = quantity(
        "Largest distance from mid-stroke, inclusive",
        shown="mm",
        unit="m",
        source=f"{PAPER}: 170 mm by 290 mm",
        gt=0,
        le=1,
    )
    velocity_max: float = quantity(
        "Largest velocity of a trajectory",
        label="max speed",
        shown="mm/s",
        unit="m/s",
        source=f"{PAPER}, section II: specified 1 m/s",
        gt=0,
        le=10,
    )
    acceleration_max: float = quantity(
        "Largest acceleration of a trajectory",
        label="max accel.",
        unit="m/s^2",
        source=f"{PAPER}, section IV-A: 43.1 N over the mass",
        gt=0,
        le=100,
    )
    stop_distance: float = quantity(
        "Distance of the end stops beyond the stroke",
        shown="mm",
        unit="m",
        source=OURS,
        default=1e-3,
        gt=0,
        le=0.1,
    )
    stop_stiffness: float = quantity(
        "Stiffness of the end stops",
        shown="N/mm",
        unit="N/m",
        source=OURS,
        default=2e6,
        gt=0,
        le=1e7,
    )
    stop_damping: float = quantity(
        "Damping of the end stops",
        shown="N s/mm",
        unit="N s/m",
        source=OURS,
        default=2e3,
        ge=0,
        le=1e4,
    )
    friction: FrictionConfig
    force_map: AnyForceMapConfig = Field(description="Thrust over position and current")
    amplifiers: AmplifierConfig = AmplifierConfig()
    encoder: EncoderConfig = EncoderConfig()
    resonance: ResonanceConfig = ResonanceConfig()
    effects: Annotated[tuple[EffectConfig, ...], Field(strict=False, max_length=SLOTS)] = Field(
        default=(),
        description="Effects that act besides, such as other friction or cogging; they add up",
    )

    def effect_lanes(self) -> list[tuple[str, Any]]:
        """Return name and `Parameters` of each effect, as plain numbers."""
        if not self.effects:
            return []
        friction = LuGre(**self.friction.model_dump(exclude={"enabled"}))
        return [each.lane(friction) for each in self.effects]

    @model_validator(mode="after")
    def _has_effects_that_work(self) -> Self:
        from motionlab.targets.record_law import lane_error  # noqa: PLC0415 - see pyproject.toml

        for name, par in self.effect_lanes():
            if reason := lane_error(EFFECTS[name]):
                raise ValueError(f"effect {name} is not made of lanes: {reason}")
            if reason := EFFECTS[name].refuse(par):
                raise ValueError(f"effect {name}: {reason}")
        return self

    @model_validator(mode="after")
    def _can_be_stepped(self) -> Self:
        """Check the numerical stability limit of the explicit step."""
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

    name: Text = Field(default="custom", description="Name of the shipped motor it started from")
    description: Text = Field(default="", description="What this motor stands for")
    force: Literal["phases", "ideal"] = Field(
        default="phases",
        description="phases: three phases with currents; ideal: any force commanded acts at once",
    )
    x: AxisConfig
    y: AxisConfig
