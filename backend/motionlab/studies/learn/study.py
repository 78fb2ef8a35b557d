"""Learning from lap to lap, as a study."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from motionlab.errors import FieldError
from motionlab.studies.options import set_options
from motionlab.studies.study import RequestLimits, Study, StudyCommand, above, lazy

if TYPE_CHECKING:
    from motionlab.studies.learn.documents import LearnDocument
    from motionlab.studies.learn.learn import Learnt
    from motionlab.studies.learn.plan import LearnPlan

_EXAMPLES = """\
examples:
  motionlab learn circle-matched --laps 20
  motionlab learn circle --variant B --out learnt.toml && motionlab run learnt.toml
  motionlab learn circle-matched --after rhombus --after pentagram --after trapezoid-y
  motionlab learn circle-resonant --bandwidth y=150 --anyway

`motionlab docs learning` has the method, its limits and what it reaches.
"""


class LearnStudy(Study):
    """Learn a force from lap to lap of a motion that repeats, and the encoder's error with it.

    Before the first lap, convergence is predicted over frequency, for the motor and for drawn ones.
    The job's report carries the laps so far, and at the end what was learnt, as changes of the
    scenario.
    """

    kind = "learn"
    path = "/learn"
    operation = "learn"
    tag = "learn"
    report_name = "LearningJob"
    request_model = lazy("studies.learn.documents:LearnRequest")
    document_model = lazy("studies.learn.documents:LearnDocument")
    partial_model = lazy("studies.learn.documents:PartialLearning")
    planner = lazy("studies.learn.plan:plan")
    run = lazy("studies.learn.learn:learn")
    suffixes = (".toml",)
    write = lazy("studies.learn.learn:save")
    bodies = ({"scenario": "circle-matched", "variant": "B", "laps": 12},)
    command = StudyCommand(
        name="learn",
        help="learn a force from lap to lap of a motion that repeats",
        description="Learn a force from lap to lap of a motion that repeats, and the encoder's "
        "sub-divisional error with it; before, predict whether learning converges.",
        examples=_EXAMPLES,
        title="learning",
    )

    def excess(self, plan: LearnPlan, bounds: RequestLimits) -> list[FieldError]:
        """Bound the simulated time of all laps."""
        message = "simulated time of all laps is too large for one request"
        return above(plan.seconds, bounds.work_max, loc="laps", message=message)

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add who learns and how."""
        parser.add_argument("--variant", metavar="LETTER", help="who learns (default: the last)")
        parser.add_argument(
            "--after",
            metavar="MOTION",
            action="append",
            default=None,
            help="a trajectory that is learnt first, and carried over (repeatable)",
        )
        parser.add_argument("--laps", metavar="N", type=int, help="laps to learn in (default: 12)")
        parser.add_argument("--gain", metavar="G", type=float, help="learning gain (default: 0.6)")
        parser.add_argument(
            "--bandwidth",
            metavar="AXIS=HZ",
            action="append",
            default=[],
            help="bandwidth of learning on x or y, Hz (repeatable; default: 150, or 0.6 of the "
            "notch's frequency)",
        )
        parser.add_argument(
            "--motors", metavar="N", type=int, help="drawn motors to predict for (default: 100)"
        )
        parser.add_argument("--seed", type=int, help="of the draws (default: the scenario's)")
        parser.add_argument(
            "--no-encoder",
            dest="encoder",
            action="store_false",
            default=None,
            help="leave the encoder's error as it is",
        )
        parser.add_argument(
            "--anyway", action="store_true", default=None, help="where it would diverge, too"
        )
        parser.add_argument(
            "--out", metavar="FILE", help="write the scenario with what was learnt to FILE, .toml"
        )

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the options."""
        from motionlab.config.changes import parse_assignments

        names = ("after", "variant", "laps", "gain", "motors", "seed", "encoder", "anyway")
        bandwidth = {"bandwidth": parse_assignments(options.bandwidth, "--bandwidth")}
        return super().request_of(options, changes) | bandwidth | set_options(options, *names)

    def has_failed(self, result: Learnt) -> bool:
        """Return whether the motor diverged."""
        return result.document.diverged

    def document(self, result: Learnt) -> LearnDocument:
        """Return the document of what was learnt."""
        return result.document
