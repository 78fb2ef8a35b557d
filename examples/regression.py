"""Fail if an error has grown by more than 5 %: ``python examples/regression.py my.toml``.

With ``--write`` it writes the baseline, my.baseline.json, which belongs under version control.
Exit codes: 0 nothing has grown, 1 something has, 2 it could not be compared.
"""

import argparse
import json
import math
import sys
from pathlib import Path

import motionlab
from motionlab.errors import MotionLabError

GROWTH = 1.05
METRICS = ("max_abs_following_error", "rms_following_error")


def errors(scenario: Path) -> dict[str, float | None]:
    """Run the scenario; return each axis' errors, m, None where a variant has diverged."""
    run = motionlab.run(scenario)
    return {
        f"{variant}.{axis}.{name}": axes[axis].get(name)
        for variant, axes in run.metrics.items()
        for axis in axes
        if axis != "xy"
        for name in METRICS
    }


def write(baseline: Path, found: dict[str, float | None]) -> str:
    """Write a baseline; return what was done."""
    for name, value in found.items():
        if value is None:
            raise ValueError(f"{name} is no number: a variant has diverged; nothing was written")
    baseline.write_text(json.dumps(found, indent=1) + "\n")
    return f"wrote {baseline}, {len(found)} errors: commit it"


def read(baseline: Path) -> dict[str, float]:
    """Return a baseline."""
    if not baseline.is_file():
        raise ValueError(f"{baseline} is not there: --write writes it, once")
    try:
        found = {name: float(value) for name, value in json.loads(baseline.read_text()).items()}
    except (ValueError, TypeError, AttributeError):
        found = {"": math.nan}
    if not all(math.isfinite(value) for value in found.values()):
        raise ValueError(f"{baseline} is no baseline: --write writes it anew")
    return found


def main() -> int:
    """Write a baseline, or compare with it."""
    parser = argparse.ArgumentParser(description="Fail if an error has grown by more than 5 %.")
    parser.add_argument("scenario", type=Path, help="a .toml file")
    parser.add_argument("--write", action="store_true", help="write the baseline")
    options = parser.parse_args()
    baseline = options.scenario.with_suffix(".baseline.json")
    try:
        before = {} if options.write else read(baseline)
        found = errors(options.scenario)
        if options.write:
            print(write(baseline, found))
            return 0
    except (MotionLabError, ValueError, OSError) as error:
        print(f"regression: {error}", file=sys.stderr)
        return 2
    grown = 0
    for name, value in before.items():
        now = found.get(name)
        if now is None or now > GROWTH * value:  # None: it has diverged, or is gone
            grown += 1
            shown = "none" if now is None else f"{now:.3g} m"
            print(f"{name}: {value:.3g} m before, {shown} now", file=sys.stderr)
    if not grown:
        print(f"{len(before)} errors, none has grown by more than 5 %")
    return 1 if grown else 0


if __name__ == "__main__":
    sys.exit(main())
