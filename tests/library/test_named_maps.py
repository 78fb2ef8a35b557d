"""Force maps named in scenarios: found, refused, recorded, and the same bits whoever is beside."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motionlab.config.force_map import ForceMapConfig, TableMapConfig
from motionlab.config.load import load_scenario
from motionlab.config.named_configs import config_root
from motionlab.errors import ConfigError, StoreError
from motionlab.force_sharing.tables import share_cells
from motionlab.lanes.bank import Bank
from motionlab.library.maps import ForceMaps
from motionlab.loop.linearise import linearise
from motionlab.motor_design.fem.force_map import ForceMap, ForceMapDocument
from motionlab.motor_design.kept_maps import map_names, named_map
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document, metadata
from motionlab.simulation.run import run

SHIPPED = json.loads((config_root() / "maps" / "new-design.json").read_text())
SHORT = {"trajectory": {"kind": "sine", "amplitude": {"x": 0.01, "y": 0.01}, "frequency": 2.0}}
MODEL = "variants.B.controller.model.force_map"


def refusal(changes: dict[str, Any]) -> str:
    with pytest.raises(ConfigError) as refused:
        prepare(load_scenario("circle", changes))
    return str(refused.value)


@pytest.fixture
def own_map(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the file of a map that a user keeps under a name of their own: half the forces."""
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    path = tmp_path / "maps" / "mine.json"
    path.parent.mkdir()
    path.write_text(json.dumps(scaled(1 / 2)))
    return path


def scaled(factor: float) -> dict[str, Any]:
    """Return the shipped map with other forces."""
    names = ("coenergy", "linkage", "thrust")
    return SHIPPED | {name: (factor * np.array(SHIPPED[name])).tolist() for name in names}


def test_a_name_stands_for_a_table_on_one_axis_or_both() -> None:
    both = load_scenario("circle", {"plant.force_map": "new-design", MODEL: "previous-design"})
    assert both.plant.x.force_map == both.plant.y.force_map == TableMapConfig(name="new-design")
    assert both.variants["B"].controller.model.y.force_map == TableMapConfig(name="previous-design")
    assert isinstance(both.variants["A"].controller.model.y.force_map, ForceMapConfig)
    one = load_scenario("circle", {"plant.x.force_map": "new-design"})
    assert isinstance(one.plant.x.force_map, TableMapConfig)
    assert isinstance(one.plant.y.force_map, ForceMapConfig)
    table = {"kind": "table", "name": "new-design", "gain": 0.9}
    assert load_scenario("circle", {"plant.force_map": table}).plant.x.force_map == (
        TableMapConfig(name="new-design", gain=0.9)
    )
    peak = load_scenario("circle", {"plant.force_map": {"F_pk": 38.4}}).plant.y.force_map
    assert isinstance(peak, ForceMapConfig)
    assert (peak.F_pk, peak.tau) == (38.4, 7.2e-3)


def test_a_scenario_with_a_table_is_read_back_the_same() -> None:
    scenario = load_scenario("circle", {"plant.force_map": "new-design"})
    assert load_scenario(scenario.model_dump(mode="json")) == scenario


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"plant.force_map": "nwe-design"}, ["plant.x.force_map.name", "new-design", "previous"]),
        ({MODEL: "none-such"}, ["variants.B.controller.model.x.force_map.name", "none-such"]),
        (
            {"plant.x.force_map": {"kind": "table", "name": "new-design", "F_pk": 3.0}},
            ["plant.x.force_map.F_pk", "unknown key"],
        ),
        ({"plant.x.force_map": {"kind": "tabel"}}, ["plant.x.force_map.kind", "table"]),
        ({"plant.x.force_map": "../secrets"}, ["plant.x.force_map.name"]),
        (
            {"plant.force_map": "new-design", "plant.x.amplifiers.limit": 12.0},
            ["plant.x.amplifiers.limit", "12", "<= 10 A"],
        ),
        (
            {MODEL: "new-design", "variants.B.controller.current_limit": 11.0},
            ["variants.B.controller.current_limit", "<= 10 A"],
        ),
        ({"variants.B.controller.sharing.law": "sin"}, ["sharing.law", "sine", "cubic"]),
        ({"variants.B.controller.sharing.overlap": 0.2}, ["sharing.overlap", "0.2"]),
    ],
)
def test_what_cannot_be_used_is_refused(changes: dict[str, Any], words: list[str]) -> None:
    text = refusal(changes)
    for word in words:
        assert word in text


def test_a_result_names_its_maps_by_their_numbers(own_map: Path) -> None:
    assert map_names() == ["mine", "new-design", "previous-design"]
    prepared = prepare(load_scenario("circle", SHORT | {"plant.x.force_map": "mine"}))
    found = document(prepared, run(prepared))["maps"]
    assert found.keys() == {"plant.x.force_map"}
    record = found["plant.x.force_map"]
    assert record["name"] == "mine"
    # The hash of the geometry is that of the map it was made from; that of the numbers is not.
    shipped = named_map("new-design")
    assert record["content_hash"] == shipped.document.content_hash
    assert record["digest"] == named_map("mine").digest != shipped.digest
    assert json.loads(metadata(prepared.scenario)["maps"]) == found


def test_another_file_under_a_name_is_another_map(own_map: Path) -> None:
    scenario = load_scenario("circle", SHORT | {"plant.force_map": "mine"})
    first = run(prepare(scenario))
    own_map.write_text(json.dumps(scaled(1 / 3), indent=1))
    second = run(prepare(scenario))
    assert (first.variants["A"].samples != second.variants["A"].samples).any()


def test_a_damaged_file_is_told(own_map: Path) -> None:
    own_map.write_text("{}")
    assert "plant.x.force_map: map 'mine' cannot be used" in refusal({"plant.force_map": "mine"})


def test_a_pipe_or_a_link_to_itself_is_no_map(own_map: Path) -> None:
    os.mkfifo(own_map.with_name("pipe.json"))
    own_map.with_name("loop.json").symlink_to(own_map.with_name("loop.json"))
    assert [entry.name for entry in ForceMaps().all() if not entry.shipped] == ["mine"]
    assert "no force map of that name" in refusal({"plant.force_map": "pipe"})


@pytest.mark.parametrize("value", [1e308, -1e308])
def test_absurd_numbers_in_a_file_are_told_and_harm_no_list(own_map: Path, value: float) -> None:
    tables = json.loads(own_map.read_text())
    tables["coenergy"][10][10] = value
    own_map.write_text(json.dumps(tables))
    assert "coenergy must hold numbers up to 1e+09" in refusal({"plant.force_map": "mine"})
    assert own_map.stem not in [entry.name for entry in ForceMaps().all()]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("thrust", ("thrust.", "contradicts coenergy: dW'/dx is ", "within 5% of the largest")),
        ("linkage", ("linkage.", "contradicts coenergy: dW'/di is ")),
        ("coenergy", ("contradicts coenergy",)),
    ],
)
def test_tables_that_contradict_each_other_are_refused(
    own_map: Path, name: str, words: tuple[str, ...]
) -> None:
    tables = json.loads(own_map.read_text())
    tables[name] = (1.2 * np.array(tables[name])).tolist()
    own_map.write_text(json.dumps(tables))
    refused = refusal({"plant.force_map": "mine"})
    assert all(word in refused for word in words)


def test_the_hash_of_another_geometry_is_refused(own_map: Path) -> None:
    right = SHIPPED["content_hash"]
    own_map.write_text(json.dumps(scaled(1 / 2) | {"content_hash": "0123456789abcdef"}))
    refused = refusal({"plant.force_map": "mine"})
    assert "content_hash: is not that of its geometry and preset" in refused
    assert f"got '0123456789abcdef'; allowed {right}" in refused


def test_a_map_that_gives_no_thrust_is_told(own_map: Path) -> None:
    tables = json.loads(own_map.read_text())
    tables["coenergy"] = [tables["coenergy"][0]] * len(tables["coenergy"])
    own_map.write_text(json.dumps(tables))
    assert "or there is no thrust" in refusal({"plant.force_map": "mine"})


def test_a_place_without_thrust_one_way_is_no_crash(own_map: Path) -> None:
    tables = json.loads(own_map.read_text())
    tables["coenergy"][10][10] = 0.0
    found = ForceMap(ForceMapDocument.model_validate(tables))

    def thrust(turns: Any, i: Any) -> Any:
        return found.thrust((turns - 0.5) * found.tau, i)

    assert np.isfinite(share_cells(thrust, found.i_max)).all()


def test_a_variant_does_not_depend_on_another_ones_table() -> None:
    alone = run(prepare(load_scenario("circle", SHORT))).variants["A"].samples
    beside = run(prepare(load_scenario("circle", SHORT | {MODEL: "new-design"})))
    assert (beside.variants["A"].samples == alone).all()
    assert (beside.variants["B"].samples != beside.variants["A"].samples).any()


def test_the_right_map_gives_what_the_right_formula_gives() -> None:
    maps = {"plant.force_map": "new-design"}
    maps |= {f"variants.{name}.controller.model.force_map": "new-design" for name in "AB"}

    def errors(changes: dict[str, Any]) -> dict[str, float]:
        prepared = prepare(load_scenario("circle", changes))
        variants = document(prepared, run(prepared))["variants"]
        return {
            f"{name}.{axis}": variant["axes"][axis]["max_abs_following_error"]
            for name, variant in variants.items()
            for axis in "xy"
        }

    matched, formula = errors(maps), errors({})
    mismatched = errors({"plant.force_map": "new-design"})
    assert matched == pytest.approx(formula, rel=0.02)
    assert mismatched["B.x"] > 1.5 * matched["B.x"]


def test_the_linearised_loop_has_the_mean_gain_of_the_maps() -> None:
    frequency = np.array([100.0])

    def plant_at(changes: dict[str, Any]) -> float:
        loop = linearise(load_scenario("circle", changes), "B", "x", v=0.2)
        return float(abs(loop.plant.response(frequency)[0]))

    formula = plant_at({})
    both = plant_at({"plant.force_map": "new-design", MODEL: "new-design"})
    stronger = plant_at(
        {
            "plant.force_map": {"kind": "table", "name": "new-design", "gain": 1.2},
            MODEL: "new-design",
        }
    )
    assert both == pytest.approx(formula, rel=2e-3)
    assert stronger == pytest.approx(1.2 * formula, rel=2e-3)


def test_tables_stay_where_they_are_while_others_are_added() -> None:
    bank = Bank()
    first = bank.place("a", lambda: np.arange(100.0))
    held = bank.values
    second = bank.place("b", lambda: np.full(200_000, 7.0))
    assert bank.place("a", lambda: np.zeros(0)) == first
    assert (held[first : first + 100] == np.arange(100.0)).all()
    assert (bank.values[first : first + 100] == np.arange(100.0)).all()
    assert (bank.values[second : second + 200_000] == 7.0).all()
    with pytest.raises(StoreError, match="no room"):
        Bank(numbers_most=100).place("c", lambda: np.zeros(50))
