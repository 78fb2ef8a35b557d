"""The paper's numbers, computed and compared with the printed ones."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING, Any

from motionlab.reports.tables import on_terminal
from motionlab.studies.study import Study, StudyCommand, lazy

if TYPE_CHECKING:
    from motionlab.paper.documents import ReproduceDocument

_EXAMPLES = """\
examples:
  motionlab reproduce
  motionlab reproduce --only fig5 rhombus-x
  motionlab reproduce --only sizing --json

The first run computes a force map by finite elements, which takes a minute and is kept.
"""


class ReproduceStudy(Study):
    """Compute the paper's numbers and compare them.

    The job's report carries the rows as they are judged.
    """

    kind = "reproduce"
    path = "/reproduce"
    operation = "reproduce"
    tag = "paper"
    report_name = "ReproduceJob"
    request_model = lazy("paper.documents:ReproduceRequest")
    document_model = lazy("paper.documents:ReproduceDocument")
    partial_model = lazy("paper.documents:PartialReproduce")
    planner = lazy("paper.reproduce:plan")
    run = lazy("paper.reproduce:reproduce")
    has_failed = lazy("paper.reproduce:has_failed")
    bodies = ({"only": ["sizing", "rhombus-x"]},)
    batches = True
    scatters = True
    command = StudyCommand(
        name="reproduce",
        help="compute the paper's numbers and compare them",
        description="Compute every number that the paper prints and judge it by its band. Exit "
        "code 1 if a row fails, or one of the known failures has come to hold; "
        "`motionlab docs paper` explains.",
        examples=_EXAMPLES,
        scenario=None,
        set=None,
        title="reproduce",
    )

    def report(self, result: ReproduceDocument) -> str:
        """Return rows and errata as tables, in colour on a terminal."""
        from motionlab.paper.reproduce import report

        return report(result, colour=on_terminal() and not os.environ.get("NO_COLOR"))

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
        """Return the request of the options."""
        return {"only": options.only}
