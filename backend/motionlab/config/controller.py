"""Controller configuration: gains, compensation, model of the motor, limits."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import Field

from motionlab.config.force_map import AnyForceMapConfig
from motionlab.config.plant import FrictionConfig
from motionlab.config.quantity import OURS, PAPER, Config, Text, choices, quantity

Law = Literal["off", "lugre-observer", "published-k", "residual-k", "canudas-de-wit", "reversed-k"]
SharingLaw = Literal["least-norm", "force-per-ampere", "sine", "cubic"]

LAWS = choices(
    ("off", "no compensation", "No friction is compensated; the observer runs all the same"),
    ("lugre-observer", "LuGre observer, K = 0", "The LuGre model driven by the velocity alone"),
    ("residual-k", "K from the residual", "K from the filtered residual of the force balance"),
    ("canudas-de-wit", "Canudas de Wit", "K in proportion to the following error, 1995"),
    ("reversed-k", "K, sign reversed", "Eq. (25) with the opposite sign and a filtered balance"),
    ("published-k", "K as published", "Eq. (25) as printed, which does not work in discrete time"),
)
"""Laws of friction compensation, with their names on the screen; motionlab.control.compensation."""

LAW_PARAMETERS: dict[Law, tuple[str, ...]] = {
    "off": (),
    "lugre-observer": ("velocity", "bristle_limit"),
    "residual-k": ("velocity", "bristle_limit", "gain", "residual_bandwidth", "regularisation"),
    "canudas-de-wit": ("velocity", "bristle_limit", "gain"),
    "reversed-k": ("velocity", "bristle_limit", "residual_bandwidth", "k_d_share"),
    "published-k": ("velocity", "bristle_limit"),
}
"""Fields of `CompensationConfig` that each law uses, beside ``enabled``."""

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


class CompensationConfig(Config):
    """Friction compensation; the laws are described in motionlab.control.compensation."""

    law: Law = Field(
        default="off",
        description="How the friction estimate is corrected",
        json_schema_extra=LAWS,
    )
    enabled: bool = Field(
        title="compensation",
        default=True,
        description="Add the estimate to the command; off, the observer runs all the same",
    )
    velocity: Literal["measured", "reference"] = Field(
        default="measured", description="Velocity that drives the observer"
    )
    gain: float | None = quantity(
        "Gain of K; left out: 300/s for canudas-de-wit; for residual-k 40/s, or 0.9 of its limit, "
        "below which its residual does not feed itself: 2 c sigma_0/sigma_1 of the controller's "
        "model, 1 + c^2 instead of 2 c from c = 1 on, c being the regularisation",
        label="gain of K",
        unit="1/s",
        source=OURS,
        default=None,
        ge=0,
        le=1e5,
    )
    residual_bandwidth: float = quantity(
        "Bandwidth of the filter of the force balance (residual-k, reversed-k)",
        unit="Hz",
        source=OURS,
        default=30.0,
        gt=0,
        le=1000,
    )
    regularisation: float = quantity(
        "What keeps e_z finite where D crosses zero, in units of sigma_0 (residual-k)",
        unit="1",
        source=OURS,
        default=0.4,
        gt=0,
        le=10,
    )
    bristle_limit: float | None = quantity(
        "Largest bristle estimate, in units of F_s/sigma_0; left out: 1.2 for residual-k and "
        "reversed-k, none otherwise",
        unit="1",
        source=OURS,
        default=None,
        gt=0,
        le=1000,
    )
    k_d_share: float = quantity(
        "Share of k_d in the denominator of (25) (reversed-k): 0 leaves K = -(M a - u)/sigma_1; "
        "0.001 takes the number of Table 1, in N s/mm, as N s/m",
        label="share of k_d",
        unit="1",
        source=OURS,
        default=0.0,
        ge=0,
        le=1,
    )


_CANUDAS_DE_WIT_GAIN = 300.0  # 1/s
_RESIDUAL_GAIN, _OF_LIMIT = 40.0, 0.9  # 1/s; of its limit, 1


def residual_gain_limit(friction: FrictionConfig, regularisation: float) -> float:
    """Return the gain, 1/s, from which on the residual of residual-k feeds itself; inf for none.

    Between two measurements ``r += alpha (gain sigma_1 d/(sigma_0 (d^2 + c^2)) - 1) r``, where
    ``d = abs(D)/sigma_0`` falls from 1 at rest to 0 with velocity: largest at d = c, or at rest.
    """
    if not friction.enabled or friction.sigma_1 == 0.0:
        return math.inf
    c = regularisation
    return (2.0 * c if c < 1.0 else 1.0 + c * c) * friction.sigma_0 / friction.sigma_1


def gain_of_K(config: CompensationConfig, model: FrictionConfig) -> float:
    """Return the gain of K on an axis, 1/s."""
    if config.gain is not None:
        return config.gain
    if config.law == "canudas-de-wit":
        return _CANUDAS_DE_WIT_GAIN
    return min(_RESIDUAL_GAIN, _OF_LIMIT * residual_gain_limit(model, config.regularisation))


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

    def refusal_of_gain(self, gain: float, regularisation: float) -> tuple[str, float] | None:
        """Return why a gain of residual-k is refused, and its limit, 1/s; None where it is not."""
        models = {"x": self.model.x.friction, "y": self.model.y.friction}
        limits = {
            axis: residual_gain_limit(friction, regularisation) for axis, friction in models.items()
        }
        axis = min(limits, key=lambda name: limits[name])
        if self.compensation.law != "residual-k" or gain < limits[axis]:
            return None
        factor = "2 c" if regularisation < 1.0 else "(1 + c^2)"
        return (
            f"is unstable on {axis}: the residual feeds itself from {factor} sigma_0/sigma_1 = "
            f"{limits[axis]:.4g} 1/s on, with sigma_0 = {models[axis].sigma_0:.4g} N/m and "
            f"sigma_1 = {models[axis].sigma_1:.4g} N s/m of the controller's model and "
            f"c = {regularisation:g}, its regularisation; lower the gain or raise c",
            limits[axis],
        )
