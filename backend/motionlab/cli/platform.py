"""The command ``motionlab platform``."""

from __future__ import annotations

import argparse
import json
from typing import Any

from motionlab.cli.exit_codes import DONE
from motionlab.cli.options import add_json, add_set

EXAMPLES = """\
examples:
  motionlab platform
  motionlab platform --axis x --json
  motionlab platform --set new.rib_height=0.04 --set new.support=guides
  motionlab platform --map new-design

Lengths are in m, forces in N; docs/platform.md lists the fields.
"""


def add(commands: Any) -> None:
    """Add ``motionlab platform``."""
    parser = commands.add_parser(
        "platform",
        help="bend a moving platform under normal forces",
        description="Bend two designs of a ribbed platform under four movers' normal forces, by "
        "plate elements, and tell what is left of the air gap.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--axis", choices=("x", "y"), default="y", help="whose default shapes (%(default)s)"
    )
    parser.add_argument(
        "--map",
        metavar="NAME",
        help="take the forces from a force map, shipped or computed: they grow as the gap closes",
    )
    add_set(
        parser,
        "change a field of previous, new or load, or cells, SI (repeatable, all applied together)",
    )
    add_json(parser)
    parser.set_defaults(command=_platform)


def _platform(options: argparse.Namespace) -> int:
    """Carry out ``motionlab platform``."""
    from motionlab.config.changes import parse_assignments
    from motionlab.design.plate.document import platform
    from motionlab.design.plate.inputs import from_assignments
    from motionlab.store.maps import named_map

    changes: dict[str, Any] = {"axis": options.axis}
    if options.map is not None:
        changes["map.name"] = options.map
    request = from_assignments(changes | parse_assignments(options.assignments))
    force_map = None if request.map is None else named_map(request.map.name, "map")
    found = platform(request, force_map)
    if options.json:
        print(json.dumps(found.model_dump(mode="json"), allow_nan=False))
    else:
        from motionlab.design.plate.report import report

        print(report(found))
    return DONE
