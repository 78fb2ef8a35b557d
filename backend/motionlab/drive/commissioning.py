"""Commissioning: what a person checks before a machine moves, step after step, and what was found.

A step is offered once those before it hold. Doing one again forgets those after it. What was found
is one document, kept as a file.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from motionlab.config.drive import DriveConfig
from motionlab.config.planar import AXES
from motionlab.drive.link.carrier import LinkError
from motionlab.store.files import failure, opened, replace

StepName = Literal["drives", "identity", "encoders"]
TRAVEL = 500e-6
"""How far an axis is moved by hand until its direction is known, m."""
_TEXT_MAX = 1000
_FILE_MAX = 100_000  # bytes


class Step(NamedTuple):
    """One step, as a person reads it."""

    name: StepName
    title: str
    task: str


STEPS = (
    Step("drives", "Find drives", "Counts the drives on the bus and checks that all are in OP."),
    Step(
        "identity",
        "Identity and limits",
        "Compares vendor, product and rated current of each drive with the configuration.",
    ),
    Step(
        "encoders",
        "Encoders, moved by hand",
        "Torque is off. Push the mover by half a millimetre or more towards +x, then towards +y.",
    ),
)
_ORDER: list[StepName] = [step.name for step in STEPS]


class FoundFigure(BaseModel):
    """One figure that was found, beside what is expected."""

    model_config = ConfigDict(extra="forbid")

    name: str = Field(max_length=_TEXT_MAX)
    found: str = Field(max_length=_TEXT_MAX)
    expected: str = Field(max_length=_TEXT_MAX)
    holds: bool


class ConfigChange(BaseModel):
    """A value of the configuration that does not fit what was found."""

    model_config = ConfigDict(extra="forbid")

    path: str = Field(max_length=_TEXT_MAX)
    now: float
    then: float


class Finding(BaseModel):
    """What a step has found."""

    model_config = ConfigDict(extra="forbid")

    at: float = Field(description="Wall clock, s since 1970")
    holds: bool
    text: str = Field(max_length=_TEXT_MAX, description="In one line")
    rows: list[FoundFigure] = Field(default_factory=list, max_length=64)
    changes: list[ConfigChange] = Field(
        default_factory=list, max_length=64, description="To be made in the file of the link"
    )


class CommissioningRecord(BaseModel):
    """All that was found on one machine."""

    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"examples": [{"link": "Virtual drive", "findings": {}}]}
    )

    link: str = Field(max_length=200, description="Title of the drive link")
    findings: dict[StepName, Finding] = Field(default_factory=dict)


class ByHand:
    """A mover that is pushed by hand, and which way each axis was moved first.

    Parameters
    ----------
    start : sequence of float
        Position of x and y, m.
    """

    def __init__(self, start: Sequence[float]) -> None:
        self._start = tuple(start)
        self._now = self._start
        self.travel: list[float | None] = [None, None]

    @property
    def moved(self) -> tuple[float, float]:
        """How far each axis is from where it was, m."""
        x, y = (now - start for now, start in zip(self._now, self._start, strict=True))
        return x, y

    @property
    def complete(self) -> bool:
        """Whether both axes have been moved far enough."""
        return None not in self.travel

    def note(self, position: Sequence[float]) -> None:
        """Take a position; the first move beyond `TRAVEL` tells the direction of its axis."""
        self._now = tuple(position)
        for axis, moved in enumerate(self.moved):
            if self.travel[axis] is None and abs(moved) >= TRAVEL:
                self.travel[axis] = moved


class Commissioning:
    """The steps of one drive link and what they found.

    Parameters
    ----------
    config : DriveConfig
        The link.
    path : Path
        File of the document.
    """

    def __init__(self, config: DriveConfig, path: Path) -> None:
        self._config = config
        self._path = path
        self.by_hand: ByHand | None = None
        self.record = self._kept() or CommissioningRecord(link=config.title)

    @property
    def present(self) -> StepName | None:
        """The step that is to be done; None when all hold."""
        for name in _ORDER:
            finding = self.record.findings.get(name)
            if finding is None or not finding.holds:
                return name
        return None

    def begin(self, name: StepName) -> None:
        """Forget a step and those after it.

        Raises
        ------
        LinkError
            If a step before it does not hold.
        """
        present = self.present
        if present is not None and _ORDER.index(name) > _ORDER.index(present):
            raise LinkError(f"{_title(present)} comes first")
        kept = _ORDER[: _ORDER.index(name)]
        findings = {step: self.record.findings[step] for step in kept}
        self.record = self.record.model_copy(update={"findings": findings})
        self.by_hand = None

    def put(self, name: StepName, finding: Finding) -> None:
        """Keep what a step has found, in the file too.

        Raises
        ------
        StoreError
            If the file cannot be written.
        """
        self.begin(name)
        findings = self.record.findings | {name: finding}
        self.record = self.record.model_copy(update={"findings": findings})
        self._keep()

    def load(self, record: CommissioningRecord) -> None:
        """Take another document, as far as its steps follow one another.

        Raises
        ------
        LinkError
            If it is of another link.
        StoreError
            If the file cannot be written.
        """
        if record.link != self._config.title:
            raise LinkError(
                f"this document is of the link {record.link!r}, not of {self._config.title!r}"
            )
        findings: dict[StepName, Finding] = {}
        for name in _ORDER:
            if name not in record.findings:
                break
            findings[name] = record.findings[name]
        self.by_hand = None
        self.record = CommissioningRecord(link=record.link, findings=findings)
        self._keep()

    def find_drives(self, found: Sequence[dict[str, Any]]) -> Finding:
        """Return what was found on the bus."""
        expected = len(self._config.nodes)
        right = len(found) == expected
        names = ", ".join(dict.fromkeys(drive["name"] for drive in found))
        return Finding(
            at=time.time(),
            holds=right,
            text=f"{len(found)} of {expected} found, in OP: {names}",
        )

    def compare_identity(self, found: Sequence[dict[str, Any]]) -> Finding:
        """Return each drive's identity and rated current beside what the configuration says."""
        rows = [
            FoundFigure(
                name=f"{number} {node.axis} {node.phase}",
                found=_identity(drive["vendor"], drive["product"], drive["rated_current"])
                + f", serial {drive['serial']}",
                expected=_identity(node.vendor, node.product, node.rated_current),
                holds=(drive["vendor"], drive["product"]) == (node.vendor, node.product)
                and abs(drive["rated_current"] - node.rated_current) < 1e-3,
            )
            for number, (node, drive) in enumerate(
                zip(self._config.nodes, found, strict=True), start=1
            )
        ]
        right = sum(row.holds for row in rows)
        rated = " and ".join(f"{value:g} A" for value in _rated(self._config))
        return Finding(
            at=time.time(),
            holds=right == len(rows),
            text=f"{right} of {len(rows)} match; {rated} rated",
            rows=rows,
        )

    def judge_encoders(self, by_hand: ByHand) -> Finding:
        """Return whether positions grew when the mover was pushed towards positive positions."""
        rows, changes = [], []
        for axis, travel in zip(AXES, by_hand.travel, strict=True):
            config = getattr(self._config, axis)
            right = travel is not None and travel > 0
            rows.append(
                FoundFigure(
                    name=axis,
                    found=f"{1e3 * (travel or 0.0):+.3f} mm",
                    expected="positive",
                    holds=right,
                )
            )
            if not right:
                changes.append(
                    ConfigChange(
                        path=f"{axis}.direction", now=config.direction, then=-config.direction
                    )
                )
        wrong = " and ".join(row.name for row in rows if not row.holds)
        return Finding(
            at=time.time(),
            holds=not wrong,
            text=f"{wrong} counts the wrong way" if wrong else "both signs right",
            rows=rows,
            changes=changes,
        )

    def _keep(self) -> None:
        try:
            replace(self._path, self.record.model_dump_json(indent=2).encode())
        except OSError as error:
            raise failure("the commissioning document cannot be written", error) from error

    def _kept(self) -> CommissioningRecord | None:
        """Return the document of the file; None where there is none of this link."""
        try:
            with opened(self._path) as file:
                record = CommissioningRecord.model_validate_json(file.read(_FILE_MAX))
        except (OSError, ValidationError):
            return None
        return record if record.link == self._config.title else None


def _title(name: StepName) -> str:
    return next(step.title for step in STEPS if step.name == name)


def _identity(vendor: int, product: int, rated: float) -> str:
    return f"0x{vendor:08X}, 0x{product:04X}, {rated:g} A"


def _rated(config: DriveConfig) -> list[float]:
    return sorted({node.rated_current for node in config.nodes})
