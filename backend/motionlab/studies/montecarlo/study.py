"""Monte Carlo: a scenario on many plausible plants."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from motionlab.errors import FieldError
from motionlab.studies.options import set_options
from motionlab.studies.study import RequestLimits, Study, StudyCommand, above, lazy

if TYPE_CHECKING:
    from motionlab.studies.montecarlo.cases import MonteCarloPlan

WORK_MAX = 100_000.0
"""Simulated time summed over cases and variants, s: a few minutes of four cores."""

_EXAMPLES = """\
examples:
  motionlab montecarlo
  motionlab montecarlo circle --cases 300 --spec x=12e-6 --spec y=15e-6
  motionlab montecarlo trapezoid-y --cases 50 --json
  motionlab run circle $(motionlab montecarlo circle --case 262)

`motionlab docs montecarlo` lists how the plants differ; POST /api/v1/montecarlo takes other ways.
"""


class MonteCarloStudy(Study):
    """Run every controller of a scenario on many plausible plants.

    The job ends with quantiles of every metric, bands of the following error over time, the
    probability of meeting the spec, and the worst cases with their changes.
    """

    kind = "monte-carlo"
    path = "/montecarlo"
    operation = "monteCarlo"
    tag = "montecarlo"
    report_name = "MonteCarloJob"
    request_model = lazy("studies.montecarlo.documents:MonteCarloRequest")
    document_model = lazy("studies.montecarlo.documents:MonteCarloDocument")
    read = lazy("studies.montecarlo.documents:read_request")
    planner = lazy("studies.montecarlo.cases:plan")
    run = lazy("studies.montecarlo.cases:run_cases")
    bodies = ({"scenario": "circle", "cases": 300, "spec": {"x": 12e-6, "y": 15e-6}},)
    batches = True
    scatters = True
    command = StudyCommand(
        name="montecarlo",
        help="run a scenario on many plausible plants",
        description="Run every controller of a scenario on many plausible plants: how far its "
        "metrics are spread, and how likely it meets a spec.",
        examples=_EXAMPLES,
        title="plants",
    )

    def excess(self, plan: MonteCarloPlan, bounds: RequestLimits) -> list[FieldError]:
        """Bound the simulated time of all cases."""
        message = "simulated time of all cases and variants is too large for one request"
        return above(plan.seconds, WORK_MAX, loc="cases", message=message)

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add number of plants, seed, spec and the case to print."""
        parser.add_argument("--cases", metavar="N", type=int, help="plants to draw (default: 300)")
        parser.add_argument("--seed", type=int, help="of the draws (default: the scenario's)")
        parser.add_argument(
            "--spec",
            metavar="AXIS=M",
            action="append",
            default=[],
            help="largest following error allowed on x or y, m (repeatable)",
        )
        parser.add_argument(
            "--case",
            metavar="N",
            type=int,
            help="run nothing: print what makes the plant of case N, as options of motionlab run",
        )

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the options."""
        from motionlab.config.changes import parse_assignments

        spec = {"spec": parse_assignments(options.spec, "--spec")}
        return super().request_of(options, changes) | spec | set_options(options, "cases", "seed")

    def before(self, plan: MonteCarloPlan, options: argparse.Namespace) -> str | None:
        """Return one plant as options of ``motionlab run``, if requested."""
        from motionlab.studies.montecarlo.cases import case_changes

        if options.case is None:
            return None
        drawn = [
            f"--set {path}={_inline(value)}"
            for path, value in case_changes(plan, options.case).items()
        ]
        return " ".join([*(f"--set {text}" for text in options.assignments), *drawn])


def _inline(value: Any) -> str:
    """Return a value as TOML without a space, so that a shell takes it as one word."""
    if isinstance(value, dict):
        return "{" + ",".join(f"{key}={_inline(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ",".join(map(_inline, value)) + "]"
    return json.dumps(value)
