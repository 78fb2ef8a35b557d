"""Hints and places in errors of scenarios: paths meant, SI values, lines of files."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from motionlab.config.changes import parse_assignments
from motionlab.config.load import load_scenario
from motionlab.config.named_configs import config_root
from motionlab.config.toml_lines import lines_of
from motionlab.config.units import si_amount
from motionlab.errors import ConfigError, FieldError

A, B = "variants.A.controller", "variants.B.controller"


def refusal(source: Any, *assignments: str) -> tuple[FieldError, ...]:
    with pytest.raises(ConfigError) as caught:
        load_scenario(source, parse_assignments(assignments))
    return caught.value.errors


@pytest.mark.parametrize(
    ("assignment", "paths"),
    [
        ("k_p=3e5", [f"{A}.x.k_p", f"{A}.y.k_p", f"{B}.x.k_p", f"{B}.y.k_p"]),
        ("feedforward=true", [f"{A}.feedforward", f"{B}.feedforward"]),
        ("radius=0.1", ["trajectory.radius"]),
        ("controller.x.k_d=3", [f"{A}.x.k_d", f"{B}.x.k_d"]),
        ("variants.B.x.k_p=3", [f"{B}.x.k_p"]),
        ("x.k_p=3", [f"{A}.x.k_p", f"{B}.x.k_p"]),
        ("amplifiers.gain[0]=2", ["plant.x.amplifiers.gain.0", "plant.y.amplifiers.gain.0"]),
        ("plant.x.amplifiers.gain[0]=2", ["plant.x.amplifiers.gain.0"]),
        ("amplifiers.gain[7]=2", []),
        ("nothing=2", []),
    ],
)
def test_an_unknown_key_names_the_paths_meant(assignment: str, paths: list[str]) -> None:
    (error,) = refusal("circle", assignment)
    assert error.message.startswith("unknown key")
    quoted = error.message.split("'")[1::2]
    assert quoted == paths
    for path in quoted:  # which there are
        with pytest.raises(ConfigError, match="must be"):
            load_scenario("circle", {path: [[]]})


def test_a_name_in_place_of_a_variant_names_the_controller() -> None:
    (error,) = refusal("circle", "variants.B=pd")
    assert error.message == "must be a table, did you mean 'variants.B.controller'?"


@pytest.mark.parametrize(
    ("assignment", "message"),
    [
        ("trajectory.radius=15mm", "must be a number, in m: 0.015"),
        ("trajectory.radius=15 µm", "must be a number, in m: 1.5e-05"),
        ("trajectory.radius=1.5 cm", "must be a number, in m: 0.015"),
        (f"{B}.x.k_p=200 N/mm", "must be a number, in N/m: 200000.0"),
        ("plant.x.mass='5.9'", "must be a number, in kg: 5.9"),
        ("plant.x.mass=5900 g", "must be a number, in kg: 5.9"),
        ("thrust_reserve=12%", "must be a number: 0.12"),
        ("trajectory.start_angle=90deg", "must be a number, in rad: 1.57079632679"),
        ("trajectory.radius=15 kg", "must be a number"),
        ("trajectory.radius=1e999 mm", "must be a number"),
        ("trajectory.radius=mm", "must be a number"),
    ],
)
def test_a_value_with_a_unit_is_refused_with_its_si_number(assignment: str, message: str) -> None:
    (error,) = refusal("circle", assignment)
    assert error.message == message


def test_amounts_of_the_same_dimension_alone() -> None:
    assert si_amount("3 kHz", "1/s") == 3000.0
    assert si_amount("2 N s/mm", "N s/m") == 2000.0
    assert si_amount("5", "m") == 5.0
    assert si_amount("5 s", "m") is None


MISTAKES = """\
base = "circl"
titel = "x"
[plant]
base = "matchd"
[plant.x.friction]
F_c = -3

[trajectory]
radius = "15mm"
frequency = -4
[variants.A]
controler = "pd"
[variants.B.controller.x]
k_p = 1e99
[[load.steps]]
time = 1.0
[[load.steps]]
time = -1.0
[[schedule]]
time = 1.0
set = { "variants.B.controller.x.k_p" = -4 }
"""


def test_mistakes_of_a_file_come_together_in_its_order_with_their_lines(tmp_path: Path) -> None:
    path = tmp_path / "my.toml"
    path.write_text(MISTAKES)
    errors = refusal(path)
    assert [(error.loc, error.place) for error in errors] == [
        (loc, f"{path}:{line}")
        for loc, line in [
            ("scenario", 1),
            ("titel", 2),
            ("plant", 4),
            ("plant.x.friction.F_c", 6),
            ("trajectory.radius", 9),
            ("trajectory.frequency", 10),
            ("variants.A.controler", 12),
            ("variants.B.controller.x.k_p", 14),
            ("load.steps.1.time", 18),
            ("schedule.0.set.variants.B.controller.x.k_p", 21),
        ]
    ]
    assert str(errors[1]).startswith(f"{path}:2: titel: unknown key, did you mean 'title'?")


def test_what_a_change_sets_is_not_a_mistake_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "my.toml"
    path.write_text('base = "circle"\nseed = 1\n[load]\nx = 1e9\n')
    assert [(e.loc, e.place) for e in refusal(path, "seed=-1")] == [
        ("load.x", f"{path}:4"),
        ("seed", ""),
    ]


def test_what_a_file_lacks_names_the_table(tmp_path: Path) -> None:
    path = tmp_path / "my.toml"
    path.write_text('plant = "nominal"\n[trajectory]\nkind = "circle"\nradius = 0.01\n')
    places = {error.loc: error.place for error in refusal(path)}
    assert places == {"trajectory.frequency": f"{path}:2", "variants": str(path)}


def paths_of(value: Any, path: str = "") -> set[str]:
    items = value.items() if isinstance(value, dict) else enumerate(value)
    paths = {path} if path else set[str]()
    for key, item in items:
        below = f"{path}.{key}" if path else str(key)
        paths |= paths_of(item, below) if isinstance(item, dict | list) else {below}
    return paths


@pytest.mark.parametrize("path", sorted(config_root().rglob("*.toml")), ids=lambda path: path.stem)
def test_every_field_of_shipped_files_has_a_line(path: Path) -> None:
    text = path.read_text()
    lines = lines_of(text)
    assert set(lines) == paths_of(tomllib.loads(text))
    assert all(1 <= line <= len(text.splitlines()) for line in lines.values())


def test_lines_of_every_form_of_toml() -> None:
    text = """\
# a = 1
"quoted.key" = "x = 1 # ["
text = '''
b = 2
'''
list = [
  1,
  { c = [3, 4] , d.e = 5 },
]
empty = {}
last = { f = "}" }
[[table.array]]
g = 6
[table.array.inner]
h = 7
[[table.array]]
g = 8"""
    lines = lines_of(text)
    assert set(lines) == paths_of(tomllib.loads(text))
    chosen = ["quoted.key", "text", "list.0", "list.1.c.1", "list.1.d.e", "empty", "last.f"]
    assert [lines[path] for path in chosen] == [2, 3, 7, 8, 8, 10, 11]
    assert lines["table.array.0.inner.h"] == 15
    assert lines["table.array.1.g"] == 17


STAGE = 'base = "matched"\n[x]\nmass = 7.0\n'


def test_files_stand_for_parts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parts = tmp_path / "parts"
    parts.mkdir()
    (parts / "stage.toml").write_text(STAGE)
    (parts / "heavy.toml").write_text('base = "stage.toml"\ny.mass = 20.0\n')
    (parts / "slow.toml").write_text('kind = "circle"\nradius = 0.01\nfrequency = 0.5\n')
    (parts / "law.toml").write_text('base = "lugre-observer"\nx.k_p = 1e5\n')
    file = tmp_path / "scenario.toml"
    file.write_text(
        'base = "circle"\nplant = "parts/heavy.toml"\n'
        'trajectory = { base = "parts/slow.toml", radius = 0.02 }\n'
        '[variants.B.controller]\nmodel = "parts/stage.toml"\n'
    )
    scenario = load_scenario(file)
    plant, model = scenario.plant, scenario.variants["B"].controller.model
    assert (plant.name, plant.x.mass, plant.y.mass) == ("heavy", 7.0, 20.0)
    assert (model.x.mass, model.y.mass) == (7.0, 13.9)
    motion = scenario.trajectory.model_dump()
    assert (motion["radius"], motion["frequency"]) == (0.02, 0.5)
    monkeypatch.chdir(parts)
    changes = ["plant=stage.toml", "trajectory=slow.toml", f"{B}=law.toml", f"{A}.model=stage.toml"]
    scenario = load_scenario("circle", parse_assignments(changes))
    assert (scenario.plant.name, scenario.plant.x.mass) == ("stage", 7.0)
    assert scenario.variants["B"].label == scenario.variants["B"].controller.name == "law"
    assert scenario.variants["B"].controller.x.k_p == 1e5
    assert scenario.variants["A"].controller.model.x.mass == 7.0
    (error,) = refusal(file, "load.x=1e9", "plant.x.mass=5.0")
    assert error.loc == "load.x"
    with pytest.raises(ConfigError, match=r"none\.toml: cannot be read: No such file or directory"):
        parse_assignments(["plant=none.toml"])


def test_text_of_a_remote_caller_is_never_a_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "stage.toml").write_text(STAGE)
    monkeypatch.chdir(tmp_path)
    cases: list[tuple[dict[str, Any], dict[str, Any]]] = [
        ({"base": "circle", "plant": "stage.toml"}, {}),
        ({"base": "circle", "plant": {"base": "stage.toml"}}, {}),
        ({"base": "circle"}, {"plant": "stage.toml"}),
    ]
    for tables, changes in cases:
        with pytest.raises(ConfigError, match="no motor of that name"):
            load_scenario(tables, changes)


def test_trajectories_of_ones_own_have_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    (tmp_path / "trajectories").mkdir()
    for name in ("mine", "circle"):
        path = tmp_path / "trajectories" / f"{name}.toml"
        path.write_text('kind = "circle"\nradius = 0.012\nfrequency = 0.5\n')
    assert load_scenario("pentagram", {"trajectory": "mine"}).trajectory.model_dump()["radius"] == (
        0.012
    )
    assert load_scenario("circle").trajectory.model_dump()["radius"] == 0.015
    (error,) = refusal("circle", "trajectory=mines")
    assert error.message == "no trajectory of that name, did you mean 'mine'?"
