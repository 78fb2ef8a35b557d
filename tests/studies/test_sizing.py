"""``motionlab design``, ``POST /design`` and their page: one document, and what is refused."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import httpx
import pytest
from pydantic import BaseModel

from motionlab.cli import main
from motionlab.config.changes import as_tables
from motionlab.motor_design.design import design
from motionlab.motor_design.document import AxisRating, DesignDocument, Rating, Reading, Sizing
from motionlab.motor_design.inputs import Axis, AxisX, AxisY, Choices, DesignRequest, Dimensions
from tests.paths import DOCS

PAGE = (DOCS / "design.md").read_text()

TWICE = "a table that is a single value"
"""Only the command line can say this: in a JSON body a key has one value."""

# what is set, and what the complaint must say
BAD: dict[str, tuple[dict[str, Any], list[str]]] = {
    "a wrong key": (
        {"requirements.fmax": 40.0},
        ["requirements.fmax", "did you mean 'f_max'?", "40.0", "f_max, v_max"],
    ),
    "a wrong key of an axis": (
        {"dimensions.x.weight": 4.0},
        ["dimensions.x.weight", "unknown key", "4.0", "mass, platform_mass, stroke"],
    ),
    "a wrong table": ({"motor.tau": 1}, ["motor", "unknown key", "requirements"]),
    "an unknown preset": ({"preset": "next"}, ["preset", "'next'", "one of paper, previous"]),
    "no gap": ({"requirements.g": 0.0}, ["requirements.g", "0.0", ">= 1e-06 and <= 0.01 m"]),
    "no force": ({"requirements.f_max": -32.0}, ["f_max", "-32.0", ">= 0.001 and <= 100000 N"]),
    "lambda of one": (
        {"requirements.lambda": 1.0},
        ["requirements.lambda", "1.0", "> 1 and <= 1000"],
    ),
    "NaN": (
        {"dimensions.l_m": float("nan")},
        ["dimensions.l_m", "finite", "nan", ">= 1e-05 and <= 100 m"],
    ),
    "infinity": ({"dimensions.y.mass": float("inf")}, ["dimensions.y.mass", "finite", "kg"]),
    "text": ({"requirements.i": "ten"}, ["requirements.i", "must be a number", "'ten'", "A"]),
    "half a tooth": ({"requirements.n": 2.5}, ["requirements.n", "whole number", "2.5"]),
    "true": ({"requirements.n": True}, ["requirements.n", "whole number", "true"]),
    "three limbs": ({"dimensions.limbs": 3}, ["dimensions.limbs", "3", ">= 1 and <= 2"]),
    "teeth that do not add up": (
        {"requirements.p": 3e-3, "requirements.s": 3e-3},
        ["requirements", "p + s = 0.006 m", "must equal tau = 0.0072 m"],
    ),
    "a pitch without its teeth": (
        {"dimensions.p": 3.6e-3, "dimensions.s": 3.6e-3, "dimensions.tau": 9e-3},
        ["dimensions", "p + s = 0.0072 m", "must equal tau = 0.009 m"],
    ),
    "a slot without a tooth": (
        {"requirements.s": 7.2e-3},
        ["requirements", "tau = 0.0072 m", "no tooth", "slot s = 0.0072 m"],
    ),
    "a tooth without a slot": (
        {"dimensions.p": 8e-3},
        ["dimensions", "tau = 0.0072 m", "no slot", "tooth p = 0.008 m"],
    ),
    "sigma of other teeth": (
        {"requirements.p": 2.4e-3, "requirements.sigma": 2.0},
        ["requirements", "p/s = 0.5", "sigma = 2"],
    ),
    "a loading range upside down": (
        {"requirements.loading_min": 95e3},
        ["loading_min = 95000 A/m", "below", "loading_max = 90000 A/m"],
    ),
    "a stack too long to build": (
        {"requirements.lambda": 1.000001},
        ["requirements", "a machine whose l_m is out of range", "<= 100 m"],
    ),
    "turns beyond counting": (
        {"requirements.i": 1e-3, "requirements.H_a": 1e6, "requirements.l_a": 10.0},
        ["requirements", "a machine whose N is out of range", "<= 10000000"],
    ),
    "the previous design's stack": (
        {"preset": "previous", "dimensions.N": 100},
        ["dimensions.l_m: is missing", "dimensions.x.mass: is missing", "does not give it"],
    ),
    TWICE: (
        {"requirements": 5, "requirements.n": 3},
        ["requirements.n", "requirements is a single value", "3"],
    ),
    "a value with fields": (
        {"requirements.n.m": 3},
        ["requirements.n", "must be a whole number", "m"],
    ),
}


def arguments(changes: dict[str, Any]) -> list[str]:
    return [word for key, value in changes.items() for word in ("--set", f"{key}={_toml(value)}")]


def _toml(value: Any) -> str:
    return json.dumps(value) if isinstance(value, bool) else str(value)


# -- the command ----------------------------------------------------------------------------------


def test_the_document_on_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["design", "--json"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert printed.out.count("\n") == 1
    assert json.loads(printed.out) == design({}).model_dump(by_alias=True)
    assert list(tmp_path.iterdir()) == []


def test_settings_are_applied_together(capsys: pytest.CaptureFixture[str]) -> None:
    changes = {"requirements.p": 2e-3, "requirements.tau": 5e-3, "requirements.s": 3e-3}
    assert main(["design", "--json", *arguments({**changes, "dimensions.x.mass": 8.0})]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["requirements"]["sigma"] == pytest.approx(2 / 3)
    assert document["dimensions"]["x"] == {"mass": 8.0, "platform_mass": 8.0, "stroke": 0.17}
    assert document["dimensions"]["y"]["mass"] == 13.9


def test_a_table_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["design"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    rows = [re.split(r"\s{2,}", line.strip()) for line in printed.out.splitlines()]

    def row(name: str) -> str:
        return next(" ".join(cells[1:]) for cells in rows if cells[0] == name)

    assert row("mover width w").startswith("(3) 18.0 mm 39.6 mm [")
    assert row("turns of a phase N").startswith("(14) 144.2 145 [")
    assert row("electric loading A").startswith("(11) 80.6 kA/m 36.6 kA/m [")
    assert row("stack length l_m").startswith("(13) 93.1 mm 42.3 mm [")
    assert "3.687 1.495 [" in row("lambda needed for f_max and l_m")
    assert row("largest velocity, one phase, y").startswith("0.890 m/s 0.843 m/s [")
    assert "warning: y reaches 0.843 m/s from rest to rest with one phase" in printed.out
    assert max(len(line) for line in printed.out.splitlines()) <= 140
    # every mark has its remark, once
    marks = set(re.findall(r" \[(\d+)\] +\S", printed.out))
    remarks = re.findall(r"^  \[(\d+)\] ", printed.out, re.MULTILINE)
    assert marks == set(remarks)
    assert "None" not in printed.out


def test_a_table_without_dimensions(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["design", "--set", "preset=previous"]) == 0
    printed = capsys.readouterr().out
    assert "tau = 9.00 mm" in printed
    assert "tau = 9 mm and n = 2 only" in printed
    assert "no dimensions are known" in printed


@pytest.mark.parametrize(
    ("length", "shown"),
    [(42.3e-3, "42.3 mm"), (9.9996e-4, "1.00 mm"), (2e-5, "20.0 um"), (50.0, "50.0 m")],
)
def test_lengths_as_people_read_them(
    length: float, shown: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["design", *arguments({"dimensions.l_m": length})]) == 0
    assert f"l_m = {shown}, " in capsys.readouterr().out


def test_a_large_area_as_people_read_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["design", *arguments({"dimensions.l_m": 0.5, "requirements.f_max": 1234.0})]) == 0
    printed = capsys.readouterr().out
    assert "2700 mm^2" in printed
    assert "f_max = 1.23 kN" in printed
    assert "e+0" not in printed


def test_help_names_the_page(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["design", "--help"])
    assert left.value.code == 0
    text = " ".join(capsys.readouterr().out.split())
    for word in ("--set KEY=VALUE", "--json", "preset=previous", "motionlab docs design"):
        assert word in text


# -- refusals -------------------------------------------------------------------------------------


@pytest.mark.parametrize("what", BAD)
def test_bad_input(what: str, capsys: pytest.CaptureFixture[str]) -> None:
    changes, words = BAD[what]
    assert main(["design", "--json", *arguments(changes)]) == 2
    printed = capsys.readouterr()
    assert json.loads(printed.out)["status"] == 422
    assert printed.err.startswith("motionlab: ")
    assert "Traceback" not in printed.err
    for word in words:
        assert word in printed.err


@pytest.mark.parametrize("what", [what for what in BAD if what != TWICE])
def test_bad_input_over_rest(client: httpx.Client, what: str) -> None:
    changes, words = BAD[what]
    content = json.dumps(as_tables(changes))  # NaN and Infinity included
    answer = client.post(
        "/api/v1/design", content=content, headers={"content-type": "application/json"}
    )
    assert answer.status_code == 422
    problem = answer.json()
    told = problem["detail"] + json.dumps(problem["errors"])
    for word in words:
        assert word in told
    assert all(error["loc"] and error["message"] for error in problem["errors"])


def test_every_complaint_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["design", *arguments({"requirements.g": 0.0, "dimensions.N": 0})]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert [line.removeprefix("motionlab: ").split(":")[0] for line in lines] == [
        "requirements.g",
        "dimensions.N",
    ]


# -- over REST ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "body",
    [
        {},
        {"preset": "previous"},
        {"requirements": {"lambda": 2.0, "n": 4}},
        {"dimensions": {"y": {"stroke": 0.4}}},
        {"dimensions": None},
        {"requirements": {"K_e": 0.65}, "dimensions": {"N": 160}},
    ],
    ids=json.dumps,
)
def test_rest_answers_with_the_document(client: httpx.Client, body: dict[str, Any]) -> None:
    answer = client.post("/api/v1/design", json=body)
    assert answer.status_code == 200
    assert answer.json() == design(body).model_dump(by_alias=True)


def test_openapi_tells_unit_range_and_source(document: dict[str, Any]) -> None:
    schemas = document["components"]["schemas"]
    for model in ("Requirements", "Dimensions", "SizedDimensions", "AxisX", "AxisY"):
        for name, field in schemas[model]["properties"].items():
            if "$ref" in field:
                continue
            assert field["description"], name
            assert field["unit"], name
            assert field["source"], name
            number = next((f for f in field.get("anyOf", []) if f["type"] == "number"), field)
            assert {"minimum", "exclusiveMinimum"} & set(number), name
            assert "maximum" in number, name
    body = document["paths"]["/api/v1/design"]["post"]["requestBody"]["content"]
    assert set(body["application/json"]["schema"]["properties"]) == set(DesignRequest.model_fields)


# -- the page -------------------------------------------------------------------------------------


def named(model: type[BaseModel]) -> set[str]:
    return {info.alias or name for name, info in model.model_fields.items()}


def rows(heading: str) -> set[str]:
    """Return the names in the first column of the table that a heading begins."""
    table = PAGE.split(f"| {heading} |")[1].split("\n\n")[0]
    cells = [line.split("|")[1] for line in table.splitlines()[2:]]
    return {name for cell in cells for name in re.findall(r"`([^`]+)`", cell)}


def test_the_page_names_every_field() -> None:
    assert rows("of both") == named(Choices)
    axes = {f"{axis}.{name}" for axis in "xy" for name in named(Axis)}
    own = named(Dimensions) - named(Choices) - {"x", "y"}
    assert rows("of dimensions only") == own | axes
    assert named(AxisX) == named(AxisY) == named(Axis)


def test_the_page_names_every_key_of_the_document() -> None:
    assert rows("key") == named(DesignDocument)
    for section, model in (
        ("`sizing`", Sizing),
        ("`rating`", Rating),
        ("`rating.x` and `rating.y`", AxisRating),
    ):
        line = re.search(rf"^Readings of {section}: (.+)\.$", PAGE, re.MULTILINE)
        assert line is not None, section
        readings = [name for name, i in model.model_fields.items() if i.annotation is Reading]
        assert re.findall(r"`(\w+)`", line[1]) == readings


def test_the_reading_on_the_page_is_one() -> None:
    shown = re.search(r'\{"quantity".+?\}', PAGE, re.DOTALL)
    assert shown is not None
    width = design({}).sizing.w.model_dump()
    shown = json.loads(shown[0])
    assert shown.pop("printed_value") == pytest.approx(width.pop("printed_value"))
    assert shown == width


def test_the_figures_on_the_page_are_those_printed(capsys: pytest.CaptureFixture[str]) -> None:
    main(["design"])
    printed = capsys.readouterr().out
    table = PAGE.split("## Printed beside corrected")[1]
    figures = re.findall(r"\d+\.?\d* (?:mm\^2|mm|kA/m|W|ms)\b", table)
    assert len(figures) > 15
    for figure in figures:
        assert figure in printed or figure == "457 mm^2", figure
