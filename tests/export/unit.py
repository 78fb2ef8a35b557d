"""Exported units, unpacked and driven as an importer drives them."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import fmpy
from fmpy.fmi3 import FMU3Slave


class Unit:
    """One instance of an FMU, in its step mode unless it is to be initialised later."""

    def __init__(
        self, path: Path, start: Mapping[str, Any] | None = None, *, initialised: bool = True
    ) -> None:
        self.description: Any = fmpy.read_model_description(str(path))
        self.variables = {each.name: each for each in self.description.modelVariables}
        self.messages: list[str] = []
        folder = tempfile.mkdtemp(dir=path.parent)
        self.fmu: Any = FMU3Slave(
            guid=self.description.guid,
            unzipDirectory=fmpy.extract(str(path), folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="unit",
        )
        self.fmu.instantiate(
            logMessage=lambda _e, _s, _c, text: self.messages.append(text.decode())
        )
        self.time = 0.0
        for name, value in (start or {}).items():
            self.set({name: value})
        if initialised:
            self.initialise()

    def initialise(self) -> None:
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def references(self, names: Sequence[str]) -> list[int]:
        return [self.variables[name].valueReference for name in names]

    def set(self, values: Mapping[str, Any]) -> None:
        for name, value in values.items():
            if isinstance(value, bool):
                self.fmu.setBoolean(self.references([name]), [value])
            else:
                self.fmu.setFloat64(self.references([name]), [value])

    def get(self, names: Sequence[str]) -> list[float]:
        return self.fmu.getFloat64(self.references(names))

    def step(self, seconds: float) -> None:
        self.fmu.doStep(self.time, seconds)
        self.time += seconds

    @property
    def outputs(self) -> list[str]:
        return [each.name for each in self.variables.values() if each.causality == "output"]
