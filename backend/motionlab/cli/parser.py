"""A parser whose refusals are short: what is wrong, what may be meant, where to read on."""

from __future__ import annotations

import argparse
import re
import textwrap
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from motionlab.config.named_configs import did_you_mean
from motionlab.errors import BAD_INPUT, ConfigError, FieldError

_CHOICE = re.compile(r"(.+?): invalid choice: '?(.*?)'? \(choose from (.*)\)")
_NUMBER = re.compile(r"(.+?): invalid (int|float) value: (.*)")
_NEGATIVE = re.compile(r"-\.?\d|-inf|-nan", re.IGNORECASE)
_MISSING = "the following arguments are required: "
_QUIET = "print results and errors alone: no progress, no notes"
_LAWS = "folder, or file, of laws and effects of one's own (MOTIONLAB_LAWS); docs/own-law.md"
_STUDIES = "folder, or file, of studies and views of one's own (MOTIONLAB_STUDIES)"
_VERBOSE = "say how long it took, and where in the program an error arose"
_MEANT = {
    "convert": "export",
    "describe": "show",
    "diff": "compare",
    "init": "new",
    "list": "scenarios",
    "ls": "runs",
    "margins": "loop",
    "optimise": "tune",
    "optimize": "tune",
    "save": "export",
    "simulate": "run",
    "start": "serve",
    "template": "new",
    "validate": "check",
}
"""Commands by other words for them that no spelling is close to."""


class HelpFormatter(argparse.RawDescriptionHelpFormatter):
    """Wraps sentences at the terminal's width, and leaves indented lines as they are."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        lines: list[str] = []
        sentences: list[str] = []
        for line in [*text.splitlines(), ""]:
            if line and not line[0].isspace() and not line.endswith(":"):
                sentences.append(line)
                continue
            if sentences:
                filled = " ".join(sentences)
                lines += textwrap.wrap(filled, width, break_long_words=False)
                sentences.clear()
            lines.append(line)
        return "\n".join(indent + line for line in lines).rstrip() + "\n"


class Parser(argparse.ArgumentParser):
    """Refuses in two lines, with the closest of the words that it knows.

    Options whose model takes long to import are added by `late` when this parser is used.
    """

    def __init__(self, *, late: Callable[[Parser], None] | None = None, **settings: Any) -> None:
        settings["formatter_class"] = HelpFormatter
        super().__init__(**settings)
        self._late = late
        self._words: list[str] = []
        # A value such as -0.001,0.002 is no option either: argparse knows single numbers alone.
        self._negative_number_matcher = _NEGATIVE
        self.add_argument(
            "-q", "--quiet", action="store_true", default=argparse.SUPPRESS, help=_QUIET
        )
        self.add_argument(
            "-v", "--verbose", action="store_true", default=argparse.SUPPRESS, help=_VERBOSE
        )
        # Taken by `cli.main` before a command is imported.
        self.add_argument("--laws", metavar="FOLDER", default=argparse.SUPPRESS, help=_LAWS)
        self.add_argument("--studies", metavar="FOLDER", default=argparse.SUPPRESS, help=_STUDIES)

    def parse_known_args(  # pyright: ignore[reportIncompatibleMethodOverride]
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse, and refuse what is left over: here the command is known that does not take it."""
        self._words = list(args or [])
        if self._late is not None:
            late, self._late = self._late, None
            late(self)
        known, left = super().parse_known_args(args, namespace)
        if left:
            self._refuse(left[0])
        return known, left

    def error(self, message: str) -> NoReturn:
        """End with the reason in the words of all other errors, and the page that helps."""
        message = message.removeprefix("argument ")
        error = FieldError(self.prog, message)
        if match := _CHOICE.fullmatch(message):
            name, value, choices = match.groups()
            known = [word.strip().strip("'") for word in choices.split(",")]
            other = _MEANT.get(value, "")
            hint = did_you_mean(other if other in known else value, known)
            if not hint:
                meant = [word for word, command in _MEANT.items() if command in known]
                hint = did_you_mean(value, meant)
                for word, command in _MEANT.items():
                    hint = hint.replace(f"{word!r}", f"{command!r}")
            allowed = "" if name == "COMMAND" else f"one of {', '.join(known)}"
            error = FieldError(name, f"no such {name}{hint}", value, allowed)
            message = str(error).removeprefix(f"{name}: ")
        elif match := _NUMBER.fullmatch(message):
            name, kind, value = match.groups()
            what = "a whole number" if kind == "int" else "a number"
            error = FieldError(name, f"is not {what}", value.strip("'"))
            message = str(error)
        elif message.startswith(_MISSING):
            for word in self._words:  # which may be why
                if word.startswith("-") and not self._knows(word):
                    self._refuse(word)
            name = message.removeprefix(_MISSING)
            error = FieldError(name, "is missing")
            message = f"{name} is missing"
        self._end(message, error)

    def _end(self, message: str, error: FieldError) -> NoReturn:
        if "--json" in self._words:
            print_problem(ConfigError(error))
        self.exit(BAD_INPUT, f"{self.prog}: {message}\n`{self.prog} --help` shows what there is\n")

    def _knows(self, word: str) -> bool:
        option = word.split("=", maxsplit=1)[0]
        return any(name.startswith(option) for name in self._option_string_actions)

    def _refuse(self, word: str) -> NoReturn:
        if not word.startswith("-"):
            message = f"nothing here takes {word!r}"
            self._end(message, FieldError(self.prog, message))
        option = word.split("=", maxsplit=1)[0]
        known = [name[2:] for name in self._option_string_actions if name.startswith("--")]
        hint = did_you_mean(option.lstrip("-"), known).replace("mean '", "mean '--")
        self._end(f"no option {option}{hint}", FieldError(option, f"no such option{hint}"))


def print_problem(error: Any) -> None:
    """Print an error as a problem document on stdout."""
    import json

    from motionlab.reports.problems import problem_of

    print(json.dumps(problem_of(error), allow_nan=False))
