"""Results that the screens open with: readable, of the present form, and what is computed today."""

from __future__ import annotations

import json
import re
from typing import Any

import httpx
import pytest

from motionlab.lanes import model_hash
from motionlab.server import shipped
from motionlab.server.http.openapi_input import ID
from motionlab.server.job_reports import REPORT, JobSummary
from motionlab.server.routes import jobs
from motionlab.server.shipped.__main__ import record, requests, rounded
from motionlab.studies.table import BY_KIND
from tests.server.live import API

KINDS = ("identify", "landscape", "reproduce", "sweep", "tune")
SIZE_MAX = 300_000
"""Of all files, bytes: they are part of every download."""


def report_of(kind: str) -> dict[str, Any]:
    report = shipped.report(shipped.id_of(kind))
    assert report is not None
    return json.loads(report)


def test_the_files_are_those_of_the_screens_and_small() -> None:
    files = sorted(shipped.FOLDER.glob("*.gz"))
    assert files == [shipped.path_of(kind) for kind in KINDS]
    assert sorted(requests()) == list(KINDS)
    assert sum(path.stat().st_size for path in files) < SIZE_MAX


@pytest.mark.parametrize("kind", KINDS)
def test_a_report_has_the_present_form(kind: str) -> None:
    assert re.fullmatch(ID, shipped.id_of(kind))
    report = report_of(kind)
    checked = REPORT.validate_python(report)
    assert (checked.id, checked.kind, checked.state) == (shipped.id_of(kind), kind, "done")
    assert checked.shipped
    assert re.fullmatch(r"\d+\.\d+\.\d+(\.dev\d+)?", checked.version)
    assert re.fullmatch("[0-9a-f]{16}", checked.model)
    # Written by an older form, it would lack fields or have others.
    assert set(report) == set(type(checked).model_fields)
    assert checked.result.model_dump(mode="json", by_alias=True) == report["result"]
    (summary,) = [line for line in shipped.summaries() if json.loads(line)["kind"] == kind]
    assert JobSummary.model_validate_json(summary).request == report["request"]


@pytest.mark.parametrize("kind", KINDS)
def test_a_result_is_of_the_question_that_its_form_begins_with(kind: str) -> None:
    assert report_of(kind)["request"] == requests()[kind]


def test_the_sweep_is_what_it_is_computed_to_be_today() -> None:
    _, report = record("sweep", requests()["sweep"])
    new, old = (each["result"] for each in (json.loads(report), report_of("sweep")))
    assert new["fields"] == old["fields"]
    for variant, cases in old["variants"].items():
        for axis, figures in cases["axes"].items():
            again = new["variants"][variant]["axes"][axis]["metrics"]
            for metric, values in figures["metrics"].items():
                for new_value, value in zip(again[metric], values, strict=True):
                    expected = value if value is None else pytest.approx(value, rel=1e-3, abs=1e-9)
                    assert new_value == expected, (variant, axis, metric)


def test_the_papers_quick_rows_are_what_they_are_computed_to_be_today() -> None:
    study = BY_KIND["reproduce"]
    only = ["sizing", "rhombus-x"]
    document = study.document(study.run(study.plan({"only": only}), lambda *_: None))
    rows = {row["id"]: row for row in report_of("reproduce")["result"]["rows"]}
    assert document.rows
    for row in document.rows:
        old = rows[row.id]
        assert row.status == old["status"], row.id
        if row.ours is not None:
            assert row.ours == pytest.approx(old["ours"], rel=1e-3), row.id


def test_long_lists_of_numbers_are_rounded() -> None:
    many = [1 / (k + 3) for k in range(40)]
    document = {"value": 1 / 3, "pair": [1 / 3, 2 / 3], "curve": [*many, None], "deep": [many]}
    result = rounded(document)
    assert (result["value"], result["pair"]) == (document["value"], document["pair"])
    assert result["curve"][:2] == [0.3333, 0.25]
    assert result["curve"][-1] is None
    assert result["deep"] == [result["curve"][:-1]]


def test_they_are_listed_last_among_those_of_their_kind_and_read(client: httpx.Client) -> None:
    listed = client.get(f"{API}/jobs?kind=tune").json()
    assert listed[-1]["id"] == "tune--------"
    assert listed[-1]["shipped"]
    assert "result" not in listed[-1]
    url = f"{API}/jobs/tune--------"
    assert client.get(url).json() == report_of("tune")
    assert client.delete(url).json() == report_of("tune")  # it has ended: it stays as it is
    assert not any(job["shipped"] for job in client.get(f"{API}/jobs").json())


def test_one_of_another_model_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    class NoRecords:
        def summaries(self) -> list[bytes]:
            return []

    def listed() -> JobSummary:
        (only,) = jobs._listed(NoRecords(), "sweep", [])  # pyright: ignore[reportArgumentType]
        return only

    monkeypatch.setattr(jobs, "model_hash", lambda: listed_model)
    listed_model = report_of("sweep")["model"]
    assert not listed().other_model
    listed_model = "0" * 16
    assert listed().other_model
    assert len(model_hash()) == len(listed_model)
