"""The command ``motionlab run``."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from motionlab.cli.exit_codes import DONE, FAILED
from motionlab.config.shipped import names
from motionlab.progress import tick_bar
from motionlab.studies.options import add_json, add_set, source

EXAMPLES = """\
examples:
  motionlab run circle
  motionlab run circle --json
  motionlab run circle --set variants.B.controller.x.k_p=312000 --set seed=7
  motionlab run circle --set plant=matched --set trajectory=rhombus
  motionlab run my-scenario.toml --out run.parquet
  motionlab run circle --keep --name 'first try'

Values are SI (k_p in N/m, k_d in N s/m, lengths in m); docs/scenarios.md lists the fields.
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
    parser.add_argument(
        "scenario",
        metavar="SCENARIO",
        help="path of a .toml file, or a shipped scenario: " + ", ".join(names("scenarios")),
    )
    add_set(
        parser,
        "change a field (repeatable, all applied together); a part can be swapped for a "
        "shipped one by name, as in --set plant=matched",
    )
    parser.add_argument(
        "--out", metavar="FILE", help="write every channel to FILE, .parquet or .csv"
    )
    parser.add_argument("--keep", action="store_true", help="keep it as a run; docs/runs.md")
    parser.add_argument("--name", metavar="TEXT", default="", help="what the kept run is called")
    add_json(parser)
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> int:
    """Carry out ``motionlab run``."""
    from motionlab.config.changes import parse_assignments
    from motionlab.config.load import load_scenario
    from motionlab.simulation.prepare import prepare
    from motionlab.simulation.result import document, metadata
    from motionlab.simulation.run import run
    from motionlab.store.files import check_target
    from motionlab.telemetry.recorder import SUFFIXES, write

    scenario = load_scenario(source(options), parse_assignments(options.assignments))
    if options.out is not None:
        check_target(options.out, *SUFFIXES)
    prepared = prepare(scenario)
    with tick_bar(prepared.reference.ticks) as progress:
        recording = run(prepared, progress)
    result = document(prepared, recording)
    if options.out is not None:
        write(recording, options.out, metadata=metadata(prepared.scenario))
    if options.keep:
        from motionlab.config.shipped import data_root
        from motionlab.runs.files import runs_url
        from motionlab.runs.library import library

        result["run"] = library().keep(prepared, recording, result, name=options.name).id
        print(f"kept as {result['run']} in {runs_url(data_root())}", file=sys.stderr)
    if options.json:
        print(json.dumps(result, allow_nan=False))
    else:
        from motionlab.results.report import report

        print(report(result))
    diverged = [name for name, variant in result["variants"].items() if variant["diverged"]]
    for name in diverged:
        where = result["variants"][name]["diverged"]
        print(
            f"motionlab: variant {name} diverged at t = {where['time']:.4f} s: {where['channel']}",
            file=sys.stderr,
        )
    return FAILED if diverged else DONE
