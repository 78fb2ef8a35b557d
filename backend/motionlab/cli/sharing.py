"""The command ``motionlab sharing``."""

from __future__ import annotations

import argparse
import json
from typing import Any

from motionlab.cli.exit_codes import DONE
from motionlab.cli.options import add_set

EXAMPLES = """\
examples:
  motionlab sharing
  motionlab sharing --set force=5 --set resistance=1.5
  motionlab sharing --set controller=new-design --set law=force-per-ampere --json
  motionlab sharing --set controller=nominal --set plant=new-design

Values are SI; docs/sharing.md lists the fields.
"""


def add(commands: Any) -> None:
    """Add ``motionlab sharing``."""
    parser = commands.add_parser(
        "sharing",
        help="share a force among the phases over one pole pitch",
        description="Share a force among the phases over one pole pitch by each law: ripple, "
        "copper loss, reachable force. The controller's map and the plant's may differ.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_set(parser, "change a field of the request (repeatable, all applied together)")
    parser.add_argument("--json", action="store_true", help="print the document of one law")
    parser.set_defaults(command=_sharing)


def _sharing(options: argparse.Namespace) -> int:
    """Carry out ``motionlab sharing``."""
    from motionlab.config.changes import parse_assignments
    from motionlab.studies.sharing.report import report
    from motionlab.studies.sharing.sharing import LAWS, read_sharing_request, sharing

    tables = parse_assignments(options.assignments)
    wanted = read_sharing_request(tables)
    if options.json:
        print(json.dumps(sharing(wanted).model_dump(), allow_nan=False))
        return DONE
    laws = (wanted.law,) if "law" in tables else LAWS
    print(report([sharing(wanted.model_copy(update={"law": law})) for law in laws]))
    return DONE
