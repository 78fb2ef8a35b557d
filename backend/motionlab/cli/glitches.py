"""The command ``motionlab glitches``."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from motionlab.cli.exit_codes import DONE
from motionlab.cli.output import show
from motionlab.studies.options import add_json

if TYPE_CHECKING:
    from motionlab.library.glitches import AxisGlitches, GlitchMean, GlitchRow, RunGlitches

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
    parser.add_argument("run", metavar="RUN", help="identifier or name of a run")
    add_json(parser)
    parser.set_defaults(command=_glitches)


def _glitches(options: argparse.Namespace) -> int:
    from motionlab.library.glitches import run_glitches
    from motionlab.library.library import library

    found = run_glitches(library().named(options.run))
    if options.json:
        print(json.dumps(found.model_dump(mode="json")))
    else:
        show(_table(found))
    return DONE


def _table(found: RunGlitches) -> str:
    if not found.axes:
        return "no axis of it reverses"
    return "\n".join(_axis(name, axis) for name, axis in found.axes.items())


def _axis(name: str, axis: AxisGlitches) -> str:
    from motionlab.reports.tables import table

    rows: list[tuple[str, ...]] = []
    for variant, each in axis.variants.items():
        rows += [_row(variant, f"{row.time:.4f}", row.height, row) for row in each.rows]
        rows.append(_row(variant, "mean", each.mean.height, each.mean))
    heads = (name, "variant", "time s", "height um", "delay ms", "rise ms", "duration ms")
    return table(heads, rows, right=range(2, len(heads)))


def _row(variant: str, when: str, height: float, of: GlitchRow | GlitchMean) -> tuple[str, ...]:
    times = [of.delay, of.rise, of.duration]
    cells = ["-" if each is None else f"{_MILLI * each:.1f}" for each in times]
    return "", variant, when, f"{_MICRO * height:.3f}", *cells
