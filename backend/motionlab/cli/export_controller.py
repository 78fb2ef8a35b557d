"""The command ``motionlab export-controller``."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motionlab.cli.output import add_overwrite, check_output, wrote
from motionlab.errors import DONE, ConfigError, FieldError
from motionlab.studies.options import add_scenario, add_set, source

if TYPE_CHECKING:
    from motionlab.config.scenario import Scenario

EXAMPLES = """\
examples:
  motionlab export-controller circle -o controller --variant B
  motionlab export-controller tuned.toml -o controller
  motionlab export-controller circle -o controller.fmu --variant B
  make -C controller check

`motionlab docs export-controller` says what is in the folder, `motionlab docs fmu` what is in the
FMU, and how to close a loop of it and the motor.
"""


def add(commands: Any) -> None:
    """Add ``motionlab export-controller``."""
    parser = commands.add_parser(
        "export-controller",
        help="write a controller as C99 for real-time targets, or as an FMU",
        description="Write the controller of a scenario's variant as portable C99, with test "
        "vectors from its simulation and a program that compares both; or as an FMU 3.0 for "
        "co-simulation.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_scenario(parser)
    parser.add_argument(
        "-o",
        "--out",
        metavar="PATH",
        required=True,
        help="a folder: new, empty, or of a former export, whose files are replaced; or a file "
        "whose name ends in .fmu, for a co-simulation unit of FMI 3.0",
    )
    parser.add_argument(
        "--variant", metavar="NAME", default="A", help="which controller (default: %(default)s)"
    )
    parser.add_argument(
        "--seconds",
        metavar="S",
        type=float,
        help="longest test vectors of a folder (default: 10, or all of a shorter scenario)",
    )
    add_overwrite(parser)
    add_set(parser, "change a field of the scenario (repeatable), as in motionlab run")
    parser.set_defaults(command=_export)


def _export(options: argparse.Namespace) -> int:
    from motionlab.config.changes import parse_assignments
    from motionlab.config.load import load_scenario
    from motionlab.export.export import VECTOR_TIME, export_controller

    scenario = load_scenario(source(options), parse_assignments(options.assignments))
    if options.out.lower().endswith(".fmu"):
        return _export_fmu(scenario, options)
    seconds = VECTOR_TIME if options.seconds is None else options.seconds
    done = export_controller(scenario, options.variant, Path(options.out), seconds=seconds)
    print(
        f"variant {options.variant} of {scenario.name}, test vectors of {done.seconds:g} s; "
        f"to check: make -C {shlex.quote(options.out)} check"
    )
    return DONE


def _export_fmu(scenario: Scenario, options: argparse.Namespace) -> int:
    from motionlab.export.controller_fmu import export_controller_fmu

    if options.seconds is not None:
        raise ConfigError(
            FieldError("--seconds", "is for a folder: an FMU has no test vectors", options.seconds)
        )
    check_output(options.out, ".fmu", overwrite=options.overwrite)
    done = export_controller_fmu(scenario, options.variant, Path(options.out))
    wrote(options.out)
    print(f"variant {options.variant} of {scenario.name}, {done.built}")
    return DONE
