"""The command ``motionlab glitches``."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from motionlab.cli.exit_codes import DONE
from motionlab.studies.options import add_json

if TYPE_CHECKING:
    from motionlab.runs.glitches import AxisGlitches, GlitchMean, GlitchRow, RunGlitches

EXAMPLES = """\
examples:
  motionlab glitches r-gpd6hecc7x3n
  motionlab glitches r-gpd6hecc7x3n --json

`motionlab docs glitches` says how height, delay, rise and duration are measured.
"""
_MICRO, _MILLI = 1e6, 1e3


def add(commands: Any) -> None:
    """Add ``motionlab glitches``."""
    parser = commands.add_parser(
        "glitches",
        help="measure the error of a run where its axes reverse",
        description="Measure the following error of a kept run at every reversal of its axes.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("run", metavar="RUN", help="identifier of a run")
    add_json(parser)
    parser.set_defaults(command=_glitches)


def _glitches(options: argparse.Namespace) -> int:
    from motionlab.runs.glitches import run_glitches

    found = run_glitches(options.run)
    print(json.dumps(found.model_dump(mode="json")) if options.json else _table(found))
    return DONE


def _table(found: RunGlitches) -> str:
    if not found.axes:
        return "no axis of it reverses"
    return "\n".join(line for name, axis in found.axes.items() for line in _axis(name, axis))


def _axis(name: str, axis: AxisGlitches) -> list[str]:
    lines = [f"  {name}  variant      time s   height um   delay ms    rise ms  duration ms"]
    for variant, each in axis.variants.items():
        lines += [_row(variant, f"{row.time:.4f}", row.height, row) for row in each.rows]
        lines.append(_row(variant, "mean", each.mean.height, each.mean))
    return lines


def _row(variant: str, when: str, height: float, of: GlitchRow | GlitchMean) -> str:
    times = [of.delay, of.rise, of.duration]
    cells = ["-" if each is None else f"{_MILLI * each:.1f}" for each in times]
    figures = "".join(f"{cell:>{width}}" for cell, width in zip(cells, (11, 11, 13), strict=True))
    return f"     {variant:7} {when:>11} {_MICRO * height:>11.3f}{figures}"
