"""The command ``motionlab compare``."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any, get_args

from motionlab.cli.output import show
from motionlab.errors import DONE, FAILED
from motionlab.studies.options import add_json

if TYPE_CHECKING:
    from motionlab.analysis.comparison_document import ChannelComparison, Comparison
    from motionlab.analysis.comparison_options import Comparing

EXAMPLES = """\
examples:
  motionlab compare r-gpd6hecc7x3n r-cb3v3zvyllhu
  motionlab compare baseline.parquet candidate.csv --exact
  motionlab compare baseline.parquet candidate.csv --only '*' --tolerance 1e-9,1e-6
  motionlab compare a.parquet b.parquet --tolerance '*.following_error=2e-6,0' --only '*_error'
  motionlab compare a.parquet b.parquet --align reference --time-tolerance 0.002
  motionlab compare a.parquet b.parquet --from 0.5 --to 10
  motionlab compare r-gpd6hecc7x3n measured.parquet --variant M=B

The exit code is 1 if a channel is beyond its tolerance or could not be compared;
`motionlab docs runs-compare`.
"""


def add(commands: Any) -> None:
    """Add ``motionlab compare``."""
    parser = commands.add_parser(
        "compare",
        help="compare two runs, channel by channel",
        description="Compare channels of run B with those of run A, the baseline: the following "
        "errors, forces and currents, within tolerances that follow from range, noise and encoder.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    for name, what in (("a", "baseline"), ("b", "candidate")):
        parser.add_argument(
            name,
            metavar=name.upper(),
            help=f"{what}: identifier or name of a run, or telemetry, .parquet or .csv",
        )
    add_comparing(parser)
    parser.add_argument(
        "--all", action="store_true", help="list equal channels too, not only how many they are"
    )
    add_json(parser)
    parser.set_defaults(command=_compare)


def add_comparing(parser: argparse.ArgumentParser) -> None:
    """Add the options that say how two runs are compared."""
    parser.add_argument(
        "--align",
        choices=("time", "reference", "index"),
        default="time",
        help="reference: by lap and arc length of the position reference (default: %(default)s)",
    )
    parser.add_argument(
        "--offset", metavar="S", type=float, default=0.0, help="with time: move B by so much, s"
    )
    parser.add_argument(
        "--from",
        dest="start",
        metavar="S",
        type=float,
        help="first time of A, s (default: the overlap)",
    )
    parser.add_argument(
        "--to", dest="end", metavar="S", type=float, help="last time of A, s (default: the overlap)"
    )
    parser.add_argument(
        "--samples",
        choices=("union", "intersection"),
        default="union",
        help="compare at the samples of either run, or only at those of both "
        "(default: %(default)s)",
    )
    parser.add_argument(
        "--tolerance",
        metavar="[CHANNEL=]ABS,REL[,S]",
        action="append",
        default=[],
        help="max(ABS, REL |baseline|) in SI, and a tolerance in time, of all channels or of those "
        "that fit a name such as '*.following_error' (repeatable; default: 2 %% of the baseline's "
        "range, six times its noise and an encoder count; 1 ms)",
    )
    parser.add_argument(
        "--exact",
        action="store_true",
        help="every channel, and equal values where no tolerance is given",
    )
    parser.add_argument(
        "--time-tolerance",
        metavar="S",
        type=float,
        help="time by which a value may come earlier or later, s (default: 1 ms without a "
        "tolerance, else none)",
    )
    parser.add_argument(
        "--interpolation",
        metavar="CHANNEL=HOW",
        action="append",
        default=[],
        help="linear or hold between samples of channels that fit a name (repeatable; hold for "
        "flags and commands, otherwise linear)",
    )
    parser.add_argument(
        "--only",
        metavar="CHANNEL",
        action="append",
        default=[],
        help="compare these, '*' all (repeatable; default: eight at most that tell how the motion "
        "was)",
    )
    parser.add_argument(
        "--variant",
        metavar="B=A",
        action="append",
        default=[],
        help="compare a variant of B with that of A, such as M=B: a measurement with variant B of "
        "a simulation (repeatable; letters as they are)",
    )


def _compare(options: argparse.Namespace) -> int:
    from motionlab.analysis.run_comparison import compare
    from motionlab.library.columns import of_file_or_run

    how = comparing_of(options)
    comparison = compare(of_file_or_run(options.a), of_file_or_run(options.b), how)
    if options.json:
        print(json.dumps(comparison.model_dump(mode="json"), allow_nan=False))
    else:
        show(_report(comparison, every=options.all))
    return DONE if comparison.holds else FAILED


def comparing_of(options: argparse.Namespace) -> Comparing:
    """Return what the options of `add_comparing` say.

    Raises
    ------
    ConfigError
        If a tolerance is none.
    """
    from pydantic import ValidationError

    from motionlab.analysis.comparison_options import Comparing, Interpolation
    from motionlab.config.validation_errors import field_errors
    from motionlab.errors import ConfigError, FieldError

    every: dict[str, float] = {}
    if options.time_tolerance is not None:
        every["time"] = options.time_tolerance
    channels: dict[str, dict[str, Any]] = {}
    for text in options.tolerance:
        name, equals, numbers = text.rpartition("=")
        if equals:
            channels.setdefault(name, {}).update(_tolerance(numbers, text))
        else:
            every |= _tolerance(numbers, text)
    for text in options.interpolation:
        name, equals, how = text.rpartition("=")
        if not equals or how not in get_args(Interpolation):
            allowed = "CHANNEL=linear or CHANNEL=hold"
            raise ConfigError(FieldError("--interpolation", "is no interpolation", text, allowed))
        channels.setdefault(name, {})["interpolation"] = how
    variants: dict[str, str] = {}
    for text in options.variant:
        letter, equals, target = text.partition("=")
        if not equals or letter in variants:
            message = "says the same variant twice" if equals else "is no pair of letters"
            raise ConfigError(FieldError("--variant", message, text, "letters such as M=B"))
        variants[letter] = target
    try:
        return Comparing.model_validate(
            {
                "align": options.align,
                "offset": options.offset,
                "samples": options.samples,
                "start": options.start,
                "end": options.end,
                "tolerance": every or None,
                "exact": options.exact,
                "channels": channels,
                "only": options.only,
                "variants": variants,
            }
        )
    except ValidationError as error:
        raise ConfigError(*field_errors(error, Comparing)) from None


def _tolerance(numbers: str, text: str) -> dict[str, float]:
    from motionlab.errors import ConfigError, FieldError

    try:
        limits = [float(number) for number in numbers.split(",")]
        names = ("absolute", "relative", "time")[: max(2, len(limits))]
        return dict(zip(names, limits, strict=True))
    except ValueError:
        allowed = "ABS,REL or CHANNEL=ABS,REL, each with ,S"
        raise ConfigError(FieldError("--tolerance", "is no tolerance", text, allowed)) from None


def _report(comparison: Comparison, *, every: bool) -> str:
    from motionlab.reports.tables import table

    heads = ("channel", "verdict", "largest", "rms", "unit", "beyond", "at")
    overlap = comparison.note
    if comparison.start is not None and comparison.end is not None:
        start, end = comparison.start.time, comparison.end.time
        overlap = f"{comparison.instants} instants from {start:.4f} s to {end:.4f} s"
        overlap += f" of {comparison.a.name}"
    listed = [
        channel
        for channel in comparison.channels
        if every or channel.verdict != "within" or channel.largest != 0.0
    ]
    lines = [table(heads, map(_row, listed)), ""] if listed else []
    if equal := len(comparison.channels) - len(listed):
        some = "1 channel is" if equal == 1 else f"{equal} channels are"
        lines.append(f"{some} equal; --all lists them")
    return "\n".join([*lines, f"{comparison.headline}; {overlap}"])


def _row(channel: ChannelComparison) -> tuple[str, ...]:
    unit = channel.unit or channel.candidate_unit or ""
    if channel.verdict == "units-differ":
        unit = f"{channel.unit or '?'} and {channel.candidate_unit or '?'}"
    largest = rms = beyond = at = ""
    if channel.largest is not None and channel.rms is not None and channel.at is not None:
        largest, rms = f"{channel.largest:.4g}", f"{channel.rms:.4g}"
        at = f"{channel.at.time:.4f} s"
        if channel.at.arc is not None:
            at += f", lap {channel.at.lap}, {channel.at.arc:.6g} m"
    if channel.beyond is not None:
        beyond = f"{100 * channel.beyond:.3g} %"
    return channel.name, channel.verdict, largest, rms, unit, beyond, at
