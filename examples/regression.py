"""Fail if an error has grown by more than 5 %: ``python examples/regression.py my.toml``.

The first call writes my.baseline.json, which belongs under version control.
"""

import json
import sys
from pathlib import Path

import motionlab

GROWTH = 1.05
METRICS = ("max_abs_following_error", "rms_following_error")


def main(scenario: Path) -> str | None:
    """Return what has grown, or None."""
    baseline = scenario.with_suffix(".baseline.json")
    run = motionlab.run(scenario)
    found = {
        f"{variant}.{axis}.{name}": axes[axis].get(name)
        for variant, axes in run.metrics.items()
        for axis in axes
        if axis != "xy"
        for name in METRICS
    }
    if not baseline.is_file():
        baseline.write_text(json.dumps(found, indent=1) + "\n")
        return None
    grown = []
    for name, before in json.loads(baseline.read_text()).items():
        now = found.get(name)
        if now is None or now > GROWTH * before:  # None: it has diverged, or is gone
            grown.append(f"{name}: {before:.3g} m before, {now} m now")
    return "\n".join(grown) or None


sys.exit(main(Path(sys.argv[1])))
