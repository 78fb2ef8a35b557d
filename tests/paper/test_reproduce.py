"""``motionlab reproduce`` and its routes: the document, exit codes, recipes that really work."""

from __future__ import annotations

import contextlib
import io
import json
import re
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import httpx
import pytest

from motionlab.cli import main
from motionlab.paper import experiments, judgement, reproduce
from motionlab.paper.documents import ReproduceDocument
from motionlab.paper.printed_number import look_up
from motionlab.paper.registry import GROUPS, paper
from motionlab.studies.identify import experiment
from motionlab.studies.identify.documents import IdentificationDocument
from motionlab.studies.identify.experiment import Experiment
from tests.paths import DOCS
from tests.server.live import API, until
from tests.server.servers import PATIENCE, Server

Reproduced = tuple[int, dict[str, Any]]
CASES = 20
"""Plants of a Monte Carlo study, which judges no row."""


@pytest.fixture(scope="module", autouse=True)
def _no_more_than_needed() -> Iterator[None]:
    """Draw few plants, and carry each identification out once.

    A command of a recipe asks for the identification by which its row was found.
    """
    carry_out = experiment.identify
    known: list[tuple[Experiment, IdentificationDocument]] = []

    def once(asked: Experiment, progress: experiment.Progress | None) -> IdentificationDocument:
        for other, document in known:
            if (other.request, other.rig) == (asked.request, asked.rig):
                return document
        known.append((asked, carry_out(asked, progress)))
        return known[-1][1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(experiments, "CASES", CASES)
        patch.setattr(experiments, "identify", once)
        patch.setattr(experiment, "identify", once)
        yield


@pytest.fixture(scope="module")
def whole() -> ReproduceDocument:
    """Return what `motionlab reproduce` finds, which prints it and exits with 0."""
    found: list[ReproduceDocument] = []
    compute = reproduce.reproduce

    def kept(only: Sequence[str], progress: reproduce.Progress) -> ReproduceDocument:
        found.append(compute(only, progress))
        return found[0]

    with (
        pytest.MonkeyPatch.context() as patch,
        contextlib.redirect_stdout(io.StringIO()) as printed,
    ):
        patch.setattr(reproduce, "reproduce", kept)
        assert main(["reproduce"]) == 0
    (document,) = found
    assert [row.id for row in document.rows if row.id not in printed.getvalue()] == []
    return document


def command(capsys: pytest.CaptureFixture[str], *arguments: str) -> Reproduced:
    code = main([*arguments, "--json"])
    return code, json.loads(capsys.readouterr().out)


def test_everything_holds_but_what_is_known_not_to(whole: ReproduceDocument) -> None:
    red = {row.id for row in whole.rows if row.holds is False}
    assert red == set(judgement.known_failures())
    assert whole.summary.fails == 0
    assert whole.summary.come_to_hold == []
    assert [row.id for row in whole.rows if row.error is not None] == []


def test_what_is_not_comparable_has_no_number_of_ours(whole: ReproduceDocument) -> None:
    for row in whole.rows:
        assert (row.status == "not_comparable") == (row.comparison == "none"), row.id
        if row.status == "not_comparable":
            assert (row.ours, row.holds, row.band) == (None, None, None), row.id
        assert len(row.reason) > 3, row.id


def test_one_figure_agrees_with_one_of_two_values_only(whole: ReproduceDocument) -> None:
    held: dict[tuple[Any, str], Any] = {}
    for row in whole.rows:
        if row.kind == "printed" and row.comparison == "value" and row.holds:
            assert held.setdefault((row.ours, row.unit), row.paper) == row.paper, row.id
    rows = {row.id: row for row in whole.rows}
    for what in ("thrust", "normal"):
        own, other = rows[f"{what}-fem"], rows[f"{what}-measured"]
        assert (own.status, other.status) == ("holds", "not_comparable")
        assert [value.value for value in other.values] == [own.ours]


def test_the_page_counts_kinds_and_lists_lax_rows_as_they_come_out(
    whole: ReproduceDocument,
) -> None:
    page = (DOCS / "paper.md").read_text()
    summary = whole.summary
    counted = {**summary.kinds, "all": summary}
    for kind, count in counted.items():
        cells = (count.holds, count.lax, count.known_failure, count.not_comparable)
        name = kind if kind == "all" else f"`{kind}`"
        (found,) = re.findall(rf"^\| {name} \| .*$", page, re.MULTILINE)
        shown = [int(cell.strip() or 0) for cell in found.split("|")[3:7]]
        assert shown == list(cells), kind
    listed = set(re.findall(r"^\| `(\S+)` \| lax: ", page, re.MULTILINE))
    assert listed == {row.id for row in whole.rows if row.lax}


def test_errors_of_runs_stand_beside_plausible_motors(whole: ReproduceDocument) -> None:
    rows = {row.id: row for row in whole.rows if row.monte_carlo is not None}
    assert {"fig5-on-x", "fig5-improvement-y", "pentagram-y", "trapezoid-y"} <= set(rows)
    for row in rows.values():
        assert row.monte_carlo is not None
        assert row.monte_carlo.low <= row.monte_carlo.median <= row.monte_carlo.high, row.id
        assert 0 < row.monte_carlo.plants <= CASES
        assert shlex.split(row.monte_carlo.cli)[:2] == ["motionlab", "montecarlo"]
    kept = rows["rhombus-y"].monte_carlo
    assert kept is not None and kept.share is not None and 0.0 <= kept.share <= 1.0


def test_every_erratum_is_shown_by_its_computation(whole: ReproduceDocument) -> None:
    assert len(whole.errata) == 21
    assert [e.id for e in whole.errata if not e.shown] == []
    assert [e.id for e in whole.errata if not e.steps] == []
    assert len({e.id for e in whole.errata}) == len(whole.errata)


def test_every_figure_has_something_to_draw(whole: ReproduceDocument) -> None:
    assert len(whole.figures) > 25
    for figure in whole.figures:
        assert figure.series, figure.id
        for series in figure.series:
            assert 0 < len(series.x) == len(series.y) <= 2000, (figure.id, series.label)
    drawn = {figure.id for figure in whole.figures}
    assert {row.figure for row in whole.rows if row.figure is not None} <= drawn


def test_the_command_prints_one_document(capsys: pytest.CaptureFixture[str]) -> None:
    code, document = command(capsys, "reproduce", "--only", "limits", "rhombus-x", "turns")
    assert code == 0
    assert {row["group"] for row in document["rows"]} == {"limits", "table1", "sizing"}
    for row in document["rows"]:
        assert {"id", "paper", "ours", "band", "reason", "holds", "status"} <= set(row)
    by_id = {row["id"]: row for row in document["rows"]}
    assert by_id["turns"]["ours"] == 145.0
    assert by_id["velocity-single-y"]["status"] == "known_failure"
    assert by_id["velocity-single-y"]["known"] == judgement.known_failures()["velocity-single-y"]
    low, high = by_id["rhombus-x"]["ours"]
    assert -14.2e-6 < low < 0.0 < high < 14.3e-6
    assert by_id["rhombus-x"]["better"] is True
    ReproduceDocument.model_validate(document)


@pytest.mark.parametrize(
    ("listed", "said"),
    [
        ("", "1 fail"),
        ('velocity-single-y = "why"\nturns = "it never holds"\n', "it holds now"),
    ],
    ids=["a failure that no one knows", "a known failure that holds"],
)
def test_it_fails_on_what_the_list_does_not_say(
    listed: str,
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    path = tmp_path / "known_failures.toml"
    path.write_text(listed)
    monkeypatch.setattr(judgement, "FILE", path)
    assert main(["reproduce", "--only", "turns", "velocity-single-y"]) == 1
    assert said in capsys.readouterr().out


def test_an_unknown_row_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "--only", "rombus-x"]) == 2
    complaint = capsys.readouterr().err
    assert "did you mean 'rhombus-x'" in complaint
    assert "one of the groups sizing, forces" in complaint


def test_every_command_of_a_recipe_gives_its_number(
    whole: ReproduceDocument, capsys: pytest.CaptureFixture[str]
) -> None:
    """But those that ask for the row itself: of these the options alone are checked."""
    printed: dict[str, Any] = {}
    for row in whole.rows:
        program, *arguments = shlex.split(row.recipe.cli)
        assert program == "motionlab", row.id
        if not row.recipe.find:
            assert arguments[0] in {"reproduce", "run"}, row.id
            continue
        if row.recipe.cli not in printed:
            assert main(arguments) == 0, row.id
            printed[row.recipe.cli] = json.loads(capsys.readouterr().out)
        found = [look_up(printed[row.recipe.cli], path) for path in row.recipe.find]
        ours = list(row.ours) if isinstance(row.ours, tuple) else [row.ours]
        if row.group == "stability":  # chaotic: another order of summing is another run
            continue
        assert found == pytest.approx(ours, rel=1e-12), row.id
    assert len(printed) > 8
    code, document = command(capsys, "reproduce", "--only", "acceleration-x")
    assert (code, len(document["rows"])) == (0, 1)


def test_every_curl_line_of_a_recipe_is_answered(whole: ReproduceDocument, server: Server) -> None:
    answers: dict[str, Any] = {}
    rows = [row for row in whole.rows if row.comparison != "none"]
    with httpx.Client(timeout=PATIENCE) as client:
        for row in rows:
            program, silent, option, body, url = shlex.split(row.recipe.curl)
            assert (program, silent, option) == ("curl", "-s", "--json"), row.id
            url = url.replace("http://127.0.0.1:8000", server.url)
            call = url.rsplit("/", 1)[1]
            if call == "reproduce":
                assert json.loads(body) == {"only": [row.id]}, row.id
                continue  # a job each; one is carried out below
            if row.recipe.curl not in answers:
                answer = client.post(
                    url, content=body, headers={"Content-Type": "application/json"}
                )
                assert answer.status_code in {200, 202}, (row.id, answer.text)
                answers[row.recipe.curl] = answer.json()
                if call == "identify":
                    client.delete(f"{server.url}{API}/jobs/{answer.json()['id']}")
            if call in {"design", "simulate"} and row.recipe.find and row.group != "stability":
                found = [look_up(answers[row.recipe.curl], path) for path in row.recipe.find]
                ours = list(row.ours) if isinstance(row.ours, tuple) else [row.ours]
                assert found == pytest.approx(ours, rel=1e-12), row.id
    assert len(answers) > 8


def test_the_rows_are_listed_before_anything_is_computed(server: Server) -> None:
    answer = httpx.get(f"{server.url}{API}/paper", timeout=PATIENCE)
    assert answer.status_code == 200
    assert answer.json() == paper().model_dump(mode="json")
    assert [group["id"] for group in answer.json()["groups"]] == [group.id for group in GROUPS]


def test_a_job_computes_them_row_by_row(server: Server) -> None:
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        refused = client.post(f"{API}/reproduce", json={"only": ["no-row"]})
        assert refused.status_code == 422
        assert refused.json()["errors"][0]["loc"] == "only"
        answer = client.post(f"{API}/reproduce", json={"only": ["limits", "sizing"]})
        assert answer.status_code == 202
        assert answer.json()["kind"] == "reproduce"
        location = answer.headers["location"]
        rows: list[int] = []

        def done() -> bool:
            report = client.get(location).json()
            rows.append(len((report["partial"] or {"rows": []})["rows"]))
            return report["state"] == "done"

        until(done)
        assert rows == sorted(rows)
        report = client.get(location).json()
        assert report["request"] == {"only": ["limits", "sizing"]}
        ReproduceDocument.model_validate(report["result"])
        assert len(report["result"]["rows"]) == rows[-1] > 20


def test_a_job_can_be_cancelled(server: Server) -> None:
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        location = client.post(f"{API}/reproduce", json={}).headers["location"]
        assert client.delete(location).json()["state"] == "cancelled"
        assert client.get(location).json()["result"] is None
