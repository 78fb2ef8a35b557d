"""Every number of a scenario at the ends of its range: a result, or a complaint, never a crash."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

from motionlab.config.load import load_scenario
from motionlab.config.schema import scenario_schema
from motionlab.errors import ConfigError, Infeasible
from motionlab.reports.result_text import report
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run

SCHEMA: dict[str, Any] = scenario_schema()
MOTION = {
    "kind": "sequence",
    "parts": [
        {"kind": "step", "height": {"x": 1e-6, "y": 2e-6}, "delay": 0.01, "dwell": 0.1},
        {"kind": "line", "end": {"x": 0.002, "y": 0.003}, "edge_time": 0.1, "dwell": 0.05},
    ],
}


def leaves(definition: dict[str, Any], path: str) -> list[tuple[str, dict[str, Any]]]:
    """Return every field below a model with its dotted path."""
    found = []
    for name, schema in definition["properties"].items():
        below = schema.get("$ref") or next((c.get("$ref") for c in schema.get("allOf", [])), None)
        if below is not None:
            found += leaves(SCHEMA["$defs"][below.rsplit("/", 1)[1]], f"{path}.{name}")
        else:
            found.append((f"{path}.{name}", schema))
    return found


def ends(schema: dict[str, Any]) -> list[Any]:
    """Return the values at the ends of a field's range, just inside where they are excluded."""
    kinds = [schema, *schema.get("anyOf", [])]
    number = next((kind for kind in kinds if kind.get("type") in {"number", "integer"}), None)
    if number is None:
        return []
    low, high = number.get("minimum"), number["maximum"]
    if low is None:
        low = number["exclusiveMinimum"]
        low = math.nextafter(low, math.inf) if low > 0.0 else 1e-300
    kind = int if number["type"] == "integer" else float
    return [kind(low), kind(high)]


CASES = [
    (path, value)
    for start, model in {
        "plant": "PlantConfig",
        "variants.B.controller": "ControllerConfig",
        "load": "LoadConfig",
    }.items()
    for path, schema in leaves(SCHEMA["$defs"][model], start)
    for value in ends(schema)
] + [
    (name, value)
    for name in ("seed", "settling_band", "divergence_error")
    for value in ends(SCHEMA["properties"][name])
]


def test_the_cases_reach_everywhere() -> None:
    paths = {path for path, _ in CASES}
    assert len(paths) > 90
    assert {"plant.x.mass", "variants.B.controller.model.y.friction.v_s", "load.noise"} <= paths


@pytest.mark.parametrize(("path", "value"), CASES, ids=str)
def test_a_number_at_the_end_of_its_range(path: str, value: Any) -> None:
    try:
        prepared = prepare(load_scenario("circle", {"trajectory": MOTION, path: value}))
    except (ConfigError, Infeasible) as error:
        assert str(error)
        return
    recording = run(prepared)
    result = document(prepared, recording)
    json.dumps(result, allow_nan=False)
    assert report(result)
    if not path.startswith(("plant", "load", "divergence")):  # what concerns B leaves A alone
        assert recording.variants["A"].diverged is None
