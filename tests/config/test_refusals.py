"""What a scenario refuses, and that each complaint names field, value, range and unit."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from motionlab.config.load import load_scenario
from motionlab.config.named_configs import names
from motionlab.errors import ConfigError, FieldError

GAIN = "variants.B.controller.x.k_p"
EVENT = {"time": 1.0, "set": {GAIN: 1e5}}


def waypoints(points: list[Any]) -> dict[str, Any]:
    return {"trajectory": {"kind": "waypoints", "edge_time": 1.0, "points": points}}


def sequence(*parts: dict[str, Any]) -> dict[str, Any]:
    return {"trajectory": {"kind": "sequence", "parts": [{"kind": "dwell"}, *parts]}}


def schedule(change: str, value: Any) -> dict[str, Any]:
    return {"schedule": [EVENT, {"time": 2.0, "set": {change: value}}]}


def complaints(changes: dict[str, Any], source: Any = "circle") -> tuple[FieldError, ...]:
    with pytest.raises(ConfigError) as caught:
        load_scenario(source, changes)
    return caught.value.errors


# changes, field, words of the message, value, range, unit
NUMBERS: list[tuple[dict[str, Any], str, str, Any, str, str]] = [
    ({"plant.x.mass": -1.0}, "plant.x.mass", "range", -1.0, ">= 0.001 and <= 1000", "kg"),
    ({"plant.x.mass": 0}, "plant.x.mass", "range", 0, ">= 0.001 and <= 1000", "kg"),
    ({"plant.x.mass": 1001.0}, "plant.x.mass", "range", 1001.0, ">= 0.001 and <= 1000", "kg"),
    ({"plant.x.mass": math.inf}, "plant.x.mass", "finite", math.inf, ">= 0.001 and <= 1000", "kg"),
    ({"plant.x.mass": "5.9"}, "plant.x.mass", "number", "5.9", ">= 0.001 and <= 1000", "kg"),
    ({"plant.x.mass": True}, "plant.x.mass", "number", True, ">= 0.001 and <= 1000", "kg"),
    ({GAIN: "stiff"}, GAIN, "must be a number", "stiff", ">= 0 and <= 1000000000", "N/m"),
    ({GAIN: -1.0}, GAIN, "range", -1.0, ">= 0 and <= 1000000000", "N/m"),
    ({"seed": 1.5}, "seed", "whole", 1.5, ">= 0 and <= 9007199254740991", "1"),
    ({"seed": -1}, "seed", "range", -1, ">= 0 and <= 9007199254740991", "1"),
    ({"trajectory.radius": "5"}, "trajectory.radius", "number", "5", "> 0 and <= 1", "m"),
    (
        sequence({"kind": "circle", "radius": -1.0, "frequency": 1.0}),
        "trajectory.parts.1.radius",
        "range",
        -1.0,
        "> 0 and <= 1",
        "m",
    ),
    (
        waypoints([[0.0, 0.0], [0.1, 0.0], [0.0, 85.0]]),
        "trajectory.points.2.1",
        "range",
        85.0,
        ">= -1 and <= 1",
        "m",
    ),
    (
        waypoints([[0.0, 0.0], ["a", 0.0], [0.1, 0.0]]),
        "trajectory.points.1.0",
        "number",
        "a",
        ">= -1 and <= 1",
        "m",
    ),
    (
        {"plant.x.amplifiers.gain": [1.0, 1.0, 3.0]},
        "plant.x.amplifiers.gain.2",
        "range",
        3.0,
        ">= 0 and <= 2",
        "1",
    ),
    (
        {"plant.y.amplifiers.offset": [0.0, -11.0, 0.0]},
        "plant.y.amplifiers.offset.1",
        "range",
        -11.0,
        ">= -10 and <= 10",
        "A",
    ),
    (
        {"load.steps": [{"time": 1.0}, {"time": 2.0, "x": 200.0}]},
        "load.steps.1.x",
        "range",
        200.0,
        ">= -100 and <= 100",
        "N",
    ),
    (
        {"schedule": [{"time": 0.0, "set": {GAIN: 1.0}}]},
        "schedule.0.time",
        "range",
        0.0,
        "> 0",
        "s",
    ),
    (schedule(GAIN, -1.0), f"schedule.1.set.{GAIN}", "range", -1.0, ">= 0", "N/m"),
]


@pytest.mark.parametrize(
    ("changes", "loc", "words", "value", "allowed", "unit"), NUMBERS, ids=lambda v: str(v)[:40]
)
def test_a_number_is_refused_with_range_and_unit(
    changes: dict[str, Any], loc: str, words: str, value: Any, allowed: str, unit: str
) -> None:
    (error,) = complaints(changes)
    assert error.loc == loc
    assert words in error.message
    assert error.value == value
    assert type(error.value) is type(value)
    assert error.range.startswith(allowed)
    assert error.unit == unit
    text = str(error)
    assert all(part in text for part in (loc, "true" if value is True else repr(value), allowed))
    assert unit == "1" or text.endswith(f" {unit}")  # a pure number needs no unit


@pytest.mark.parametrize("field", ["plant.x.mass", GAIN, "trajectory.radius", "settling_band"])
def test_nan_is_refused(field: str) -> None:
    (error,) = complaints({field: math.nan})
    assert error.loc == field
    assert math.isnan(error.value)  # pyright: ignore[reportArgumentType]
    assert "finite" in error.message
    assert error.range
    assert error.unit


# changes, field, words of the message, value, what the range names
WORDS: list[tuple[dict[str, Any], str, str, Any, str]] = [
    ({"plant.x.mas": 1.0}, "plant.x.mas", "did you mean 'mass'?", 1.0, "mass, stroke"),
    (
        {"variants.B.controler": "pd"},
        "variants.B.controler",
        "did you mean 'controller'?",
        "pd",
        "label, controller",
    ),
    ({"trajectory.raduis": 0.01}, "trajectory.raduis", "did you mean 'radius'?", 0.01, "radius"),
    ({"sead": 1}, "sead", "did you mean 'seed'?", 1, "seed"),
    ({"colour": "red"}, "colour", "unknown key", "red", "one of name, title"),
    (
        sequence({"kind": "dwell", "duraton": 1.0}),
        "trajectory.parts.1.duraton",
        "did you mean 'duration'?",
        1.0,
        "one of kind, duration",
    ),
    (schedule("plant.x.mas", 1.0), "schedule.1.set.plant.x.mas", "'mass'?", 1.0, "mass"),
    ({"plant": "nomnal"}, "plant", "did you mean 'nominal'?", "nomnal", "as-measured, matched"),
    (
        {"variants.B.controller": "lugre"},
        "variants.B.controller",
        "no shipped controller",
        "lugre",
        "lugre-observer",
    ),
    (
        {"variants.B.controller.model": "matchd"},
        "variants.B.controller.model",
        "did you mean 'matched'?",
        "matchd",
        "nominal",
    ),
    ({"trajectory": "rhomb"}, "trajectory", "did you mean 'rhombus'?", "rhomb", "pentagram"),
    (schedule("plant", "nomnal"), "schedule.1.set.plant", "'nominal'?", "nomnal", "matched"),
    ({"trajectory": {"kind": "circel"}}, "trajectory.kind", "'circle'?", "circel", "circle"),
    ({"trajectory.direction": "up"}, "trajectory.direction", "choices", "up", "ccw, cw"),
    (
        {"variants.A.controller.compensation.law": "K"},
        "variants.A.controller.compensation.law",
        "choices",
        "K",
        "lugre-observer",
    ),
    ({"plant": 5}, "plant", "must be a table", 5, ""),
    ({"variants.B": "pd"}, "variants.B", "must be a table", "pd", ""),
    ({"plant.x.mass.a": 1.0}, "plant.x.mass.a", "single value", 1.0, ""),
    (
        {"plant.x.friction.enabled": 1},
        "plant.x.friction.enabled",
        "must be true or false",
        1,
        "",
    ),
]


@pytest.mark.parametrize(
    ("changes", "loc", "words", "value", "allowed"), WORDS, ids=lambda v: str(v)[:40]
)
def test_a_name_is_refused_with_the_choices(
    changes: dict[str, Any], loc: str, words: str, value: Any, allowed: str
) -> None:
    (error,) = complaints(changes)
    assert error.loc == loc
    assert words in error.message
    assert error.value == value
    assert allowed in error.range


def test_several_complaints_come_at_once() -> None:
    errors = complaints({"plant.x.mass": -1.0, GAIN: "big", "seed": 0.5})
    assert {error.loc for error in errors} == {"plant.x.mass", GAIN, "seed"}


def test_stiction_below_coulomb_friction() -> None:
    (error,) = complaints({"plant.x.friction.F_s": 0.1})
    assert error.loc == "plant.x.friction"
    assert error.message == "F_s = 0.1 N is below F_c = 0.2399 N"


def test_missing_fields_are_named() -> None:
    (error,) = complaints({"trajectory": {"kind": "circle", "radius": 0.01}})
    assert (error.loc, error.message, error.unit) == ("trajectory.frequency", "is missing", "Hz")
    errors = complaints({}, source={})
    assert {error.loc for error in errors} == {"plant", "variants", "trajectory"}


@pytest.mark.parametrize(
    ("name", "hint"),
    [("circl", "did you mean 'circle'?"), ("pentagon", "'pentagram'?"), ("zzz", "")],
)
def test_an_unknown_scenario_is_refused(name: str, hint: str) -> None:
    (error,) = complaints({}, source=name)
    assert (error.loc, error.value) == ("scenario", name)
    assert hint in error.message
    assert all(known in error.range for known in names("scenarios"))


@pytest.mark.parametrize(
    "name", ["../motors/nominal", "/etc/passwd", "..", "", "Nominal", "a" * 65]
)
@pytest.mark.parametrize("part", ["plant", "trajectory", "variants.A.controller", "scenario"])
def test_a_name_is_never_a_path(part: str, name: str) -> None:
    if part == "scenario":
        (error,) = complaints({}, source=name)
    else:
        (error,) = complaints({part: name})
        (inside,) = complaints({part: {"base": name}})
        assert inside.loc == part
    assert error.loc == part
    kinds = {"plant": "no motor", "trajectory": "no trajectory"}
    assert kinds.get(part, "no shipped") in error.message
    assert error.range.startswith("one of ")


@pytest.mark.parametrize(
    ("content", "words"),
    [(b"radius 5", "is not TOML"), (b"\xff\xfe", "is not UTF-8 text"), (None, "cannot be read")],
)
def test_a_file_that_cannot_be_used(tmp_path: Path, content: bytes | None, words: str) -> None:
    file = tmp_path / "mine.toml"
    if content is not None:
        file.write_bytes(content)
    (error,) = complaints({}, source=file)
    assert error.loc == str(file)
    assert words in error.message


@pytest.mark.parametrize(
    "path", ["trajectory.radius", "seed", "window.start", "schedule.0.time", "divergence_error"]
)
def test_what_cannot_change_during_a_run(path: str) -> None:
    (error,) = complaints(schedule(path, 1.0))
    assert error.loc == f"schedule.1.set.{path}"
    assert error.message == "cannot change during a run"
    assert "plant" in error.range


def test_no_variant_is_added_during_a_run() -> None:
    (error,) = complaints(schedule("variants.C.controller", "pd"))
    assert error.loc == "schedule.1.set"
    assert "variant" in error.message


@pytest.mark.parametrize("times", [(1.0, 1.0), (1.0, 1.0001), (1.0001, 1.0)])
def test_two_events_cannot_share_a_tick(times: tuple[float, float]) -> None:
    (error,) = complaints({"schedule": [EVENT | {"time": time} for time in times]})
    later = 0 if times[0] > times[1] else 1
    assert error.loc == f"schedule.{later}.time"
    assert "control period of its own" in error.message
    assert error.value == max(times)
    assert error.range == ">= 1.0005"
    assert error.unit == "s"


def test_an_event_cannot_come_before_the_first_period() -> None:
    (error,) = complaints({"schedule": [EVENT | {"time": 1e-4}]})
    assert (error.loc, error.value, error.unit) == ("schedule.0.time", 1e-4, "s")
