"""A printed number: what it says, how far off still holds and why, and what computes ours."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from motionlab.studies.paper.document import Comparison, Kind, Number, PaperRow, Recipe
from motionlab.studies.paper.experiments import Experiments

API = "http://127.0.0.1:8000/api/v1"


@dataclass(frozen=True)
class Found:
    """What was computed for one row.

    Attributes
    ----------
    ours : float, tuple of float or None
        The number that is judged; None if there should be one and is not.
    values : mapping of str to number
        Ours under other controllers and on other motors.
    error : str, optional
        Why there is none.
    """

    ours: Number | None
    values: Mapping[str, Number | None] = field(default_factory=dict)
    error: str | None = None


Compute = Callable[[Experiments], Found]


@dataclass(frozen=True)
class Spread:
    """Which number of a Monte Carlo study stands beside a row.

    Attributes
    ----------
    scenario : str
        Whose study.
    axis : str
        ``x`` or ``y``.
    metric : str
        Metric of a run.
    variant : str, optional
        Whose; None for what the second gains on the first, 1 - B/A.
    """

    scenario: str
    axis: str
    metric: str
    variant: str | None = "B"

    @property
    def what(self) -> str:
        """The number in words."""
        if self.variant is None:
            return "reduction by compensation, 1 - B/A"
        law = "LuGre observer" if self.variant == "B" else "no compensation"
        return f"{self.metric.replace('_', ' ')}, {law}"


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """One printed number.

    Attributes
    ----------
    id, group, kind, place, quantity, unit, comparison, paper, printed, band, reason, basis, note, \
    conflict
        See `motionlab.studies.paper.document.PaperRow`.
    compute : callable or None
        Returns ours; None where nothing can be computed.
    doing : str
        What that takes, in words.
    recipe : Recipe, optional
        How to get it otherwise; ``motionlab reproduce --only`` when left out.
    figure : str, optional
        The figure that shows it.
    spread : Spread, optional
        The Monte Carlo study beside it.
    rival : float, optional
        Another value that is printed of the same thing, with which ours cannot agree as well.
    """

    id: str
    group: str
    place: str
    quantity: str
    unit: str
    printed: str
    reason: str
    kind: Kind = "printed"
    paper: Number | None = None
    comparison: Comparison = "none"
    band: float | None = None
    basis: str = ""
    note: str = ""
    conflict: str = ""
    compute: Compute | None = None
    doing: str = "sizing equations"
    recipe: Recipe | None = None
    figure: str | None = None
    spread: Spread | None = None
    rival: float | None = None

    def __post_init__(self) -> None:
        """Refuse a row that could neither be judged nor says why."""
        judged = self.comparison != "none"
        if judged == (self.kind in {"input", "no_data"}):
            raise ValueError(f"{self.id}: an input is not judged, nor is what has no data")
        if judged != (
            self.band is not None and self.paper is not None and self.compute is not None
        ):
            raise ValueError(f"{self.id}: what is judged has paper, band and compute; nothing else")
        if not self.reason:
            raise ValueError(f"{self.id}: no reason for the band")

    def row(self, known: Mapping[str, str]) -> PaperRow:
        """Return the row as it stands before anything is computed."""
        return PaperRow(
            id=self.id,
            group=self.group,
            kind=self.kind,
            place=self.place,
            quantity=self.quantity,
            unit=self.unit,
            comparison=self.comparison,
            paper=self.paper,
            printed=self.printed,
            band=self.band,
            reason=self.reason,
            basis=self.basis,
            fitted=self.kind == "fit",
            note=self.note,
            conflict=self.conflict,
            known=known.get(self.id),
            figure=self.figure,
            recipe=self.recipe or by_reproduce(self.id),
        )


def not_comparable(  # noqa: PLR0913 - what a row without comparison has
    row_id: str,
    group: str,
    place: str,
    quantity: str,
    *,
    printed: str,
    reason: str,
    kind: Literal["input", "no_data"] = "no_data",
    unit: str = "1",
    paper: Number | None = None,
    note: str = "",
) -> Quantity:
    """Return a row for which there is nothing to compute, or no way to."""
    return Quantity(
        id=row_id,
        group=group,
        kind=kind,
        place=place,
        quantity=quantity,
        unit=unit,
        printed=printed,
        paper=paper,
        reason=reason,
        note=note,
    )


def by_reproduce(row_id: str) -> Recipe:
    """Return the recipe of a number that only ``motionlab reproduce`` computes."""
    return Recipe(
        scenario=None,
        set={},
        cli=f"motionlab reproduce --only {row_id} --json",
        curl=_curl("reproduce", {"only": [row_id]}),
        find=[],
    )


def by_run(scenario: str, changes: Mapping[str, Any], find: Sequence[str] = ()) -> Recipe:
    """Return the recipe of a number in the result document of a run."""
    settings = "".join(f" --set {shlex.quote(f'{k}={_toml(v)}')}" for k, v in changes.items())
    body: dict[str, Any] = {"scenario": scenario}
    return Recipe(
        scenario=scenario,
        set=dict(changes),
        cli=f"motionlab run {scenario}{settings} --json",
        curl=_curl("simulate", body | ({"set": dict(changes)} if changes else {})),
        find=list(find),
    )


def by_design(find: str) -> Recipe:
    """Return the recipe of a number in the document of the sizing."""
    return Recipe(
        scenario=None,
        set={},
        cli="motionlab design --json",
        curl=_curl("design", {}),
        find=[find],
    )


def by_identify(find: str) -> Recipe:
    """Return the recipe of an identified parameter; REST answers with a job."""
    return Recipe(
        scenario=None,
        set={},
        cli="motionlab identify --json",
        curl=_curl("identify", {}),
        find=[find],
    )


def look_up(document: Any, path: str) -> Any:
    """Return what a dotted path with whole numbers for places in lists leads to."""
    for key in path.split("."):
        document = document[int(key)] if isinstance(document, list) else document[key]
    return document


def from_run(
    scenario: str,
    find: str | tuple[str, str],
    *,
    changes: Mapping[str, Any] | None = None,
    others: Mapping[str, tuple[str, Mapping[str, Any], str | tuple[str, str]]] | None = None,
) -> Compute:
    """Return what looks a number, or both ends of a range, up in result documents of runs.

    Parameters
    ----------
    scenario, changes
        The run.
    find : str or tuple of str
        Path in its document.
    others : mapping of str to tuple, optional
        Label to scenario, changes and path of further values.
    """

    def compute(experiments: Experiments) -> Found:
        document = experiments.run(scenario, changes or {}).document
        ours = _number(document, find)
        values = {
            label: _number(experiments.run(name, sets).document, path)
            for label, (name, sets, path) in (others or {}).items()
        }
        error = None if ours is not None else _diverged(document, find)
        return Found(ours, values, error=error)

    return compute


def from_design(find: str) -> Compute:
    """Return what looks a number up in the document of the sizing."""

    def compute(experiments: Experiments) -> Found:
        return Found(look_up(experiments.design().model_dump(by_alias=True), find))

    return compute


def from_identify(find: str) -> Compute:
    """Return what looks a parameter up in the document of the identification."""

    def compute(experiments: Experiments) -> Found:
        found = look_up(experiments.identification().model_dump(), find)
        return Found(found["value"], {"low end, 95 %": found["low"], "high end": found["high"]})

    return compute


def _number(document: Any, path: str | tuple[str, str]) -> Number | None:
    if isinstance(path, str):
        return look_up(document, path)
    low, high = (look_up(document, end) for end in path)
    return None if low is None or high is None else (low, high)


def _diverged(document: Any, path: str | tuple[str, str]) -> str:
    """Return why a run has no such number."""
    first = path if isinstance(path, str) else path[0]
    variant = re.match(r"(.*variants\.\w+)\.", first)
    where = look_up(document, variant[1])["diverged"] if variant else None
    if where is None:
        return "the run has no such number"
    return f"the variant diverged at {where['time']:g} s: {where['channel']}"


def _curl(call: str, body: Mapping[str, Any]) -> str:
    return f"curl -s --json {shlex.quote(json.dumps(body))} {API}/{call}"


def _toml(value: Any) -> str:
    return json.dumps(value) if isinstance(value, (bool, int, float, list)) else str(value)
