"""The command ``motionlab view``."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from motionlab.cli.exit_codes import DONE
from motionlab.runs.views.table import BY_NAME, VIEWS
from motionlab.studies.options import add_json, add_set, source

if TYPE_CHECKING:
    from motionlab.runs.views.recorded import Recorded

EXAMPLES = """\
examples:
  motionlab view ballbar circle
  motionlab view ballbar circle-matched --set variants.B.controller.x.k_p=312000 --json
  motionlab view ballbar r-gpd6hecc7x3n --from 0 --to 10.5

docs/views.md defines every figure.
"""
_RUN = "r-"


def add(commands: Any) -> None:
    """Add ``motionlab view``."""
    parser = commands.add_parser(
        "view",
        help="circular test and other views of a run or a scenario",
        description="Compute a view of a kept run, or of a scenario that is simulated for it.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    told = "; ".join(f"{view.name}: {view.summary}" for view in VIEWS)
    parser.add_argument("view", metavar="VIEW", choices=list(BY_NAME), help=told)
    parser.add_argument(
        "scenario",
        metavar="RUN|SCENARIO",
        help="identifier of a kept run, path of a .toml file, or a shipped scenario",
    )
    parser.add_argument("--from", dest="start", metavar="S", type=float, help="begin, s")
    parser.add_argument("--to", dest="end", metavar="S", type=float, help="end, s")
    add_set(parser, "change a field of the scenario (repeatable)")
    add_json(parser)
    parser.set_defaults(command=_view)


def _view(options: argparse.Namespace) -> int:
    view = BY_NAME[options.view]
    found = view.compute(_recorded(options, window=view.window))
    print(
        json.dumps(found.model_dump(mode="json")) if options.json else "\n".join(view.report(found))
    )
    return DONE


def _recorded(options: argparse.Namespace, *, window: bool) -> Recorded:
    from motionlab.config.changes import parse_assignments
    from motionlab.config.load import load_scenario
    from motionlab.errors import ConfigError, FieldError
    from motionlab.runs.views.recorded import of_run, of_scenario
    from motionlab.simulation.prepare import prepare

    if options.scenario.startswith(_RUN):
        if options.assignments:
            told = "changes a scenario; a kept run is as it was"
            raise ConfigError(FieldError("--set", told, options.assignments[0]))
        return of_run(options.scenario, options.start, options.end, window=window)
    scenario = load_scenario(source(options), parse_assignments(options.assignments))
    return of_scenario(prepare(scenario), options.start, options.end, window=window)
