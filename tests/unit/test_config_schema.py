"""The JSON schema of scenarios: units, ranges and sources everywhere, and up to date."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import jsonschema
import pytest

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.config.schema import schema_text
from motionlab.config.shipped import config_root, names

SCHEMA: dict[str, Any] = json.loads(schema_text())
LOWER, UPPER = {"minimum", "exclusiveMinimum"}, {"maximum", "exclusiveMaximum"}


def kinds(schema: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield a field's schema and those of the items and choices it is made of."""
    yield schema
    for choice in schema.get("anyOf", []):
        yield from kinds(choice)
    for item in schema.get("prefixItems", []):
        yield from kinds(item)
    if isinstance(schema.get("items"), dict):
        yield from kinds(schema["items"])


def fields() -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield model, name and schema of every field of every model."""
    for model, definition in {"Scenario": SCHEMA, **SCHEMA["$defs"]}.items():
        for name, schema in definition["properties"].items():
            yield model, name, schema


def numbers() -> list[tuple[str, str, dict[str, Any], dict[str, Any]]]:
    """Return every field that holds numbers, with the schema of the number."""
    return [
        (model, name, schema, kind)
        for model, name, schema in fields()
        for kind in kinds(schema)
        if kind.get("type") in {"number", "integer"}
    ]


def test_every_number_has_unit_and_source() -> None:
    found = numbers()
    assert len(found) > 100
    bare = [f"{m}.{n}" for m, n, schema, _ in found if not schema.get("unit")]
    assert bare == []
    unsourced = [f"{m}.{n}" for m, n, schema, _ in found if not schema.get("source")]
    assert unsourced == []


def test_every_number_has_a_range() -> None:
    open_ended = {
        (model, name)
        for model, name, _, number in numbers()
        if not (LOWER & number.keys() and UPPER & number.keys())
    }
    assert open_ended == set()


def test_every_field_is_described() -> None:
    silent = [
        f"{model}.{name}"
        for model, name, schema in fields()
        if not schema.get("description") and "const" not in schema and "$ref" not in schema
    ]
    # tables say what they are in the docstring of their model
    assert [field for field in silent if field != "Scenario.trajectory"] == []
    assert all(definition.get("description") for definition in SCHEMA["$defs"].values())


def test_every_model_refuses_unknown_keys() -> None:
    for definition in (SCHEMA, *SCHEMA["$defs"].values()):
        assert definition["additionalProperties"] is False


def test_the_schema_that_ships_is_current() -> None:
    shipped = (config_root() / "scenario.schema.json").read_text(encoding="utf-8")
    assert shipped == schema_text(), "run `make schema`"


def test_the_schema_is_one() -> None:
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    assert SCHEMA["$schema"] == jsonschema.Draft202012Validator.META_SCHEMA["$id"]


@pytest.mark.parametrize("name", names("scenarios"))
def test_shipped_scenarios_fit_the_schema(name: str) -> None:
    validator = jsonschema.Draft202012Validator(SCHEMA)
    tables = load_scenario(name).model_dump(mode="json")
    validator.validate(tables)
    tables["plant"]["x"]["mass"] = -1.0
    with pytest.raises(jsonschema.ValidationError, match=r"-1\.0"):
        validator.validate(tables)


def test_models_are_frozen() -> None:
    scenario = load_scenario("circle")
    with pytest.raises(ValueError, match="frozen"):
        scenario.seed = 1  # pyright: ignore[reportAttributeAccessIssue]
    assert isinstance(scenario, Scenario)
