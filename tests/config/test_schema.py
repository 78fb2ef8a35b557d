"""The JSON schema of scenarios: units, ranges and sources everywhere, and up to date."""

from __future__ import annotations

import copy
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from motionlab.config.load import load_scenario
from motionlab.config.named_configs import config_root, names
from motionlab.config.scenario import Scenario
from motionlab.config.schema import FILES, file_schema, scenario_schema, schema_text
from motionlab.errors import ConfigError

SCHEMA: dict[str, Any] = scenario_schema()
SOURCE: dict[str, Any] = file_schema("scenario")
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


@pytest.mark.parametrize("kind", FILES)
def test_the_schema_that_ships_is_current(kind: str) -> None:
    shipped = (config_root() / f"{kind}.schema.json").read_text(encoding="utf-8")
    assert shipped == schema_text(kind), "run `make schema`"


@pytest.mark.parametrize("schema", [SCHEMA, *map(file_schema, FILES)])
def test_the_schema_is_one(schema: dict[str, Any]) -> None:
    jsonschema.Draft202012Validator.check_schema(schema)
    assert schema["$schema"] == jsonschema.Draft202012Validator.META_SCHEMA["$id"]


SHIPPED = sorted(config_root().glob("*/*.toml"))


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_a_file_that_ships_fits_the_schema_that_it_names(path: Path) -> None:
    first, *_ = path.read_text(encoding="utf-8").splitlines()
    named = path.parent / first.removeprefix("#:schema ")
    validator = jsonschema.Draft202012Validator(json.loads(named.read_text(encoding="utf-8")))
    tables = tomllib.loads(path.read_text(encoding="utf-8"))
    validator.validate(tables)
    assert not validator.is_valid(tables | {"unknown": 1.0})


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        ("motor", "x.mass = -1.0"),
        ("motor", 'base = "nominal"\nx.friction.F_z = 1.0'),
        ("controller", "x.kp = 1.0"),
        ("controller", 'base = "no such name"'),
        ("trajectory", 'kind = "circle"\nraduis = 0.01'),
        ("trajectory", "radius = 0.01"),
        ("drive", 'title = "None but a title"'),
    ],
)
def test_a_mistake_in_the_file_of_a_part_does_not_fit(kind: str, text: str) -> None:
    assert not jsonschema.Draft202012Validator(file_schema(kind)).is_valid(tomllib.loads(text))


@pytest.mark.parametrize(
    "text",
    [
        'base = "circle"',
        'base = "circle"\nplant.x.mass = 6.0\ntrajectory.laps = 5',
        'base = "circle"\nplant = { base = "matched", force_map = "new-design" }',
        'base = "circle"\nvariants.B.controller.model = "matched"',
        'base = "circle"\nplant.x.force_map = "new-design"',
        'base = "circle"\ntrajectory = { kind = "circle", radius = 0.01, frequency = 0.3 }',
        'base = "circle"\n[[schedule]]\ntime = 1.0\nset = { "plant.x.mass" = 6.0 }',
    ],
)
def test_what_builds_on_a_shipped_scenario_fits_the_schema(text: str) -> None:
    tables = tomllib.loads(text)
    load_scenario(copy.deepcopy(tables))
    jsonschema.Draft202012Validator(SOURCE).validate(tables)


@pytest.mark.parametrize(
    "text",
    [
        'base = "circel"',
        'titel = "no base"',
        'plant = "nominal"\ntrajectory = "circle"',
        'base = "circle"\nsead = 1',
        'base = "circle"\nplant = "Matched"',
        'base = "circle"\nplant.x.mas = 6.0',
        'base = "circle"\nplant.x.mass = -6.0',
        'base = "circle"\nplant.x.friction.F_z = 1.0',
        'base = "circle"\ntrajectory.lap = 5',
        'base = "circle"\ntrajectory = { base = "circle", lap = 5 }',
        'base = "circle"\ntrajectory = { kind = "circle", raduis = 0.01 }',
        'base = "circle"\nvariants.B.controler = "pd"',
        'base = "circle"\nvariants.B.controller.x.kp = 1.0',
        'base = "circle"\nvariants.B.controller = { base = "pd", x = { kp = 1.0 } }',
        'base = "circle"\nvariants.bee.controller = "pd"',
        'base = "circle"\nload.nose = 1.0',
    ],
)
def test_a_mistake_in_a_file_is_refused(text: str) -> None:
    tables = tomllib.loads(text)
    with pytest.raises(ConfigError):
        load_scenario(copy.deepcopy(tables))
    assert not jsonschema.Draft202012Validator(SOURCE).is_valid(tables)


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
