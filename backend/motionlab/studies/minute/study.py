"""A recorded stretch under another controller, as a study."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from motionlab.errors import FieldError
from motionlab.studies.options import set_options
from motionlab.studies.record.options import add_part
from motionlab.studies.study import RequestLimits, Study, StudyCommand, above, lazy

if TYPE_CHECKING:
    from motionlab.studies.minute.recorded import MinutePlan

_EXAMPLES = """\
examples:
  motionlab minute r-abcdefghijkl --other B
  motionlab minute "morning" --variant A --set variants.B.controller=lugre-reference
  motionlab minute r-abcdefghijkl --from 10 --to 70 --out minute.csv

`motionlab docs minute` has the method, and how often its band holds.
"""


class MinuteStudy(Study):
    """Predict what another controller would have done in a recorded stretch, with a band.

    Friction, mass and the stretch's own disturbance are fitted to the record; the other controller
    runs on that motor. Refused where the record cannot tell.
    """

    kind = "minute"
    path = "/minute"
    operation = "predictMinute"
    tag = "simulate"
    report_name = "MinuteJob"
    request_model = lazy("studies.minute.documents:MinuteRequest")
    document_model = lazy("studies.minute.documents:MinuteDocument")
    planner = lazy("studies.minute.recorded:plan")
    run = lazy("studies.minute.predict:predict")
    report = lazy("studies.minute.report:report")
    suffixes = (".csv",)
    write = lazy("studies.minute.report:write")
    bodies = ({"run": "r-abcdefghijkl", "variant": "A", "other": "B"},)
    command = StudyCommand(
        name="minute",
        help="what another law would have done in a recorded stretch",
        description="Predict what another controller would have done in a recorded stretch: same "
        "motion, same disturbance, with a 95 % band.",
        examples=_EXAMPLES,
        scenario=None,
        set="change a field of the run's scenario for the controller that is tried (repeatable)",
        title="members",
    )

    def excess(self, plan: MinutePlan, bounds: RequestLimits) -> list[FieldError]:
        """Bound the simulated time of all members."""
        message = "simulated time of all members is too large for one request"
        return above(plan.seconds, bounds.work_max, loc="members", message=message)

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add the run, the two controllers, and the stretch."""
        parser.add_argument("run", metavar="RUN", help="identifier or name of a kept run")
        parser.add_argument(
            "--variant", metavar="LETTER", help="whose record is read (default: the run's first)"
        )
        parser.add_argument(
            "--other", metavar="LETTER", help="whose controller is tried (default: the second)"
        )
        add_part(parser)
        parser.add_argument(
            "--members", type=int, metavar="N", help="motors that are simulated (default: 24)"
        )
        parser.add_argument("--seed", type=int, help="of the motors and their noise (default: 0)")
        parser.add_argument("--out", metavar="FILE", help="write every sample to FILE, .csv")

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the options."""
        from motionlab.library.library import library

        names = ("variant", "other", "start", "end", "members", "seed")
        return {"run": library().named(options.run), "set": changes} | set_options(options, *names)

    def document(self, result: Any) -> Any:
        """Return the document of a prediction."""
        return result.document
