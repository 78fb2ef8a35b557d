"""The command line. Exit codes: 0 done, 1 the run failed, 2 bad input."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from motionlab import __version__
from motionlab.config.shipped import names
from motionlab.errors import ConfigError, Infeasible, MotionLabError

DONE, FAILED, BAD_INPUT = 0, 1, 2

_PORT_MAX = 65_535
_LONG_RUN = 100_000  # ticks; shorter runs are over before a bar could be read

_EXAMPLES = """\
examples:
  motionlab run circle
  motionlab run circle --json
  motionlab run circle --set variants.B.controller.x.k_p=312000 --set seed=7
  motionlab run circle --set plant=matched --set trajectory=rhombus
  motionlab run my-scenario.toml --out run.parquet

Values are SI (k_p in N/m, k_d in N s/m, lengths in m); docs/scenarios.md lists the fields.
"""


def main(arguments: Sequence[str] | None = None) -> int:  # noqa: PLR0911 - one a failure
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
    if sys.stdout is None:
        return _complain("stdout is closed: there is nowhere to print a result", FAILED)
    try:
        if isinstance(sys.stdout, io.TextIOWrapper):
            sys.stdout.reconfigure(errors="backslashreplace")  # no letter stops a result
        try:
            options = _parser().parse_args(arguments)
            return options.command(options)
        finally:
            sys.stdout.flush()  # here, not at exit, where a failure could not be told
    except (ConfigError, Infeasible) as error:
        return _complain(str(error), BAD_INPUT)
    except MotionLabError as error:
        return _complain(str(error), FAILED)
    except KeyboardInterrupt:
        return _complain("interrupted", FAILED)
    except MemoryError as error:
        return _complain(f"not enough memory: {error}; shorten the run", FAILED)
    except BrokenPipeError:  # the reader of stdout has gone, as in `motionlab run circle | head`
        _discard_stdout()
        return DONE
    except OSError as error:
        _discard_stdout()
        return _complain(str(error), FAILED)


def _complain(message: str, code: int) -> int:
    print(f"motionlab: {message}", file=sys.stderr)
    return code


def _discard_stdout() -> None:
    """Let what is still buffered for stdout go nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="motionlab",
        description="A motion lab for planar switched reluctance motors.",
    )
    parser.add_argument("--version", action="version", version=f"motionlab {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    run = commands.add_parser(
        "run",
        help="run a scenario and compare its controllers",
        description="Run a scenario on the simulated motor, all variants on the same noise, and "
        "compare the controllers.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    run.add_argument(
        "scenario",
        metavar="SCENARIO",
        help="path of a .toml file, or a shipped scenario: " + ", ".join(names("scenarios")),
    )
    run.add_argument(
        "--set",
        dest="assignments",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="change a field (repeatable, all applied together); a part can be swapped for a "
        "shipped one by name, as in --set plant=matched",
    )
    run.add_argument("--out", metavar="FILE", help="write every channel to FILE, .parquet or .csv")
    run.add_argument("--json", action="store_true", help="print one JSON document on stdout")
    run.set_defaults(command=_run)
    serve = commands.add_parser(
        "serve",
        help="serve the REST API",
        description="Serve the REST API; /docs describes it. Another host than loopback needs a "
        "token in MOTIONLAB_TOKEN.",
    )
    serve.add_argument("--host", default="127.0.0.1", help="address to listen on (%(default)s)")
    serve.add_argument("--port", type=_port, default=8000, help="port (%(default)s)")
    serve.add_argument(
        "--name",
        dest="host_names",
        metavar="HOST",
        action="append",
        default=[],
        help="further name under which clients reach this server (repeatable)",
    )
    serve.set_defaults(command=_serve)
    openapi = commands.add_parser(
        "openapi", help="print the OpenAPI document", description="Print the OpenAPI document."
    )
    openapi.set_defaults(command=_openapi)
    return parser


def _port(text: str) -> int:
    port = int(text) if text.isdecimal() else -1
    if not 0 <= port <= _PORT_MAX:
        raise argparse.ArgumentTypeError(f"{text!r} is no port; allowed 0 to {_PORT_MAX}")
    return port


def _serve(options: argparse.Namespace) -> int:
    """Carry out ``motionlab serve``."""
    from motionlab.service.serve import serve

    serve(options.host, options.port, frozenset(options.host_names))
    return DONE


def _openapi(_: argparse.Namespace) -> int:
    """Carry out ``motionlab openapi``."""
    from motionlab.service.app import create_app

    print(json.dumps(create_app().openapi(), indent=2))
    return DONE


def _run(options: argparse.Namespace) -> int:
    """Carry out ``motionlab run``."""
    from motionlab.config.load import load_scenario, parse_assignments
    from motionlab.simulation.result import document, metadata
    from motionlab.simulation.run import prepare, run
    from motionlab.telemetry.recorder import check_target, write

    source = Path(options.scenario) if options.scenario.endswith(".toml") else options.scenario
    scenario = load_scenario(source, parse_assignments(options.assignments))
    if options.out is not None:
        check_target(options.out)
    prepared = prepare(scenario)
    with _progress(prepared.reference.ticks) as progress:
        recording = run(prepared, progress)
    result = document(prepared, recording)
    if options.out is not None:
        write(recording, options.out, metadata=metadata(prepared))
    if options.json:
        print(json.dumps(result, allow_nan=False))
    else:
        from motionlab.simulation.report import report

        print(report(result))
    diverged = [name for name, variant in result["variants"].items() if variant["diverged"]]
    for name in diverged:
        where = result["variants"][name]["diverged"]
        print(
            f"motionlab: variant {name} diverged at t = {where['time']:.4f} s: {where['channel']}",
            file=sys.stderr,
        )
    return FAILED if diverged else DONE


@contextlib.contextmanager
def _progress(ticks: int) -> Iterator[Callable[[int], Any] | None]:
    """Show a bar on stderr while a long run goes on in a terminal."""
    if ticks < _LONG_RUN or not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    with tqdm(total=ticks, unit="tick", unit_scale=True, leave=False, file=sys.stderr) as bar:
        yield bar.update
