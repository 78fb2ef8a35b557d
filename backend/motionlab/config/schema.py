"""Write the JSON schema of scenarios: ``python -m motionlab.config.schema``."""

from __future__ import annotations

import json
import sys
from typing import Any

from motionlab.config.scenario import Scenario
from motionlab.config.shipped import config_root


def scenario_schema() -> dict[str, Any]:
    """Return the JSON schema of a resolved scenario, with unit and source of every number."""
    return Scenario.model_json_schema() | {
        "$schema": "https://json-schema.org/draft/2020-12/schema"
    }


def schema_text() -> str:
    """Return that schema as the text of its file."""
    return json.dumps(scenario_schema(), indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    path = config_root() / "scenario.schema.json"
    path.write_text(schema_text(), encoding="utf-8")
    print(f"wrote {path.name}", file=sys.stderr)
