"""Identification of friction by uniform motions and force ramps, or from a run."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from motionlab.errors import ConfigError, FieldError
from motionlab.studies.options import set_options
from motionlab.studies.record.options import add_columns, add_part
from motionlab.studies.study import RequestLimits, Study, StudyCommand, above, lazy

if TYPE_CHECKING:
    from motionlab.studies.identify.documents import IdentificationDocument
    from motionlab.studies.identify.experiment import AnyExperiment

_EXAMPLES = """\
examples:
  motionlab identify
  motionlab identify circle --set plant=as-measured --axis x --json
  motionlab identify --set plant=matched --compare
  motionlab identify --speeds 0.001 0.003 0.01 0.03 0.1 --out points.csv
  motionlab identify --axis y --time-max 5 --rates 50 100 --places 5

  motionlab identify --run r-abcdefghijkl --axis x --mass 5.9
  motionlab identify --run r-abcdefghijkl --motor rig-7
  motionlab identify --run r-abcdefghijkl --axis x --position-column Pos --force-column F --from 2

Speeds are in m/s, each run both ways; forces come out in the newtons of the controller's command.
"""
_COLUMNS = {"position": "position_column", "force": "force_column"}
_OF_RECORD = ("mass", "bandwidth", "start", "end")
_OF_A_RUN = {
    **{f"--{name}": name for name in ("motor", "mass", "bandwidth")},
    **{f"--{kind}-column": field for kind, field in _COLUMNS.items()},
    **{"--run-variant": "run_variant", "--from": "start", "--to": "end"},
}
"""Options that say something of a run, and where they are kept."""


class IdentifyStudy(Study):
    """Identify friction by uniform motions and force ramps on the simulated motor, or from a run.

    The job's report carries the points measured so far, and at the end what is fitted to them. With
    `run` a kept run is read instead, such as an imported measurement; nothing moves.
    """

    kind = "identify"
    path = "/identify"
    operation = "identify"
    tag = "identify"
    report_name = "IdentificationJob"
    request_model = lazy("studies.identify.documents:IdentifyRequest")
    document_model = lazy("studies.identify.documents:IdentificationDocument")
    partial_model = lazy("studies.identify.documents:PartialIdentification")
    planner = lazy("studies.identify.experiment:plan_identification")
    run = lazy("studies.identify.experiment:run_identification")
    suffixes = (".csv", ".json")
    write = lazy("studies.identify.results:write")
    bodies = (
        {"scenario": "circle", "set": {"plant": "as-measured"}, "axis": "x"},
        {"run": "r-abcdefghijkl", "axis": "x", "record": {"mass": 5.9}},
    )
    command = StudyCommand(
        name="identify",
        help="identify a motor's friction",
        description="Identify friction as the paper does: uniform motions at many speeds for "
        "F_c, F_s, v_s and sigma_2, open-loop force ramps for sigma_0 and sigma_1. With --run: "
        "from positions and forces or currents of a kept run, such as an imported measurement.",
        examples=_EXAMPLES,
        scenario="whose motor and gains: ",
        title="identification",
    )

    def excess(self, plan: AnyExperiment, bounds: RequestLimits) -> list[FieldError]:
        """Bound the simulated time of all motions."""
        message = "simulated time of all of them is too large for one request"
        return above(plan.seconds, bounds.work_max, loc="speeds", message=message)

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add axes, motions, force ramps, variants and the file to write."""
        parser.add_argument(
            "--axis",
            choices=("x", "y", "both"),
            default="both",
            help="which axis (default: %(default)s)",
        )
        parser.add_argument(
            "--speeds",
            metavar="V",
            type=float,
            nargs="+",
            help="speeds, m/s (default: 32 from 0.0005 to 0.15)",
        )
        parser.add_argument(
            "--time-max",
            metavar="S",
            type=float,
            help="time after which a motion takes no further pole pitch, s (default: 20)",
        )
        parser.add_argument(
            "--pitches-max",
            metavar="N",
            type=int,
            help="most pole pitches that a force is averaged over (default: all that time and "
            "stroke allow)",
        )
        parser.add_argument(
            "--no-presliding",
            dest="presliding",
            action="store_false",
            help="no force ramps: sigma_0 and sigma_1 are not identified",
        )
        parser.add_argument(
            "--rates",
            metavar="N/S",
            type=float,
            nargs="+",
            help="rates of the force ramps (default: 20 50 100)",
        )
        parser.add_argument(
            "--share",
            type=float,
            help="largest force of a ramp, as a share of the stiction (default: 0.5)",
        )
        parser.add_argument(
            "--places",
            type=int,
            help="places in a pole pitch at which ramps are repeated (default: 7)",
        )
        parser.add_argument(
            "--variant",
            metavar="NAME",
            help="whose gains and force map drive the motor (default: the first)",
        )
        parser.add_argument(
            "--apply-to", metavar="NAME", help="whose model the result is for (default: the second)"
        )
        parser.add_argument(
            "--compare",
            action="store_true",
            help="run the circle with the old friction model (A) and the one identified (B)",
        )
        parser.add_argument(
            "--out",
            metavar="FILE",
            help="write the points to FILE.csv, or the document to FILE.json",
        )

        record = parser.add_argument_group("from a run")
        record.add_argument(
            "--run", metavar="RUN", help="identifier or name of a kept run to identify from"
        )
        record.add_argument(
            "--motor",
            metavar="NAME",
            help="save the run's simulated motor with what was identified, as plant=NAME",
        )
        record.add_argument("--run-variant", metavar="NAME", help="variant of the run (its first)")
        add_columns(record, **_COLUMNS)
        record.add_argument(
            "--mass", metavar="KG", type=float, help="moving mass, kg (default: identified too)"
        )
        record.add_argument(
            "--bandwidth", metavar="HZ", type=float, help="of the filter, Hz (default: 50, or less)"
        )
        add_part(record)

    def after(self, result: IdentificationDocument, options: argparse.Namespace) -> None:
        """Write the file of ``--out``, and save the motor of ``--motor``."""
        super().after(result, options)
        if options.motor is None:
            return
        from motionlab.library.motors import Motors

        if result.motor is None:
            message = "there is none to save: it is fitted to a drive's run or to a measurement"
            raise ConfigError(FieldError("--motor", message, options.motor))
        Motors().put(options.motor, result.motor)

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the options."""
        if options.run is None:
            wrong = [
                FieldError(option, "is of a run: it needs --run", value)
                for option, name in _OF_A_RUN.items()
                if (value := getattr(options, name)) is not None
            ]
            if wrong:
                raise ConfigError(*wrong)
        else:
            from motionlab.library.library import library

            options.run = library().named(options.run, "--run")
        if options.motor is not None:
            from motionlab.library.motors import check_name

            check_name(options.motor)
        presliding = {"enabled": options.presliding} | set_options(
            options, "rates", "share", "places"
        )
        record = set_options(options, *_COLUMNS.values(), *_OF_RECORD)
        if options.run_variant is not None:
            record["variant"] = options.run_variant
        return (
            super().request_of(options, changes)
            | set_options(options, "run")
            | ({"record": record} if record else {})
            | set_options(options, "axis", "compare", "variant", "apply_to")
            | set_options(options, "speeds", "time_max", "pitches_max")
            | {"presliding": presliding}
        )
