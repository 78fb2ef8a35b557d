"""Write the JSON schema of scenarios: ``python -m motionlab.config.schema``."""

from __future__ import annotations

import json
import sys

from motionlab.config.scenario import Scenario
from motionlab.config.shipped import config_root


def schema_text() -> str:
    """Return the JSON schema of a resolved scenario, with unit and source of every number."""
    schema = Scenario.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    path = config_root() / "scenario.schema.json"
    path.write_text(schema_text(), encoding="utf-8")
    print(f"wrote {path.name}", file=sys.stderr)
