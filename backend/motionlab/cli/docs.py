"""The commands ``motionlab docs`` and ``motionlab completion``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from motionlab.errors import DONE

_PACKAGE = Path(__file__).resolve().parent.parent
_CHECKOUT = _PACKAGE.parent.parent

COMPLETION_EXAMPLES = """\
examples:
  mkdir -p ~/.local/share/bash-completion/completions
  motionlab completion bash > ~/.local/share/bash-completion/completions/motionlab

  mkdir -p ~/.zfunc
  motionlab completion zsh > ~/.zfunc/_motionlab

zsh looks there with `fpath+=~/.zfunc` before `compinit` in ~/.zshrc.
"""

_FILES = {"A", "B", "FIG", "FILE", "PATH", "RUN", "RUN_B"}
"""Metavars of arguments that may be files."""


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
        description="Print what makes a shell complete commands, options, scenarios and files.",
        epilog=COMPLETION_EXAMPLES,
    )
    parser.add_argument(
        "shell", metavar="SHELL", choices=("bash", "zsh", "tcsh"), help="bash, zsh or tcsh"
    )
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
    from motionlab.config.named_configs import did_you_mean
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
        "this installation has no documentation: a wheel has it that was built after `make docs`; "
        "in a checkout, docs/ has the text"
    )


def _completion(options: argparse.Namespace) -> int:
    import shtab

    from motionlab.cli.main import _parser

    parser = _parser()
    _say_what_is_taken(parser, {"FOLDER": shtab.DIRECTORY} | dict.fromkeys(_FILES, shtab.FILE))
    text = shtab.complete(parser, options.shell)
    print(text.replace("complete -o bashdefault -F", "complete -o bashdefault -o default -F"))
    return DONE


def _say_what_is_taken(parser: argparse.ArgumentParser, of: dict[str, Any]) -> None:
    """Tell shtab, by their metavars, which arguments are files, folders and scenarios."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                _say_what_is_taken(command, of)
        elif isinstance(action.metavar, str):
            known = _scenarios() if "SCENARIO" in action.metavar else of.get(action.metavar)
            if known is not None:
                action.complete = known  # pyright: ignore[reportAttributeAccessIssue]


def _scenarios() -> dict[str, Any]:
    """Return the completion of shipped scenarios and files."""
    from motionlab.config.named_configs import names

    known = " ".join(names("scenarios"))
    function = "_motionlab_scenarios_and_files"
    return {
        "bash": function,
        "zsh": function,
        "tcsh": "f",
        "preamble": {
            "bash": f"{function}() {{\n  compgen -W '{known}' -- $1\n  compgen -f -- $1\n}}",
            "zsh": f"{function}() {{\n"
            f"  _alternative 'scenarios:scenario:({known})' 'files:file:_files'\n}}",
        },
    }
