"""The command line. Exit codes: 0 done, 1 the run failed, 2 bad input."""

from __future__ import annotations

import argparse
import io
import select
import sys
from collections.abc import Sequence

from motionlab import __version__
from motionlab.cli import (
    compare,
    drive,
    exchange,
    export_controller,
    export_plant,
    glitches,
    replay,
    report,
    run,
    runs,
    scenarios,
    serve,
    spectrum,
    study,
    trajectory,
    vdrive,
    view,
)
from motionlab.cli.exit_codes import BAD_INPUT, DONE, FAILED
from motionlab.cli.messages import discard, unbreakable_stderr
from motionlab.cli.parser import Parser
from motionlab.errors import ConfigError, Infeasible, MotionLabError

_COMMANDS = (
    run,
    scenarios,
    runs,
    compare,
    replay,
    glitches,
    spectrum,
    view,
    report,
    exchange,
    trajectory,
    export_controller,
    export_plant,
    study,
    serve,
    drive,
    vdrive,
)
"""In the order of the help page."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        What follows the program's name; ``sys.argv`` when left out.

    Returns
    -------
    int
        0 done, 1 the run failed, 2 bad input.
    """
    with unbreakable_stderr():
        return _carry_out(arguments)


def _carry_out(arguments: Sequence[str] | None) -> int:  # noqa: PLR0911 - one a failure
    if sys.stdout is None:
        return _complain("stdout is closed: there is nowhere to print a result", FAILED)
    try:
        if isinstance(sys.stdout, io.TextIOWrapper):
            sys.stdout.reconfigure(errors="backslashreplace")  # no letter stops a result
        try:
            given = sys.argv[1:] if arguments is None else list(arguments)
            options = _parser().parse_args(given if given not in ([], ["help"]) else ["--help"])
            return options.command(options)
        finally:
            sys.stdout.flush()  # here, not at exit, where a failure could not be reported
    except (ConfigError, Infeasible) as error:
        return _complain(str(error), BAD_INPUT)
    except MotionLabError as error:
        return _complain(str(error), FAILED)
    except KeyboardInterrupt:
        return _complain("interrupted", FAILED)
    except MemoryError as error:
        return _complain(f"not enough memory: {error}; shorten the run", FAILED)
    except OSError as error:
        left = isinstance(error, BrokenPipeError) and _reader_has_left()
        discard(sys.stdout)
        return DONE if left else _complain(str(error), FAILED)


def _complain(message: str, code: int) -> int:
    print(f"motionlab: {message}", file=sys.stderr)
    return code


def _reader_has_left() -> bool:
    """Return whether the reader of stdout has exited, as in ``motionlab run circle | head``."""
    stdout = select.poll()
    stdout.register(sys.stdout.fileno(), 0)  # errors alone
    return bool(stdout.poll(0))


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="motionlab",
        description="A motion lab for planar switched reluctance motors.",
    )
    parser.add_argument("-V", "--version", action="version", version=f"motionlab {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for command in _COMMANDS:
        command.add(commands)
    return parser
