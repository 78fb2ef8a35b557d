"""Files that commands write: checked before the work, named with their size after it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from motionlab.cli.messages import say
from motionlab.errors import ConfigError, FieldError, MotionLabError

_KILO = 1000


def add_overwrite(parser: argparse.ArgumentParser) -> None:
    """Add ``--overwrite``."""
    parser.add_argument(
        "--overwrite",
        action="store_true",
        help="replace a file that is there, without asking",
    )


def check_output(path: str, *suffixes: str, overwrite: bool, loc: str = "--out") -> None:
    """Refuse a file that could not be written, and one that is there unless it may be replaced.

    On a terminal the user is asked, elsewhere ``--overwrite`` is needed.

    Raises
    ------
    ConfigError
        If it cannot be written, or is there and no terminal can be asked.
    MotionLabError
        If the user wants to keep it.
    """
    from motionlab.files import check_target

    check_target(path, *suffixes, loc=loc)
    if overwrite or not Path(path).exists():
        return
    if not (sys.stdin is not None and sys.stdin.isatty() and sys.stderr.isatty()):
        raise ConfigError(FieldError(loc, "is there already; --overwrite replaces it", path))
    print(f"motionlab: {path} is there already. Replace it? [y/N] ", end="", file=sys.stderr)
    sys.stderr.flush()
    if sys.stdin.readline().strip().lower() not in {"y", "yes"}:
        raise MotionLabError(f"{path} is kept as it was; nothing was done")


def wrote(path: str) -> None:
    """Say which file was written, and its size."""
    say(f"wrote {path}, {size(Path(path).stat().st_size)}")


def names_run(text: str) -> bool:
    """Return whether it is the identifier or the name of a kept run, and no scenario."""
    from motionlab.config.named_configs import names
    from motionlab.library.library import library

    if text == "-" or text in names("scenarios") or "/" in text or text.endswith(".toml"):
        return False
    return text.startswith("r-") or bool(library().index.named(text))


def size(count: int) -> str:
    """Return a number of bytes in words, such as ``21.3 MB``."""
    number, unit = float(count), "bytes"
    for larger in ("kB", "MB", "GB", "TB"):
        if number < _KILO:
            break
        number, unit = number / _KILO, larger
    return f"{count} bytes" if unit == "bytes" else f"{number:.3g} {unit}"


def show(text: str) -> None:
    """Print a report: on a terminal fitted to its columns, with µm for um where it can."""
    from motionlab.reports.tables import fitted, in_letters

    print(fitted(in_letters(text)))
