"""What a law may not declare is refused when the laws are read, naming file, field and value."""

from __future__ import annotations

import dataclasses
import math
import re
import sys
from types import ModuleType
from typing import Any, NamedTuple

import pytest

from motionlab import declarations, laws
from motionlab.declarations import DeclarationError
from motionlab.lanes import Lanes
from motionlab.laws import lugre_observer
from motionlab.laws.law import Law, Parameter

OWN = dataclasses.replace(lugre_observer.LAW, name="own")
LEVEL = Parameter("level", "A level", unit="N", default=0.3, ge=0, le=100, usual=(0.01, 10))


class Levels(NamedTuple):
    """Levels of each lane."""

    level: Lanes
    other: Lanes


def declared(**changes: Any) -> Law:
    """Return a law with a parameter that is declared otherwise."""
    return dataclasses.replace(OWN, parameters=(dataclasses.replace(LEVEL, **changes),))


def named(name: str) -> Law:
    return dataclasses.replace(OWN, name=name)


def read(monkeypatch: pytest.MonkeyPatch, law: Any) -> None:
    """Read the laws with one more."""
    module = ModuleType("motionlab.laws.more")
    module.LAW = law  # pyright: ignore[reportAttributeAccessIssue]
    monkeypatch.setitem(sys.modules, module.__name__, module)
    names = [*declarations.pkgutil.iter_modules(laws.__path__)]
    more = declarations.pkgutil.ModuleInfo(names[0].module_finder, "more", ispkg=False)
    monkeypatch.setattr(declarations.pkgutil, "iter_modules", lambda _: [*names, more])
    monkeypatch.setattr(laws, "LAWS", laws._shipped())
    declarations.parameters_of(laws.LAWS.values(), laws._TAKEN)


FILE = "motionlab/laws/more.py: "
RANGE = "allowed >= 0 and <= 100 N"


@pytest.mark.parametrize(
    ("law", "reason"),
    [
        (named("off"), "off: two files declare a law of this name"),
        (5, f"{FILE}LAW: is no law; got 5"),
        (Law, f"{FILE}LAW: is no law; got "),
        (named(""), f"{FILE}LAW.name: is no name for configs and files; got ''; allowed a letter"),
        (named("l" * 41), f"{FILE}LAW.name: is no name"),
        (named("my law; */ ../x"), f"{FILE}LAW.name: is no name"),
        (named("lé"), f"{FILE}LAW.name: is no name"),
        (dataclasses.replace(OWN, label=5), f"{FILE}own.label: is no text; got 5"),
        (dataclasses.replace(OWN, parameters=[LEVEL]), "own.parameters: is no tuple of Parameter"),
        (dataclasses.replace(OWN, parameters=(5,)), "holds what is no Parameter; got 5"),
        (declared(name="enabled"), "own: a parameter may not be called enabled"),
        (declared(name="register"), f"{FILE}own.register: has a name that every config"),
        (declared(name="model_config"), f"{FILE}own.model_config: has a name that"),
        (declared(name="gain"), "gain is declared otherwise by another"),
        (declared(name="ω"), f"{FILE}own.ω: is no name for a field"),
        (declared(name="class"), f"{FILE}own.class: is no name for a field"),
        (declared(name="l" * 41), "is no name for a field"),
        (
            declared(default=500.0),
            f"own.level.default: is outside of its range; got 500.0; {RANGE}",
        ),
        (declared(gt=0, ge=None, default=0.0), "is outside of its range; got 0.0; allowed > 0 and"),
        (declared(default=math.nan), f"{FILE}own.level.default: is no finite number; got nan"),
        (declared(le=math.inf), f"{FILE}own.level.le: is no finite number; got inf"),
        (declared(default="a"), f"{FILE}own.level.default: is no finite number; got 'a'"),
        (declared(ge=100, le=0), "own.level: has bounds between which no number is; got '>= 100"),
        (declared(ge=None), f"{FILE}own.level: needs a lower bound; allowed one of ge and gt"),
        (declared(le=None), f"{FILE}own.level: needs an upper bound; allowed one of le and lt"),
        (declared(usual=(-5.0, 1e9)), "own.level.usual: is no range within its bounds"),
        (declared(usual=(1.0,)), "own.level.usual: is no pair of finite numbers"),
        (declared(choices=("a", "b")), "own.level.default: is none of its choices; got 0.3"),
        (dataclasses.replace(OWN, State=5), f"{FILE}own.State: is no NamedTuple class; got 5"),
        (dataclasses.replace(OWN, step=5), f"{FILE}own.step: is no function; got 5"),
        (
            dataclasses.replace(OWN, Parameters=Levels, lane=None, parameters=(LEVEL,)),
            "own.other: is in its Parameters, but not declared",
        ),
        (
            dataclasses.replace(
                OWN,
                Parameters=Levels,
                lane=None,
                parameters=(LEVEL, dataclasses.replace(LEVEL, name="other", default=None)),
            ),
            "own.other.default: is no number that a lane can have",
        ),
    ],
)
def test_what_cannot_be_used_is_refused(
    law: Any, reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(DeclarationError, match=re.escape(reason)):
        read(monkeypatch, law)


def test_a_law_with_parameters_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    read(monkeypatch, declared(name="own_level"))
