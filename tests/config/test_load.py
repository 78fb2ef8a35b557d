"""Loading scenarios: what ships, bases and names, changes by --set."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any

import pytest

from motionlab.config.changes import parse_assignments
from motionlab.config.force_map import ForceMapConfig
from motionlab.config.load import epochs, load_scenario
from motionlab.config.named_configs import config_root, names, read
from motionlab.errors import ConfigError, FieldError
from motionlab.timing import CONTROL_PERIOD, to_ticks

SCENARIOS = [
    "circle",
    "circle-matched",
    "circle-published-k",
    "circle-resonant",
    "circle-reversed-k",
    "fig5",
    "pentagram",
    "rhombus",
    "stair-x-500nm",
    "stair-y-500nm",
    "stair-y-50mm",
    "trapezoid-y",
]
TABLE_1 = {  # k_xp, k_xd, k_yp, k_yd in N/m and N s/m; None: the paper gives none
    "stair-x-500nm": (3.2e6, 1500.0, None, None),
    "stair-y-500nm": (None, None, 6e6, 3000.0),
    "stair-y-50mm": (None, None, 800e3, 1230.0),
    "trapezoid-y": (None, None, 987e3, 1600.0),
    "rhombus": (400e3, 1480.0, 501.6e3, 1570.0),
    "pentagram": (200.3e3, 1530.0, 280.5e3, 1080.0),
    "circle": (200.3e3, 1530.0, 280.5e3, 1080.0),
}
CIRCLE = {"plant": "nominal", "trajectory": "circle", "variants": {"A": {"controller": "pd"}}}


def refused(changes: dict[str, Any]) -> tuple[FieldError, ...]:
    with pytest.raises(ConfigError) as caught:
        load_scenario("circle", changes)
    return caught.value.errors


def test_errors_of_scenario_and_schedule_come_together() -> None:
    events = [
        {"time": 1.0, "set": {"load.x": 1e9}},
        {"time": 2.0, "set": {"trajectory.laps": 3}},
        {"time": 3.0, "set": {"plant.x.mass": -1.0}},
    ]
    found = refused({"load.y": 1e9, "seed": -1, "schedule": events})
    assert [error.loc for error in found] == [
        "seed",
        "load.y",
        "schedule.0.set.load.x",
        "schedule.1.set.trajectory.laps",
        "schedule.2.set.plant.x.mass",
    ]
    found = refused({"schedule": [events[0], events[2]]})
    assert [error.loc for error in found] == [
        "schedule.0.set.load.x",
        "schedule.1.set.plant.x.mass",
    ]


def test_a_value_is_shown_as_json_and_a_switch_is_named() -> None:
    (found,) = refused({"load.x": {"constant": 1.0, "on": [True, None]}})
    assert 'got {"constant": 1.0, "on": [true, null]}; allowed' in str(found)
    (found,) = refused({"variants.B.controller.compensation": False})
    assert str(found).endswith(
        "must be a table: set variants.B.controller.compensation.enabled; got false"
    )


def test_a_table_that_is_given_stays_as_it_was() -> None:
    circle = {"kind": "circle", "radius": 0.01, "frequency": 1.0}
    given = {"trajectory": circle, "trajectory.radius": 0.02}
    assert getattr(load_scenario("circle", given).trajectory, "radius") == 0.02  # noqa: B009
    assert circle["radius"] == 0.01


def test_one_field_under_two_names_is_refused() -> None:
    (found,) = refused({"plant": "matched", "plant.base": "nominal"})
    assert (found.loc, found.message) == ("plant.base", "is set twice, also as plant")


def test_what_ships() -> None:
    assert names("scenarios") == SCENARIOS
    assert names("motors") == ["as-measured", "matched", "matched-resonant", "nominal"]


@pytest.mark.parametrize("name", SCENARIOS)
def test_shipped_scenario_loads(name: str) -> None:
    scenario = load_scenario(name)
    assert scenario.name == name
    assert scenario.title
    assert scenario.description
    assert list(scenario.variants) == ["A", "B"]
    assert all(variant.label for variant in scenario.variants.values())


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_resolved_scenario_loads_to_itself(name: str) -> None:
    scenario = load_scenario(name)
    assert load_scenario(scenario.model_dump(mode="json")) == scenario


@pytest.mark.parametrize("name", names("motors"))
def test_shipped_motor_loads(name: str) -> None:
    plant = load_scenario(CIRCLE | {"plant": name}).plant
    assert plant.name == name
    assert plant.description


@pytest.mark.parametrize("name", names("controllers"))
def test_shipped_controller_loads(name: str) -> None:
    changes = {"variants.A.controller": name}
    controller = load_scenario(CIRCLE, changes).variants["A"].controller
    assert controller.name == name
    assert controller.description
    if name in {"lugre-observer", "published-k", "residual-k", "canudas-de-wit", "reversed-k"}:
        assert controller.compensation.law == name


@pytest.mark.parametrize("name", names("trajectories"))
def test_shipped_trajectory_loads(name: str) -> None:
    trajectory = load_scenario(CIRCLE | {"trajectory": name}).trajectory
    assert trajectory.kind == read("trajectories", name, loc="trajectory")["kind"]


@pytest.mark.parametrize("name", TABLE_1)
def test_gains_of_table_1(name: str) -> None:
    for variant in load_scenario(name).variants.values():
        gains = variant.controller
        found = (gains.x.k_p, gains.x.k_d, gains.y.k_p, gains.y.k_d)
        for value, expected in zip(found, TABLE_1[name], strict=True):
            assert expected is None or value == expected


def test_the_circle_is_the_papers() -> None:
    scenario = load_scenario("circle")
    circle = scenario.trajectory
    assert circle.kind == "circle"
    assert circle.radius == 0.015
    assert circle.frequency == pytest.approx(1 / 3)
    assert (circle.center.x, circle.center.y) == (0.0, 0.0)
    laws = [variant.controller.compensation.law for variant in scenario.variants.values()]
    assert laws == ["off", "lugre-observer"]
    assert scenario.plant.name == "nominal"


def test_plant_and_model_are_two_objects() -> None:
    scenario = load_scenario("circle", {"plant.x.mass": 7.0, "plant.x.friction.F_s": 5.0})
    model = scenario.variants["A"].controller.model
    assert model.x.mass == 5.9
    assert model.x.friction.F_s == 3.5908
    scenario = load_scenario("circle", {"variants.A.controller.model.x.mass": 7.0})
    assert scenario.plant.x.mass == 5.9
    assert scenario.variants["B"].controller.model.x.mass == 5.9


def test_a_base_is_merged_table_by_table(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(
        'base = "circle"\ntrajectory = { base = "circle", laps = 5 }\n'
        "[plant]\nbase = 'matched'\nx.friction.F_s = 4.5\n"
        '[variants.B]\ncontroller = { base = "lugre-full", x.k_p = 300e3 }\n'
    )
    scenario = load_scenario(file)
    assert scenario.name == "mine"
    assert scenario.plant.name == "matched"
    assert scenario.plant.x.friction.F_s == 4.5
    assert scenario.plant.x.friction.F_c == 0.2399  # from nominal, through as-measured and matched
    assert isinstance(scenario.plant.x.force_map, ForceMapConfig)
    assert scenario.plant.x.force_map.F_pk == 38.4
    assert scenario.trajectory.kind == "circle"
    assert scenario.trajectory.laps == 5
    assert scenario.trajectory.radius == 0.015
    B = scenario.variants["B"]
    assert B.label == "lugre-full"
    assert (B.controller.x.k_p, B.controller.x.k_d) == (300e3, 1530.0)
    assert B.controller.feedforward


def test_a_model_may_start_from_a_motor() -> None:
    scenario = load_scenario("circle", {"variants.B.controller.model": "matched"})
    model = scenario.variants["B"].controller.model
    assert model.x.friction == load_scenario("circle-matched").plant.x.friction
    assert isinstance(model.x.force_map, ForceMapConfig)
    assert model.x.force_map.F_pk == 38.4


def test_loading_leaves_its_source_alone() -> None:
    tables: dict[str, Any] = {**CIRCLE, "variants": {"A": {"controller": {"base": "pd"}}}}
    load_scenario(tables, {"variants.A.controller.x.k_p": 1.0, "plant.x.mass": 1.0})
    assert tables["variants"] == {"A": {"controller": {"base": "pd"}}}
    assert tables["plant"] == "nominal"


# -- --set ----------------------------------------------------------------------------------------


def test_assignments_are_toml_or_else_text() -> None:
    assert parse_assignments(
        [
            "seed=7",
            "a=1e-3",
            "b = true",
            "c=[1, 2.5]",
            'd="quoted text"',
            "e=matched",
            "f={ x = 1.0 }",
            "g=a=b",
            "h=-0.5",
            "i=nan",
            "j=",
        ]
    ) == {
        "seed": 7,
        "a": 1e-3,
        "b": True,
        "c": [1, 2.5],
        "d": "quoted text",
        "e": "matched",
        "f": {"x": 1.0},
        "g": "a=b",
        "h": -0.5,
        "i": pytest.approx(math.nan, nan_ok=True),
        "j": "",
    }


@pytest.mark.parametrize("text", ["seed", "=7", "  =7", ""])
def test_assignment_without_key_or_value_is_refused(text: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse_assignments([text])
    assert caught.value.errors[0].loc == "--set"
    assert caught.value.errors[0].value == text


def test_a_key_set_twice_is_refused() -> None:
    with pytest.raises(ConfigError, match="--set: sets seed twice"):
        parse_assignments(["seed=1", "seed = 2"])


def test_errors_name_the_option_that_was_given() -> None:
    for texts in (["x"], ["x=1", "x=2"]):
        with pytest.raises(ConfigError, match=r"^--spec: "):
            parse_assignments(texts, "--spec")


def test_changes_apply_together_whatever_their_order() -> None:
    changes: list[tuple[str, Any]] = [
        ("plant.x.mass", 6.5),
        ("plant", "matched"),
        ("variants.B.controller.x.k_p", 1e5),
        ("variants.B.controller", "pd"),
        ("trajectory.laps", 2),
        ("trajectory", "rhombus"),
    ]
    forward = load_scenario("circle", dict(changes))
    backward = load_scenario("circle", dict(reversed(changes)))
    assert forward == backward
    assert forward.plant.name == "matched"
    assert forward.plant.x.mass == 6.5
    assert forward.variants["B"].controller.name == "pd"
    assert forward.variants["B"].controller.x.k_p == 1e5
    assert forward.trajectory.kind == "polygon"
    assert forward.trajectory.laps == 2


def test_changes_are_judged_together() -> None:
    # each alone would leave F_s below F_c
    scenario = load_scenario("circle", {"plant.x.friction.F_c": 8.0, "plant.x.friction.F_s": 9.0})
    assert scenario.plant.x.friction.F_s == 9.0


def test_changes_reach_into_lists() -> None:
    scenario = load_scenario("fig5", {"schedule.0.time": 100.0})
    assert scenario.schedule[0].time == 100.0
    vertices = [[0.02, 0.0], [0.0, 0.02], [-0.02, 0.0]]
    polygon = {"kind": "polygon", "frequency": 0.3, "vertices": vertices}
    changes = {"trajectory": polygon, "trajectory.vertices.1": [0.0, 0.01]}
    trajectory = load_scenario("circle", changes).trajectory
    assert trajectory.kind == "polygon"
    assert trajectory.vertices == ((0.02, 0.0), (0.0, 0.01), (-0.02, 0.0))


def test_changes_make_tables_where_there_were_none() -> None:
    scenario = load_scenario("circle", {"window.start": 1.0, "window.end": 2.0, "load.x": 1.0})
    assert scenario.window is not None
    assert scenario.window.end == 2.0
    assert scenario.load.x == 1.0


def test_a_variant_can_be_added() -> None:
    scenario = load_scenario("circle", {"variants.C.controller": "residual-k"})
    assert list(scenario.variants) == ["A", "B", "C"]


@pytest.mark.parametrize(
    ("base", "changes", "label"),
    [
        ({}, {}, "LuGre observer"),
        ({}, {"variants.B.controller": "lugre-full"}, "lugre-full"),
        ({}, {"variants.B.controller.base": "pd"}, "pd"),
        ({}, {"variants.B.controller": {"base": "pd", "delay": 1}}, "pd"),
        ({}, {"variants.B.controller": "pd", "variants.B.label": "mine"}, "mine"),
        ({}, {"variants.B.controller.x.k_p": 2e5}, "LuGre observer"),
        ({"controller": "lugre-full"}, {}, "lugre-full"),
        (
            {"controller": {"base": "lugre-full"}},
            {"variants.B.controller.x.k_p": 2e5},
            "lugre-full",
        ),
        ({"controller": {"x": {"k_p": 2e5}}}, {}, "LuGre observer"),
        ({"controller": "lugre-full", "label": "mine"}, {}, "mine"),
    ],
)
def test_a_label_is_that_of_the_controller_that_runs(
    base: dict[str, Any], changes: dict[str, Any], label: str
) -> None:
    scenario = load_scenario({"base": "circle", "variants": {"B": base}}, changes)
    assert scenario.variants["B"].label == label
    assert scenario.variants["A"].label == "no compensation"


def test_a_schedule_gives_phases_in_order_of_time() -> None:
    gain = "variants.A.controller.x.k_p"
    schedule = [{"time": 2.0, "set": {gain: 2e5}}, {"time": 1.0, "set": {gain: 1e5}}]
    found = epochs(load_scenario("circle", {"schedule": schedule}))
    assert [tick for tick, _ in found] == [0, 2000, 4000]
    gains = [scenario.variants["A"].controller.x.k_p for _, scenario in found]
    assert gains == [200300.0, 1e5, 2e5]


def test_seconds_become_ticks_by_rounding() -> None:
    # int(t/T) gives 599 for 0.3 s
    assert [to_ticks(k * 0.1) for k in range(8)] == [200 * k for k in range(8)]
    assert to_ticks(1234567 * CONTROL_PERIOD) == 1234567


def test_a_table_changes_the_part_that_the_base_names(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text('base = "circle"\n[trajectory]\nlaps = 5\n[plant.x]\nmass = 6.0\n')
    scenario = load_scenario(file)
    shipped = load_scenario("circle")
    assert scenario.trajectory == shipped.trajectory.model_copy(update={"laps": 5})
    assert scenario.plant.x == shipped.plant.x.model_copy(update={"mass": 6.0})
    assert scenario.plant.y == shipped.plant.y


def test_a_table_with_a_kind_replaces_the_trajectory() -> None:
    sine = {"kind": "sine", "frequency": 1.0, "amplitude": {"x": 0.01}}
    assert load_scenario("circle", {"trajectory": sine}).trajectory.kind == "sine"
    assert load_scenario({"base": "circle", "trajectory": sine}).trajectory.kind == "sine"


def test_other_configs_can_be_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for kind in ("scenarios", "motors", "controllers", "trajectories"):
        (tmp_path / kind).mkdir()
    tables = load_scenario("circle").model_dump(mode="json", exclude_none=True)
    text = (config_root() / "motors" / "nominal.toml").read_text()
    assert tomllib.loads(text)["x"]["mass"] == tables["plant"]["x"]["mass"]
    (tmp_path / "motors" / "heavy.toml").write_text(text.replace("mass = 5.9", "mass = 8.0"))
    monkeypatch.setenv("MOTIONLAB_CONFIGS", str(tmp_path))
    assert names("motors") == ["heavy"]
    assert load_scenario(tables, {"plant": "heavy"}).plant.x.mass == 8.0
