"""Tuning on a machine in few motions."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from motionlab.errors import FieldError
from motionlab.studies.options import add_fields, set_options
from motionlab.studies.study import RequestLimits, Study, StudyCommand, above, lazy

if TYPE_CHECKING:
    from motionlab.studies.safe_tune.tuning import SafeTunePlan

_EXAMPLES = """\
examples:
  motionlab safe-tune circle --axis x --machine plant=matched --machine plant.x.mass=6.2
  motionlab safe-tune circle --axis x --run 'first' --run 'second' --response 'shaken'
  motionlab drive tune circle --axis x

The last one does it on the drives of a server, and asks before each motion. `motionlab docs
safe-tune` has the method. POST /api/v1/safe-tune takes the same.
"""
_KNOWN = {"scenario", "set", "runs", "machine", "measure", "vary"}
_REPEATED: dict[str, Any] = {"action": "append", "default": []}


class SafeTuneStudy(Study):
    """Propose the next gains to try on a machine, inside margins and bounds on error and force.

    Each request has the runs made so far; a rehearsal makes all motions on a simulated machine.
    """

    kind = "safe-tune"
    path = "/safe-tune"
    operation = "tuneSafely"
    tag = "tune"
    report_name = "SafeTuneJob"
    request_model = lazy("studies.safe_tune.documents:SafeTuneRequest")
    document_model = lazy("studies.safe_tune.documents:SafeTuneDocument")
    partial_model = lazy("studies.safe_tune.documents:SafeTuneDocument")
    planner = lazy("studies.safe_tune.tuning:plan")
    run = lazy("studies.safe_tune.tuning:tune_safely")
    report = lazy("studies.safe_tune.report:report")
    batches = True
    bodies = (
        {"scenario": "circle", "axis": "x"},
        {"scenario": "circle", "axis": "x", "machine": {"plant": "matched"}, "motions": 4},
    )
    command = StudyCommand(
        name="safe-tune",
        help="tune gains on a machine in few motions, within margins and bounds",
        description="Propose the next gains to try on a machine from the runs made so far, inside "
        "the model's stability boundary and bounds on measured error and force; or rehearse it.",
        examples=_EXAMPLES,
        title="motions",
    )

    def excess(self, plan: SafeTunePlan, bounds: RequestLimits) -> list[FieldError]:
        """Bound the simulated time of all that is looked at."""
        message = "simulated time of all gains looked at is too large for one request"
        return above(plan.seconds, bounds.trials_max, loc="motions", message=message)

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add runs, the machine of a rehearsal, and the limits."""
        add_fields(parser, self.request_model, _KNOWN | {"response"})
        parser.add_argument(
            "--run",
            dest="runs",
            metavar="RUN",
            help="kept run of a motion made on the machine (repeatable, in their order)",
            **_REPEATED,
        )
        parser.add_argument(
            "--response", metavar="RUN", help="kept run of a multisine on it, for the margins"
        )
        parser.add_argument(
            "--machine",
            dest="machine",
            metavar="KEY=VALUE",
            help="rehearse on a simulated machine: a change of plant or load (repeatable)",
            **_REPEATED,
        )
        parser.add_argument(
            "--no-measure",
            dest="measure",
            action="store_false",
            help="rehearse without a measured response",
        )

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the options."""
        from motionlab.config.changes import parse_assignments
        from motionlab.library.library import library

        request = super().request_of(options, changes)
        if options.runs:
            request["runs"] = [library().named(run, "--run") for run in options.runs]
        if options.response is not None:
            request["response"] = library().named(options.response, "--response")
        if options.machine:
            request["machine"] = parse_assignments(options.machine, "--machine")
        request["measure"] = options.measure
        others = _KNOWN | {"response"}
        names = [name for name in self.request_model.model_fields if name not in others]
        return request | set_options(options, *names)
