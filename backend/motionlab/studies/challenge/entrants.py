"""Laws that take part, each with its parameters."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from pydantic import ValidationError

from motionlab.config.controller import CompensationConfig
from motionlab.config.named_configs import did_you_mean
from motionlab.config.validation_errors import field_errors
from motionlab.errors import ConfigError, FieldError
from motionlab.laws import LAWS, PROBLEMS, SHIPPED, SOURCES

REFERENCE = "off"
"""The law that all others are compared with."""
MOST = 26
"""Laws of one challenge: as many as a scenario may have variants."""


@dataclass(frozen=True)
class Entrant:
    """A law with its parameters.

    Attributes
    ----------
    law : str
        Its name.
    parameters : dict
        Those that are not left to its declaration.
    entered : bool
        Whether it was named; the shipped ones take part in any case.
    """

    law: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    entered: bool = False

    @property
    def label(self) -> str:
        """Name, and parameters that were set."""
        return " ".join([self.law, *(f"{name}={each}" for name, each in self.parameters.items())])

    @property
    def shipped(self) -> bool:
        """Whether it is a shipped law as it is declared."""
        return self.law in SHIPPED and not self.parameters

    @property
    def source(self) -> str | None:
        """SHA-256 of its file; None of a shipped one."""
        text = SOURCES.get(self.law)
        return None if text is None else hashlib.sha256(text.encode()).hexdigest()

    @property
    def compensation(self) -> dict[str, Any]:
        """Table of a controller."""
        return {"law": self.law, **self.parameters}


def entrants(laws: Sequence[str], parameters: Mapping[str, Any]) -> list[Entrant]:
    """Return the shipped laws, and those that are named.

    Parameters
    ----------
    laws : sequence of str
        Names.
    parameters : mapping of str to value
        Parameters in place of the declared defaults, of each named law that has them.

    Raises
    ------
    ConfigError
        If there is no such law, none that is named has a parameter, a value is not allowed, or
        there are too many.
    """
    if unknown := [name for name in laws if name not in LAWS]:
        raise ConfigError(*map(_unknown, unknown), *PROBLEMS)
    own = {name: {each.name for each in LAWS[name].parameters} for name in laws}
    for name, value in parameters.items():
        if not any(name in each for each in own.values()):
            known = sorted({each for of in own.values() for each in of})
            message = f"no law that is named has this parameter{did_you_mean(name, known)}"
            allowed = f"one of {', '.join(known)}" if known else ""
            raise ConfigError(FieldError(f"--set {name}", message, value, allowed))
    for law, known in own.items():
        _check(law, {name: value for name, value in parameters.items() if name in known})
    named = [
        Entrant(law, {k: v for k, v in parameters.items() if k in own[law]}, entered=True)
        for law in dict.fromkeys(laws)
    ]
    plain = {each.law for each in named if each.shipped}
    shipped = [Entrant(law, entered=law in plain) for law in SHIPPED]
    everyone = [*shipped, *(each for each in named if not each.shipped)]
    if len(everyone) > MOST:
        message = "are too many laws at once, with those that ship"
        raise ConfigError(FieldError("LAW", message, len(everyone), f"at most {MOST}", "1"))
    return everyone


def _check(law: str, parameters: Mapping[str, Any]) -> None:
    """Refuse values that the law's fields do not allow, by the names under which they came."""
    try:
        CompensationConfig.model_validate({"law": law, **parameters})
    except ValidationError as error:
        wrong = field_errors(error, CompensationConfig)
        raise ConfigError(*(replace(each, loc=f"--set {each.loc}") for each in wrong)) from None


def _unknown(name: str) -> FieldError:
    known = list(LAWS)
    allowed = f"the path of a .py file, or one of {', '.join(known)}"
    return FieldError("LAW", f"no such law{did_you_mean(name, known)}", name, allowed)
