"""The command ``motionlab montecarlo``."""

from __future__ import annotations

import argparse
import json
from typing import Any

from motionlab.cli.exit_codes import DONE
from motionlab.cli.options import add_json, add_scenario, add_set, given, source
from motionlab.cli.progress import share_done

EXAMPLES = """\
examples:
  motionlab montecarlo
  motionlab montecarlo circle --cases 300 --spec x=12e-6 --spec y=15e-6
  motionlab montecarlo trapezoid-y --cases 50 --json
  motionlab run circle $(motionlab montecarlo circle --case 262)

docs/montecarlo.md lists how the plants differ; POST /api/v1/montecarlo takes other ways.
"""


def add(commands: Any) -> None:
    """Add ``motionlab montecarlo``."""
    parser = commands.add_parser(
        "montecarlo",
        help="run a scenario on many plausible plants",
        description="Run every controller of a scenario on many plausible plants: how far its "
        "metrics are spread, and how likely it meets a spec.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_scenario(parser)
    add_set(parser, "change a field of the scenario (repeatable, all applied together)")
    parser.add_argument("--cases", metavar="N", type=int, help="plants to draw (300)")
    parser.add_argument("--seed", type=int, help="of the draws (the scenario's)")
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
    add_json(parser)
    parser.set_defaults(command=_montecarlo)


def _montecarlo(options: argparse.Namespace) -> int:
    """Carry out ``motionlab montecarlo``."""
    from motionlab.config.changes import parse_assignments
    from motionlab.studies.montecarlo.report import report
    from motionlab.studies.montecarlo.request import read_request
    from motionlab.studies.montecarlo.study import case_changes, plan, study

    request: dict[str, Any] = {
        "scenario": options.scenario,
        "set": parse_assignments(options.assignments),
        "spec": parse_assignments(options.spec, "--spec"),
    } | given(options, "cases", "seed")
    planned = plan(read_request(request), source(options))
    if options.case is not None:
        changes = case_changes(planned, options.case)
        assigned = [f"--set {text}" for text in options.assignments]
        drawn = [
            f"--set {path}={json.dumps(value, separators=(',', ':'))}"
            for path, value in changes.items()
        ]
        print(*assigned, *drawn)
        return DONE
    with share_done("plants") as progress:
        found = study(planned, progress)
    if options.json:
        print(json.dumps(found.model_dump(), allow_nan=False))
    else:
        print(report(found))
    return DONE
