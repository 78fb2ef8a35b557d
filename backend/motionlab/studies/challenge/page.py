"""The page: the challenge as one HTML file."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from motionlab.reports.markup import Markup
from motionlab.reports.page import page
from motionlab.reports.quantities import digits
from motionlab.reports.svg_chart import VARIANT_LOOKS, Chart, Curve, svg
from motionlab.studies.challenge.documents import (
    HEADS,
    UNITS,
    ChallengeDocument,
    LawDocument,
    cells,
    place_of,
)
from motionlab.studies.challenge.entrants import REFERENCE
from motionlab.studies.challenge.ranking import Challenge
from motionlab.studies.challenge.runs import ErrorCurves
from motionlab.studies.challenge.score import LIMITS, WEIGHTS

_WIDTH = 352  # of a plot: two are side by side
_NUMBERS = range(2, 8)  # columns of the ranking


def challenge_page(challenge: Challenge) -> bytes:
    """Return the ranking, its parts, curves and the spread over motors as an HTML file."""
    document = challenge.document
    drawn = _drawn(document.laws)
    named = [law for law in document.laws if law.entered]
    who = ", ".join(law.label for law in named) or "shipped laws"
    return page(
        "challenge.html.j2",
        f"Challenge {document.challenge}: {who}",
        document=document,
        places=[place_of(law, document) for law in named],
        named=named,
        heads=list(zip(HEADS, UNITS, strict=True)),
        numbers=_NUMBERS,
        rows=[(law, cells(law)[:-1]) for law in document.laws],
        ratios=_ratios(document),
        figures=[
            (name, document.titles[name], list(_curves(of_axes, document, drawn)))
            for name, of_axes in challenge.curves.items()
        ],
        spreads=_spreads(document, drawn),
        limits=LIMITS,
        weights=WEIGHTS,
    )


def _drawn(laws: list[LawDocument]) -> dict[int, str]:
    """Return place and look of the laws that are drawn: off, the best shipped, those named."""
    numbered = list(enumerate(laws))
    off = next(place for place, law in numbered if law.law == REFERENCE)
    best = next(place for place, law in numbered if law.shipped and place != off)
    named = [place for place, law in numbered if law.entered and place not in {off, best}]
    looks = dict(zip([best, *named], VARIANT_LOOKS, strict=False))
    return {off: "reference"} | looks


def _ratios(document: ChallengeDocument) -> list[tuple[str, str, list[str]]]:
    """Return name and title of each scenario, and the error of each law in it."""
    return [
        (name, title, [_shown(law.scenarios[name].error) for law in document.laws])
        for name, title in document.titles.items()
    ]


def _shown(value: float | None) -> str:
    return "diverged" if value is None else digits(value)


def _curves(
    of_axes: dict[str, ErrorCurves], document: ChallengeDocument, drawn: dict[int, str]
) -> Iterator[Markup]:
    for axis, curves in of_axes.items():
        bins = curves.low.shape[1]
        width = (curves.end - curves.start) / bins
        yield svg(
            Chart(
                title=f"following error {axis}",
                unit="m",
                x=curves.start + width * (np.arange(bins) + 0.5),
                span=(curves.start, curves.end),
                curves=[
                    Curve(document.laws[place].label, look, curves.low[place], curves.high[place])
                    for place, look in drawn.items()
                ],
                width=_WIDTH,
            )
        )


def _spreads(
    document: ChallengeDocument, drawn: dict[int, str]
) -> list[tuple[str, Markup, list[tuple[LawDocument, list[str]]]]]:
    """Return of each scenario with drawn motors a figure and a table of the spread."""
    spreads = []
    for name in document.titles:
        if document.laws[0].scenarios[name].motors is None:
            continue
        sorted_ratios = {place: _sorted(document.laws[place], name) for place in drawn}
        count = np.arange(1.0, document.motors + 1.0)
        chart = Chart(
            title=f"error on the motors of {name}, relative to {REFERENCE}",
            unit="1",
            x=count,
            span=(1, document.motors),
            x_label="motors, each law's best first",
            x_unit="1",
            curves=[
                Curve(document.laws[place].label, drawn[place], values, values)
                for place, values in sorted_ratios.items()
            ],
        )
        rows = []
        for law in document.laws:
            motors = law.scenarios[name].motors
            assert motors is not None
            rows.append((law, [_shown(motors.median), _shown(motors.q95), str(motors.diverged)]))
        spreads.append((name, svg(chart), rows))
    return spreads


def _sorted(law: LawDocument, name: str) -> np.ndarray:
    motors = law.scenarios[name].motors
    assert motors is not None
    ratios = [math.nan if each is None else each for each in motors.ratios]
    return np.sort(np.array(ratios))
