"""Why an error peaks."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from motionlab.studies.options import set_options
from motionlab.studies.study import Progress, Study, StudyCommand, lazy

if TYPE_CHECKING:
    from motionlab.studies.why.documents import WhyDocument
    from motionlab.studies.why.explain import WhyPlan

_EXAMPLES = """\
examples:
  motionlab why circle-matched
  motionlab why circle --axis x --goal 1e-6
  motionlab why fig5 --variant B --time 120 --json

Values are SI; `motionlab docs why` lists the causes. POST /api/v1/why takes the same.
"""


class WhyStudy(Study):
    """Explain a peak of the following error.

    The run is simulated again with each cause taken away, and with changes of the controller: the
    smallest one that reaches the goal within the margins is named.
    """

    kind = "why"
    path = "/why"
    operation = "explainPeak"
    tag = "simulate"
    request_model = lazy("studies.why.documents:WhyRequest")
    document_model = lazy("studies.why.documents:WhyDocument")
    planner = lazy("studies.why.explain:plan")
    bodies = (
        {"scenario": "circle-matched", "variant": "B", "axis": "x"},
        {"scenario": "circle", "variant": "A", "time": 7.5, "goal": 5e-6},
    )
    direct = True
    command = StudyCommand(
        name="why",
        help="explain a peak of the following error",
        description="Simulate a scenario again with each cause of its largest following error "
        "taken away, and find the smallest change of the controller that mends it.",
        examples=_EXAMPLES,
    )

    def run(self, plan: WhyPlan, progress: Progress) -> WhyDocument:
        """Explain the peak."""
        from motionlab.studies.why.explain import explain

        return explain(plan)

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add whose peak, where, and what counts as mended."""
        parser.add_argument("--variant", metavar="LETTER", help="whose error (default: the second)")
        parser.add_argument("--axis", choices=("x", "y"), help="axis (default: the worse one)")
        parser.add_argument(
            "--time", metavar="S", type=float, help="a moment near the peak, s (default: the peak)"
        )
        parser.add_argument(
            "--goal", metavar="M", type=float, help="error to reach, m (default: half the peak)"
        )

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the options."""
        overrides = set_options(options, "variant", "axis", "time", "goal")
        return super().request_of(options, changes) | overrides
