"""Writing a variant's controller as a folder of C99, with test vectors and a check."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from string import Template

from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.export.controller_code import ControllerCode, controller_code
from motionlab.export.sources import SOURCE, TABLES_FILE, scenario_facts
from motionlab.export.vectors import simulated_vectors, vector_file
from motionlab.files import failure, replace
from motionlab.simulation.prepare import prepare
from motionlab.targets.record_values import RecordError
from motionlab.timing import CONTROL_PERIOD

VECTOR_TIME = 10.0
"""Length of the test vectors where none is given, s."""

_MARK = "psrm_controller.h"
"""What tells a folder of a former export from any other."""


@dataclass(frozen=True)
class Export:
    """Files of an exported controller.

    Attributes
    ----------
    files : tuple of str
        Names in the folder.
    scenario_hash : str
        SHA-256 of its scenario.toml.
    periods : int
        Control periods in the test vectors.
    """

    files: tuple[str, ...]
    scenario_hash: str
    periods: int

    @property
    def seconds(self) -> float:
        """Length of the test vectors, s."""
        return self.periods * CONTROL_PERIOD


def export_controller(
    scenario: Scenario, variant: str, folder: Path, *, seconds: float = VECTOR_TIME
) -> Export:
    """Write a variant's controller as C99, with test vectors of its simulation.

    Parameters
    ----------
    scenario : Scenario
        Resolved scenario; exported is the controller that it begins with.
    variant : str
        One of its variants.
    folder : Path
        New, empty, or of a former export, whose files are replaced.
    seconds : float
        Longest test vectors, s.

    Raises
    ------
    ConfigError
        If there is no such variant, the folder holds something else, the vectors are empty, or the
        law cannot be recorded.
    Infeasible
        If the motor cannot follow the trajectory.
    StoreError
        If a file cannot be written.
    """
    _check_variant(scenario, variant)
    _check_folder(folder)
    if not seconds >= CONTROL_PERIOD:
        allowed = f">= {CONTROL_PERIOD:g}"
        raise ConfigError(FieldError("--seconds", "is too short", seconds, allowed, "s"))
    prepared = prepare(scenario)
    vectors = simulated_vectors(prepared, variant, seconds)
    if not len(vectors):
        raise ConfigError(FieldError(f"variants.{variant}", "diverges in its first period"))
    code = controller_of_variant(scenario, variant)
    toml, facts = scenario_facts(scenario, code.tables)
    facts |= {
        "variant": variant,
        "periods": str(len(vectors)),
        "seconds": f"{len(vectors) * CONTROL_PERIOD:g}",
        **code._asdict(),
    }
    files = {"scenario.toml": toml, "vectors.bin": vector_file(vectors)}
    for path in sorted(SOURCE.iterdir()):
        if path.suffix != ".in":
            files[path.name] = path.read_bytes()
        elif path.stem != TABLES_FILE or code.tables:
            files[path.stem] = Template(path.read_text("utf-8")).substitute(facts).encode()
    path = folder
    try:
        for name, content in files.items():
            path = folder / name
            replace(path, content, mode=None)
        if not code.tables:  # of a former export
            path = folder / TABLES_FILE
            path.unlink(missing_ok=True)
    except OSError as error:
        raise failure(f"{path}: cannot be written", error) from error
    return Export(tuple(sorted(files)), facts["hash"], len(vectors))


def controller_of_variant(scenario: Scenario, variant: str) -> ControllerCode:
    """Return the controller of a variant as C.

    Raises
    ------
    ConfigError
        If there is no such variant, or its law cannot be recorded.
    """
    _check_variant(scenario, variant)
    try:
        return controller_code(scenario, variant)
    except RecordError as error:
        law = scenario.variants[variant].controller.compensation.law
        loc = f"variants.{variant}.controller.compensation.law"
        raise ConfigError(FieldError(loc, f"cannot be written as C: {error}", law)) from error


def _check_variant(scenario: Scenario, variant: str) -> None:
    if variant not in scenario.variants:
        allowed = " or ".join(scenario.variants)
        raise ConfigError(FieldError("--variant", "is no variant of it", variant, allowed))
    if scenario.learnt is not None and scenario.variants[variant].controller.learnt:
        place = f"variants.{variant}.controller.learnt"
        raise ConfigError(FieldError(place, "a learnt force is not written as C", True))


def _check_folder(folder: Path) -> None:
    """Refuse a folder with files that are no export: some names, like Makefile, are common."""
    try:
        entries = list(folder.iterdir()) if folder.exists() else []
    except OSError as error:
        raise ConfigError(
            FieldError("PATH", f"cannot be read: {error.strerror}", str(folder))
        ) from None
    if entries and not (folder / _MARK).is_file():
        raise ConfigError(FieldError("PATH", "has files that are no export", str(folder)))
