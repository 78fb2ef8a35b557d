"""Controller configuration: gains, compensation, model of the motor, limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field, create_model

from motionlab.config.force_map import AnyForceMapConfig
from motionlab.config.plant import FrictionConfig
from motionlab.config.quantity import OURS, PAPER, Config, Text, choices, quantity
from motionlab.laws import LAWS, PARAMETERS, Parameter
from motionlab.laws.law import Refusal

if TYPE_CHECKING:
    Law = str
else:
    Law = Literal[tuple(LAWS)]
"""Name of a law of friction compensation; `motionlab.laws`."""

SharingLaw = Literal["least-norm", "force-per-ampere", "sine", "cubic"]

SHARINGS = choices(
    ("least-norm", "least norm", "In proportion to the square of what each phase can give"),
    ("force-per-ampere", "force per ampere", "Least copper loss for the force"),
    ("sine", "sine", "Classical, one phase hands over to the next along a sine"),
    ("cubic", "cubic", "Classical, one phase hands over to the next along a cubic"),
)
"""Force-sharing functions; motionlab.force_sharing.functions."""

HAND_OVER = ["sine", "cubic"]
"""Force-sharing functions of which the overlap is a parameter."""


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


class AxisModelConfig(Config):
    """A controller's model of one axis."""

    mass: float = quantity(
        "Moving mass", unit="kg", source=f"{PAPER}, section IV-A", ge=1e-3, le=1000
    )
    friction: FrictionConfig
    force_map: AnyForceMapConfig = Field(description="Thrust over position and current")


class ModelConfig(Config):
    """The controller's model of the motor; by name it is read off a shipped motor."""

    x: AxisModelConfig
    y: AxisModelConfig


def _field(parameter: Parameter) -> Any:
    """Return the type and the declaration of a law's parameter as a field of a config."""
    each = parameter
    users: Any = [law.name for law in LAWS.values() if each in law.parameters]
    if each.choices:
        choice = Field(
            default=each.default,
            title=each.label,
            description=each.description,
            json_schema_extra={"used_with": users},
        )
        return Literal[each.choices], choice
    declared = quantity(
        each.description,
        label=each.label,
        unit=each.unit,
        source=each.source,
        default=each.default,
        ge=each.ge,
        gt=each.gt,
        le=each.le,
        lt=each.lt,
        usual=each.usual,
        used_with=users,
    )
    return (float if each.default is not None else float | None), declared


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

    def values(self) -> dict[str, Any]:
        """Return the parameters of all laws, by name."""
        return {name: getattr(self, name) for name in PARAMETERS}


_Declared: Any = create_model(
    "_Declared",
    __base__=_AnyLaw,
    __doc__="Parameters of all laws.",
    **{each.name: _field(each) for each in PARAMETERS.values()},
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


class SharingConfig(Config):
    """Force-sharing function of the phases; docs/sharing.md."""

    law: SharingLaw = Field(
        title="force sharing",
        default="least-norm",
        description="least-norm: in proportion to the square of what each phase can give; "
        "force-per-ampere: least copper loss; sine, cubic: classical sharing functions",
        json_schema_extra=SHARINGS,
    )
    overlap: float = quantity(
        "Share of the pole pitch over which one phase hands over to the next (sine, cubic)",
        shown="% of pitch",
        unit="1",
        source=f"{OURS}: a sixth is all that two phases have in common",
        default=1 / 6,
        ge=0.005,
        le=1 / 6,
        used_with=HAND_OVER,
    )


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
