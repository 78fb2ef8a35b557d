"""What rows of the paper count for: arithmetic, lax bands, conflicts; and that none is missing."""

from __future__ import annotations

import re
from typing import Any

import pytest

from motionlab.paper.documents import Comparison, Number
from motionlab.paper.experiments import Experiments
from motionlab.paper.judgement import lax
from motionlab.paper.printed_number import RowResult
from motionlab.paper.registry import quantities
from motionlab.paper.reproduce import judged, report
from tests.paper.test_verdicts import document, row


class PaperAlone(Experiments):
    """Nothing but the sizing, which computes from printed numbers."""

    def _refuse(self, *_: Any, **__: Any) -> Any:
        raise LookupError("that needs more than printed numbers")

    run = study = force_map = identification = _refuse


def test_what_is_computed_from_printed_numbers_alone_is_arithmetic() -> None:
    paper_alone, wrong = PaperAlone(), []
    for q in quantities():
        if q.source is None or q.kind not in {"printed", "claim", "arithmetic", "recovered"}:
            continue
        try:
            q.source.compute(paper_alone)
            needs_more = False
        except LookupError:
            needs_more = True
        if needs_more == (q.kind == "arithmetic"):
            wrong.append(q.id)
    assert wrong == []
    kinds = [q.kind for q in quantities()]
    assert kinds.count("arithmetic") >= 13


CASES: list[tuple[Comparison, Number, Number, float, str]] = [
    # the band: its share of what is printed
    ("value", 10.0, 10.0, 2.0, ""),
    ("value", 10.0, 10.0, 2.1, "the band is 21 % of the printed value"),
    ("value", -10.0, -10.0, 2.1, "the band is 21 %"),
    ("at_most", 1.5, 1.4, 0.525, "the band is 35 % of the printed bound"),
    ("within", (-14.2, 14.3), (-13.0, 13.0), 1.5, ""),
    ("within", (-31.5, 38.6), (-26.4, 27.7), 8.4, "the band is 24 % of half the printed range"),
    # a range that is no bound of an error is a band itself
    ("within", (25e3, 90e3), 36.6e3, 0.0, "the range is 57 % to either side of its middle"),
    ("within", (0.65, 0.75), 0.7, 0.0, ""),
    # how far inside of a bound
    ("at_most", 10.0, 5.1, 0.1, ""),
    ("at_most", 10.0, 4.0, 0.1, "the bound is 2.5 times ours"),
    ("at_most", 10.0, 0.0, 0.1, "ours is nothing beside the bound"),
    ("at_least", 10.0, 19.9, 0.1, ""),
    ("at_least", 10.0, 25.0, 0.1, "ours is 2.5 times the bound"),
    ("within", (-14.0, 14.0), (-8.0, 6.0), 0.1, ""),
    ("within", (-14.0, 14.0), (-5.6, 6.0), 0.1, "the bound is 2.3 times ours"),
    ("within", (-14.0, 14.0), (1.0, 6.0), 0.1, "the bound is 2.3 times ours"),
    # a share of nothing says nothing
    ("value", 0.0, 0.0, 1.0, ""),
    ("at_most", 0.0, 0.0, 1.0, ""),
]


@pytest.mark.parametrize(("comparison", "paper", "ours", "band", "why"), CASES)
def test_a_band_is_lax_by_a_rule(
    comparison: Comparison, paper: Number, ours: Number, band: float, why: str
) -> None:
    found = lax(comparison, paper=paper, ours=ours, band=band)
    assert found.startswith(why) if why else not found


def test_a_band_that_holds_a_rival_is_lax() -> None:
    asked: dict[str, Any] = {"paper": 34.1, "ours": 38.57, "band": 5.115}
    assert lax("value", **asked) == ""
    assert lax("value", **asked, rival=38.4).startswith("the band holds 38.4 too")
    assert lax("value", paper=380.1, ours=413.0, band=38.01, rival=427.4) == ""


def test_lax_rows_say_so_and_are_counted_and_what_fails_is_not_lax() -> None:
    wide = judged(row(band=0.5), RowResult(1.0), {})
    assert wide.lax == "the band is 50 % of the printed bound"
    assert judged(row(band=0.5), RowResult(2.0), {}).lax == ""
    tight = judged(row(), RowResult(1.0), {})
    assert tight.lax == ""
    found = document(wide, tight)
    assert (found.summary.lax, found.summary.kinds["printed"].lax) == (1, 1)
    text = report(found)
    assert "one: lax: the band is 50 % of the printed bound" in text
    assert "2 hold (0 better than a bound asks for, 1 lax)" in text
    assert "2 hold, 1 of them lax" in text


def test_one_figure_confirms_one_value() -> None:
    rows = {q.id: q for q in quantities()}
    for what in ("thrust", "normal"):
        own, other = rows[f"{what}-fem"], rows[f"{what}-measured"]
        assert own.rival == other.paper
        assert own.comparison == "value"
        assert other.comparison == "none", "ours is finite elements: held against finite elements"
        assert other.source is not None, "but shown"
        assert own.conflict.startswith(f"{other.id} prints {other.printed}")
        assert other.conflict.startswith(f"{own.id} prints {own.printed}")
    told = report(document(judged(rows["normal-fem"], RowResult(413.0), {})))
    assert "normal-fem: normal-measured prints 427.4 N, 12.4 % more" in told


PRINTED = """
I: 1.0 m x 1.5 m|1 um|centimeter range|50 nm|200 nm|500 nm|32 cm x 32 cm|±2 um|20 mm|100 mm x 180 mm
II-A-1: 32 N|1 m/s|10 A|0.65 to 0.75|25000 to 90000 A/m
II-A-2: 0.3 mm|multiple of 3|7.2 mm|9 mm|n = 3|n = 2|p = 3.6 mm|s = 3.6 mm|39.6 mm|36.0 mm|145.1 mm
II-A-2: 1.5 T|5000 A/m|0.7|145 turns|42.3 mm|intervals of 1 A|1 to 10 A|0 to 7.2 mm|34.1 N|380.1 N
II-A-2: three-phase
II-B: 400 N|four movers|two on each axis|5.7 kg|0.01612 mm|0.00405 mm|74.9 %|0.12636 mm|0.03418 mm
II-B: 72.5 %|1.01 m/s|0.89 m/s|higher than 1.01 m/s
IV-A: two encoders|50 nm|six drives|1 GHz|1.25 MHz|0.5 ms|1000 mm/m|5.9 kg|13.9 kg|0.03 % to 11.11 %
IV-A: 0.65 % to 2.82 %|less than 1.89 %|0 N|38.4 N|427.4 N|43.1 N|7.31 m/s^2|3.10 m/s^2|1.58 m/s
IV-A: 1.34 m/s|15 mm|90 s|±20.5 um|±17.4 um|±10.4 um|±11.6 um|49.3 %|33.3 %|10 A|40 N|290 mm|50 mm
IV-A: ±1.6 um|[-0.14, 0.15] m/s|[-3.06, 1.66] m/s^2|1/3 Hz|±18.2 um|±56.8 um
(43): 118913.2532 N/m|1162.3000 N s/m|10.3128 N s/m|0.2399 N|3.5908 N|0.0436 m/s
(46): 84737 N/m|1493.5 N s/m|25.8778 N s/m|0.8179 N|4.3917 N|0.0222 m/s
Table 1: 0.5 um|3200.0 N/mm|1.50 N s/mm|±0.4 um|6000.0 N/mm|3.00 N s/mm|800.0 N/mm|1.23 N s/mm
Table 1: ±1.5 um|987.0 N/mm|1.60 N s/mm|60.00 mm|400.0 N/mm|1.48 N s/mm|501.6 N/mm|1.57 N s/mm
Table 1: [-14.2, 14.3] um|[-18.2, 16.9] um|57.06 mm|200.3 N/mm|1.53 N s/mm|280.5 N/mm|1.08 N s/mm
Table 1: [-31.5, 38.6] um|[-52.7, 56.8] um
IV-B: 60 mm|±2 um|20 mm|±500 um|40 mm
V: 170 mm|290 mm
"""
"""Every printed number as the text goes, read off it once: no dates, references, type numbers or
constants of formulas."""


@pytest.mark.parametrize("line", PRINTED.strip().splitlines())
def test_every_printed_number_has_a_row(line: str) -> None:
    texts = [q.printed for q in quantities()]
    numbers = line.split(": ", 1)[1].split("|")
    found = {n for n in numbers for t in texts if re.search(rf"(?<![\d.]){re.escape(n)}(?!\d)", t)}
    assert set(numbers) - found == set()
