"""``motionlab sharing``, ``map --fit``, their calls over REST and their page: one document."""

from __future__ import annotations

import json
import re
from typing import Any

import httpx
import numpy as np
import pytest

from motionlab.cli import main
from motionlab.config.controller import SharingConfig
from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.force_sharing.functions import FUNCTIONS
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.studies.sharing.sharing import SharingDocument, SharingRequest, sharing
from tests.paths import DOCS

PAGE = (DOCS / "sharing.md").read_text()
API = "/api/v1"

BAD: dict[str, tuple[list[str], list[str]]] = {
    "a wrong key": (["forec=2.0"], ["forec", "did you mean 'force'?"]),
    "an unknown map": (["controller=none-such"], ["controller.name", "none-such", "new-design"]),
    "another pitch": (["plant=previous-design"], ["plant", "another pole pitch", "0.009"]),
    "a current out of the map": (
        ["controller=new-design", "current_limit=12.0"],
        ["current_limit", "12.0", "<= 10 A"],
    ),
    "no law": (["law=best"], ["law", "force-per-ampere"]),
    "no resistance": (["resistance=0.0"], ["resistance", "> 0", "Ohm"]),
    "a wrong number of a map": (["controller={F_pk=2.0}"], ["controller", "tau", "is missing"]),
}


def sets(assignments: list[str]) -> list[str]:
    return [word for text in assignments for word in ("--set", text)]


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    assert main([*arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_the_command_and_the_call_give_one_document(
    client: httpx.Client, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = {"controller": "nominal", "plant": "new-design", "law": "sine", "force": -12.0}
    answer = client.post(f"{API}/design/sharing", json=asked)
    assert answer.status_code == 200
    found = printed(capsys, "sharing", *sets([f"{k}={v}" for k, v in asked.items()]))
    assert answer.json() == found
    document = SharingDocument.model_validate(found)
    assert document.plant.kind == "table"
    assert document.plant.digest is not None
    assert document.controller.name == "nominal"
    curves = document.curves
    assert np.sum(curves.phase_thrust, axis=0) == pytest.approx(np.array(curves.thrust))
    assert np.mean(curves.thrust) == pytest.approx(document.thrust.mean)
    assert np.ptp(curves.thrust) == pytest.approx(document.thrust.peak_to_peak)
    assert np.mean(curves.believed) == pytest.approx(-12.0)
    assert min(curves.reachable) == document.linear_up_to
    assert document.loss.squared_current == pytest.approx(np.mean(curves.squared_current))
    assert document.loss.power is None
    assert document.normal_force.mean == pytest.approx(np.mean(curves.normal_force))
    assert document.normal_force.largest == max(curves.normal_force)


def test_loss_in_watts(client: httpx.Client) -> None:
    found = client.post(f"{API}/design/sharing", json={"resistance": 1.5}).json()
    assert found["loss"]["power"] == pytest.approx(1.5 * found["loss"]["squared_current"])
    assert found["loss"]["relative"] > 1.0


@pytest.mark.parametrize(("assignments", "words"), BAD.values(), ids=BAD)
def test_what_is_refused(
    assignments: list[str], words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["sharing", *sets(assignments)]) == 2
    text = capsys.readouterr().err
    for word in words:
        assert word in text


def test_a_refusal_over_rest(client: httpx.Client) -> None:
    answer = client.post(f"{API}/design/sharing", json={"force": "much", "plant": "none"})
    assert answer.status_code == 422
    assert [error["loc"] for error in answer.json()["errors"]] == ["force"]
    assert client.post(f"{API}/design/sharing", json={"plant": "none"}).status_code == 422


def test_a_fit_is_a_map_for_a_controller(
    client: httpx.Client, capsys: pytest.CaptureFixture[str]
) -> None:
    found = client.get(f"{API}/maps/new-design/fit").json()
    assert found == printed(capsys, "map", "--fit", "new-design")
    assert found["fitted"] == ["F_pk", "I_knee", "h_2", "h_3"]
    field = "variants.B.controller.model.force_map"
    scenario = load_scenario("circle", {field: found["force_map"]})
    assert scenario.variants["B"].controller.model.y.force_map.model_dump() == found["force_map"]
    assert client.get(f"{API}/maps/none-such/fit").status_code == 404
    assert main(["map", "--fit", "new-design", "--set", "g=0.4e-3"]) == 2
    assert "--set" in capsys.readouterr().err


def test_people_see_every_law(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sharing"]) == 0
    text = capsys.readouterr().out
    for law in FUNCTIONS:
        assert law in text
    assert re.search(r"normal force\n  mean +N .*\n  largest +N ", text)
    assert main(["sharing", "--set", "law=sine"]) == 0
    assert "cubic" not in capsys.readouterr().out
    assert main(["map", "--fit", "previous-design"]) == 0
    assert "As numbers for a controller's model: { tau = " in capsys.readouterr().out


def test_the_page_names_every_field_and_law() -> None:
    for field in (*SharingRequest.model_fields, *SharingConfig.model_fields):
        assert f"`{field}`" in PAGE or f"`sharing.{field}`" in PAGE or f"sharing.{field}`" in PAGE
    for field in SharingDocument.model_fields:
        assert f"`{field}`" in PAGE


def test_what_the_page_prints_is_what_comes_out(capsys: pytest.CaptureFixture[str]) -> None:
    rows = re.findall(r"^\| `([a-z-]+)` \| ([\d.]+) N \| ([\d.]+) N \| ([\d.]+) N \|", PAGE, re.M)
    assert {law for law, *_ in rows} == set(FUNCTIONS)
    for law, *linear in rows:
        for name, shown in zip(("nominal", "new-design", "previous-design"), linear, strict=True):
            words = sets([f"controller={name}", f"law={law}", "points=360"])
            assert printed(capsys, "sharing", *words)["linear_up_to"] == (
                pytest.approx(float(shown), abs=0.006)
            )


LEAST_NORMAL_FORCE = "least-normal-force"
COMPARED: dict[str, dict[str, Any]] = {
    "`least-norm`": {"law": "least-norm"},
    "`force-per-ampere`": {"law": "force-per-ampere"},
    "`least-normal-force`": {"law": LEAST_NORMAL_FORCE},
    "with `rise` 0.1": {"law": LEAST_NORMAL_FORCE, "rise": 0.1},
}


def table(*heads: str) -> list[dict[str, str]]:
    """Return the rows of the page's table with these heads, cells by head."""
    _, _, below = PAGE.partition(f"| {' | '.join(heads)} |\n")
    lines = below.split("\n\n")[0].splitlines()[1:]
    assert lines
    return [dict(zip(heads, line.strip("| ").split(" | "), strict=True)) for line in lines]


def numbers(cell: str) -> list[float]:
    return [float(number) for number in re.findall(r"\d+(?:\.\d+)?", cell)]


def test_the_normal_force_on_the_page() -> None:
    laws = ("`least-norm`", "`least-normal-force`", "with `rise` 0.1")
    for row in table("map", "thrust", *laws, "least of all"):
        asked = {"controller": row["map"].strip("`"), "force": numbers(row["thrust"])[0]}
        usual, *means = (
            sharing(SharingRequest(**asked, **COMPARED[law])).normal_force.mean for law in laws
        )
        assert numbers(row["`least-norm`"]) == [pytest.approx(usual, abs=0.06)]
        for law, mean in zip(laws[1:], means, strict=True):
            saved = 100.0 * (1.0 - mean / usual)
            assert numbers(row[law]) == [
                pytest.approx(mean, abs=0.06),
                pytest.approx(saved, abs=0.6),
            ]
        assert numbers(row["least of all"])[0] < min(means)


def test_the_price_on_the_page() -> None:
    for row in table("thrust", *(COMPARED)):
        force = numbers(row["thrust"])[0]
        for law, changes in COMPARED.items():
            document = sharing(SharingRequest(force=force, **changes))
            assert numbers(row[law]) == [
                pytest.approx(document.loss.relative, abs=6e-4),
                pytest.approx(1e-3 * document.steepest_current, abs=0.06),
            ]


def test_the_errors_on_the_page() -> None:
    laws = ("`least-norm`", "`least-normal-force`", "with `rise` 0.1")
    for row in table("scenario", "map", "mu", *laws):
        changes: dict[str, Any] = {}
        if mu := numbers(row["mu"])[0]:
            for axis in AXES:
                changes[f"plant.{axis}.effects"] = [{"effect": "lugre", "mu": mu}]
                changes[f"plant.{axis}.friction.enabled"] = False
        if row["map"] != "nominal":
            for place in ("plant", "variants.B.controller.model"):
                changes[f"{place}.force_map"] = row["map"].strip("`")
        for law in laws:
            own = {f"variants.B.controller.sharing.{k}": v for k, v in COMPARED[law].items()}
            prepared = prepare(load_scenario(row["scenario"].strip("`"), changes | own))
            record, window = run(prepared).variants["B"], slice(*prepared.reference.window)
            errors = (np.abs(record.channel("following_error", axis)[window]) for axis in AXES)
            largest = [1e6 * float(each.max()) for each in errors]
            assert numbers(row[law]) == pytest.approx(largest, abs=0.006), (row, law)
