"""A parser whose refusals are short: what is wrong, what may be meant, where to read on."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from typing import Any, NoReturn

from motionlab.cli.exit_codes import BAD_INPUT
from motionlab.config.shipped import did_you_mean

_CHOICE = re.compile(r"(.+?): invalid choice: '?(.*?)'? \(choose from (.*)\)")
_NUMBER = re.compile(r"(.+?): invalid (int|float) value: (.*)")
_MISSING = "the following arguments are required: "


class Parser(argparse.ArgumentParser):
    """Refuses in two lines, with the closest of the words that it knows."""

    def parse_known_args(  # pyright: ignore[reportIncompatibleMethodOverride]
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse, and refuse what is left over: here the command is known that does not take it."""
        self._given = list(args or [])
        found, left = super().parse_known_args(args, namespace)
        if left:
            self._refuse(left[0])
        return found, left

    def error(self, message: str) -> NoReturn:
        """End with the reason in the words of all other errors, and the page that helps."""
        message = message.removeprefix("argument ")
        if found := _CHOICE.fullmatch(message):
            name, value, choices = found.groups()
            known = [word.strip().strip("'") for word in choices.split(",")]
            message = f"no such {name}{did_you_mean(value, known)}; got {value!r}"
            if name != "COMMAND":
                message += f"; allowed one of {', '.join(known)}"
        elif found := _NUMBER.fullmatch(message):
            name, kind, value = found.groups()
            what = "a whole number" if kind == "int" else "a number"
            message = f"{name}: is not {what}; got {value}"
        elif message.startswith(_MISSING):
            for word in self._given:  # which may be why
                if word.startswith("-") and not self._knows(word):
                    self._refuse(word)
            message = f"{message.removeprefix(_MISSING)} is missing"
        self.exit(BAD_INPUT, f"{self.prog}: {message}\n`{self.prog} --help` shows what there is\n")

    def _knows(self, word: str) -> bool:
        option = word.split("=", maxsplit=1)[0]
        return any(name.startswith(option) for name in self._option_string_actions)

    def _refuse(self, word: str) -> NoReturn:
        if not word.startswith("-"):
            self.error(f"nothing here takes {word!r}")
        option = word.split("=", maxsplit=1)[0]
        known = [name[2:] for name in self._option_string_actions if name.startswith("--")]
        hint = did_you_mean(option.lstrip("-"), known).replace("mean '", "mean '--")
        self.error(f"no option {option}{hint}")
