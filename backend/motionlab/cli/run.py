"""The command ``motionlab run``."""

from __future__ import annotations

import argparse
import importlib
import json
import sys
from typing import TYPE_CHECKING, Any

from motionlab.cli.messages import say
from motionlab.cli.output import add_overwrite, check_output, show, wrote
from motionlab.config.named_configs import names
from motionlab.errors import DONE, FAILED
from motionlab.executors.progress import tick_bar
from motionlab.studies.options import add_json, add_scenario, add_set, source

if TYPE_CHECKING:
    from motionlab.config.scenario import Scenario
    from motionlab.simulation.prepare import Prepared

EXAMPLES = """\
examples:
  motionlab run circle
  motionlab run circle --json
  motionlab run circle --set variants.B.controller.x.k_p=312000 --set seed=7
  motionlab run circle --set plant=matched --set trajectory=rhombus
  motionlab run my-scenario.toml --out run.parquet
  motionlab run circle --keep --name 'first try'

Values are SI (k_p in N/m, k_d in N s/m, lengths in m); `motionlab docs scenarios` lists the fields.
"""


def add(commands: Any) -> None:
    """Add ``motionlab run``."""
    parser = commands.add_parser(
        "run",
        help="run a scenario and compare its controllers",
        description="Run a scenario on the simulated motor, all variants on the same noise, and "
        "compare the controllers.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_scenario(parser, shipped=", ".join(names("scenarios")))
    add_set(
        parser,
        "change a field (repeatable, all applied together); a part can be swapped for a "
        "shipped one by name, as in --set plant=matched",
    )
    parser.add_argument(
        "--out", metavar="FILE", help="write every channel to FILE, .parquet or .csv"
    )
    add_overwrite(parser)
    parser.add_argument(
        "--keep", action="store_true", help="keep it as a run; `motionlab docs runs`"
    )
    parser.add_argument(
        "--name", metavar="TEXT", default="", help="what the kept run is called; with --keep"
    )
    add_json(parser)
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> int:
    """Carry out ``motionlab run``."""
    from motionlab.config.changes import parse_assignments
    from motionlab.config.load import load_scenario
    from motionlab.simulation.result import document, metadata
    from motionlab.simulation.run import run
    from motionlab.telemetry.recorder import SUFFIXES, write

    if options.name:
        _check_name(options)
    scenario = load_scenario(source(options), parse_assignments(options.assignments))
    if options.out is not None:
        check_output(options.out, *SUFFIXES, overwrite=options.overwrite)
        importlib.import_module("pyarrow")  # may be missing, which a long run should not end with
    kept_runs = None
    if options.keep:
        from motionlab.library.library import library

        kept_runs = library()
    prepared = _prepared(scenario)
    with tick_bar(prepared.reference.ticks) as progress:
        recording = run(prepared, progress)
    result = document(prepared, recording)
    if options.out is not None:
        write(recording, options.out, metadata=metadata(prepared.scenario))
        wrote(options.out)
    if kept_runs is not None:
        from motionlab.config.named_configs import data_root
        from motionlab.library.files import runs_url

        result["run"] = kept_runs.keep(prepared, recording, result, name=options.name).id
        say(f"kept as {result['run']} in {runs_url(data_root())}")
    if options.json:
        print(json.dumps(result, allow_nan=False))
    else:
        from motionlab.reports.result_text import report

        show(report(result))
    if options.json or not sys.stdout.isatty():  # on a terminal they stand below the table
        for name, variant in result["variants"].items():
            for note in variant["notes"]:
                print(f"motionlab: variant {name}: {note}", file=sys.stderr)
    return FAILED if any(each["diverged"] for each in result["variants"].values()) else DONE


def _check_name(options: argparse.Namespace) -> None:
    from motionlab.errors import ConfigError, FieldError
    from motionlab.library.run import check_name

    if not options.keep:
        raise ConfigError(FieldError("--name", "needs --keep: it names a kept run", options.name))
    check_name(options.name, "--name")


def _prepared(scenario: Scenario) -> Prepared:
    """Return a scenario ready to run; one that cannot be followed is refused with the remedy."""
    from motionlab.cli.check import slower
    from motionlab.errors import Infeasible
    from motionlab.simulation.prepare import prepare

    try:
        return prepare(scenario)
    except Infeasible as error:
        remedy = slower(scenario)
        if remedy is not None:
            error.args = (f"{error}\n{remedy}",)
        raise
