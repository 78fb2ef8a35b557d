"""The command ``motionlab loop``: margins of the controllers of a scenario."""

from __future__ import annotations

import argparse
from typing import Any

from motionlab.cli.output import show
from motionlab.errors import DONE
from motionlab.studies.options import add_json, add_scenario, add_set, source

EXAMPLES = """\
examples:
  motionlab loop circle
  motionlab loop circle --set variants.B.controller.x.k_p=1e6 --json

`motionlab docs loop` defines every figure.
"""


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
    document = loop_document(scenario)
    if options.json:
        print(document.model_dump_json())
    else:
        from motionlab.reports.document_text import document_text

        show(document_text(document))
    return DONE
