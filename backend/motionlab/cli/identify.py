"""The command ``motionlab identify``."""

from __future__ import annotations

import argparse
import json
from typing import Any

from motionlab.cli.exit_codes import DONE
from motionlab.cli.options import add_json, add_scenario, add_set, given, source
from motionlab.cli.progress import share_done

EXAMPLES = """\
examples:
  motionlab identify
  motionlab identify circle --set plant=as-measured --axis x --json
  motionlab identify --set plant=matched --compare
  motionlab identify --speeds 0.001 0.003 0.01 0.03 0.1 --out points.csv
  motionlab identify --axis y --time-max 5 --rates 50 100 --places 5

Speeds are in m/s, each run both ways; forces come out in the newtons of the controller's command.
"""


def add(commands: Any) -> None:
    """Add ``motionlab identify``."""
    parser = commands.add_parser(
        "identify",
        help="identify a motor's friction",
        description="Identify friction as the paper does: uniform motions at many speeds for "
        "F_c, F_s, v_s and sigma_2, open-loop force ramps for sigma_0 and sigma_1.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_scenario(parser, "whose motor and gains: ")
    add_set(parser, "change a field of the scenario (repeatable, all applied together)")
    parser.add_argument(
        "--axis", choices=("x", "y", "both"), default="both", help="which axis (%(default)s)"
    )
    parser.add_argument(
        "--speeds", metavar="V", type=float, nargs="+", help="speeds, m/s (32 from 0.0005 to 0.15)"
    )
    parser.add_argument(
        "--time-max",
        metavar="S",
        type=float,
        help="time after which a motion takes no further pole pitch, s (20)",
    )
    parser.add_argument(
        "--pitches-max",
        metavar="N",
        type=int,
        help="most pole pitches that a force is averaged over (as many as time and stroke allow)",
    )
    parser.add_argument(
        "--no-presliding",
        dest="presliding",
        action="store_false",
        help="no force ramps: sigma_0 and sigma_1 are not identified",
    )
    parser.add_argument(
        "--rates", metavar="N/S", type=float, nargs="+", help="rates of the force ramps (20 50 100)"
    )
    parser.add_argument(
        "--share",
        type=float,
        help="largest force of a ramp, as a share of the stiction (0.5)",
    )
    parser.add_argument(
        "--places", type=int, help="places in a pole pitch at which ramps are repeated (7)"
    )
    parser.add_argument(
        "--variant", metavar="NAME", help="whose gains and force map drive the motor (the first)"
    )
    parser.add_argument(
        "--apply-to", metavar="NAME", help="whose model the result is for (the second)"
    )
    parser.add_argument(
        "--compare",
        action="store_true",
        help="run the circle with the old friction model (A) and the one identified (B)",
    )
    parser.add_argument(
        "--out", metavar="FILE", help="write the points to FILE.csv, or the document to FILE.json"
    )
    add_json(parser)
    parser.set_defaults(command=_identify)


def _identify(options: argparse.Namespace) -> int:
    """Carry out ``motionlab identify``."""
    from motionlab.config.changes import parse_assignments
    from motionlab.studies.identify.experiment import identify
    from motionlab.studies.identify.plan import plan
    from motionlab.studies.identify.report import check_target, report, write
    from motionlab.studies.identify.request import read_request

    request: dict[str, Any] = {
        "scenario": options.scenario,
        "set": parse_assignments(options.assignments),
        "axis": options.axis,
        "compare": options.compare,
        "variant": options.variant,
        "apply_to": options.apply_to,
        "presliding": {"enabled": options.presliding} | given(options, "rates", "share", "places"),
    } | given(options, "speeds", "time_max", "pitches_max")
    checked = read_request(request)
    experiment = plan(checked, source(options))
    if options.out is not None:
        check_target(options.out)
    with share_done("identification") as progress:
        found = identify(experiment, lambda share, _: progress(share))
    if options.out is not None:
        write(found, options.out)
    if options.json:
        print(json.dumps(found.model_dump(), allow_nan=False))
    else:
        print(report(found))
    return DONE
