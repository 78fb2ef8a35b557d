"""Controller configuration: gains, compensation, model of the motor, limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, create_model, field_validator, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from motionlab.config.force_map import AnyForceMapConfig
from motionlab.config.plant import FrictionConfig
from motionlab.config.quantity import Config, Text, choices, declared_field, quantity
from motionlab.declarations import OURS, PAPER
from motionlab.force_sharing.functions import FUNCTIONS
from motionlab.force_sharing.functions import PARAMETERS as SHARING_PARAMETERS
from motionlab.laws import LAWS, PARAMETERS, REDECLARED, Parameter
from motionlab.laws.law import Refusal

if TYPE_CHECKING:
    SharingLaw = str
else:
    SharingLaw = Literal[tuple(FUNCTIONS)]
"""Names of force-sharing functions."""


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


def _frequency(of: str, *, label: str, example: float) -> Any:
    return quantity(
        f"Natural frequency of the {of}",
        label=label,
        unit="Hz",
        source=OURS,
        default=0.0,
        example=example,
        ge=0,
        le=900,
    )


def _damping(of: str, *, label: str, default: float) -> Any:
    return quantity(
        f"Damping ratio of the {of}",
        label=label,
        unit="1",
        source=OURS,
        default=default,
        ge=0,
        le=5,
    )


class FilterConfig(Config):
    """A filter of second order on PD and disturbance observer; gain 1 at rest; not in the paper.

    ``(s^2/omega_z^2 + 2 zeta_z s/omega_z + 1)/(s^2/omega_p^2 + 2 zeta_p s/omega_p + 1)``: a notch,
    a lead where the zeros lie below the poles, a low-pass without zeros.
    """

    zeros_frequency: float = _frequency("zeros; 0: no zeros", label="zeros, frequency", example=200)
    zeros_damping: float = _damping("zeros", label="zeros, damping", default=0.7)
    poles_frequency: float = _frequency(
        "poles; 0: no filter", label="poles, frequency", example=400
    )
    poles_damping: float = _damping("poles", label="poles, damping", default=0.7)

    @model_validator(mode="after")
    def _is_proper_and_stable(self) -> Self:
        for name in ("zeros_frequency", "poles_frequency"):
            if 0.0 < (frequency := getattr(self, name)) < _LEAST_FREQUENCY:
                raise ValueError(
                    f"{name} must be 0, for none, or at least {_LEAST_FREQUENCY:g} Hz; "
                    f"got {frequency:g} Hz"
                )
        if self.zeros_frequency > 0.0 and self.poles_frequency == 0.0:
            raise ValueError(
                "zeros_frequency needs poles_frequency above 0 Hz: zeros alone differentiate; "
                f"got {self.zeros_frequency:g} Hz and 0 Hz"
            )
        if self.poles_frequency > 0.0 and self.poles_damping < _LEAST_DAMPING:
            raise ValueError(
                f"poles_damping must be at least {_LEAST_DAMPING:g} where there are poles; "
                f"got {self.poles_damping:g}"
            )
        return self


_LEAST_DAMPING = 0.01
_LEAST_FREQUENCY = 1.0  # Hz


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
    filter_1: FilterConfig = Field(
        default=FilterConfig(), description="Filter of second order after the notch"
    )
    filter_2: FilterConfig = Field(default=FilterConfig(), description="Another after it")
    filter_3: FilterConfig = Field(default=FilterConfig(), description="And another")


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


class CompensationConfig(Config):
    """Friction compensation; each law uses the parameters that it declares: `motionlab.laws`."""

    law: str = "off"
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
        """Return the parameters of all laws, by name; the default of one that has come since."""
        there = vars(self)
        return {name: there.get(name, each.default) for name, each in [*PARAMETERS.items()]}


_VALIDATOR: list[Any] = []
"""The one of the present declarations: not that of the class, which a rebuild takes away first."""
_NO_LAW = CompensationConfig()
"""The default of a controller."""


def _redeclare() -> None:
    """Give configs the names of the present laws and the parameters that those declare.

    The model is rebuilt in place: models that have it validate through `_AsDeclared`.
    """
    law = Field(
        default="off",
        description="How the friction estimate is corrected",
        json_schema_extra=choices(
            *((each.name, each.label, each.description) for each in LAWS.values())
        ),
    )
    declared: dict[str, Any] = {"law": (Literal[tuple(LAWS)], law)} | _fields(PARAMETERS, LAWS)
    fields: Any = CompensationConfig.__pydantic_fields__
    for name in fields.keys() - {"law", "enabled"} - declared.keys():
        del fields[name]
    for name, (annotation, field) in declared.items():
        fields[name] = FieldInfo.from_annotated_attribute(annotation, field)
    CompensationConfig.model_rebuild(force=True)
    _VALIDATOR[:] = [CompensationConfig.__pydantic_validator__]
    vars(_NO_LAW).update(vars(CompensationConfig()))


_redeclare()
REDECLARED.append(_redeclare)


class _AsDeclared:
    """Has a field validated as the laws are declared then, not when its model was built."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        def validated(value: Any, _: Any) -> Any:
            return _VALIDATOR[0].validate_python(value)

        return core_schema.no_info_wrap_validator_function(
            validated, handler(source), serialization=core_schema.simple_ser_schema("any")
        )

    def __get_pydantic_json_schema__(self, _: Any, handler: Any) -> Any:
        model = CompensationConfig
        ref = f"{model.__module__}.{model.__qualname__}:{id(model)}"  # or it has no name there
        named: Any = {**model.__pydantic_core_schema__, "ref": ref}
        there = core_schema.definition_reference_schema(ref)
        return handler(core_schema.definitions_schema(there, [named]))


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
    compensation: Annotated[CompensationConfig, _AsDeclared()] = _NO_LAW
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
        law, values = LAWS[self.compensation.law], {**self.compensation.values(), **(changes or {})}
        refusals = [
            (axis, refusal)
            for axis, model in (("x", self.model.x), ("y", self.model.y))
            if (refusal := law.refuse(values, model.friction.parameters())) is not None
        ]
        return min(refusals, key=lambda each: each[1].limit, default=None)
