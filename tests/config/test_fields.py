"""Fields as forms show them: every number of every scenario is called and measured."""

from __future__ import annotations

import typing
from collections.abc import Iterator
from typing import Any

import pytest

from motionlab.config.fields import FieldEntry, fields_of
from motionlab.config.load import load_scenario
from motionlab.config.named_configs import names
from motionlab.config.quantity import FACTORS
from motionlab.config.scenario import Scenario
from motionlab.studies.table import BY_KIND

FIELDS = fields_of(Scenario)


def _numbers(table: Any, path: str) -> Iterator[str]:
    match table:
        case dict():
            for key, value in table.items():
                yield from _numbers(value, f"{path}.{'*' if path == 'variants' else key}")
        case list():
            yield path
        case bool() | int() | float():
            yield path


@pytest.mark.parametrize("name", names("scenarios"))
def test_every_number_of_a_shipped_scenario_is_a_field(name: str) -> None:
    tables = load_scenario(name).model_dump(mode="json")
    tables.pop("schedule")  # holds paths, not fields
    found = {path for key, value in tables.items() for path in _numbers(value, key)}
    assert found - FIELDS.keys() == set()


def test_a_gain_is_shown_as_the_paper_prints_it() -> None:
    gain = FIELDS["variants.*.controller.x.k_p"]
    assert (gain.label, gain.unit, gain.factor) == ("k_p x", "N/mm", 1e-3)
    assert gain.bounds == {"minimum": 0.0, "maximum": 1e9}
    assert FIELDS["plant.y.friction.F_s"].label == "stiction F_s"
    assert FIELDS["variants.*.controller.model.y.friction.F_s"].label == "stiction F_s y"


def test_components_are_shown_as_their_pair() -> None:
    assert FIELDS["trajectory.step.x"] == FIELDS["trajectory.step.y"].model_copy(
        update={"label": "step x"}
    )
    assert FIELDS["trajectory.step.x"].unit == "\N{MICRO SIGN}m"
    assert FIELDS["trajectory.start.x"].unit == "mm"


def test_a_unit_on_the_screen_has_the_factor_of_its_unit() -> None:
    for path, field in FIELDS.items():
        assert field.factor == FACTORS.get(field.unit, 1.0), path


def test_choices_are_all_that_the_field_takes() -> None:
    schema = Scenario.model_json_schema()["$defs"]
    for path, table, key in (
        ("compensation.law", "CompensationConfig", "law"),
        ("sharing.law", "SharingConfig", "law"),
    ):
        choices = FIELDS[f"variants.*.controller.{path}"].choices or []
        enum = schema[table]["properties"][key]["enum"]
        assert sorted(each.value for each in choices) == sorted(enum)
        assert all(each.label and each.description for each in choices)
    overlap = FIELDS["variants.*.controller.sharing.overlap"]
    assert overlap.used_with == ["cubic", "sine"]


def test_requests_have_the_defaults_of_their_models() -> None:
    tune = fields_of(BY_KIND["tune"].request_model)
    assert tune["bounds.k_p"].default == [1e4, 3e7]
    assert tune["constraints.Ms"] == FieldEntry(
        label="M_s",
        description="Largest peak of the sensitivity 1/(1 + L)",
        bounds={"exclusive_minimum": 1.0, "maximum": 100.0},
        example=2.0,
    )
    assert fields_of(BY_KIND["identify"].request_model)["presliding.share"].default == 0.5


def test_sliders_symbols_and_switches() -> None:
    controller = "variants.*.controller"
    gain = FIELDS[f"{controller}.x.k_d"]
    assert gain.usual == (1e2, 1e5)
    notch = FIELDS[f"{controller}.y.notch.gain"]
    assert (notch.default, notch.example) == (1.0, 0.1)
    assert FIELDS[f"{controller}.x.notch.damping"].symbol == "zeta"
    observer = FIELDS[f"{controller}.disturbance_observer.enabled"]
    assert (observer.label, observer.symbol) == ("disturbance observer", "DOB")
    for path in ("compensation.enabled", "feedforward", "x.notch", "compensation.law"):
        assert FIELDS[f"{controller}.{path}"].description


def test_every_number_of_the_motor_screen_is_shown_with_its_unit() -> None:
    fields = {kind: fields_of(BY_KIND[kind].request_model) for kind in ("design", "map")}
    stack = fields["design"]["dimensions.l_m"]
    assert (stack.label, stack.symbol, stack.unit) == ("stack length", "l_m", "mm")
    assert fields["map"]["geometry.l_m"].label == stack.label
    for known in fields.values():
        for path, field in known.items():
            assert field.factor == FACTORS.get(field.unit, 1.0), path
            assert field.unit != "m", path


def test_choices_of_a_request_are_all_that_the_field_takes() -> None:
    for kind, path in (
        ("platform", "new.support"),
        ("platform", "axis"),
        ("map", "preset"),
        ("design", "preset"),
    ):
        model: Any = BY_KIND[kind].request_model
        *tables, name = path.split(".")
        for table in tables:
            model = model.model_fields[table].annotation
        choices = fields_of(BY_KIND[kind].request_model)[path].choices or []
        values = typing.get_args(model.model_fields[name].annotation)
        assert [each.value for each in choices] == list(values), path
