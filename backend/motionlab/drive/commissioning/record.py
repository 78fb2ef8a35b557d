"""The document of commissioning: what each step found, and what was changed for it."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import Annotated, Literal, NamedTuple

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from motionlab.config.drive import DriveConfig
from motionlab.config.validation_errors import field_errors
from motionlab.errors import ConfigError

StepName = Literal[
    "drives",
    "identity",
    "encoders",
    "currents",
    "commutation",
    "homing",
    "hold",
    "friction",
    "response",
]
_TEXT_MAX = 1000
_Value = Annotated[float, AfterValidator(lambda value: value + 0.0)]  # -0 is 0 in a browser's JSON
Serial = Annotated[int, Field(ge=0, lt=2**32)]


class Step(NamedTuple):
    """One step, as a person reads it."""

    name: StepName
    title: str
    task: str
    torque: bool = False


STEPS = (
    Step("drives", "Find drives", "Counts the drives on the bus and checks that all are in OP."),
    Step(
        "identity",
        "Identity and limits",
        "Compares vendor, product, rated current and limits of each drive with the configuration.",
    ),
    Step(
        "encoders",
        "Encoders, moved by hand",
        "Torque is off. Push the mover by half a millimetre or more towards +x, then towards +y.",
    ),
    Step(
        "currents",
        "Phase currents, one by one",
        "Each drive alone gets a tenth of its largest current and must report it; no other may.",
        torque=True,
    ),
    Step(
        "commutation",
        "Commutation offset",
        "Draws each axis from phase to phase, up a pitch and down. Keep two pitches free.",
        torque=True,
    ),
    Step(
        "homing",
        "Homing",
        "Draws each axis slowly to both end stops, then to the middle. Keep the stroke clear.",
        torque=True,
    ),
    Step(
        "hold",
        "Low-gain loop",
        "Holds the position with low gains and moves each axis 2 mm forth and back.",
        torque=True,
    ),
    Step(
        "friction",
        "Identification",
        "Moves both axes slowly there and back, records a run and identifies friction from it.",
        torque=True,
    ),
    Step(
        "response",
        "Frequency response",
        "Slides each axis to and fro under a small multisine and measures its response, recorded.",
        torque=True,
    ),
)
ORDER: list[StepName] = [step.name for step in STEPS]


def step_of(name: StepName) -> Step:
    """Return a step by its name."""
    return STEPS[ORDER.index(name)]


class FoundFigure(BaseModel):
    """One figure that was found, beside what is expected."""

    model_config = ConfigDict(extra="forbid")

    name: str = Field(max_length=_TEXT_MAX)
    found: str = Field(max_length=_TEXT_MAX)
    expected: str = Field(max_length=_TEXT_MAX)
    holds: bool


class ConfigChange(BaseModel):
    """A value of the configuration that does not fit what was found."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"examples": [{"path": "x.offset", "now": 0.0, "then": 0.0012}]},
    )

    path: str = Field(pattern=r"^[xy]\.(direction|offset)$", description="In the file of the link")
    now: _Value = Field(allow_inf_nan=False)
    then: _Value = Field(allow_inf_nan=False)


class Finding(BaseModel):
    """What a step has found."""

    model_config = ConfigDict(extra="forbid")

    at: float = Field(allow_inf_nan=False, description="Wall clock, s since 1970")
    holds: bool
    text: str = Field(max_length=_TEXT_MAX, description="In one line")
    rows: list[FoundFigure] = Field(default_factory=list, max_length=64)
    changes: list[ConfigChange] = Field(
        default_factory=list, max_length=64, description="To be taken before the step is done again"
    )
    run: str | None = Field(
        default=None, pattern="^r-[a-z2-7]{12}$", description="Run from which it was found"
    )


class Findings:
    """What a step finds on its way, axis by axis."""

    def __init__(self) -> None:
        self.rows: list[FoundFigure] = []
        self.changes: list[ConfigChange] = []
        self._texts: list[str] = []

    def row(self, name: str, *, found: str, expected: str, holds: bool) -> None:
        """Add a figure beside what is expected."""
        self.rows.append(FoundFigure(name=name, found=found, expected=expected, holds=holds))

    def change(self, path: str, *, now: float, then: float) -> None:
        """Add a value of the configuration that does not fit."""
        self.changes.append(ConfigChange(path=path, now=now, then=then))

    def tell(self, text: str) -> None:
        """Add to the line of text."""
        self._texts.append(text)

    def finding(self) -> Finding:
        """Return all of it; it holds where every figure does."""
        return Finding(
            at=time.time(),
            holds=all(row.holds for row in self.rows),
            text="; ".join(self._texts),
            rows=self.rows,
            changes=self.changes,
        )


class CommissioningRecord(BaseModel):
    """All that was found on one machine."""

    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"examples": [{"link": "Virtual drive", "findings": {}}]}
    )

    link: str = Field(max_length=200, description="Title of the drive link")
    serials: list[Serial] = Field(
        default_factory=list,
        max_length=64,
        description="Serial numbers of the drives on which it was found, in the order of the bus",
    )
    findings: dict[StepName, Finding] = Field(default_factory=dict)
    taken: list[ConfigChange] = Field(
        default_factory=list,
        max_length=64,
        description="Changes in effect: `now` is the value of the file, `then` the one in effect",
    )
    seal: str = Field(
        default="",
        pattern="^([0-9a-f]{64})?$",
        description="Of the server that found it; a document with any change has another one",
    )

    @property
    def empty(self) -> bool:
        """Whether nothing was found, and nothing changed."""
        return not self.findings and not self.taken


def in_effect(config: DriveConfig, taken: Iterable[ConfigChange]) -> DriveConfig:
    """Return the configuration of a file with changes.

    Raises
    ------
    ConfigError
        If a value is out of its range.
    """
    document = config.model_dump()
    for change in taken:
        axis, field = change.path.split(".")
        whole = field == "direction" and change.then in {1.0, -1.0}
        document[axis][field] = int(change.then) if whole else change.then
    try:
        return DriveConfig.model_validate(document)
    except ValidationError as error:
        raise ConfigError(*field_errors(error, DriveConfig)) from None


def value_at(config: DriveConfig, path: str) -> float:
    """Return the value of a configuration that a change names."""
    axis, field = path.split(".")
    return float(getattr(getattr(config, axis), field))
