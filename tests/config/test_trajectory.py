"""What a trajectory table may hold."""

import tomllib

import pytest
from pydantic import TypeAdapter, ValidationError

from motionlab.config.trajectory import TrajectoryConfig

ADAPTER = TypeAdapter(TrajectoryConfig)

ONE_OF_EACH = """
[[motion]]
kind = "point"
[[motion]]
kind = "dwell"
duration = 2
[[motion]]
kind = "step"
height = { x = 5e-6 }
[[motion]]
kind = "ramp"
velocity = { x = 0.02, y = -0.01 }
[[motion]]
kind = "parabola"
coefficient = { y = 0.2 }
[[motion]]
kind = "sine"
amplitude = { x = 0.01 }
frequency = 1
[[motion]]
kind = "circle"
radius = 0.015
frequency = 0.3333333333333333
[[motion]]
kind = "line"
end = { x = 0.05, y = 0.02 }
edge_time = 1.0
[[motion]]
kind = "trapezoid"
end = { y = 0.1 }
[[motion]]
kind = "staircase"
step = { x = 5e-7 }
[[motion]]
kind = "polygon"
vertices = [[0.03, 0], [0, 0.03], [-0.03, 0], [0, -0.03]]
frequency = 0.5
[[motion]]
kind = "star"
circumradius = 0.03
frequency = 0.5
[[motion]]
kind = "waypoints"
points = [[0, 0], [0.01, 0.02], [0.03, -0.01]]
v_max = 0.1
a_max = 1.0
[[motion]]
kind = "samples"
time = [0.0, 0.1, 0.2]
x = [0, 0.001, 0.004]
y = [0, 0, 0]
[[motion]]
kind = "multisine"
axis = "y"
velocity = 0.0432
slides = 6
[[motion]]
kind = "path"
points = [[0, 0], [0.01, 0.02], [0.03, -0.01]]
closed = true
geometry = "spline"
law = "jerk_limited"
v_max = 0.1
a_max = 1
j_max = 20
laps = 2
[[motion]]
kind = "sequence"
parts = [
    { kind = "point" },
    { kind = "step", height = { x = 1e-6 } },
    { kind = "dwell", duration = 0.5 },
]
"""


@pytest.mark.parametrize(
    "table", tomllib.loads(ONE_OF_EACH)["motion"], ids=lambda table: table["kind"]
)
def test_every_kind_reads_from_toml_and_survives_a_round_trip(table):
    config = ADAPTER.validate_python(table)
    assert config.kind == table["kind"]
    assert ADAPTER.validate_python(config.model_dump()) == config
    assert ADAPTER.validate_json(config.model_dump_json()) == config


def test_every_kind_is_covered_above():
    kinds = ADAPTER.json_schema()["discriminator"]["mapping"]
    assert set(kinds) == {table["kind"] for table in tomllib.loads(ONE_OF_EACH)["motion"]}


def test_every_field_states_unit_and_source():
    for name, model in ADAPTER.json_schema()["$defs"].items():
        for field, schema in model["properties"].items():
            if field != "kind":
                assert {"unit", "source", "description"} <= set(schema), f"{name}.{field}"
                assert schema["source"], f"{name}.{field}"


def polygon(**change):
    vertices = [[0.03, 0.0], [0.0, 0.03], [-0.03, 0.0]]
    return {"kind": "polygon", "vertices": vertices, "frequency": 0.5} | change


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (polygon(vertices=[["0.03", 0], [0, 0.03], [0, 0]]), "valid number"),
        (polygon(vertices=[[True, 0], [0, 0.03], [0, 0]]), "valid number"),
        (polygon(vertices=[[float("nan"), 0], [0, 0.03], [0, 0]]), "finite|greater than"),
        (polygon(vertices=[[30.0, 0], [0, 0.03], [0, 0]]), "less than or equal to 1"),
        (polygon(vertices=[[0.03, 0, 0], [0, 0.03], [0, 0]]), "at most 2 items"),
        (polygon(vertices=[[0.03, 0], [0, 0.03]]), "at least 3 items"),
        (polygon(vertices="0.03"), "valid tuple"),
        (polygon(vertices=[[0.03, 0], [0.03, 0], [0, 0]]), "point 0 is repeated"),
        (polygon(vertices=[[0.03, 0], [0, 0.03], [0.03, 0]]), "point 2 is repeated"),
        (polygon(frequency="0.5"), "valid number"),
        (polygon(frequency=0), "greater than or equal to 0.0001"),
        (polygon(frequency=float("inf")), "finite|less than"),
        (polygon(laps=0), "greater than or equal to 1"),
        (polygon(laps=2.5), "valid integer"),
        (polygon(radius=1.0), "Extra inputs"),
        ({"kind": "hexagon"}, "does not match any of the expected tags"),
        ({}, "Unable to extract tag"),
        ({"kind": "circle", "radius": -0.01, "frequency": 1}, "greater than 0"),
        ({"kind": "circle", "radius": 0.01}, "Field required"),
        ({"kind": "circle", "radius": 0.01, "frequency": 1, "direction": "left"}, "'ccw' or 'cw'"),
        ({"kind": "sine", "frequency": 1, "amplitude": {"x": "1"}}, "valid number"),
        ({"kind": "sine", "frequency": 1, "amplitude": {"z": 1.0}}, "Extra inputs"),
        ({"kind": "step", "height": {"x": 1e-6}, "delay": 0}, "greater than 0"),
        ({"kind": "trapezoid", "end": {}}, "start and end must differ"),
        (
            {"kind": "trapezoid", "end": {"x": 0.1}, "there_and_back": False, "cycles": 2},
            "needs there_and_back",
        ),
        ({"kind": "staircase", "step": {}}, "must not be zero"),
        ({"kind": "staircase", "step": {"x": 0.01}, "v_max": 0.1}, "v_max and a_max together"),
        ({"kind": "line", "end": {"x": 0.1}}, "either edge_time, or both"),
        ({"kind": "line", "end": {"x": 0.1}, "v_max": 0.1}, "either edge_time, or both"),
        (
            {"kind": "line", "end": {"x": 0.1}, "v_max": 0.1, "a_max": 1, "edge_time": 1},
            "either edge_time, or both",
        ),
        ({"kind": "line", "end": {}, "edge_time": 1}, "start and end must differ"),
        ({"kind": "waypoints", "points": [[0, 0], [0, 0]], "edge_time": 1}, "point 0 is repeated"),
        (
            {"kind": "star", "circumradius": 0.03, "frequency": 1, "points": 6},
            "one stroke",
        ),
        (
            {"kind": "star", "circumradius": 0.03, "frequency": 1, "density": 3},
            "one stroke",
        ),
        ({"kind": "sequence", "parts": []}, "at least 1 item"),
        (
            {"kind": "sequence", "parts": [{"kind": "sequence", "parts": [{"kind": "dwell"}]}]},
            "does not match any of the expected tags",
        ),
    ],
)
def test_refusals_say_why(table, message):
    with pytest.raises(ValidationError, match=message):
        ADAPTER.validate_python(table)


def test_a_config_cannot_be_changed():
    config = ADAPTER.validate_python(polygon())
    with pytest.raises(ValidationError, match="frozen"):
        setattr(config, "laps", 5)  # noqa: B010 - a type checker would refuse the plain form
