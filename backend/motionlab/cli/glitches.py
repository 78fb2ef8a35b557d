"""The command ``motionlab glitches``."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from motionlab.cli.output import show
from motionlab.errors import DONE
from motionlab.studies.options import add_json

if TYPE_CHECKING:
    pass

EXAMPLES = """\
examples:
  motionlab glitches r-gpd6hecc7x3n
  motionlab glitches r-gpd6hecc7x3n --json

`motionlab docs glitches` says how height, delay, rise and duration are measured.
"""


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
    from motionlab.library.library import library
    from motionlab.library.recorded import run_glitches

    reversals = run_glitches(library().named(options.run))
    if options.json:
        print(json.dumps(reversals.model_dump(mode="json")))
    else:
        from motionlab.reports.document_text import document_text

        show(document_text(reversals) or "no axis of it reverses")
    return DONE
