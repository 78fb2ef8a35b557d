"""Write golden.json anew: ``python -m tests.golden.regenerate``.

Golden runs pin what every shipped scenario gives, on both sides: an unexplained improvement fails
as a worsening does. Regenerate only when a change of the model, of a shipped config or of a
metric's definition is *meant* to move a figure; look at the difference, and say in the commit which
figures moved, by how much and why. Never to make a failing test pass: a change that should not have
moved a figure is a bug.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from motionlab.config.load import load_scenario
from motionlab.config.named_configs import names
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run

FILE = Path(__file__).with_name("golden.json")
METRICS = ("max_abs_following_error", "rms_following_error")


def measure(name: str) -> list[dict[str, Any]]:
    """Return the main metrics of a shipped scenario: segment, variant, axis, metric."""
    prepared = prepare(load_scenario(name))
    result = document(prepared, run(prepared))
    return [
        {
            variant: {
                axis: {metric: metrics[metric] for metric in METRICS}
                for axis, metrics in entry["axes"].items()
            }
            for variant, entry in segment["variants"].items()
        }
        for segment in result["segments"]
    ]


def main() -> None:
    """Write the file."""
    golden = {name: measure(name) for name in names("scenarios")}
    FILE.write_text(json.dumps(golden, indent=2) + "\n", encoding="utf-8")
    print(f"wrote {FILE.name}", file=sys.stderr)


if __name__ == "__main__":
    main()
