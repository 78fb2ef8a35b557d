"""The command ``motionlab loop``: margins of the controllers of a scenario."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING, Any

from motionlab.cli.exit_codes import DONE
from motionlab.cli.output import show
from motionlab.studies.options import add_json, add_scenario, add_set, source

if TYPE_CHECKING:
    from motionlab.loop.document import LoopAt, LoopDocument, LoopOfAxis

EXAMPLES = """\
examples:
  motionlab loop circle
  motionlab loop circle --set variants.B.controller.x.k_p=1e6 --json

`motionlab docs loop` defines every figure.
"""


_WORST = (
    "Figures hold while sliding at four Stribeck velocities; worst: the worst at rest and from 0.5 "
    "to 4\nof them, the gain margin up or down, as tune and why judge."
)


def add(commands: Any) -> None:
    """Add ``motionlab loop``."""
    parser = commands.add_parser(
        "loop",
        help="margins and stability limits of every controller",
        description="Linearise the loop of every controller and axis while the axis slides and at "
        "standstill, and give its margins, and the gains at which it becomes unstable.",
        epilog=EXAMPLES,
    )
    add_scenario(parser)
    add_set(parser, "change a field (repeatable, all applied together)")
    add_json(parser)
    parser.set_defaults(command=_loop)


def _loop(options: argparse.Namespace) -> int:
    from motionlab.config.changes import parse_assignments
    from motionlab.config.load import load_scenario
    from motionlab.loop.document import loop_document

    scenario = load_scenario(source(options), parse_assignments(options.assignments))
    found = loop_document(scenario)
    if options.json:
        print(found.model_dump_json())
    else:
        show(_report(found))
    return DONE


def _report(found: LoopDocument) -> str:
    from motionlab.reports.tables import table

    rows: list[tuple[str, ...]] = [
        row
        for name, variant in found.variants.items()
        for axis, sliding in variant.axes.items()
        for row in _axis(f"{name} {axis}", sliding)
    ]
    heads = ("", "stable", "crossover", "bandwidth", "phase margin", "gain margin", "down to")
    heads += ("Ms", "k_p limit", "k_d limit")
    units = ("", "", "Hz", "Hz", "degrees", "", "", "", "N/m", "N s/m")
    lines = [table(heads, rows, right=range(2, len(heads)), units=units)] if rows else []
    return "\n".join(
        [
            *lines,
            *([_WORST] if rows else []),
            *(f"{name}: {each.note}" for name, each in found.variants.items() if each.note),
        ]
    )


def _axis(label: str, sliding: LoopOfAxis) -> list[tuple[str, ...]]:
    worst = sliding.worst
    gain, phase, Ms = (at and at.value for at in (worst.gain_margin, worst.phase_margin, worst.Ms))
    degrees = None if phase is None else math.degrees(phase)
    least = (None, None, degrees, gain, None, Ms, None, None)
    return [
        (label, *_cells(sliding)),
        ("  at rest", *_cells(sliding.standstill)),
        ("  worst", "yes" if worst.stable else "NO", *map(_figure, least)),
    ]


def _cells(loop: LoopAt) -> tuple[str, ...]:
    margin = None if loop.phase_margin is None else math.degrees(loop.phase_margin)
    figures = (loop.crossover, loop.bandwidth, margin, loop.gain_margin, loop.gain_reduction)
    more = (loop.Ms, loop.k_p_limit, loop.k_d_limit)
    return ("yes" if loop.stable else "NO", *map(_figure, figures + more))


def _figure(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}" if value < 1e4 else f"{value:.0f}"
