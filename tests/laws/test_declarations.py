"""What a law may not declare is refused when the laws are read, naming the law."""

from __future__ import annotations

import dataclasses
import sys
from types import ModuleType

import pytest

from motionlab import declarations, laws
from motionlab.laws import lugre_observer
from motionlab.laws.law import Law, Parameter

OWN = dataclasses.replace(lugre_observer.LAW, name="own")


def read(monkeypatch: pytest.MonkeyPatch, law: Law) -> None:
    """Read the laws with one more."""
    module = ModuleType("motionlab.laws.more")
    module.LAW = law  # pyright: ignore[reportAttributeAccessIssue]
    monkeypatch.setitem(sys.modules, module.__name__, module)
    names = [*declarations.pkgutil.iter_modules(laws.__path__)]
    more = declarations.pkgutil.ModuleInfo(names[0].module_finder, "more", ispkg=False)
    monkeypatch.setattr(declarations.pkgutil, "iter_modules", lambda _: [*names, more])
    monkeypatch.setattr(laws, "LAWS", laws._laws())
    declarations.parameters_of(laws.LAWS.values(), laws._TAKEN)


@pytest.mark.parametrize(
    ("law", "reason"),
    [
        (dataclasses.replace(OWN, name="off"), "off: two files declare a law of this name"),
        (dataclasses.replace(OWN, parameters=(Parameter("enabled", "x"),)), "may not be called"),
        (
            dataclasses.replace(OWN, parameters=(Parameter("gain", "another"),)),
            "gain is declared otherwise by another",
        ),
    ],
)
def test_a_name_that_is_taken(law: Law, reason: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(TypeError, match=reason):
        read(monkeypatch, law)


def test_a_law_with_parameters_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    read(monkeypatch, dataclasses.replace(OWN, parameters=(Parameter("own_gain", "x"),)))
