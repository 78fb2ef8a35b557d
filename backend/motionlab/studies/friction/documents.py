"""Request and result of a selection among friction models."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.quantity import choices, si
from motionlab.declarations import NAME_MAX
from motionlab.effects import EFFECTS, Effect
from motionlab.library.run import ID
from motionlab.studies.identify.documents import RecordOptions


def comparable() -> list[Effect]:
    """Return the effects of friction; LuGre and GMS are compared anyway."""
    return [each for each in EFFECTS.values() if each.friction and each.name not in _ANYWAY]


_ANYWAY = frozenset({"lugre", "gms"})
"""Effects that are models already."""


class FrictionModelsRequest(RecordOptions):
    """A run whose friction is compared with models."""

    run: Annotated[str, Field(pattern=ID)] = Field(description="Identifier of a kept run")
    axis: Literal["x", "y"] = Field(default="x", description="Axis whose channels are read")
    normal_force_column: str | None = Field(
        default=None,
        max_length=120,
        description="Column of the normal force of the guide; left out: normal_force of the "
        "variant, or that of the currents by the force map of the driving variant",
    )
    effects: list[Annotated[str, Field(min_length=1, max_length=NAME_MAX)]] = Field(
        default_factory=list,
        max_length=4,
        description="Effects of friction, such as one's own, that are compared too",
        json_schema_extra=choices(*((each.name, each.label) for each in comparable())),
    )
    normal_force_magnitude: bool = Field(
        default=False,
        description="Whether the normal force is the magnitude of its column, such as the force or "
        "torque of a gear",
    )
    scenario: str | dict[str, Any] = Field(
        default="circle",
        description="Whose force map makes thrust of recorded currents, and at whose friction "
        "parameters of effects begin that have no default",
    )
    set: dict[str, Any] = Field(
        default_factory=dict, max_length=4096, description="Dotted path to value, SI"
    )


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class ModelParameter(_Document):
    """A parameter of a friction model, fitted to the whole record."""

    value: float
    unit: str
    low: float | None = Field(
        repr=False, description="Of the 95 % interval; null where the record does not determine it"
    )
    high: float | None = Field(repr=False, description="The same")

    def derived(self) -> dict[str, float | None]:
        """Return half of the 95 % interval."""
        return {"+-": None if self.high is None else self.high - self.value}


class FrictionModel(_Document):
    """A friction model and what it leaves of a record."""

    name: str = Field(repr=False)
    label: str
    complexity: int = Field(description="Number of its parameters")
    error: float = Field(description="Held-out error: RMS force that is left, in `force_unit`")
    difference: float = Field(description="Of that error to the least one")
    difference_error: float = Field(description="Its standard error")
    fitted: float = Field(description="RMS force that a fit to the whole record leaves")
    parameters: dict[str, ModelParameter] = Field(
        description="Of the fit to the whole record, if the machine follows this model; none where "
        "no model explains the force"
    )


class FrictionModelsDocument(_Document):
    """Which friction model a record supports."""

    labels: ClassVar[dict[str, str]] = {"among": "indistinguishable from"}
    foot: ClassVar[str] = (
        "Errors are of windows that the model was not fitted to; +- is half of the 95 % interval."
    )

    run: str
    name: str = Field(description="Of the run")
    axis: str
    position: str = Field(description="Column of the position")
    force: str = Field(description="Column of the force, or currents")
    normal_force: str | None = Field(description="Where the normal force comes from; null: none")
    force_unit: str
    duration: float = si("Of the part that was read", "s")
    rate: float = si("Samples a second", "Hz")
    bandwidth: float = si("Of the filter at -3 dB", "Hz")
    reversals: int
    windows: int = Field(description="Windows that count")
    friction: float = Field(description="RMS of the best model's friction, in `force_unit`")
    models: list[FrictionModel] = Field(description="In the order of their complexity")
    best: str = Field(description="Model of the least held-out error")
    selected: str | None = Field(description="The model that the record supports; null: no one")
    among: list[str] = Field(description="Models that the record does not tell apart, or the one")
    reasons: list[str] = Field(description="Why it cannot be told")
    describes: bool = Field(
        description="Whether that model, or the best, describes the friction; false too where more "
        "than 5 % of the friction depends on what no model has a term for"
    )
    notes: list[str] = Field(
        description="Models that were not tried, and why; what is left over and on what it depends"
    )
    version: str
