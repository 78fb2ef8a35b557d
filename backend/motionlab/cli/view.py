"""The command ``motionlab view``."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from motionlab.analysis.views.table import BY_NAME, VIEWS
from motionlab.cli.exit_codes import DONE
from motionlab.cli.output import names_run, show
from motionlab.errors import ConfigError, FieldError
from motionlab.studies.options import add_json, add_set, source

if TYPE_CHECKING:
    from motionlab.analysis.views.positioning import Positioning
    from motionlab.analysis.views.recorded import Recorded

EXAMPLES = """\
examples:
  motionlab view ballbar circle
  motionlab view ballbar circle-matched --set variants.B.controller.x.k_p=312000 --json
  motionlab view ballbar r-gpd6hecc7x3n --from 0 --to 10.5
  motionlab view positioning circle-matched --axis y --targets 7 --runs 5

`motionlab docs views` defines every figure.
"""
_POSITIONING = "positioning"
_CYCLE = ("axis", "targets", "runs", "dwell", "low", "high", "instrument")


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
    told += f"; {_POSITIONING}: Accuracy and repeatability at targets, ISO 230-2 style"
    parser.add_argument("view", metavar="VIEW", choices=[*BY_NAME, _POSITIONING], help=told)
    parser.add_argument(
        "scenario",
        metavar="RUN|SCENARIO",
        nargs="?",
        default="circle",
        help="identifier or name of a kept run, path of a .toml file, - for stdin, or a shipped "
        "scenario (default: %(default)s)",
    )
    parser.add_argument("--from", dest="start", metavar="S", type=float, help="begin, s")
    parser.add_argument("--to", dest="end", metavar="S", type=float, help="end, s")
    add_set(parser, "change a field of the scenario (repeatable)")
    add_json(parser)
    cycle = parser.add_argument_group(_POSITIONING, "the test cycle of a scenario, and its reading")
    cycle.add_argument("--axis", choices=["x", "y"], help="which axis, default x")
    cycle.add_argument("--targets", metavar="N", type=int, help="targets, default 5")
    cycle.add_argument("--runs", metavar="N", type=int, help="runs each way, default 5")
    cycle.add_argument("--dwell", metavar="S", type=float, help="rest at each, s, default 0.5")
    cycle.add_argument("--low", metavar="M", type=float, help="first target, m")
    cycle.add_argument("--high", metavar="M", type=float, help="last target, m")
    cycle.add_argument("--instrument", choices=["true", "encoder"], help="default true")
    parser.set_defaults(command=_view)


def _view(options: argparse.Namespace) -> int:
    asked = {name: getattr(options, name) for name in _CYCLE}
    given = {name: value for name, value in asked.items() if value is not None}
    if options.view == _POSITIONING:
        found, lines = _positioning(options, given)
    elif given:
        told = f"is of the view {_POSITIONING}"
        raise ConfigError(*(FieldError(f"--{name}", told, given[name]) for name in given))
    else:
        view = BY_NAME[options.view]
        found = view.compute(_recorded(options, window=view.window))
        lines = view.report(found)
    if options.json:
        print(json.dumps(found.model_dump(mode="json")))
    else:
        show("\n".join(lines))
    return DONE


def _positioning(
    options: argparse.Namespace, given: dict[str, Any]
) -> tuple[Positioning, list[str]]:
    from motionlab.analysis.views.positioning import PositioningCycle, cycled, positioning, report
    from motionlab.config.changes import parse_assignments
    from motionlab.config.load import load_scenario
    from motionlab.config.validation_errors import checked
    from motionlab.library.recorded import of_recording
    from motionlab.simulation.prepare import prepare
    from motionlab.simulation.run import run

    asked = checked(PositioningCycle, given, _POSITIONING)
    if names_run(options.scenario):
        found = positioning(_recorded(options, window=False), asked, simulated=False)
        return found, report(found)
    for name, time in (("--from", options.start), ("--to", options.end)):
        if time is not None:
            raise ConfigError(FieldError(name, "is of a run; a cycle is measured whole", time))
    scenario = load_scenario(source(options), parse_assignments(options.assignments))
    prepared = prepare(cycled(scenario, asked))
    recorded = of_recording(run(prepared), prepared, 0, prepared.reference.ticks)
    found = positioning(recorded, asked, simulated=True)
    return found, report(found)


def _recorded(options: argparse.Namespace, *, window: bool) -> Recorded:
    from motionlab.config.changes import parse_assignments
    from motionlab.config.load import load_scenario
    from motionlab.library.library import library
    from motionlab.library.recorded import of_run, of_scenario
    from motionlab.simulation.prepare import prepare

    if names_run(options.scenario):
        if options.assignments:
            told = "changes a scenario; a kept run is as it was"
            raise ConfigError(FieldError("--set", told, options.assignments[0]))
        run_id = library().named(options.scenario)
        return of_run(run_id, options.start, options.end, window=window)
    scenario = load_scenario(source(options), parse_assignments(options.assignments))
    return of_scenario(prepare(scenario), options.start, options.end, window=window)
