"""A frequency response, measured."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from motionlab.errors import FieldError
from motionlab.studies.options import add_fields, set_options
from motionlab.studies.record.options import add_columns, add_part
from motionlab.studies.study import RequestLimits, Study, StudyCommand, above, lazy

if TYPE_CHECKING:
    from motionlab.studies.response.measure import ResponsePlan

_EXAMPLES = """\
examples:
  motionlab response circle-resonant --axis y
  motionlab response circle --variant A --velocity 0.02 --seconds 120 --out plant.csv
  motionlab response circle-matched --force 1 --json
  motionlab response circle --axis y --signal chirp
  motionlab response --run 'rig 7' --axis y --force-column torque

`motionlab docs response` has the method and what it reaches. POST /api/v1/response takes the same.
"""
_KNOWN = {"scenario", "set"}
_COLUMNS = {kind: f"{kind}_column" for kind in ("position", "force", "excitation")}


class ResponseStudy(Study):
    """Measure the frequency response of the plant of one axis, with intervals.

    The axis slides to and fro while a multisine, or another signal, shakes its reference.
    The job's report carries the response so far, and ends with the margins of the loop and their
    intervals.
    """

    kind = "response"
    path = "/response"
    operation = "measureResponse"
    tag = "simulate"
    report_name = "ResponseJob"
    request_model = lazy("studies.response.documents:ResponseRequest")
    document_model = lazy("studies.response.documents:MeasuredResponse")
    partial_model = lazy("studies.response.documents:MeasuredResponse")
    planner = lazy("studies.response.measure:plan")
    run = lazy("studies.response.measure:measure")
    report = lazy("studies.response.report:report")
    suffixes = (".csv",)
    write = lazy("studies.response.report:write")
    bodies = ({"scenario": "circle-resonant", "axis": "x"},)
    command = StudyCommand(
        name="response",
        help="measure a frequency response, with intervals",
        description="Measure the frequency response of the plant of one axis while it slides, by "
        "a multisine or another signal on its reference: with intervals, coherence, and the "
        "margins of the loop.",
        examples=_EXAMPLES,
        title="slides",
    )

    def excess(self, plan: ResponsePlan, bounds: RequestLimits) -> list[FieldError]:
        """Bound the simulated time of all slides."""
        message = "simulated time of all slides is too large for one request"
        return above(plan.seconds, bounds.work_max, loc="seconds", message=message)

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add how it is measured, and the file to write."""
        add_fields(parser, self.request_model, _KNOWN | {"start", "end", *_COLUMNS.values()})
        add_part(parser)
        add_columns(parser, **_COLUMNS)
        parser.add_argument("--out", metavar="FILE", help="write the curves to FILE, .csv")

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the options."""
        if options.run is not None:
            from motionlab.library.library import library

            options.run = library().named(options.run, "--run")
        names = [name for name in self.request_model.model_fields if name not in _KNOWN]
        return super().request_of(options, changes) | set_options(options, *names)
