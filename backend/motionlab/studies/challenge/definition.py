"""What the challenge is: its scenarios, motors and controller, frozen in ``challenge.toml``."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from motionlab.config.includes import resolve
from motionlab.config.load import load_scenario
from motionlab.config.named_configs import config_root, parse
from motionlab.config.scenario import Scenario
from motionlab.studies.challenge.score import LIMITS, WEIGHTS
from motionlab.studies.montecarlo.documents import DEFAULT

_WORDS = frozenset({"title", "description"})

Compensations = Sequence[Mapping[str, Any]]
"""Tables ``compensation`` of controllers that are alike in all else."""


@dataclass(frozen=True)
class Definition:
    """The challenge.

    Attributes
    ----------
    version : int
        Raised with every change.
    seed : int
        Of the drawn motors.
    motors : int
        How many are drawn for a scenario.
    on_motors : tuple of str
        Scenarios that are also run on drawn motors.
    margins : tuple of str
        Shipped motors with which margins are taken.
    controller : dict
        Tables of the controller that all laws share.
    scenarios : dict of str to dict
        Tables by name, without variants.
    """

    version: int
    seed: int
    motors: int
    on_motors: tuple[str, ...]
    margins: tuple[str, ...]
    controller: dict[str, Any]
    scenarios: dict[str, dict[str, Any]]

    def scenario(self, name: str, compensations: Compensations) -> Scenario:
        """Return a scenario with a variant for each law.

        Raises
        ------
        ConfigError
            If a parameter of a law is not valid.
        """
        return _with_laws(self._tables(name), compensations)

    def on_motor(self, motor: str, compensations: Compensations) -> Scenario:
        """Return the controllers on a shipped motor, of which margins are taken; see `scenario`."""
        tables = self._tables(next(iter(self.scenarios))) | {"plant": motor}
        return _with_laws(resolve(tables), compensations)

    def digest(self) -> str:
        """Return the SHA-256 of all that decides, motors and trajectories resolved, no words."""
        parts: dict[str, Any] = {
            "version": self.version,
            "seed": self.seed,
            "motors": self.motors,
            "on_motors": self.on_motors,
            "margins": {name: resolve({"plant": name}) for name in self.margins},
            "scenarios": {name: self._tables(name) for name in self.scenarios},
            "vary": [each.model_dump(mode="json") for each in DEFAULT],
            "weights": WEIGHTS,
            "limits": LIMITS,
        }
        text = json.dumps(_without_words(parts), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()

    def _tables(self, name: str) -> dict[str, Any]:
        variants = {"A": {"controller": self.controller}}
        return resolve({"name": name} | self.scenarios[name] | {"variants": variants})


def definition() -> Definition:
    """Return the shipped definition.

    Raises
    ------
    ConfigError
        If its file is not there.
    """
    tables = parse(config_root() / "challenge.toml", loc="challenge.toml")
    tables |= {name: tuple(tables[name]) for name in ("on_motors", "margins")}
    return Definition(**tables)


def _with_laws(tables: dict[str, Any], compensations: Compensations) -> Scenario:
    variant = tables["variants"]["A"]
    letters = [chr(ord("A") + number) for number in range(len(compensations))]
    tables = tables | {"variants": {letter: variant for letter in letters}}
    return load_scenario(
        tables,
        {
            f"variants.{letter}.controller.compensation": dict(each)
            for letter, each in zip(letters, compensations, strict=True)
        },
    )


def _without_words(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _without_words(each) for key, each in value.items() if key not in _WORDS}
    return [_without_words(each) for each in value] if isinstance(value, list | tuple) else value
