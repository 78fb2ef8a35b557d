"""The commands ``motionlab docs`` and ``motionlab completion``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from motionlab.cli.exit_codes import DONE

_PACKAGE = Path(__file__).resolve().parent.parent
_CHECKOUT = _PACKAGE.parent.parent


def add(commands: Any) -> None:
    """Add both commands."""
    parser = commands.add_parser(
        "docs",
        help="open the documentation",
        description="Open the documentation in a browser; without a terminal, print where it is.",
        epilog="examples:\n  motionlab docs\n  motionlab docs scenarios\n",
    )
    parser.add_argument(
        "page", metavar="PAGE", nargs="?", default="index", help="such as scenarios or tutorial"
    )
    parser.set_defaults(command=_docs)

    parser = commands.add_parser(
        "completion",
        help="print the completion of commands and options for a shell",
        description="Print what makes a shell complete the commands and options of motionlab.",
        epilog="examples:\n"
        "  motionlab completion bash > ~/.local/share/bash-completion/completions/motionlab\n"
        "  motionlab completion zsh > ~/.zfunc/_motionlab\n",
    )
    parser.add_argument("shell", metavar="SHELL", choices=("bash", "zsh", "tcsh"), help="which")
    parser.set_defaults(command=_completion)


def _docs(options: argparse.Namespace) -> int:
    place = _place(options.page)
    if place.suffix == ".html" and sys.stdout.isatty():
        import webbrowser

        if webbrowser.open(place.as_uri()):
            return DONE
    print(place)
    return DONE


def _place(page: str) -> Path:
    """Return the file of a page: of the built site, or else its Markdown.

    Raises
    ------
    ConfigError
        If there is no such page.
    MotionLabError
        If there is no documentation.
    """
    from motionlab.config.shipped import did_you_mean
    from motionlab.errors import ConfigError, FieldError, MotionLabError

    folders = (
        (_PACKAGE / "help", ".html"),
        (_CHECKOUT / "build" / "help", ".html"),
        (_CHECKOUT / "docs", ".md"),
    )
    for folder, suffix in folders:
        known = sorted(path.stem for path in folder.glob(f"*{suffix}"))
        if not known:
            continue
        if page == "index" and page not in known:
            return folder
        if page in known:
            return folder / f"{page}{suffix}"
        message = f"no page of that name{did_you_mean(page, known)}"
        raise ConfigError(FieldError("PAGE", message, page, f"one of {', '.join(known)}"))
    raise MotionLabError(
        "there is no documentation beside this installation; the lab has it: /help"
    )


def _completion(options: argparse.Namespace) -> int:
    import shtab

    from motionlab.cli.main import _parser

    print(shtab.complete(_parser(), options.shell))
    return DONE
