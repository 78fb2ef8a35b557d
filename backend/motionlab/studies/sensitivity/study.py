"""Sensitivities of a scenario's metrics."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from motionlab.errors import FieldError
from motionlab.studies.study import RequestLimits, Study, StudyCommand, above, lazy

if TYPE_CHECKING:
    from motionlab.studies.sensitivity.run import SensitivityPlan

WORK_MAX = 100_000.0
"""Simulated time summed over cases and variants, s."""

_EXAMPLES = """\
examples:
  motionlab sensitivity circle
  motionlab sensitivity circle --field plant --field variants.B --step 0.05 --out slopes.csv
  motionlab sensitivity circle --margins --json

`motionlab docs sweep` says more. POST /api/v1/sensitivity takes the same.
"""


class SensitivityStudy(Study):
    """Change every number of a scenario down and up, and find how each metric follows.

    The job ends with d(metric)/d(field) of every metric, variant and axis for each field.
    """

    kind = "sensitivity"
    path = "/sensitivity"
    operation = "sensitivity"
    tag = "sweep"
    report_name = "SensitivityJob"
    request_model = lazy("studies.sensitivity.documents:SensitivityRequest")
    document_model = lazy("studies.sensitivity.documents:SensitivityDocument")
    planner = lazy("studies.sensitivity.run:plan")
    run = lazy("studies.sensitivity.run:run")
    report = lazy("studies.sensitivity.report:report")
    suffixes = (".csv",)
    write = lazy("studies.sensitivity.report:write")
    bodies = ({"scenario": "circle", "fields": ["plant", "variants.B.controller.x"]},)
    batches = True
    scatters = True
    command = StudyCommand(
        name="sensitivity",
        help="find how metrics change with every number of a scenario",
        description="Change every number of a scenario down and up by a share of it, all in one "
        "batch, and find how each metric of each controller and axis follows.",
        examples=_EXAMPLES,
        title="changes",
    )

    def excess(self, plan: SensitivityPlan, bounds: RequestLimits) -> list[FieldError]:
        """Bound the simulated time of all changes."""
        message = "simulated time of all changes and variants is too large for one request"
        return above(plan.seconds, WORK_MAX, loc="scenario", message=message)

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add the fields, the step and the file to write."""
        parser.add_argument(
            "--field",
            metavar="PATH",
            action="append",
            default=[],
            help="a number, or a table for all numbers in it; left out, all (repeatable)",
        )
        parser.add_argument(
            "--step", type=float, default=0.01, help="share by which each is changed (0.01)"
        )
        parser.add_argument("--margins", action="store_true", help="of stability margins, too")
        parser.add_argument("--out", metavar="FILE", help="write every slope to FILE, .csv")

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the options."""
        rest = {"fields": options.field, "step": options.step, "margins": options.margins}
        return super().request_of(options, changes) | rest
