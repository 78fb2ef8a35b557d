"""Lane parameters that translated functions make, against those of the functions themselves."""

from __future__ import annotations

import json
import random
import subprocess
from pathlib import Path
from typing import Any

import pytest

from motionlab.config.changes import apply_changes
from motionlab.config.fields import FieldEntry, fields_of
from motionlab.config.load import load_scenario, validate
from motionlab.config.named_configs import names
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError
from motionlab.kernel.build import lane
from motionlab.kernel.layout import PARAMETERS, column
from motionlab.lanes import model_hash
from motionlab.lanes.bank import TABLES
from motionlab.targets.lane_code import lane_code
from tests.paths import ROOT

NODE = subprocess.run(
    [ROOT / "frontend" / "npm", "--version"], capture_output=True, text=True, check=False
)
DRAWS = 40
"""Scenarios with drawn values, of each that ships."""
TOGETHER = 6
"""Values that are drawn for one of them."""
ROUNDING = 1e-12
"""Relative: two libraries of elementary functions."""
RUN = """
import {{ readFileSync }} from 'node:fs';
import {{ rows, refusal, MODEL, PARAMETERS }} from '{code}';
const finite = (value) => (value === Infinity ? 'inf' : value === undefined ? null : value);
const cases = JSON.parse(readFileSync('{cases}'));
const made = cases.map((scenario) => Object.keys(scenario.variants).map((variant) =>
  ['x', 'y'].map((axis) => rows(scenario, variant, axis).map(finite))));
const refused = cases.map((scenario) => Object.values(scenario.variants).map(({{ controller }}) =>
  ['x', 'y'].map((axis) => refusal(controller.compensation, controller.model[axis]))));
console.log(JSON.stringify({{ made, refused, MODEL, PARAMETERS }}));
"""


def drawn(random: random.Random, entry: FieldEntry, value: Any) -> Any:
    """Return another value of a field: a choice, the other state of a switch, or a number."""
    if entry.choices:
        return random.choice(entry.choices).value
    if isinstance(value, bool):
        return not value
    bounds = entry.bounds or {}
    low = bounds.get("minimum", bounds.get("exclusive_minimum", 0.0))
    high = bounds.get("maximum", bounds.get("exclusive_maximum", 1.0))
    usual = entry.usual or (low, high)
    return int(usual[1]) if entry.whole else random.uniform(*usual)


def cases() -> list[Scenario]:
    """Return shipped scenarios with drawn values of plant and controllers."""
    draw, entries = random.Random(40), fields_of(Scenario)  # draws every law
    scenarios = []
    for name in names("scenarios"):
        shipped = load_scenario(name)
        scenarios.append(shipped)
        document = shipped.model_dump(mode="json")
        paths = [
            path.replace("*", letter)
            for path in entries
            for letter in shipped.variants
            if path.startswith(("plant.x.", "plant.y.", "variants.*.controller."))
            and "force_map" not in path
        ]
        while len(scenarios) % (DRAWS + 1):
            changes = {}
            for path in draw.sample(paths, TOGETHER):
                value: Any = document
                for key in path.split("."):
                    value = value.get(key) if isinstance(value, dict) else {}
                entry = entries[path.replace(".A.", ".*.").replace(".B.", ".*.")]
                if not isinstance(value, (dict, list, str)) or entry.choices:
                    changes[path] = drawn(draw, entry, value)
            try:
                scenarios.append(validate(apply_changes(document, changes)))
            except ConfigError:
                continue
    return scenarios


@pytest.mark.skipif(NODE.returncode != 0, reason="node cannot be had")
def test_the_page_makes_the_lanes_that_the_kernel_runs(tmp_path: Path) -> None:
    scenarios = cases()
    (tmp_path / "lanes.mjs").write_text(lane_code(), encoding="utf-8")
    documents = [each.model_dump(mode="json") for each in scenarios]
    (tmp_path / "cases.json").write_text(json.dumps(documents), encoding="utf-8")
    script = RUN.format(code=tmp_path / "lanes.mjs", cases=tmp_path / "cases.json")
    (tmp_path / "run.mjs").write_text(script, encoding="utf-8")
    command = [ROOT / "frontend" / "npm", "exec", "--", "node", tmp_path / "run.mjs"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout.splitlines()[-1])
    assert answer["PARAMETERS"] == list(PARAMETERS)
    assert answer["MODEL"] == model_hash()
    laws = set()
    for scenario, variants in zip(scenarios, answer["made"], strict=True):
        for variant, axes in zip(scenario.variants.values(), variants, strict=True):
            laws.add(variant.controller.compensation.law)
            for axis, rows in zip("xy", axes, strict=True):
                with TABLES.lease():
                    expected = column(lane(scenario, variant.controller, axis))
                assert len(rows) == len(expected)
                for path, value, kernel in zip(PARAMETERS, rows, expected, strict=True):
                    if value is not None:
                        close = pytest.approx(kernel, rel=ROUNDING, abs=1e-300)
                        assert float(value) == close, (scenario.name, path)
    assert len(laws) == 9
    assert not any(any(axes) for variants in answer["refused"] for axes in variants)
