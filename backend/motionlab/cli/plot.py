"""The command ``motionlab plot``: channels of a run as a figure."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motionlab.cli.output import add_overwrite, check_output, names_run, wrote
from motionlab.errors import DONE, ConfigError, FieldError
from motionlab.studies.options import add_set, source

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from motionlab.scripting.figure import Curve

EXAMPLES = """\
examples:
  motionlab plot circle --out errors.png
  motionlab plot run.parquet B.x.following_error B.x.thrust --from 4.5 --to 6 --out part.svg
  motionlab plot r-gpd6hecc7x3n x.position_reference B.x.position --out x.pdf

`motionlab docs recording` lists the channels.
"""
_SUFFIXES = (".png", ".svg", ".pdf")


def add(commands: Any) -> None:
    """Add ``motionlab plot``."""
    parser = commands.add_parser(
        "plot",
        help="draw channels of a run over time, as PNG, SVG or PDF",
        description="Draw channels of a run over time, a panel for each unit and axis. It needs "
        "matplotlib: pip install matplotlib.",
        epilog=EXAMPLES,
    )
    parser.add_argument(
        "scenario",
        metavar="SCENARIO|RUN",
        help="scenario to run; or a kept run, or a file of motionlab run --out",
    )
    parser.add_argument(
        "channels",
        metavar="CHANNEL",
        nargs="*",
        help="such as B.x.following_error (default: the following errors)",
    )
    parser.add_argument("--out", metavar="FIG", required=True, help="file: .png, .svg or .pdf")
    add_overwrite(parser)
    parser.add_argument(
        "--from", dest="start", metavar="S", type=float, help="first time, s (default: the first)"
    )
    parser.add_argument(
        "--to", dest="end", metavar="S", type=float, help="last time, s (default: the last)"
    )
    add_set(parser, "change a field of the scenario (repeatable, all applied together)")
    parser.set_defaults(command=_plot)


def _plot(options: argparse.Namespace) -> int:
    check_output(options.out, *_SUFFIXES, overwrite=options.overwrite)
    import numpy as np

    from motionlab.files import complete_file
    from motionlab.scripting.figure import figure_of

    time, curves = _curves(options)
    begin = -np.inf if options.start is None else options.start
    shown = (time >= begin) & (time <= (np.inf if options.end is None else options.end))
    if np.count_nonzero(shown) < 2:
        allowed = f"{time[0]:g} to {time[-1]:g} s"
        raise ConfigError(FieldError("--from", "leaves nothing to draw", options.start, allowed))
    part = [each._replace(values=each.values[shown]) for each in curves]
    figure = figure_of(time[shown], part, options.scenario)
    with complete_file(options.out) as partial:
        figure.savefig(partial, format=Path(options.out).suffix[1:], dpi=150)
    wrote(options.out)
    return DONE


def _curves(options: argparse.Namespace) -> tuple[NDArray[np.float64], list[Curve]]:
    """Return times, s, and the channels of a kept run, a file, or a scenario that is run."""
    import numpy as np

    from motionlab.scripting.figure import Curve
    from motionlab.telemetry.recorder import SUFFIXES

    name: str = options.scenario
    if name.endswith(SUFFIXES) or names_run(name):
        from motionlab.library.columns import of_file_or_run

        if options.assignments:
            message = "changes a scenario; a run is as it was"
            raise ConfigError(FieldError("--set", message, options.assignments[0]))
        columns = of_file_or_run(name)
        names = _channels_of(options.channels, list(columns.units))
        values = columns.read(names)
        time = columns.grid.first + columns.grid.period * np.arange(
            columns.grid.ticks, dtype=np.float64
        )
        units = columns.units
        return time, [Curve(n, units[n], v) for n, v in zip(names, values, strict=True)]
    return _simulated(options)


def _simulated(options: argparse.Namespace) -> tuple[NDArray[np.float64], list[Curve]]:
    import numpy as np

    from motionlab.config.changes import parse_assignments
    from motionlab.scripting.figure import Curve
    from motionlab.scripting.local import Local

    run = Local().run(source(options), parse_assignments(options.assignments))
    names = _channels_of(options.channels, list(run))
    curves = [Curve(name, run[name].unit, np.asarray(run[name])) for name in names]
    return np.asarray(run.time), curves


def _channels_of(channels: Sequence[str], known: list[str]) -> list[str]:
    """Return the channels to draw.

    Raises
    ------
    ConfigError
        If there is none of a name.
    """
    from motionlab.config.named_configs import did_you_mean

    if not channels:
        return [name for name in known if name.endswith(".following_error")] or known[:1]
    wrong = [
        FieldError(
            "CHANNEL",
            f"no such channel{did_you_mean(name, known)}",
            name,
            f"one of {len(known)}, such as {known[-1]}; `motionlab docs recording` lists them",
        )
        for name in channels
        if name not in known
    ]
    if wrong:
        raise ConfigError(*wrong)
    return list(channels)
