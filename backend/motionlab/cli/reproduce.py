"""The command ``motionlab reproduce``."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from motionlab.cli.exit_codes import DONE, FAILED
from motionlab.cli.options import add_json
from motionlab.cli.progress import share_done

EXAMPLES = """\
examples:
  motionlab reproduce
  motionlab reproduce --only fig5 rhombus-x
  motionlab reproduce --only sizing --json

The first run computes a force map by finite elements, which takes a minute and is kept.
"""


def add(commands: Any) -> None:
    """Add ``motionlab reproduce``."""
    parser = commands.add_parser(
        "reproduce",
        help="compute the paper's numbers and compare them",
        description="Compute every number that the paper prints and judge it by its band. Exit "
        "code 1 if a row fails, or one of docs/known-failures.md has come to hold; "
        "docs/paper.md explains.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--only",
        metavar="ID",
        nargs="+",
        default=[],
        help="rows or groups of rows; errata come with all rows only",
    )
    add_json(parser)
    parser.set_defaults(command=_reproduce)


def _reproduce(options: argparse.Namespace) -> int:
    """Carry out ``motionlab reproduce``."""
    from motionlab.studies.paper.report import report
    from motionlab.studies.paper.reproduce import is_reproduced, reproduce

    with share_done("reproduce") as progress:
        found = reproduce(options.only, lambda share, _: progress(share))
    if options.json:
        print(json.dumps(found.model_dump(), allow_nan=False))
    else:
        print(report(found, colour=sys.stdout.isatty()))
    return DONE if is_reproduced(found) else FAILED
