"""The index of runs, on SQLite and PostgreSQL alike."""

from __future__ import annotations

import base64
import itertools
import json
import random
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import sqlalchemy as sa
from sqlalchemy import event

from motionlab.errors import ConfigError, StoreError
from motionlab.library import index as index_module
from motionlab.library.database import VERSION, index_url
from motionlab.library.index import Index
from motionlab.library.run import Run, RunDetail
from motionlab.library.search import LIMIT_MAX, SORTS, parse, quoted
from tests.library.sample_runs import made_by, sample

MAX = "max_abs_following_error"


def found(index: Index, text: str = "", sort: str = "-created") -> list[str]:
    """Return the names of all runs that a search finds, page by page of three."""
    return [name for page in pages(index, text, sort) for name in page]


def pages(index: Index, text: str, sort: str) -> Iterator[list[str]]:
    for page in pages_of_runs(index, text, sort):
        yield [run.name for run in page]


def pages_of_runs(index: Index, text: str, sort: str) -> Iterator[list[Run]]:
    cursor = None
    while True:
        page = index.page(parse(text), sort=sort, limit=3, cursor=cursor)
        yield page.runs
        cursor = page.cursor
        if cursor is None:
            return


def test_a_run_comes_back_as_it_was_put(index: Index) -> None:
    run = sample(metrics={f"A.x.{MAX}": 2.5e-6}, tags=["rig"], note="a\nnote", result={"x": [1]})
    index.put(run)
    assert index.get(run.id) == run
    index.put(changed := run.model_copy(update={"tags": ["b"], "ticks": 7, "metrics": {}}))
    assert index.get(run.id) == changed
    assert index.page(parse("tag:rig")).total == 0
    index.drop(run.id)
    assert index.get(run.id) is None
    assert index.page(parse("")).runs == []


def test_searches_find_what_they_ask_for(index: Index) -> None:
    first = {f"B.x.{MAX}": 2e-6, "B.x.gain_margin": 1.9, "B.x.phase_margin": 0.52}
    second = {f"B.x.{MAX}": 4e-6, "B.x.gain_margin": 2.0, "B.x.phase_margin": 0.53}
    runs = [
        sample(name="first", created=1000.0, tags=["rig", "cold"], metrics=first),
        sample(name="second", created=2000.0, tags=["rig"], metrics=second),
        sample(name="third 100%", created=3000.0, kind="live", state="partial", pinned=True),
        sample(name="fourth_x", created=4000.0, scenario="rhombus", note="Lu's Motor No. 7 \\ old"),
    ]
    for run in runs:
        index.put(run)
    for text, names in {
        "": ["fourth_x", "third 100%", "second", "first"],
        "tag:rig": ["second", "first"],
        "tag:rig tag:cold": ["first"],
        "kind:live": ["third 100%"],
        "kind:live kind:simulation": ["fourth_x", "third 100%", "second", "first"],
        "state:partial": ["third 100%"],
        "is:pinned": ["third 100%"],
        "scenario:rhombus scenario:none": ["fourth_x"],
        "name:first name:third": ["first"],
        'name:"third 100%"': ["third 100%"],
        "B.x.max<3um": ["first"],
        "B.x.max<=4e-6 B.x.max>=2um": ["second", "first"],
        "B.x.max>4um": [],
        "B.y.max>0": [],
        "B.x.gain_margin>6dB": ["second"],
        "B.x.gain_margin<2": ["first"],
        "B.x.phase_margin<30deg": ["first"],
        "B.x.phase_margin>=0.525rad": ["second"],
        '"no. 7"': ["fourth_x"],
        "MOTOR": ["fourth_x"],
        "100%": ["third 100%"],
        "%": ["third 100%"],
        "d_x": [],
        "o.": ["fourth_x"],
        'say "no"': [],
        "h_x": ["fourth_x"],
        "'\\ old'": ["fourth_x"],
        "Lu's": ["fourth_x"],
        "'s": ["fourth_x"],
        "plant.x.mass rhombus": ["fourth_x"],
        "after:1970-01-01T00:50:00 ": ["fourth_x", "third 100%"],
        "before:1970-01-01T00:50:00+00:00": ["second", "first"],
        runs[1].id: ["second"],
        "is:deleted": [],
    }.items():
        assert found(index, text) == names, text
        assert index.page(parse(text)).total == len(names), text


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("kind:dream", "kind:dream"),
        ("is:open", "is:open"),
        ("after:yesteryear", "after:yesteryear"),
        ("B.x.max<3 um", "um"),
        ("B.x.max<3miles", "one of m, mm, um"),
        ("B.x.max<3dB", "B.x.max<3dB"),
        ("B.x.gain_margin>6deg", "one of dB; without a unit SI"),
        ("B.x.phase_margin>30dB", "one of rad, deg"),
        ("B.x.gain_margin>1e5dB", "is not finite"),
        ("B.x.nothing<3", "B.x.nothing"),
        ("max<3", "max<3"),
        ("B.x.max<1e999", "B.x.max<1e999"),
        ("a\0b", "a"),
        ("x" * 1001, "1001"),
        ("a " * 31, "31"),
    ],
)
def test_a_search_that_is_none_is_refused(text: str, named: str) -> None:
    if text == "B.x.max<3 um":
        assert parse(text).words == ("um",)  # a blank parts two terms
        return
    with pytest.raises(ConfigError) as refused:
        parse(text)
    assert named in str(refused.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Lu's", ("lu's",)),
        ("'tis Lu's", ("'tis", "lu's")),
        ('5" stage', ('5"', "stage")),
        ('"open', ('"open',)),
        ("C:\\", ("c:\\",)),
        ("""'a b' "Lu's own" """, ("a b", "lu's own")),
        ('"a<b" tab\there', ("a<b", "tab", "here")),
    ],
)
def test_any_text_can_be_searched_for(text: str, words: tuple[str, ...]) -> None:
    assert parse(text).words == words


def test_quotes_keep_the_blanks_of_a_value_and_of_a_whole_term() -> None:
    for text in ("""scenario:"my own" tag:a""", """'scenario:my own' tag:a"""):
        search = parse(text)
        assert (search.scenarios, search.tags, search.words) == (("my own",), ("a",), ())
    assert parse(quoted("scenario:my own")).scenarios == ("my own",)
    assert len(parse(quoted("B.x.max<3um")).bounds) == 1
    for text in ('say "no"', "lu's own"):
        assert parse(quoted(text)).words == (text,)


def test_pages_lose_and_repeat_nothing(index: Index) -> None:
    chance = random.Random(7)
    runs = [
        sample(
            name=f"run {chance.randrange(3)}",  # many ties
            created=float(chance.randrange(3)),
            duration=float(chance.randrange(3)),
            size=chance.randrange(3),
            metrics={f"B.x.{MAX}": chance.randrange(3) * 1e-6} if chance.random() < 0.7 else {},
        )
        for _ in range(23)
    ]
    index.put(*runs)

    def key(run: RunDetail, sort: str, sign: str) -> float | str:
        if sort in SORTS:
            return getattr(run, sort)
        return run.metrics.get(f"B.x.{MAX}", -1.0 if sign else 1.0)

    for sort, sign in itertools.product([*SORTS, "B.x.max"], ["", "-"]):
        seen: list[str] = []
        cursor = None
        while True:
            page = index.page(parse(""), sort=sign + sort, limit=4, cursor=cursor)
            assert page.total == len(runs)
            seen += [run.id for run in page.runs]
            if (cursor := page.cursor) is None:
                break
        ordered = [run.id for run in sorted(runs, key=lambda run: key(run, sort, sign))]
        assert seen == (ordered[::-1] if sign else ordered), sign + sort


def test_a_run_that_comes_between_two_pages_changes_neither(index: Index) -> None:
    for i in range(6):
        index.put(sample(name=str(i), created=float(i)))
    first = index.page(parse(""), limit=3)
    index.put(sample(name="new", created=99.0))
    index.drop(first.runs[-1].id)  # the one that the cursor names
    second = index.page(parse(""), limit=3, cursor=first.cursor)
    assert [run.name for run in (*first.runs, *second.runs)] == ["5", "4", "3", "2", "1", "0"]
    assert second.cursor is None


def test_cursors_that_are_none_are_refused(index: Index) -> None:
    for i in range(3):
        index.put(sample(created=float(i)))
    good = index.page(parse(""), limit=1).cursor
    assert good is not None

    def made(*parts: object) -> str:
        return base64.urlsafe_b64encode(json.dumps(parts).encode()).decode()

    wrong = ["", "x", "é", good[:-4], made("created", 1.0), made("created", "a", 1)]
    wrong += [made("created", float("nan"), 1), made("created", 10**400, 1)]
    wrong += [made("created", None, 1), made("created", 1.0, "r-'; DROP TABLE runs")]
    wrong += [made("created", 1.0, number) for number in (-1, 2**31, True, 1.0, None)]
    wrong += [made("name", "\ud800", 1), made("name", 1, 1)]
    wrong += [made("name", "a\0", 1), made("size", 1.0, 1)]
    for cursor in wrong:
        sort = "name" if json_of(cursor)[:1] == ["name"] else "created"
        with pytest.raises(ConfigError, match="cursor"):
            index.page(parse(""), sort=sort, cursor=cursor)
    with pytest.raises(ConfigError, match="sort"):
        index.page(parse(""), sort="seed")


def json_of(cursor: str) -> list[object]:
    try:
        return json.loads(base64.urlsafe_b64decode(cursor.encode()))
    except ValueError:
        return []


def test_changes(index: Index) -> None:
    run = sample(tags=["old"], note="before")
    index.put(run)
    index.put(other := sample(tags=["old"]))
    changes = {"name": "better", "note": "Stiff", "tags": ["new"], "pinned": True}
    expected = run.model_copy(update=changes)
    assert index.change(run.id, changes | {"seed": 7}) == expected
    assert index.get(run.id) == expected
    assert index.get(other.id) == other
    assert found(index, "tag:new stiff is:pinned") == ["better"]
    assert found(index, "before") == []
    assert index.change(run.id, {"note": ""}) == expected.model_copy(update={"note": ""})
    assert index.change(sample().id, changes) is None


def test_deletion_hides_and_can_be_undone_until_it_is_carried_out(index: Index) -> None:
    run = sample(name="gone")
    index.put(run)
    index.change(run.id, {"deleted": 500.0})
    assert found(index) == []
    assert found(index, "is:deleted") == ["gone"]
    assert index.deleted() == [(run.id, 500.0)]
    index.change(run.id, {"deleted": None})
    assert found(index) == ["gone"]
    assert not index.condemn(run.id, 500.0)  # restored in time
    index.change(run.id, {"deleted": 600.0})
    assert not index.condemn(run.id, 500.0)  # and deleted anew
    assert index.condemn(run.id, 600.0)
    assert index.deleted() == [(run.id, 0.0)]
    index.change(run.id, {"pinned": True})
    assert not index.condemn(run.id)


def test_totals(index: Index) -> None:
    assert index.totals()["runs"] == index.totals()["size"] == 0
    index.put(sample(size=10, tags=["a", "b"], pinned=True))
    index.put(sample(size=20, tags=["a"], scenario="rhombus", kind="live"))
    index.put(sample(size=40, tags=["a"], deleted=1.0))
    index.put(sample(size=80, kept=True))
    index.put(sample(size=160, kept=True, deleted=1.0))
    assert index.totals() == {
        "runs": 3,
        "size": 110,
        "pinned_size": 10,
        "kept_size": 90,
        "tags": {"a": 2, "b": 1},
        "scenarios": {"circle": 2, "rhombus": 1},
        "kinds": {"simulation": 2, "live": 1},
        "states": {"complete": 3},
    }
    assert index.sizes() == (310, 90)


def test_what_is_evicted_first(index: Index) -> None:
    runs = {
        "first": sample(created=3.0),
        "second, after the clock was set back": sample(created=1.0),
        "deleted": sample(created=4.0, deleted=5.0),
        "kept and deleted": sample(created=4.0, kept=True, deleted=5.0),
        "pinned": sample(created=0.0, pinned=True),
        "kept": sample(created=0.0, kept=True),
        "recording": sample(created=0.0, state="recording"),
    }
    for run in runs.values():
        index.put(run)
    index.put(runs["first"].model_copy(update={"size": 2000}))  # its place stays
    names = {run.id: name for name, run in runs.items()}
    order = [names[run_id] for run_id, _ in index.evictable()]
    assert set(order[:2]) == {"deleted", "kept and deleted"}
    assert order[2:] == ["first", "second, after the clock was set back"]
    for name in ("pinned", "kept"):
        assert not index.condemn(runs[name].id)


def test_evictions_are_noted_and_the_latest_stay(
    index: Index, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(index_module, "_EVICTIONS", 3)
    runs = [sample(name=str(i), size=i) for i in range(5)]
    for run in runs:
        index.note_eviction(run)
    latest = index.evictions(10)
    assert [(e.run, e.name, e.size) for e in latest] == [
        (run.id, run.name, run.size) for run in runs[:1:-1]
    ]
    assert [e.name for e in index.evictions(1)] == ["4"]


def test_no_page_is_longer_than_allowed_when_everything_matches(index: Index) -> None:
    for i in range(5):
        index.put(sample(name=str(i)))
    assert len(index.page(parse(""), limit=LIMIT_MAX).runs) == 5


# -- what searches have found is kept -------------------------------------------------------------

OTHER = """
import json, sys
from motionlab.library.index import Index
from motionlab.library.run import Run, RunDetail
index = Index(sys.argv[1])
for line in sys.stdin:
    name, *given = json.loads(line)
    if name == "put":
        given = [RunDetail(**given[0])]
    getattr(index, name)(*given)
    print("done", flush=True)
"""


def test_changes_of_this_and_of_another_process_are_seen_by_the_next_search(url: str) -> None:
    here, beside = Index(url), Index(url)
    first, second = sample(name="first", tags=["rig"]), sample(name="second", pinned=True)
    with subprocess.Popen(
        [sys.executable, "-c", OTHER, url], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin and process.stdout

        def elsewhere(*command: object) -> None:
            print(json.dumps(command), file=process.stdin, flush=True)
            assert process.stdout
            assert process.stdout.readline() == "done\n"

        def seen(*names: str) -> None:
            for _ in range(2):  # asked of the database, and of what is kept
                assert sorted(found(here, "tag:rig")) == sorted(names)
                assert sorted(found(beside, "tag:rig")) == sorted(names)
            assert here.page(parse("")).total == len(found(here))

        seen()
        here.put(first)
        seen("first")
        elsewhere("put", second.model_dump(mode="json"))
        seen("first")
        elsewhere("change", second.id, {"tags": ["rig"]})
        seen("first", "second")
        elsewhere("change", first.id, {"deleted": 500.0})
        seen("second")
        beside.change(first.id, {"deleted": None})
        seen("first", "second")
        elsewhere("drop", first.id)
        seen("second")
        here.drop(second.id)
        seen()
        process.stdin.close()
    here.close()
    beside.close()


def test_a_run_is_not_lost_where_one_process_opens_the_index_twice(url: str) -> None:
    """Closing a file of SQLite ends the locks that keep others from removing its log."""
    here = Index(url)
    assert here.page(parse("")).total == 0
    beside = Index(url)
    subprocess.run([sys.executable, "-c", OPEN, url], check=True)
    here.put(run := sample())
    seen = subprocess.run([sys.executable, "-c", OPEN, url], check=True, capture_output=True)
    assert json.loads(seen.stdout) == 1
    assert beside.get(run.id) == run
    here.close()
    beside.close()


def test_further_pages_ask_for_no_lists_until_the_index_changes(index: Index) -> None:
    for i in range(8):
        index.put(sample(name=f"run {i}", tags=["rig"]))
    statements: list[str] = []

    def lists(cursor: str | None = None) -> int:
        statements.clear()
        assert index.page(parse("tag:rig"), limit=3, cursor=cursor).total >= 8
        return sum("run_tags" in each for each in statements)

    def note(_connection: object, _cursor: object, statement: str, *_others: object) -> None:
        statements.append(statement)

    event.listen(index._engine, "before_cursor_execute", note)
    cursor = index.page(parse("tag:rig"), limit=3).cursor
    # PostgreSQL tells of any write by anybody, not only of those to this index.
    assert any(lists(cursor) == 0 for _ in range(20))
    index.put(sample(tags=["rig"]))
    assert lists() == 1


@pytest.mark.parametrize("few", [0, 4, 2000])
def test_many_runs_and_few_are_listed_alike(
    index: Index, monkeypatch: pytest.MonkeyPatch, few: int
) -> None:
    monkeypatch.setattr("motionlab.library.query._FEW", few)
    runs = [
        sample(
            name=f"run {i % 4}",
            tags=["odd"] if i % 2 else ["even", "all"],
            note="night" if i % 3 else "no.",
            metrics={f"A.x.{MAX}": (i % 5) * 1e-6} if i % 5 else {},
            deleted=1.0 if i == 8 else None,
            kind="live" if i < 6 else "simulation",
        )
        for i in range(20)
    ]
    index.put(*runs)
    met = {
        "tag:odd": lambda run: "odd" in run.tags,
        "tag:even tag:all night": lambda run: "all" in run.tags and run.note == "night",
        "o.": lambda run: run.note == "no.",
        "A.x.max<3um kind:live": lambda run: (
            0 < run.metrics.get(f"A.x.{MAX}", 0) < 2.5e-6 and run.kind == "live"
        ),
        "A.x.max>=3um A.x.max<4um": lambda run: 2.5e-6 < run.metrics.get(f"A.x.{MAX}", 0) < 3.5e-6,
        "is:deleted": lambda run: run.deleted is not None,
    }
    for text, test in met.items():
        expected = {
            run.id for run in runs if test(run) and (run.deleted is None) != ("is:" in text)
        }
        for sort in ("name", "-A.x.max"):
            assert {run.id for page in pages_of_runs(index, text, sort) for run in page} == expected
            assert index.page(parse(text), sort=sort).total == len(expected), text


def test_what_is_kept_is_bounded(index: Index, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("motionlab.library.query._KEPT_SEARCHES", 5)
    for i in range(9):
        assert not found(index, f"tag:none{i}")
        with index.begin() as connection:
            assert len(connection.info["totals"]._kept) <= 5


# -- migrations -----------------------------------------------------------------------------------

OPEN = """
import sys; from motionlab.library.index import Index; index = Index(sys.argv[1])
print(index.totals()["runs"]); index.close()
"""


def test_two_processes_make_the_tables_at_once(url: str) -> None:
    processes = [
        subprocess.Popen([sys.executable, "-c", OPEN, url], stderr=subprocess.PIPE, text=True)
        for _ in range(3)
    ]
    for process in processes:
        _, said = process.communicate()
        assert process.returncode == 0, said
    index = Index(url)
    index.put(run := sample())
    assert index.get(run.id) == run
    index.close()


@pytest.mark.parametrize("version", ["0001", "0002", "0003", "0004", "0005", "0006", "0007"])
def test_an_index_of_each_former_form_opens(url: str, version: str) -> None:
    runs = [
        sample(name=f"{version} {i}", tags=["rig"], kept=True, metrics={f"B.x.{MAX}": i * 1e-6})
        for i in range(3)
    ]
    made_by(url, version, *runs)
    index = Index(url)
    assert [index.get(run.id) for run in runs] == runs
    for text in ("", "tag:rig", version, "B.x.max>=0"):
        assert found(index, text, "B.x.max") == [run.name for run in runs]
    index.put(new := sample(kept=True))
    assert len(found(index)) == 4
    index.drop(runs[0].id)
    assert found(index, f'"{version} 0"') == []
    assert index.get(new.id) == new
    index.close()


def test_the_tables_are_those_of_the_migrations(url: str) -> None:
    from alembic.autogenerate import compare_metadata
    from alembic.migration import MigrationContext

    from motionlab.library.tables import METADATA

    def of_metadata(_: object, name: str | None, *others: object) -> bool:
        return not (name or "").startswith("run_words_trigrams")  # which no metadata can tell of

    Index(url).close()
    engine = sa.create_engine(url)
    with engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"include_object": of_metadata})
        assert compare_metadata(context, METADATA) == []
        assert context.get_current_revision() == VERSION
    engine.dispose()


def test_a_newer_index_is_refused_and_untouched(url: str) -> None:
    Index(url).close()
    engine = sa.create_engine(url)
    with engine.begin() as connection:
        connection.execute(sa.text("UPDATE alembic_version SET version_num = '9999'"))
    with pytest.raises(StoreError, match=f"of version 9999, this motionlab knows {VERSION}"):
        Index(url)
    with engine.connect() as connection:
        rows = connection.execute(sa.text("SELECT version_num FROM alembic_version")).all()
    assert [row[0] for row in rows] == ["9999"]
    engine.dispose()


# -- addresses ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "url",
    [
        "mysql://me:secret@host/db",
        "postgresql://me:secret@host:port/db",
        "postgresql://me:secret@127.0.0.1:1/none",
        "sqlite:////nowhere/at/all.sqlite",
    ],
)
def test_no_error_tells_a_password(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, url: str
) -> None:
    monkeypatch.setenv("MOTIONLAB_DATABASE_URL", url)
    with pytest.raises((ConfigError, StoreError)) as refused:
        Index(index_url(tmp_path))
    assert "secret" not in str(refused.value)


def test_a_file_that_is_no_database_is_refused_in_words(tmp_path: Path) -> None:
    (tmp_path / "runs.sqlite").write_bytes(b"not a database" * 100)
    with pytest.raises(StoreError, match="not a database"):
        Index(index_url(tmp_path))
