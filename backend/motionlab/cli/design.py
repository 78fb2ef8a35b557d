"""The command ``motionlab design``."""

from __future__ import annotations

import argparse
import json
from typing import Any

from motionlab.cli.exit_codes import DONE
from motionlab.cli.options import add_json, add_set

EXAMPLES = """\
examples:
  motionlab design
  motionlab design --json --set requirements.f_max=50
  motionlab design --set dimensions.single_phase_force=38.4
  motionlab design --set preset=previous
"""


def add(commands: Any) -> None:
    """Add ``motionlab design``."""
    parser = commands.add_parser(
        "design",
        help="size a motor, and rate its dimensions",
        description="Size a motor by the paper's equations (1) to (14): from requirements to "
        "dimensions and from dimensions to limits, as printed beside corrected. The paper's "
        "example is the default; docs/design.md lists the fields.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_set(
        parser,
        "change a field of requirements or dimensions, SI (repeatable, all applied together)",
    )
    add_json(parser)
    parser.set_defaults(command=_design)


def _design(options: argparse.Namespace) -> int:
    """Carry out ``motionlab design``."""
    from motionlab.config.changes import parse_assignments
    from motionlab.design.design import design, from_assignments

    found = design(from_assignments(parse_assignments(options.assignments)))
    if options.json:
        print(json.dumps(found.model_dump(by_alias=True), allow_nan=False))
    else:
        from motionlab.design.report import report

        print(report(found))
    return DONE
