"""The paper's numbers, computed and compared with what is printed."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from motionlab.studies.study import Command, Models, Progress, Source, Study

if TYPE_CHECKING:
    from motionlab.studies.paper.document import ReproduceDocument

_EXAMPLES = """\
examples:
  motionlab reproduce
  motionlab reproduce --only fig5 rhombus-x
  motionlab reproduce --only sizing --json

The first run computes a force map by finite elements, which takes a minute and is kept.
"""


class Reproduce(Study[list[str], "ReproduceDocument"]):
    """Compute the paper's numbers and compare them.

    The job's report carries the rows as they are judged.
    """

    kind = "reproduce"
    path = "/reproduce"
    operation = "reproduce"
    tag = "paper"
    report_name = "ReproduceJob"
    bodies = ({"only": ["sizing", "rhombus-x"]},)
    batches = True
    command = Command(
        name="reproduce",
        help="compute the paper's numbers and compare them",
        description="Compute every number that the paper prints and judge it by its band. Exit "
        "code 1 if a row fails, or one of docs/known-failures.md has come to hold; "
        "docs/paper.md explains.",
        examples=_EXAMPLES,
        scenario=None,
        set=None,
        title="reproduce",
    )

    def models(self) -> Models:
        """Return the types of request, document and partial result."""
        from motionlab.studies.paper.document import PartialReproduce, ReproduceDocument
        from motionlab.studies.paper.request import ReproduceRequest

        return Models(ReproduceRequest, ReproduceDocument, PartialReproduce)

    def plan(self, request: Mapping[str, Any], source: Source | None = None) -> list[str]:
        """Return the rows and groups that are asked for; see `Study.plan`."""
        from motionlab.config.validation_errors import checked
        from motionlab.studies.paper.registry import quantities
        from motionlab.studies.paper.request import ReproduceRequest

        only = checked(ReproduceRequest, request, "reproduce").only
        quantities(only)  # what is unknown is refused now
        return only

    def run(self, plan: list[str], progress: Progress) -> ReproduceDocument:
        """Compute the rows, one after another."""
        from motionlab.studies.paper.reproduce import reproduce

        return reproduce(plan, progress)

    def report(self, found: ReproduceDocument) -> str:
        """Return rows and errata as tables, in colour on a terminal."""
        from motionlab.studies.paper.report import report

        return report(found, colour=sys.stdout.isatty())

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add the choice of rows."""
        parser.add_argument(
            "--only",
            metavar="ID",
            nargs="+",
            default=[],
            help="rows or groups of rows; errata come with all rows only",
        )

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request that options make."""
        return {"only": options.only}

    def has_failed(self, found: ReproduceDocument) -> bool:
        """Tell whether a row fails, or a known failure has come to hold."""
        from motionlab.studies.paper.reproduce import is_reproduced

        return not is_reproduced(found)
