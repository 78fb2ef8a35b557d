"""When a printed number holds, which failures are known, and what the list of rows must satisfy."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from typing import Any, get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionlab.errors import ConfigError, StoreError
from motionlab.paper.docs_table import table
from motionlab.paper.documents import KINDS, Comparison, JudgedRow, Kind, Number, ReproduceDocument
from motionlab.paper.experiments import Experiments
from motionlab.paper.figures import FIGURES
from motionlab.paper.judgement import holds, is_better, known_failures, status
from motionlab.paper.printed_number import PrintedNumber, RowResult, arithmetic, look_up
from motionlab.paper.registry import GROUPS, SOURCE, quantities
from motionlab.paper.reproduce import is_reproduced, judged, report, reproduce, summary
from tests.paths import DOCS

PAGE = (DOCS / "paper.md").read_text()

CASES: list[tuple[Comparison, Number, Number, float, bool, bool | None]] = [
    ("value", 1.0, 1.09, 0.1, True, None),
    ("value", 1.0, 1.11, 0.1, False, None),
    ("value", 1.0, 0.89, 0.1, False, None),
    ("value", 145.0, 145.0, 0.0, True, None),
    # a printed "+-": not to be exceeded by more than the band, and being better is no failure
    ("at_most", 10.4, 10.5, 0.1, True, False),
    ("at_most", 10.4, 10.6, 0.1, False, False),
    ("at_most", 10.4, 10.35, 0.1, True, False),
    ("at_most", 10.4, 0.5, 0.1, True, True),
    ("at_least", 1.0, 0.99, 0.02, True, False),
    ("at_least", 1.0, 0.9, 0.02, False, False),
    ("at_least", 1.0, 1.5, 0.02, True, True),
    ("within", (-14.2, 14.3), (-14.25, 14.0), 0.1, True, False),
    ("within", (-14.2, 14.3), (-14.4, 14.0), 0.1, False, False),
    ("within", (-14.2, 14.3), (-1.0, 14.5), 0.1, False, False),
    ("within", (-14.2, 14.3), (-8.0, 8.0), 0.1, True, True),
    ("within", (25.0, 90.0), 36.6, 0.0, True, None),
    ("within", (25.0, 90.0), 100.0, 0.0, False, None),
]


@pytest.mark.parametrize(("comparison", "paper", "ours", "band", "held", "better"), CASES)
def test_it_is_judged_as_it_is_meant(
    comparison: Comparison, paper: Number, ours: Number, band: float, held: bool, better: bool
) -> None:
    assert holds(comparison, paper=paper, ours=ours, band=band) is held
    assert is_better(comparison, paper=paper, ours=ours, band=band) is better


@given(st.floats(-1e3, 1e3), st.floats(0.0, 10.0), st.floats(-1e3, 1e3))
def test_what_is_better_than_a_bound_holds_it(paper: float, band: float, ours: float) -> None:
    for comparison in ("at_most", "at_least"):
        if is_better(comparison, paper=paper, ours=ours, band=band):
            assert holds(comparison, paper=paper, ours=ours, band=band)


@pytest.mark.parametrize(
    ("comparison", "paper", "ours"),
    [
        ("none", 1.0, 1.0),
        ("value", (1.0, 2.0), 1.0),
        ("at_most", 1.0, (1.0, 2.0)),
        ("within", 1, 1),
    ],
)
def test_what_cannot_be_judged_is_an_error(
    comparison: Comparison, paper: Number, ours: Number
) -> None:
    with pytest.raises(ValueError, match=r"range|one number|nothing"):
        holds(comparison, paper=paper, ours=ours, band=0.0)


def test_known_or_not_a_failure_is_red() -> None:
    assert status(None, known=False) == "not_comparable"
    assert status(True, known=False) == "holds"
    assert status(False, known=False) == "fails"
    assert status(False, known=True) == "known_failure"
    assert status(True, known=True) == "holds"


def row(paper: float = 1.0, **fields: Any) -> PrintedNumber:
    return PrintedNumber(
        **{
            "id": "one",
            "group": "sizing",
            "place": "(1)",
            "quantity": "one",
            "unit": "m",
            "printed": "1 m",
            "reason": "a test",
            "paper": paper,
            "comparison": "at_most",
            "band": 0.1,
            "source": arithmetic(1.0),
            **fields,
        }  # pyright: ignore[reportArgumentType]
    )


def document(*rows: JudgedRow) -> ReproduceDocument:
    return ReproduceDocument(
        version="0",
        model="0",
        source=SOURCE,
        groups=[],
        kinds=list(KINDS),
        rows=list(rows),
        figures=[],
        errata=[],
        summary=summary(rows),
    )


def test_a_number_that_could_not_be_computed_fails() -> None:
    found = judged(row(), RowResult(None, error="it diverged"), {})
    assert (found.status, found.holds, found.ours, found.error) == (
        "fails",
        False,
        None,
        "it diverged",
    )
    assert judged(row(), RowResult(None), {}).error is not None


def test_all_is_well_without_failures_and_with_known_ones_that_fail() -> None:
    good = judged(row(), RowResult(1.0), {})
    bad = judged(row(), RowResult(2.0), {})
    known = judged(row(), RowResult(2.0), {"one": "as expected"})
    mended = judged(row(), RowResult(1.0), {"one": "as expected"})
    assert known.known == "as expected"
    assert is_reproduced(document(good, known))
    assert not is_reproduced(document(good, bad))
    assert not is_reproduced(document(good, mended)), "a known failure that holds must be told"
    assert document(mended).summary.come_to_hold == ["one"]
    count = {"holds": 2, "fails": 1, "known_failure": 1, "not_comparable": 0, "better": 0, "lax": 0}
    assert document(good, bad, known, mended).summary.model_dump() == {
        **count,
        "kinds": {"printed": count},
        "come_to_hold": ["one"],
    }


def test_rows_are_counted_by_kind_so_that_fits_and_inputs_prove_nothing() -> None:
    given = row(kind="input", comparison="none", band=None, source=None)
    rows = [
        judged(row(), RowResult(2.0), {}),
        judged(row(kind="fit"), RowResult(1.0), {}),
        judged(given, RowResult(None), {}),
    ]
    counts = document(*rows).summary.kinds
    assert list(counts) == ["printed", "fit", "input"], "in the order of KINDS"
    assert [(c.holds, c.fails, c.not_comparable) for c in counts.values()] == [
        (0, 1, 0),
        (1, 0, 0),
        (0, 0, 1),
    ]
    text = report(document(*rows)).splitlines()
    assert "1 hold" in text[-4]
    assert [line.split()[0] for line in text[-3:]] == ["printed", "fit", "input"]
    assert "it proves nothing" in text[-2]


@pytest.mark.parametrize(
    "fields",
    [
        {"band": None},
        {"paper": None},
        {"source": None},
        {"comparison": "none"},
        {"comparison": "none", "band": None, "source": None},
        {"kind": "input"},
        {"kind": "no_data"},
        {"reason": ""},
    ],
)
def test_no_row_is_judged_without_band_and_reason(fields: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"^one: "):
        row(**fields)


def test_every_row_is_unique_and_in_a_group() -> None:
    rows = quantities()
    assert len(rows) > 130
    assert [name for name, count in Counter(q.id for q in rows).items() if count > 1] == []
    assert {q.group for q in rows} == {group.id for group in GROUPS}
    assert not {q.id for q in rows} & {group.id for group in GROUPS}, "--only could mean either"


def test_every_kind_has_its_words_and_its_rows() -> None:
    assert [kind.id for kind in KINDS] == list(get_args(Kind))
    assert {q.kind for q in quantities()} == set(get_args(Kind))


def test_every_row_is_on_the_page() -> None:
    assert table() in PAGE, (
        "put what `python -m motionlab.paper.docs_table` prints into docs/paper.md"
    )


def test_every_figure_named_by_a_row_is_drawn() -> None:
    drawn = {name for builds in FIGURES.values() for name in builds}
    assert {q.figure for q in quantities()} - {None} <= drawn
    assert set(FIGURES) <= {group.id for group in GROUPS}


def test_known_failures_are_rows_that_are_judged() -> None:
    judgeable = {q.id for q in quantities() if q.comparison != "none"}
    assert set(known_failures()) <= judgeable
    assert all(len(reason) > 5 for reason in known_failures().values())


def test_a_wrong_file_of_known_failures_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "known_failures.toml"
    with pytest.raises(StoreError, match=r"known_failures\.toml cannot be read"):
        known_failures(path)
    path.write_text('a-row = "because"\n')
    assert known_failures(path) == {"a-row": "because"}
    path.write_text('a-row = "because"\na-row = "why not"\n')
    with pytest.raises(StoreError, match="is not valid TOML"):
        known_failures(path)
    path.write_text("a-row = 1\n")
    with pytest.raises(StoreError, match="a-row needs a reason"):
        known_failures(path)


def test_the_page_of_known_failures_shows_the_same_table() -> None:
    page = DOCS / "known-failures.md"
    rows = re.findall(r"^\| `(\S+)` \| (.+) \|$", page.read_text(), re.MULTILINE)
    assert dict(rows) == known_failures()
    assert len(rows) == len(known_failures())


def test_rows_are_chosen_by_row_or_group() -> None:
    assert [q.id for q in quantities(["turns"])] == ["turns"]
    assert {q.group for q in quantities(["sizing", "rhombus-x"])} == {"sizing", "table1"}
    with pytest.raises(ConfigError, match=r"'turn'.*did you mean 'turns'|did you mean.*'turn'"):
        quantities(["turn"])


def test_progress_only_rises_and_can_end_the_work() -> None:
    shares: list[float] = []
    rows: list[int] = []

    def watch(share: float, partial: object) -> None:
        shares.append(share)
        if partial is not None:
            rows.append(len(partial.rows))  # pyright: ignore[reportAttributeAccessIssue]

    found = reproduce(["limits", "platforms"], watch)
    assert shares == sorted(shares)
    assert 0.0 <= shares[0] < shares[-1] <= 1.0
    assert rows == sorted(rows)
    assert rows[-1] == len(found.rows)
    assert found.errata == []

    class Enough(Exception):
        pass

    def stop(share: float, partial: object) -> None:
        raise Enough

    with pytest.raises(Enough):
        reproduce(["limits"], stop)


def test_experiments_are_done_once() -> None:
    experiments = Experiments()
    assert experiments.run("stair-x-500nm") is experiments.run("stair-x-500nm", {})
    assert experiments.design() is experiments.design()


def test_paths_lead_through_tables_and_lists() -> None:
    assert look_up({"a": [{"b": 1}, {"b": 2}]}, "a.1.b") == 2
