"""The command ``motionlab trajectory``: trajectories from and to files of other programs."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motionlab.cli.output import add_overwrite, check_output, wrote
from motionlab.errors import DONE

if TYPE_CHECKING:
    from motionlab.config.trajectory import TrajectoryConfig

EXAMPLES = """\
examples:
  motionlab trajectory import square.ngc square.toml
  motionlab trajectory import drawing.svg --placement fit
  motionlab trajectory import recorded.csv recorded.toml --samples
  motionlab trajectory import r-7kq2m9x4tz01 recorded.toml
  motionlab trajectory export square.toml square.svg
  motionlab trajectory export circle circle.csv --points

`motionlab docs trajectories` describes the formats.
"""


def add(commands: Any) -> None:
    """Add ``motionlab trajectory``."""
    parser = commands.add_parser(
        "trajectory",
        help="read or write a trajectory as CSV, SVG or G-code",
        description="Read a trajectory from a file of another program, or write one.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parts = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    reader = parts.add_parser(
        "import",
        help="read CSV, SVG, G-code, text, samples or a kept run",
        description="Read a trajectory. NumPy and Parquet files, kept runs and, with --samples, "
        "CSV become a motion of kind samples, which keeps its times.",
    )
    reader.add_argument(
        "file", metavar="FILE|RUN", help="the file, .npy and .parquet too, or a kept run"
    )
    reader.add_argument(
        "target", metavar="TOML", nargs="?", help="file to write (default: print it)"
    )
    reader.add_argument(
        "--format", choices=("csv", "svg", "gcode", "text"), help="(default: found out)"
    )
    reader.add_argument(
        "--unit",
        choices=("m", "cm", "mm", "um", "nm", "in"),
        default="mm",
        help="of lengths in CSV that name none (default: %(default)s)",
    )
    reader.add_argument(
        "--scale",
        type=_number("--scale", 1e-6, 1e6),
        default=1.0,
        help="factor on all lengths (default: 1)",
    )
    reader.add_argument(
        "--tolerance",
        type=_number("--tolerance", 1e-7, 1e-3),
        default=5e-6,
        metavar="M",
        help="largest distance of the path from the file, m (default: %(default)s)",
    )
    reader.add_argument(
        "--placement",
        choices=("file", "centre", "fit"),
        default="file",
        help="as in the file, its middle at mid-stroke, or scaled to fit the stroke too "
        "(default: %(default)s)",
    )
    reader.add_argument(
        "--height",
        type=_number("--height", 1e-4, 1.0),
        default=0.01,
        metavar="M",
        help="of capitals of a text, m (default: %(default)s)",
    )
    reader.add_argument(
        "--samples", action="store_true", help="keep the times of a CSV with a time column"
    )
    add_overwrite(reader)
    reader.set_defaults(command=_import)
    writer = parts.add_parser(
        "export", help="write CSV, SVG or G-code", description="Write a trajectory."
    )
    writer.add_argument("source", metavar="SOURCE", help="a shipped or saved name, or a TOML file")
    writer.add_argument("file", metavar="FILE", help="file to write: .csv, .svg or .ngc")
    writer.add_argument(
        "--points", action="store_true", help="CSV of the points, not of every tick"
    )
    add_overwrite(writer)
    writer.set_defaults(command=_export)


def _number(option: str, least: float, most: float) -> Any:
    from motionlab.errors import ConfigError, FieldError

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        if not least <= value <= most:
            raise ConfigError(
                FieldError(option, "must be a number", text, f"{least:g} to {most:g}")
            )
        return value

    return read


def _import(options: argparse.Namespace) -> int:
    from motionlab.exchange.paths.reading import (
        SAMPLES_BYTES_MAX,
        ReadOptions,
        read_trajectory,
    )
    from motionlab.exchange.paths.samples import SUFFIXES

    path = Path(options.file)
    if options.target is not None:
        check_output(options.target, ".toml", overwrite=options.overwrite, loc="TOML")
    if path.suffix in SUFFIXES or not path.is_file():
        return _import_samples(options)
    reading = ReadOptions(
        format=options.format,
        unit=options.unit,
        scale=options.scale,
        tolerance=options.tolerance,
        placement=options.placement,
        height=options.height,
        samples=options.samples,
    )
    with path.open("rb") as file:
        imported = read_trajectory(file.read(SAMPLES_BYTES_MAX + 1), reading, name=path.name)
    _write(options, imported.trajectory)
    if options.samples:
        print(f"csv: {imported.read}", *imported.notes, sep="\n", file=sys.stderr)
        return DONE
    print(
        f"{imported.format}: {imported.read}; a path of {imported.points} points and "
        f"{imported.corners} corners, at most {imported.deviation * 1e6:.3g} um away",
        *imported.notes,
        sep="\n",
        file=sys.stderr,
    )
    return DONE


def _import_samples(options: argparse.Namespace) -> int:
    """Write the motion of an array or of a kept run."""
    from motionlab.config.load import validate_trajectory
    from motionlab.errors import ConfigError, FieldError
    from motionlab.exchange.paths.samples import table_of_file
    from motionlab.exchange.run_motion import motion_of_run

    path = Path(options.file)
    if path.is_file():
        table = table_of_file(path, options.unit, "FILE")
    else:
        try:
            table = motion_of_run(options.file, "FILE")
        except ConfigError as error:
            if path.suffix:
                raise ConfigError(FieldError("FILE", "is no file", options.file)) from None
            raise error
    _write(options, validate_trajectory(table))
    seconds = table["time"][-1] - table["time"][0]
    print(f"{len(table['time'])} samples over {seconds:.6g} s", file=sys.stderr)
    return DONE


def _write(options: argparse.Namespace, trajectory: TrajectoryConfig) -> None:
    import tomli_w

    from motionlab.files import replace

    text = tomli_w.dumps(trajectory.model_dump(mode="json", exclude_none=True))
    if options.target is None:
        print(text, end="")
    else:
        replace(Path(options.target), text.encode())
        wrote(options.target)


def _export(options: argparse.Namespace) -> int:
    from motionlab.config.load import validate_trajectory
    from motionlab.exchange.paths.writing import write_trajectory
    from motionlab.files import replace
    from motionlab.library.trajectories import trajectory_table

    check_output(options.file, ".csv", ".svg", ".ngc", overwrite=options.overwrite, loc="FILE")
    table = trajectory_table(options.source, "SOURCE")
    ending = Path(options.file).suffix
    csv = "points" if options.points else "csv"
    format = {".csv": csv, ".svg": "svg", ".ngc": "gcode"}[ending]
    text = write_trajectory(validate_trajectory(table), format)  # pyright: ignore[reportArgumentType]
    replace(Path(options.file), text.encode())
    wrote(options.file)
    return DONE
