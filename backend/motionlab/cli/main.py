"""The command line. Exit codes: 0 done, 1 the run failed, 2 bad input."""

from __future__ import annotations

import argparse
import contextlib
import gc
import importlib
import os
import select
import shlex
import sys
import time
import traceback
from collections.abc import Iterator, Sequence

from motionlab import __version__
from motionlab.cli.messages import discard, plain_stdout, say, unbreakable_stderr
from motionlab.cli.parser import Parser, print_problem
from motionlab.errors import (
    BAD_INPUT,
    DONE,
    FAILED,
    INTERRUPTED,
    ConfigError,
    FieldError,
    Infeasible,
    MotionLabError,
    naming_extras,
    shown,
)
from motionlab.executors.progress import first_use, progress_shown

_MODULES = {
    "run": ("run",),
    "scenarios": ("scenarios", "show", "new", "schema"),
    "fields": ("fields", "laws", "new-law", "check-law"),
    "check": ("check",),
    "loop": ("loop",),
    "plot": ("plot",),
    "runs": ("runs",),
    "compare": ("compare",),
    "replay": ("replay",),
    "glitches": ("glitches",),
    "spectrum": ("spectrum",),
    "view": ("view",),
    "report": ("report",),
    "exchange": ("export", "import"),
    "trajectory": ("trajectory",),
    "export_controller": ("export-controller",),
    "export_plant": ("export-plant",),
    "challenge": ("challenge",),
    "study": (),
    "serve": ("serve", "openapi"),
    "demo": ("demo",),
    "drive.command": ("drive",),
    "drive.virtual_command": ("vdrive",),
    "precompile": ("precompile",),
    "docs": ("docs", "completion"),
}
"""Modules in the order of the help page, and the commands of each: to import one alone.

Those with a dot are of other rooms.
"""

_ENDING = """\
`motionlab COMMAND --help` shows the options of a command, and examples.
`motionlab docs` opens the documentation.
Exit codes: 0 done; 1 a run, a check or a file failed; 2 bad input; 130 interrupted.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        What follows the program's name; ``sys.argv`` when left out.

    Returns
    -------
    int
        0 done, 1 the run failed, 2 bad input, 130 interrupted.
    """
    with unbreakable_stderr(), plain_stdout(), _seldom_collecting():
        return _carry_out(arguments)


@contextlib.contextmanager
def _seldom_collecting() -> Iterator[None]:
    """Collect garbage after 50,000 new objects: a short command makes most by its imports."""
    thresholds = gc.get_threshold()
    gc.set_threshold(50_000, *thresholds[1:])
    try:
        yield
    finally:
        gc.set_threshold(*thresholds)


def _carry_out(arguments: Sequence[str] | None) -> int:
    if sys.stdout is None:
        return _complain("stdout is closed: there is nowhere to print a result", FAILED)
    words = sys.argv[1:] if arguments is None else list(arguments)
    started = time.perf_counter()
    try:
        try:
            _take_folders(words)
            parsed = words if words not in ([], ["help"]) else ["--help"]
            options = _parser(parsed).parse_args(parsed)
            command = str(shown(shlex.join(["motionlab", *parsed])))
            with progress_shown(not hasattr(options, "quiet")), first_use(), naming_extras(command):
                code = options.command(options)
                if hasattr(options, "verbose"):
                    say(f"took {time.perf_counter() - started:.2f} s")
            return code
        except MotionLabError as error:
            if {"-v", "--verbose"} & set(words):
                traceback.print_exc()
            if "--json" in words:
                print_problem(error)
            bad = isinstance(error, ConfigError | Infeasible)
            return _complain(str(error), BAD_INPUT if bad else FAILED)
        finally:
            sys.stdout.flush()  # here, not at exit, where a failure could not be reported
    except KeyboardInterrupt:
        return _complain("interrupted", INTERRUPTED)
    except MemoryError as error:
        return _complain(f"not enough memory: {error}; shorten the run", FAILED)
    except OSError as error:
        left = isinstance(error, BrokenPipeError) and _reader_has_left()
        discard(sys.stdout)
        return DONE if left else _complain(str(error), FAILED)


def _take_folders(words: Sequence[str]) -> None:
    """Name folders of ``--laws`` and ``--studies`` in the environment, before they are read."""
    for option, variable in (("laws", "MOTIONLAB_LAWS"), ("studies", "MOTIONLAB_STUDIES")):
        parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
        parser.add_argument(f"--{option}", dest="folders", action="append", default=[])
        with contextlib.suppress(argparse.ArgumentError):  # the command's own parser refuses it
            folders = parser.parse_known_args(words)[0].folders
            for folder in folders:
                if not os.path.exists(folder):
                    message = "no such folder or file"
                    raise ConfigError(FieldError(f"--{option}", message, folder))
            if folders:
                before = filter(None, [os.environ.get(variable)])
                os.environ[variable] = os.pathsep.join([*map(os.path.abspath, folders), *before])


def _complain(message: str, code: int) -> int:
    for line in message.splitlines() or [""]:
        print(f"motionlab: {line}", file=sys.stderr)
    return code


def _reader_has_left() -> bool:
    """Return whether the reader of stdout has exited, as in ``motionlab run circle | head``."""
    stdout = select.poll()
    stdout.register(sys.stdout.fileno(), 0)  # errors alone
    return bool(stdout.poll(0))


def _parser(words: Sequence[str] = ()) -> argparse.ArgumentParser:
    """Return the parser: of one command where the first word names it, or of all."""
    parser = Parser(
        prog="motionlab",
        description="A motion lab for planar switched reluctance motors.",
        epilog=_ENDING,
    )
    parser.add_argument("-V", "--version", action="version", version=f"motionlab {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    modules = _modules(words)
    for module in modules:
        place = module if "." in module else f"cli.{module}"
        first = words[:1] if module == "study" else ()
        importlib.import_module(f"motionlab.{place}").add(commands, *first)
    if "study" in modules:
        importlib.import_module("motionlab.cli.study").add_own(commands)
    if {"study", "view"} & {*modules}:
        for problem in importlib.import_module("motionlab.own_studies").PROBLEMS:
            say(f"not taken: {problem}")
    return parser


def _modules(words: Sequence[str]) -> list[str]:
    if words:
        for module, names in _MODULES.items():
            if words[0] in names:
                return [module]
    return list(_MODULES)
