"""The language of searches over runs: ``tag:rig scenario:circle B.x.max<3um after:2026-11-01``."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from typing import Literal, get_args

from motionlab.errors import ConfigError, FieldError
from motionlab.library.run import Kind

HEADLINE = {
    "max": "max_abs_following_error",
    "rms": "rms_following_error",
    "force": "max_abs_force",
    "settling": "settling_time",
    "steady": "steady_state_error",
    "gain_margin": "gain_margin",
    "phase_margin": "phase_margin",
}
"""Metrics that can be searched and sorted by: short name to name, of each axis of each variant."""

MARGINS = ("gain_margin", "phase_margin")
"""Those that come from the linearised loop, and not from the result of a run."""

LIMIT_MAX = 200
"""Runs on a page."""

SEARCH_MAX = 1000
"""Longest search, characters."""

TERMS_MAX = 30
"""Most terms of a search: databases plan each of them, in more than proportional time."""

SORTS = ("created", "name", "duration", "size")
"""What runs are sorted by, beside metrics such as ``B.x.max``."""

KEYS = ("tag", "scenario", "kind", "state", "is", "after", "before")
"""What stands before the colon of a term."""

_LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9}
_DECIBEL = "dB"
_UNITS = {
    "max_abs_following_error": _LENGTHS,
    "rms_following_error": _LENGTHS,
    "max_abs_force": {"N": 1.0, "mN": 1e-3},
    "settling_time": {"s": 1.0, "ms": 1e-3},
    "steady_state_error": _LENGTHS,
    "gain_margin": {_DECIBEL: math.nan},  # no factor
    "phase_margin": {"rad": 1.0, "deg": math.pi / 180.0},
}
"""Of each metric: unit to SI."""
_METRIC = re.compile(
    r"(?P<metric>[A-Z]\.[xy]\.[a-z_]+)(?P<sign><=|>=|<|>)(?P<number>[-+0-9.eE]+)(?P<unit>[µμa-zA-Z]*)"
)
_FORM = "metric, sign, number and unit, as in B.x.max<3um; a text with such a sign, in quotes"
_TERM = re.compile(r"""([a-z]+:)?(?P<quote>["'])(?P<text>.*?)(?P=quote)(?=\s|$)|\S+""")
_KINDS = get_args(Kind)
_STATES = ("recording", "complete", "partial")

Sign = Literal["<", "<=", ">", ">="]


@dataclass(frozen=True)
class Bound:
    """A bound on a metric, SI."""

    metric: str
    sign: Sign
    value: float


@dataclass(frozen=True)
class Search:
    """Conditions that a run must meet, all of them.

    Attributes
    ----------
    words : tuple of str
        Texts that its name, note, tags, controllers or differences contain, in lower case.
    tags, kinds, states, scenarios, names : tuple of str
        All of the tags; one of the kinds, states, scenarios and whole names, any if there are none.
    bounds : tuple of Bound
        On metrics; a run without the metric does not meet them.
    after, before : float or None
        When it began, seconds since 1970.
    pinned : bool
        Whether only pinned runs are wanted.
    deleted : bool
        Whether deleted runs are wanted, and no others.
    """

    words: tuple[str, ...] = ()
    tags: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    states: tuple[str, ...] = ()
    scenarios: tuple[str, ...] = ()
    names: tuple[str, ...] = ()
    bounds: tuple[Bound, ...] = ()
    after: float | None = None
    before: float | None = None
    pinned: bool = False
    deleted: bool = False


@dataclass
class _Terms:
    lists: dict[str, list[str]] = field(default_factory=dict)
    bounds: list[Bound] = field(default_factory=list)
    times: dict[str, float] = field(default_factory=dict)
    flags: set[str] = field(default_factory=set)

    def add(self, match: re.Match[str]) -> None:
        """Take a term as it stands in a search."""
        quoted = match["text"]
        term = match[0] if quoted is None else f"{match[1] or ''}{quoted}"
        name, colon, value = term.partition(":")
        if colon and name in {"tag", "scenario", "name"}:
            self._listed(name, value)
        elif colon and name == "kind":
            self._listed(name, _one_of(term, value, _KINDS))
        elif colon and name == "state":
            self._listed(name, _one_of(term, value, _STATES))
        elif colon and name == "is":
            self.flags.add(_one_of(term, value, ("pinned", "deleted")))
        elif colon and name in {"after", "before"}:
            self.times[name] = _instant(term, value)
        elif quoted is None and any(sign in term for sign in "<>"):
            self.bounds.append(_bound(term))
        else:
            self._listed("word", term.lower())

    def _listed(self, name: str, value: str) -> None:
        self.lists.setdefault(name, []).append(value)


def parse(text: str) -> Search:
    """Return what a search asks for.

    Parameters
    ----------
    text : str
        Terms with blanks between them: ``tag:``, ``scenario:``, ``name:``, ``kind:``, ``state:``,
        ``is:pinned``, ``is:deleted``, ``after:`` and ``before:`` with a date or an instant of
        ISO 8601, metrics with a bound, and plain words. Quotes around a term, or around what
        follows its colon, keep blanks together and make < and > plain characters. Any other quote
        is a character like others.

    Raises
    ------
    ConfigError
        Naming the term that is none.
    """
    if len(text) > SEARCH_MAX:
        raise ConfigError(FieldError("q", "is too long", len(text), bounds={"maximum": SEARCH_MAX}))
    text = re.sub(r"[\t\r\n]", " ", text)
    if any(ord(letter) < 32 or 0xD800 <= ord(letter) < 0xE000 for letter in text):
        raise ConfigError(FieldError("q", "has a character that no text has", text))
    terms = list(_TERM.finditer(text))
    if len(terms) > TERMS_MAX:
        bounds: dict[str, float] = {"maximum": TERMS_MAX}
        raise ConfigError(FieldError("q", "has too many terms", len(terms), bounds=bounds))
    conditions = _Terms()
    for term in terms:
        conditions.add(term)
    lists = conditions.lists
    return Search(
        words=tuple(lists.get("word", ())),
        tags=tuple(lists.get("tag", ())),
        kinds=tuple(lists.get("kind", ())),
        states=tuple(lists.get("state", ())),
        scenarios=tuple(lists.get("scenario", ())),
        names=tuple(lists.get("name", ())),
        bounds=tuple(conditions.bounds),
        after=conditions.times.get("after"),
        before=conditions.times.get("before"),
        pinned="pinned" in conditions.flags,
        deleted="deleted" in conditions.flags,
    )


def quoted(term: str) -> str:
    """Return a term as it is written in a search: in quotes if it has blanks."""
    if not re.search(r"\s", term):
        return term
    return f"'{term}'" if '"' in term else f'"{term}"'


def metric_name(name: str, loc: str) -> str:
    """Return a metric's full name, such as ``B.x.max_abs_following_error`` for ``B.x.max``.

    Raises
    ------
    ConfigError
        If it is none of those that can be searched by.
    """
    place, _, metric = name.rpartition(".")
    full = HEADLINE.get(metric, metric)
    if full not in HEADLINE.values() or re.fullmatch(r"[A-Z]\.[xy]", place) is None:
        allowed = "variant, axis and one of " + ", ".join(HEADLINE)
        raise ConfigError(FieldError(loc, "no metric of that name", name, allowed))
    return f"{place}.{full}"


def _bound(term: str) -> Bound:
    match = _METRIC.fullmatch(term)
    if match is None:
        raise ConfigError(FieldError("q", "is no bound on a metric", term, _FORM))
    metric = metric_name(match["metric"], "q")
    units = _UNITS[metric.rpartition(".")[2]]
    unit = match["unit"]
    if unit and unit not in units:
        allowed = f"one of {', '.join(units)}; without a unit SI"
        raise ConfigError(FieldError("q", f"no unit of {match['metric']}", term, allowed))
    try:
        number = float(match["number"])
        value = 10.0 ** (number / 20.0) if unit == _DECIBEL else number * units.get(unit, 1.0)
    except ValueError:
        raise ConfigError(FieldError("q", "is no bound on a metric", term, _FORM)) from None
    except OverflowError:
        value = math.inf
    if not math.isfinite(value):
        raise ConfigError(FieldError("q", "is not finite", term))
    sign: Sign = match["sign"]  # pyright: ignore[reportAssignmentType]
    return Bound(metric, sign, value)


def _one_of(term: str, value: str, allowed: tuple[str, ...]) -> str:
    if value not in allowed:
        raise ConfigError(FieldError("q", "unknown", term, "one of " + ", ".join(allowed)))
    return value


def _instant(term: str, value: str) -> float:
    """Return an instant, seconds since 1970; a bare date is its midnight, UTC."""
    days = {"today": 0, "yesterday": 1}.get(value)
    if days is not None:
        midnight = datetime.now(UTC).replace(hour=0, minute=0, second=0, microsecond=0)
        return (midnight - timedelta(days=days)).timestamp()
    try:
        instant = datetime.fromisoformat(value)
    except ValueError:
        allowed = "a date or an instant of ISO 8601, today or yesterday"
        raise ConfigError(FieldError("q", "is no date", term, allowed)) from None
    if instant.tzinfo is None:
        instant = instant.replace(tzinfo=UTC)
    return instant.timestamp()
