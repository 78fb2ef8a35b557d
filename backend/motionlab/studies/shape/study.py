"""Loop shaping on a measured frequency response."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from motionlab.errors import FieldError
from motionlab.studies.options import add_fields, set_options
from motionlab.studies.record.options import add_columns, add_part
from motionlab.studies.study import RequestLimits, Study, StudyCommand, above, lazy

if TYPE_CHECKING:
    from motionlab.studies.shape.shaping import ShapePlan

_EXAMPLES = """\
examples:
  motionlab shape circle-resonant --axis y
  motionlab shape circle-matched --axis x --variant B --gain-margin 2.5 --filters 2
  motionlab shape --run 'rig 7' --axis y --second-run 'rig 8'

`motionlab docs response` has the method. POST /api/v1/shape takes the same.
"""
_KNOWN = {"scenario", "set"}
_COLUMNS = {kind: f"{kind}_column" for kind in ("position", "force", "excitation")}


class ShapeStudy(Study):
    """Propose gains and filters on a measured plant, and check them by a second measurement.

    Margins are read off the measured open loop; filters come with their reasons.
    """

    kind = "shape"
    path = "/shape"
    operation = "shapeLoop"
    tag = "tune"
    report_name = "ShapeJob"
    request_model = lazy("studies.shape.documents:ShapeRequest")
    document_model = lazy("studies.shape.documents:ShapeDocument")
    planner = lazy("studies.shape.shaping:plan")
    run = lazy("studies.shape.shaping:shape")
    report = lazy("studies.shape.report:report")
    bodies = ({"scenario": "circle-resonant", "axis": "y"},)
    command = StudyCommand(
        name="shape",
        help="propose gains and filters on a measured response",
        description="Measure the frequency response of one axis, or read it off a run, propose "
        "gains and filters whose margins hold on it, and check them by a second measurement.",
        examples=_EXAMPLES,
        title="shaping",
    )

    def excess(self, plan: ShapePlan, bounds: RequestLimits) -> list[FieldError]:
        """Bound the simulated time of both experiments."""
        message = "simulated time of both experiments is too large for one request"
        return above(plan.seconds, bounds.work_max, loc="seconds", message=message)

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add how it is measured and what is to be kept."""
        add_fields(parser, self.request_model, _KNOWN | {"start", "end", *_COLUMNS.values()})
        add_part(parser)
        add_columns(parser, **_COLUMNS)

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the options."""
        for name in ("run", "second_run"):
            if (run := getattr(options, name)) is not None:
                from motionlab.library.library import library

                setattr(options, name, library().named(run, f"--{name.replace('_', '-')}"))
        names = [name for name in self.request_model.model_fields if name not in _KNOWN]
        return super().request_of(options, changes) | set_options(options, *names)
