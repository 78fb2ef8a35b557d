"""A printed number with its band, the reason of the band, and the computation of ours.

* Encoder: one count of 50 nm.
* Printed digits: half of the last one.
* Motion profile of edges that stop at the corners. The error that acceleration alone makes is
  ``M a/k_p``, eq. (40). For an edge of length d in the time T the peak acceleration is
  4 d/T^2 at least (bang-bang), 5.77 d/T^2 by minimum jerk, which is what runs here, 6.28 d/T^2 by
  the cycloid. The band is the share by which ours may exceed the least, 31 % of ``M a/k_p``.
* Motion profile of moves on y. The paper prints up to 1.66 m/s^2 and no acceleration; without
  compensation the nominal motor's own steady state goes from 0.95 to 1.90 um (trapezoid) and from
  0.80 to 2.00 um (staircase) between 1.66 and 1.0 m/s^2. The band is half of that.
"""

from __future__ import annotations

import json
import math
import re
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import Any

from motionlab.config.load import load_scenario
from motionlab.paper.documents import Comparison, ErratumStep, Kind, Number, PaperRow, Recipe
from motionlab.paper.experiments import Experiments

API = "http://127.0.0.1:8000/api/v1"


@dataclass(frozen=True)
class RowResult:
    """Computed result of one row.

    Attributes
    ----------
    ours : float, tuple of float or None
        The number that is judged; None if there should be one and is not.
    values : mapping of str to number
        Ours under other controllers and on other motors.
    error : str, optional
        Why there is no number.
    """

    ours: Number | None
    values: Mapping[str, Number | None] = field(default_factory=dict)
    error: str | None = None


Compute = Callable[[Experiments], RowResult]


@dataclass(frozen=True)
class RowSource:
    """Source of our number.

    Attributes
    ----------
    compute : callable
        Returns ours.
    recipe : Recipe, optional
        Other way to obtain it; ``motionlab reproduce --only`` when left out.
    """

    compute: Compute
    recipe: Recipe | None = None


@dataclass(frozen=True)
class Spread:
    """Reference to a number of a Monte Carlo study, shown beside a row.

    Attributes
    ----------
    scenario : str
        Scenario of the study.
    axis : str
        ``x`` or ``y``.
    metric : str
        Metric of a run.
    variant : str, optional
        Its variant; None for the improvement of the second over the first, 1 - B/A.
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


@dataclass(frozen=True)
class PrintedNumber:
    """One printed number.

    Attributes
    ----------
    id, place, quantity, unit, paper, printed, group, kind, comparison, band, reason, basis, note, \
    conflict
        See `motionlab.paper.documents.PaperRow`.
    source : RowSource or None
        Source of our number; None if nothing can be computed.
    doing : str
        Progress label of the computation.
    figure : str, optional
        The figure that shows it.
    spread : Spread, optional
        Its Monte Carlo study.
    rival : float, optional
        Another printed value of the same quantity, which excludes this one.
    """

    id: str
    place: str
    quantity: str
    unit: str
    paper: Number | None
    printed: str
    _: KW_ONLY
    group: str
    reason: str
    kind: Kind = "printed"
    comparison: Comparison = "none"
    band: float | None = None
    basis: str = ""
    note: str = ""
    conflict: str = ""
    source: RowSource | None = None
    doing: str = "sizing equations"
    figure: str | None = None
    spread: Spread | None = None
    rival: float | None = None

    def __post_init__(self) -> None:
        """Refuse a row with neither a judgement nor a reason."""
        judged = self.comparison != "none"
        if judged == (self.kind in {"input", "no_data"}):
            raise ValueError(f"{self.id}: an input is not judged, nor is what has no data")
        if judged != (self.band is not None and self.paper is not None and self.source is not None):
            raise ValueError(f"{self.id}: what is judged has paper, band and source; nothing else")
        if not self.reason:
            raise ValueError(f"{self.id}: no reason for the band")

    def row(self, known: Mapping[str, str]) -> PaperRow:
        """Return the row before any computation."""
        recipe = None if self.source is None else self.source.recipe
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
            recipe=recipe or by_reproduce(self.id),
        )


def by_reproduce(row_id: str) -> Recipe:
    """Return the recipe of a number that only ``motionlab reproduce`` computes."""
    return _recipe(f"reproduce --only {row_id}", "reproduce", {"only": [row_id]})


def by_run(scenario: str, changes: Mapping[str, Any], find: Sequence[str] = ()) -> Recipe:
    """Return the recipe of a number in the result document of a run."""
    settings = "".join(f" --set {shlex.quote(f'{k}={_toml(v)}')}" for k, v in changes.items())
    body = {"scenario": scenario} | ({"set": dict(changes)} if changes else {})
    return _recipe(f"run {scenario}{settings}", "simulate", body, find)


def _recipe(command: str, call: str, body: dict[str, Any], find: Sequence[str] = ()) -> Recipe:
    return Recipe(
        scenario=body.get("scenario"),
        set=body.get("set", {}),
        cli=f"motionlab {command} --json",
        curl=f"curl -s --json {shlex.quote(json.dumps(body))} {API}/{call}",
        find=list(find),
    )


def look_up(document: Any, path: str) -> Any:
    """Return the value at a dotted path; integers index lists."""
    for key in path.split("."):
        document = document[int(key)] if isinstance(document, list) else document[key]
    return document


def from_run(
    scenario: str,
    find: str | tuple[str, str],
    *,
    changes: Mapping[str, Any] | None = None,
    others: Mapping[str, tuple[str, Mapping[str, Any], str | tuple[str, str]]] | None = None,
) -> RowSource:
    """Return a computation that reads a number, or both ends of a range, from runs."""

    def compute(experiments: Experiments) -> RowResult:
        document = experiments.run(scenario, changes or {}).document
        ours = _number(document, find)
        values = {
            label: _number(experiments.run(name, sets).document, path)
            for label, (name, sets, path) in (others or {}).items()
        }
        error = None if ours is not None else _diverged(document, find)
        return RowResult(ours, values, error=error)

    paths = [find] if isinstance(find, str) else find
    return RowSource(compute, by_run(scenario, changes or {}, paths))


def from_design(find: str, others: Mapping[str, str] | None = None) -> RowSource:
    """Return a computation that reads a number from the sizing."""

    def compute(experiments: Experiments) -> RowResult:
        tables = experiments.design().model_dump(by_alias=True)
        values = {label: look_up(tables, path) for label, path in (others or {}).items()}
        return RowResult(look_up(tables, find), values)

    return RowSource(compute, _recipe("design", "design", {}, [find]))


def from_identify(find: str) -> RowSource:
    """Return a computation that reads a parameter from the identification."""

    def compute(experiments: Experiments) -> RowResult:
        parameter = look_up(experiments.identification().model_dump(), find)
        return RowResult(
            parameter["value"], {"low end, 95 %": parameter["low"], "high end": parameter["high"]}
        )

    return RowSource(compute, _recipe("identify", "identify", {}, [f"{find}.value"]))


def arithmetic(ours: Number) -> RowSource:
    """Return a number that follows from the paper's own numbers."""
    return RowSource(lambda _: RowResult(ours))


def step(what: str, value: float | None, unit: str) -> ErratumStep:
    """Return one number of a computation that shows an erratum."""
    return ErratumStep(what=what, value=value, unit=unit)


def percent(share: float) -> str:
    """Return a share as the paper prints it."""
    return f"{share:.1%}".replace("%", " %")


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


def _toml(value: Any) -> str:
    return json.dumps(value) if isinstance(value, (bool, int, float, list)) else str(value)


COUNT = 50e-9
"""One encoder count, m."""

MINIMUM_JERK = 10.0 / math.sqrt(3.0)
"""Peak acceleration of minimum jerk, in d/T^2."""

BANG_BANG = 4.0
"""The least there can be between two rests, in d/T^2."""

TRAPEZOID, STAIRCASE = 0.475e-6, 0.60e-6
"""Half of the spread of the steady state over accelerations from 1.0 to 1.66 m/s^2, m."""


def gains(scenario: str, axis: str) -> tuple[float, float, float]:
    """Return mass, k_p and k_d, SI, of a shipped scenario's PD controller: the printed ones."""
    controller = load_scenario(scenario).variants["A"].controller
    own = getattr(controller, axis)
    return getattr(controller.model, axis).mass, own.k_p, own.k_d


def edge_law(scenario: str, axis: str) -> float:
    """Return the possible effect of an edge's unprinted motion profile on the error, m.

    ``(5.77 - 4) M d/(T^2 k_p)`` with d the length of an edge along the axis and T its duration.
    """
    M, k_p, _ = gains(scenario, axis)
    d, T = _EDGES[scenario, axis]
    return (MINIMUM_JERK - BANG_BANG) * M * d / (T**2 * k_p)


# The pentagram's edges along an axis: 57.06 mm on x, 57.06 mm sin 72 deg on y.
_EDGES = {
    ("rhombus", "x"): (0.03, 0.75),
    ("rhombus", "y"): (0.03, 0.75),
    ("pentagram", "x"): (0.05706, 0.6),
    ("pentagram", "y"): (0.05706 * math.sin(0.4 * math.pi), 0.6),
}
