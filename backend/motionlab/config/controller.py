"""Controller configuration: gains, compensation, model of the motor, limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field, create_model, field_validator

from motionlab.config.force_map import AnyForceMapConfig
from motionlab.config.plant import FrictionConfig
from motionlab.config.quantity import Config, Text, choices, declared_field, quantity
from motionlab.declarations import OURS, PAPER
from motionlab.force_sharing.functions import FUNCTIONS
from motionlab.force_sharing.functions import PARAMETERS as SHARING_PARAMETERS
from motionlab.laws import LAWS, PARAMETERS, Parameter
from motionlab.laws.law import Refusal

if TYPE_CHECKING:
    Law = SharingLaw = str
else:
    Law = Literal[tuple(LAWS)]
    SharingLaw = Literal[tuple(FUNCTIONS)]
"""Names of laws of friction compensation, `motionlab.laws`, and of force-sharing functions."""


class NotchConfig(Config):
    """A notch filter on PD and disturbance observer, against a resonance; not in the paper."""

    frequency: float = quantity(
        "Frequency that is held back",
        label="notch frequency",
        symbol="f",
        unit="Hz",
        source=OURS,
        default=250.0,
        ge=1,
        le=900,
    )
    damping: float = quantity(
        "Damping ratio of its poles: half its relative width",
        label="notch damping",
        symbol="zeta",
        unit="1",
        source=OURS,
        default=0.5,
        gt=0,
        le=2,
    )
    gain: float = quantity(
        "Gain at its frequency; 1 is no notch",
        label="notch gain",
        unit="1",
        source=OURS,
        default=1.0,
        example=0.1,
        ge=0,
        le=1,
    )


class GainsConfig(Config):
    """PD gains of one axis; the paper prints them in N/mm and N s/mm."""

    k_p: float = quantity(
        "Proportional gain",
        label="k_p",
        shown="N/mm",
        unit="N/m",
        source=f"{PAPER}, Table 1",
        usual=(1e4, 1e7),
        ge=0,
        le=1e9,
    )
    k_d: float = quantity(
        "Derivative gain",
        label="k_d",
        shown="N s/mm",
        unit="N s/m",
        source=f"{PAPER}, Table 1",
        usual=(1e2, 1e5),
        ge=0,
        le=1e7,
    )
    notch: NotchConfig = Field(
        default=NotchConfig(), description="Notch filter on the feedback, against a resonance"
    )


class SubdivisionConfig(Config):
    """What a controller knows of its encoder's sub-divisional error, and takes off each reading.

    ``S sin(2 pi p/period) + C cos(2 pi p/period)``; learnt from laps: docs/learning.md.
    """

    sine: float = quantity(
        "Amplitude of the known error's sine",
        label="known error, sine",
        shown="nm",
        unit="m",
        source=OURS,
        default=0.0,
        ge=-1e-5,
        le=1e-5,
    )
    cosine: float = quantity(
        "Amplitude of the known error's cosine",
        label="known error, cosine",
        shown="nm",
        unit="m",
        source=OURS,
        default=0.0,
        ge=-1e-5,
        le=1e-5,
    )
    period: float = quantity(
        "Period of the scale in the controller's model",
        label="scale period",
        shown="\u00b5m",
        unit="m",
        source="20 um scales are usual for optical encoders of this class",
        default=20e-6,
        gt=1e-7,
        le=1e-2,
    )


class AxisModelConfig(Config):
    """A controller's model of one axis."""

    mass: float = quantity(
        "Moving mass", unit="kg", source=f"{PAPER}, section IV-A", ge=1e-3, le=1000
    )
    friction: FrictionConfig
    force_map: AnyForceMapConfig = Field(description="Thrust over position and current")
    subdivision: SubdivisionConfig = Field(
        default=SubdivisionConfig(),
        title="known encoder error",
        description="Sub-divisional error of the encoder that is corrected",
    )


class ModelConfig(Config):
    """The controller's model of the motor; by name it is read off a shipped motor."""

    x: AxisModelConfig
    y: AxisModelConfig


def _fields(parameters: Mapping[str, Parameter], owners: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of parameters, each with the names of those that declare it."""
    return {
        name: declared_field(
            each, [owner.name for owner in owners.values() if each in owner.parameters]
        )
        for name, each in parameters.items()
    }


class _AnyLaw(Config):
    """What every law of friction compensation has."""

    law: Law = Field(
        default="off",
        description="How the friction estimate is corrected",
        json_schema_extra=choices(
            *((each.name, each.label, each.description) for each in LAWS.values())
        ),
    )
    enabled: bool = Field(
        title="compensation",
        default=True,
        description="Add the estimate to the command; off, the observer runs all the same",
    )

    @field_validator("law")
    @classmethod
    def _is_made_of_lanes(cls, law: str) -> str:
        from motionlab.targets.record_law import lane_error  # noqa: PLC0415 - see pyproject.toml

        if reason := lane_error(LAWS[law]):
            raise ValueError(f"is not made of lanes: {reason}")
        return law

    def values(self) -> dict[str, Any]:
        """Return the parameters of all laws, by name."""
        return {name: getattr(self, name) for name in PARAMETERS}


_Declared: Any = create_model(
    "_Declared",
    __base__=_AnyLaw,
    __doc__="Parameters of all laws.",
    **_fields(PARAMETERS, LAWS),
)


class CompensationConfig(_Declared):
    """Friction compensation; each law uses the parameters that it declares: `motionlab.laws`."""


class DisturbanceObserverConfig(Config):
    """Disturbance observer on the force balance, friction estimate excepted."""

    enabled: bool = Field(
        title="disturbance observer",
        default=False,
        description="Disturbance observer: add what the force balance does not explain",
        json_schema_extra={"symbol": "DOB"},
    )
    bandwidth: float = quantity(
        "Bandwidth of its filter",
        label="observer bandwidth",
        unit="Hz",
        source=OURS,
        default=30.0,
        gt=0,
        le=500,
    )


class _AnySharing(Config):
    """What every force-sharing function has."""

    law: SharingLaw = Field(
        title="force sharing",
        default=next(iter(FUNCTIONS)),
        description="How a force command is split among the phases",
        json_schema_extra=choices(
            *((each.name, each.label, each.description) for each in FUNCTIONS.values())
        ),
    )

    def parameters(self) -> dict[str, float]:
        """Return the parameters of all functions, by name."""
        return {name: getattr(self, name) for name in SHARING_PARAMETERS}


_DeclaredSharing: Any = create_model(
    "_DeclaredSharing",
    __base__=_AnySharing,
    __doc__="Parameters of all force-sharing functions.",
    **_fields(SHARING_PARAMETERS, FUNCTIONS),
)


class SharingConfig(_DeclaredSharing):
    """Force-sharing function of the phases, with the parameters that it declares."""


class ControllerConfig(Config):
    """A position controller for both axes."""

    name: Text = Field(
        default="custom", description="Name of the shipped controller it started from"
    )
    description: Text = Field(default="", description="What this controller is for")
    x: GainsConfig
    y: GainsConfig
    compensation: CompensationConfig = CompensationConfig()
    feedforward: bool = Field(default=False, description="Add mass times reference acceleration")
    disturbance_observer: DisturbanceObserverConfig = DisturbanceObserverConfig()
    learnt: bool = Field(
        title="learnt force",
        default=False,
        description="Add the force that was learnt of the motion, if the scenario has one",
    )
    sharing: SharingConfig = SharingConfig()
    delay: int = quantity(
        "Control periods between a measurement and the command made from it",
        unit="1",
        source=f"{OURS}: 0, because one sample of delay makes the 0.5 um gains limit-cycle",
        default=0,
        ge=0,
        le=1,
    )
    force_limit: float = quantity(
        "Largest force command",
        unit="N",
        source=f"{PAPER}, section IV-A",
        default=40.0,
        gt=0,
        le=1000,
    )
    current_limit: float = quantity(
        "Largest current command",
        unit="A",
        source=f"{PAPER}, section IV-A",
        default=10.0,
        gt=0,
        le=100,
    )
    model: ModelConfig

    def refusal(self, changes: Mapping[str, Any] | None = None) -> tuple[str, Refusal] | None:
        """Return on which axis, and why, the law does not work with its parameters, if so.

        `changes` are values of parameters in place of those of the config, by name.
        """
        law, values = LAWS[self.compensation.law], self.compensation.values() | (changes or {})
        refusals = [
            (axis, refusal)
            for axis, model in (("x", self.model.x), ("y", self.model.y))
            if (refusal := law.refuse(values, model.friction.parameters())) is not None
        ]
        return min(refusals, key=lambda each: each[1].limit, default=None)
