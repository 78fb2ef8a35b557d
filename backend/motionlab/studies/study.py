"""A study: a computation over many simulations, offered as a route, a job and a command.

A study is checked when it is asked for and again where it runs:

    request -> plan (checked) -> run (progress, partial results, cancellation) -> document -> report

`motionlab.studies.table` lists all studies; the service makes of each a route and the report of its
jobs, the command line a command.
"""

from __future__ import annotations

import argparse
import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar, Generic, NamedTuple, Protocol, TypeVar

from pydantic import BaseModel

from motionlab.errors import FieldError

Source = str | Path | dict[str, Any]
Progress = Callable[..., None]
"""Takes the share done, 0 to 1, and what is there so far; what it raises ends the study."""

PlanT = TypeVar("PlanT")
FoundT = TypeVar("FoundT")


class Models(NamedTuple):
    """Types of what goes in and comes out; ``partial`` is None where nothing is told meanwhile."""

    request: type[BaseModel]
    document: type[BaseModel]
    partial: type[BaseModel] | None = None


class Bounds(Protocol):
    """What a server allows one request; `motionlab.service.settings.Settings` has the numbers."""

    @property
    def direct_max(self) -> float: ...  # noqa: D102

    @property
    def work_max(self) -> float: ...  # noqa: D102

    @property
    def trials_max(self) -> float: ...  # noqa: D102

    @property
    def map_vertices_max(self) -> int: ...  # noqa: D102


class Command(NamedTuple):
    """A study's command.

    Attributes
    ----------
    name : str
        What follows ``motionlab``.
    help : str
        One line for the list of commands.
    description, examples : str
        Head and end of its own help.
    scenario : str or None
        What stands before the help of its scenario; None without one.
    set : str
        Help of ``--set``.
    title : str
        What its progress is called.
    """

    name: str
    help: str
    description: str
    examples: str
    scenario: str | None = ""
    set: str | None = "change a field of the scenario (repeatable, all applied together)"
    title: str = ""


class Study(ABC, Generic[PlanT, FoundT]):
    """One study; its docstring describes its operation.

    Imports of its models and its computation stand in its methods, so that ``motionlab --help``
    answers at once.
    """

    kind: ClassVar[str]
    """Name of the study, and kind of its jobs."""
    path: ClassVar[str]
    """Of its route, below /api/v1."""
    operation: ClassVar[str]
    """Identifier in the OpenAPI document."""
    tag: ClassVar[str]
    report_name: ClassVar[str] = ""
    """Name of the schema of its job's report."""
    bodies: ClassVar[tuple[dict[str, Any], ...]] = ({},)
    """Examples of requests."""
    command: ClassVar[Command | None] = None
    direct: ClassVar[bool] = False
    """Whether it is answered at once, without a job."""
    light: ClassVar[bool] = False
    """Of a direct one, whether it takes milliseconds as a rule."""
    keeps: ClassVar[bool] = False
    """Whether what was found is kept, and answered at once when it is asked for again."""
    batches: ClassVar[bool] = False
    """Whether it needs the kernels of batches, which are compiled when a server first starts."""

    @abstractmethod
    def models(self) -> Models:
        """Return the types of request, document and partial result."""

    @abstractmethod
    def plan(self, request: Mapping[str, Any], source: Source | None = None) -> PlanT:
        """Return the study that a request asks for, checked.

        Parameters
        ----------
        request : mapping
            Its fields.
        source : str, Path or dict, optional
            The scenario in place of the request's, which is never a path.

        Raises
        ------
        ConfigError
            Naming every field that is wrong, its value, range and unit.
        Infeasible
            If the motor cannot follow the motion.
        """

    @abstractmethod
    def run(self, plan: PlanT, progress: Progress) -> FoundT:
        """Carry it out.

        Raises
        ------
        MotionLabError
            What only running it shows.
        """

    def report(self, found: FoundT) -> str:
        """Return what was found as text for people; the document where there is no other."""
        return self.text(found)

    def excess(self, plan: PlanT, bounds: Bounds) -> list[FieldError]:
        """Return in what a plan is too large for one request."""
        return []

    def kept(self, plan: PlanT) -> FoundT | None:
        """Return what was found before, where that is kept."""
        return None

    def document(self, found: FoundT) -> Any:
        """Return the document of what was found."""
        return found

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add the options of its command beside scenario, ``--set`` and ``--json``."""

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request that options of the command make, with the changes of ``--set``."""
        return {"scenario": options.scenario, "set": changes}

    def before(self, plan: PlanT, options: argparse.Namespace) -> str | None:
        """Check options that do not belong to the request; return text to print instead of running.

        Raises
        ------
        ConfigError
            Such as for a file that could not be written.
        """
        return None

    def after(self, found: FoundT, options: argparse.Namespace) -> None:
        """Write the files that options ask for."""

    def text(self, found: FoundT) -> str:
        """Return the document as JSON, as ``--json`` prints it."""
        return json.dumps(
            self.document(found).model_dump(mode="json", by_alias=True), allow_nan=False
        )

    def has_failed(self, found: FoundT) -> bool:
        """Tell whether the command ends with exit code 1."""
        return False


def above(value: float, most: float, *, loc: str, message: str) -> list[FieldError]:
    """Return an error where a simulated time, s, is above a bound, else none."""
    if value <= most:
        return []
    shown = float(f"{value:.6g}")
    return [FieldError(loc=loc, message=message, value=shown, range=f"<= {most:g}", unit="s")]
