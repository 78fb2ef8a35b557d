"""``motionlab platform`` and ``POST /design/platform``: one document, and what is refused."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from motionlab.cli import main
from motionlab.motor_design.fem.compute import compute
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.motor_design.platform.inputs import Load, MapLoad, PlatformRequest, Shape
from tests.paths import DOCS
from tests.server.live import API

PAGE = (DOCS / "platform.md").read_text()
QUICK = {"cells": 4}


@pytest.fixture(autouse=True)
def _data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))


@pytest.fixture(scope="module")
def preview() -> str:
    """Return the file of a force map."""
    return compute(Geometry(), "preview").text()


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    assert main(["platform", "--set", "cells=4", "--json", *arguments]) == 0
    return json.loads(capsys.readouterr().out)


def asked(client: httpx.Client, body: dict[str, Any]) -> dict[str, Any]:
    response = client.post(f"{API}/design/platform", json=QUICK | body)
    assert response.status_code == 200, response.text
    return response.json()


@pytest.mark.parametrize("axis", ["x", "y"])
def test_the_command_prints_what_the_api_answers(
    axis: str, client: httpx.Client, capsys: pytest.CaptureFixture[str]
) -> None:
    document = printed(capsys, "--axis", axis)
    assert asked(client, {"axis": axis}) == document
    assert document["change"] < -0.5
    assert document["paper"]["status"] == "not_comparable"
    assert "Fig. 3" in document["paper"]["reason"]
    for design in document["designs"].values():
        picture = np.array(design["deflection"])
        assert picture.shape == (len(design["y"]), len(design["x"]))
        assert np.max(np.abs(picture)) == pytest.approx(design["largest"], rel=0.01)
        assert [mover["force"] for mover in design["movers"]] == [400.0] * 4
        assert design["mean_gap"] is None


def test_the_papers_figures_and_its_own_percentage(client: httpx.Client) -> None:
    paper = asked(client, {"axis": "y"})["paper"]
    assert (paper["previous"], paper["new"]) == (126.36e-6, 34.18e-6)
    assert round(paper["change"], 3) == -0.730
    assert paper["change_printed"] == -0.725


def test_a_force_map_closes_the_gap(
    client: httpx.Client, preview: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "ours.json").write_text(preview)
    document = asked(client, {"map": {"name": "ours"}})
    assert printed(capsys, "--map", "ours") == document
    new = document["designs"]["new"]
    for mover in new["movers"]:
        assert mover["gap"] == pytest.approx(0.3e-3 - mover["gap_change"])
        assert mover["force"] > 413
    assert new["mean_gap"] == pytest.approx(np.mean([m["gap"] for m in new["movers"]]))
    assert 1.01 < new["thrust_ratio"] < 1.2
    weaker = asked(client, {"map": {"name": "ours", "current": 3.0, "position": 1e-3}})
    assert weaker["designs"]["new"]["movers"][0]["force"] < 0.6 * new["movers"][0]["force"]
    assert main(["platform", "--map", "ours", "--set", "cells=4"]) == 0
    text = capsys.readouterr().out
    assert f"motionlab map --set g={new['mean_gap']:.4g}" in text


@pytest.mark.parametrize(
    ("body", "loc", "words"),
    [
        ({"new": {"thickness": 0}}, "new.thickness", "is out of range"),
        ({"new": {"nu": 0.5}}, "new.nu", "<= 0.49"),
        ({"new": {"heigth": 1}}, "new.heigth", "unknown key"),
        ({"new": {"rib_width": 0.2}}, "new", "ribs overlap"),
        ({"new": {"span_x": 0.5}}, "new", "outside of the plate"),
        ({"load": {"spacing_x": 0.45}}, "platform", "forces outside of the plate: previous.length"),
        ({"load": {"length": 0}}, "load", "is a line"),
        ({"load": {"forces": [1, 2, 3]}}, "load.forces", ""),
        ({"load": {"forces": [1e9, 0, 0, 0]}}, "load", "at most 1e6 N"),
        ({"axis": "z"}, "axis", "is not one of the choices"),
        ({"previous": 3}, "previous", "must be a table"),
        ({"map": {"name": "none"}}, "map.name", "no force map of that name"),
    ],
)
def test_what_cannot_be_is_refused(
    client: httpx.Client, body: dict[str, Any], loc: str, words: str
) -> None:
    response = client.post(f"{API}/design/platform", json=body)
    assert response.status_code == 422, response.text
    (error,) = [e for e in response.json()["errors"] if e["loc"].startswith(loc)][:1]
    assert words in error["message"] + error["range"]


def test_a_current_beyond_the_map_is_refused(
    client: httpx.Client, preview: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "ours.json").write_text(preview)
    for current in (0, 5e-324, 1e-300, 10.5):
        body = {"map": {"name": "ours", "current": current}}
        response = client.post(f"{API}/design/platform", json=body)
        assert response.status_code == 422
        assert response.json()["errors"][0]["range"] == ">= 0.001 and <= 10"
    least = asked(client, {"map": {"name": "ours", "current": 0.001}})["designs"]["new"]
    assert 0 < least["movers"][0]["force"] < 1e-3
    assert main(["platform", "--map", "ours", "--set", "new.thickness=0.004"]) == 2
    assert "too soft" in capsys.readouterr().err


def test_no_force_bends_nothing(client: httpx.Client) -> None:
    document = asked(client, {"load": {"forces": [0, 0, 0, 0]}})
    assert document["change"] is None
    assert document["designs"]["new"]["largest"] == 0


def test_the_page_lists_every_field() -> None:
    for model in (Shape, Load, MapLoad, PlatformRequest):
        for name in model.model_fields:
            assert re.search(rf"`{name}`", PAGE), name
