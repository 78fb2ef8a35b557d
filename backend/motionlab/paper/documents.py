"""Request and documents of the reproduction of the paper's numbers."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

Comparison = Literal["value", "at_most", "at_least", "within", "none"]
"""Meaning of a printed number: a value, an upper or lower bound, a range, or not comparable."""

Status = Literal["holds", "fails", "known_failure", "not_comparable"]

Kind = Literal["printed", "claim", "formula", "recovered", "arithmetic", "fit", "input", "no_data"]
"""Kind of a row's evidence: `motionlab.paper.documents.KINDS` explains each."""

Number = float | tuple[float, float]
"""One number, or the two ends of a range."""


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class Recipe(_Document):
    """Commands and calls that give the number."""

    scenario: str | None = Field(description="Shipped scenario to open in the Lab; null for none")
    set: dict[str, Any] = Field(description="Changes to that scenario, dotted path to value")
    cli: str = Field(description="Command that computes it")
    curl: str = Field(description="The same over REST")
    find: list[str] = Field(
        description="Where in the document that both print; empty where the number is derived"
    )


class PaperRow(_Document):
    """A printed number and how it is judged, before anything is computed."""

    id: str = Field(description="Name, as --only takes it")
    group: str = Field(description="Identifier of the group it is shown in")
    kind: Kind = Field(description="What is set beside what, in the words of `kinds`")
    place: str = Field(description="Where it is printed")
    quantity: str = Field(description="What it is")
    unit: str = Field(description="SI unit of every number of the row; 1 for a pure number")
    comparison: Comparison = Field(
        description="value: within the band; at_most, at_least: a bound, being better is no "
        "failure; within: a range that ours must not leave; none: nothing to compare"
    )
    paper: Number | None = Field(description="As printed, SI; null where it prints a claim only")
    printed: str = Field(description="As printed, in its own words")
    band: float | None = Field(description="How far off still holds; null where nothing is judged")
    reason: str = Field(description="Why the band is that wide, or why nothing can be compared")
    basis: str = Field(description="What ours is: which motor, which controller, which formula")
    fitted: bool = Field(description="Ours was fitted to this number: that it holds proves nothing")
    note: str = Field(description="What a reader has to know; empty for nothing")
    conflict: str = Field(
        description="Another row's value of the same thing, with which this one cannot agree, and "
        "which of them ours is held against; empty for none"
    )
    known: str | None = Field(description="Why it is known to fail; null where it is not")
    figure: str | None = Field(description="Identifier of the figure that shows it")
    recipe: Recipe


class RowValue(_Document):
    """A further value in addition to the judged one."""

    label: str
    value: Number | None


class RowSpread(_Document):
    """The number over many random motors, fitted to nothing."""

    what: str = Field(description="Which number, under which controller")
    low: float = Field(description="5 % of the motors lie below")
    median: float
    high: float = Field(description="95 % of the motors lie below")
    plants: int = Field(description="How many motors have the number")
    share: float | None = Field(
        description="Share of all motors that keep the printed bound, band included; null where "
        "that is not asked"
    )
    cli: str = Field(description="Command that computes it")


class JudgedRow(PaperRow):
    """A printed number and ours."""

    ours: Number | None = Field(description="Ours, SI; null where nothing can be computed")
    holds: bool | None = Field(description="Whether it holds; null where nothing is judged")
    status: Status
    better: bool | None = Field(
        description="Ours is better than a bound asks for; null where there is no bound"
    )
    lax: str = Field(
        description="Why nearly any model would hold this row; empty where it would not, or where "
        "ours does not hold"
    )
    values: list[RowValue] = Field(description="Ours under other controllers and on other motors")
    monte_carlo: RowSpread | None = Field(description="null where it is not of a run")
    error: str | None = Field(description="Why there is no number although there should be one")


class PaperGroup(_Document):
    """Rows that are shown together: a section, a table or a figure of the paper."""

    id: str
    title: str
    about: str


class PaperKind(_Document):
    """A kind of row, in words."""

    id: Kind
    title: str
    about: str


class FigureAxis(_Document):
    """An axis of a figure."""

    label: str
    unit: str = Field(description="SI")
    log: bool = Field(default=False, description="Drawn over its logarithm")


Role = Literal["A", "B", "reference", "phase-a", "phase-b", "phase-c", "x", "y", "printed"]


class FigureSeries(_Document):
    """A curve of a figure."""

    label: str
    role: Literal["A", "B", "reference", "phase-a", "phase-b", "phase-c", "x", "y", "printed"] = (
        Field(description="Variant, reference, phase, axis, or what the paper prints")
    )
    kind: Literal["line", "points"]
    x: list[float]
    y: list[float | None]


class FigureBound(_Document):
    """A printed range drawn across a figure."""

    label: str
    low: float | None
    high: float | None
    start: float | None = Field(description="From where on; null for all along")
    end: float | None


class PaperFigure(_Document):
    """A figure in the manner of the paper's."""

    id: str
    group: str
    title: str
    about: str
    x: FigureAxis
    y: FigureAxis
    series: list[FigureSeries]
    bounds: list[FigureBound]


class ErratumStep(_Document):
    """One number of a computation that shows an erratum."""

    what: str
    value: float | None
    unit: str


class Erratum(_Document):
    """An erratum of the paper, and the computation that shows it."""

    id: str
    place: str
    as_scanned: bool = Field(description="May be the fault of the scanned text that was read")
    printed: str
    corrected: str
    steps: list[ErratumStep]
    shown: bool = Field(description="Whether the computation shows it")


class RowCount(_Document):
    """Number of rows by status."""

    holds: int
    fails: int
    known_failure: int
    not_comparable: int
    better: int = Field(description="Bounds that ours stays well inside of")
    lax: int = Field(description="Rows that hold, but would with nearly any model")


class RowSummary(RowCount):
    """Number of rows by status, in all and of each kind."""

    kinds: dict[Kind, RowCount] = Field(description="Of each kind that there is a row of")
    come_to_hold: list[str] = Field(description="Known failures that hold now: exit code 1")


class PaperDocument(_Document):
    """Every printed number, before anything is computed."""

    source: str
    groups: list[PaperGroup]
    kinds: list[PaperKind]
    rows: list[PaperRow]


class ReproduceDocument(_Document):
    """Every printed number and ours; the same as ``motionlab reproduce --json`` prints."""

    version: str
    model: str = Field(description="Hash of the model's sources")
    source: str
    groups: list[PaperGroup]
    kinds: list[PaperKind]
    rows: list[JudgedRow]
    figures: list[PaperFigure]
    errata: list[Erratum]
    summary: RowSummary


class PartialReproduce(_Document):
    """Rows and figures computed so far."""

    doing: str = Field(description="What is computed now")
    rows: list[JudgedRow]
    figures: list[PaperFigure]
    errata: list[Erratum]


_ONLY_MAX = 500


class _Names:
    """Lists the available names in the schema, on demand.

    Unknown names are refused by `quantities`, with a suggestion.
    """

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        from motionlab.paper.registry import GROUPS, quantities

        names = [*(group.id for group in GROUPS), *(row.id for row in quantities())]
        items = {"type": "string", "enum": names}
        return {"type": "array", "items": items, "maxItems": _ONLY_MAX}


class ReproduceRequest(BaseModel):
    """Selection of the paper's numbers to compute."""

    model_config = ConfigDict(extra="forbid", strict=True)

    only: Annotated[list[str], _Names()] = Field(
        default_factory=list,
        max_length=_ONLY_MAX,
        description="Identifiers of rows or of groups; everything, with the errata, when empty",
    )


KINDS = (
    PaperKind(
        id="printed", title="printed value", about="A value or range that is printed, beside ours"
    ),
    PaperKind(id="claim", title="claim", about="What the text claims in words, beside ours"),
    PaperKind(
        id="formula",
        title="formula",
        about="A formula is printed: what it gives for the circle's gains, beside our run",
    ),
    PaperKind(
        id="recovered",
        title="recovered input",
        about="The motor was given the printed value, an experiment finds it again: this tests the "
        "experiment, not the machine",
    ),
    PaperKind(
        id="arithmetic",
        title="arithmetic",
        about="Other printed numbers put into a formula: it proves nothing of a machine",
    ),
    PaperKind(id="fit", title="fit", about="Ours was fitted to what is printed: it proves nothing"),
    PaperKind(
        id="input",
        title="input",
        about="Chosen by the paper, or given by its machine: no result of it",
    ),
    PaperKind(
        id="no_data",
        title="no data",
        about="A result that the paper prints without what it would take to compute it",
    ),
)
"""Every kind, in the order in which they are counted; only the last two are not comparable."""
