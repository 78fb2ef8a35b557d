"""A study: a computation over many simulations, offered as a route, a job and a command.

A study is checked on request and again where it runs:

    request -> plan (checked) -> run (progress, partial results, cancellation) -> document -> report

`motionlab.studies.table` lists all studies; each has a route and job reports in the service, and a
command on the command line.
"""

from __future__ import annotations

import argparse
import importlib
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

from motionlab.errors import FieldError

if TYPE_CHECKING:
    from pydantic import BaseModel

Source = str | Path | dict[str, Any]
Progress = Callable[..., None]
"""Takes the share done, 0 to 1, and the partial document; what it raises ends the study."""


class _Lazy:
    """A class attribute imported on first use."""

    def __init__(self, path: str) -> None:
        self._path = path

    def __get__(self, instance: object, owner: type) -> Any:
        module, _, name = self._path.partition(":")
        return getattr(importlib.import_module(f"motionlab.{module}"), name)


def lazy(path: str) -> Any:
    """Return a class attribute that is imported on use, ``module below motionlab:name``."""
    return _Lazy(path)


class RequestLimits(Protocol):
    """Limits of one request on a server; values in `motionlab.server.settings.Settings`."""

    @property
    def direct_max(self) -> float: ...  # noqa: D102

    @property
    def work_max(self) -> float: ...  # noqa: D102

    @property
    def trials_max(self) -> float: ...  # noqa: D102

    @property
    def map_vertices_max(self) -> int: ...  # noqa: D102


class StudyCommand(NamedTuple):
    """A study's command.

    Attributes
    ----------
    name : str
        Name after ``motionlab``.
    help : str
        One line for the list of commands.
    description, examples : str
        Head and end of its own help.
    scenario : str or None
        Prefix of the help of its scenario; None without one.
    set : str
        Help of ``--set``.
    title : str
        Label of its progress.
    """

    name: str
    help: str
    description: str
    examples: str
    scenario: str | None = ""
    set: str | None = "change a field of the scenario (repeatable, all applied together)"
    title: str = ""


class Study:
    """One study; its docstring describes its operation.

    Its models and functions are `lazy`, so that ``motionlab --help`` answers at once.
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
    request_model: ClassVar[type[BaseModel]]
    document_model: ClassVar[type[BaseModel]]
    partial_model: ClassVar[type[BaseModel] | None] = None
    """Of partial results; None without them."""
    planner: ClassVar[Any] = None
    """Takes the checked request and a scenario in place of its own; None: the request is the plan.
    """
    check_target: ClassVar[Any] = lazy("files:check_target")
    suffixes: ClassVar[tuple[str, ...]] = ()
    """Suffixes of files of ``--out``."""
    write: ClassVar[Any]
    """Writes the file of ``--out``."""
    bodies: ClassVar[tuple[dict[str, Any], ...]] = ({},)
    """Examples of requests."""
    command: ClassVar[StudyCommand | None] = None
    direct: ClassVar[bool] = False
    """Whether it is answered at once, without a job."""
    light: ClassVar[bool] = False
    """Of a direct one, whether it takes milliseconds as a rule."""
    keeps: ClassVar[bool] = False
    """Whether results are stored, and returned at once for the same request."""
    scatters: ClassVar[bool] = False
    """Whether it may be computed by a scheduler's workers."""
    batches: ClassVar[bool] = False
    """Whether it needs the kernels of batches, which are compiled when a server first starts."""

    def read(self, request: Mapping[str, Any]) -> Any:
        """Return a request, checked."""
        from motionlab.config.validation_errors import checked

        return checked(self.request_model, request, self.kind)

    def plan(self, request: Mapping[str, Any], source: Source | None = None) -> Any:
        """Return the checked plan of a request.

        Raises
        ------
        ConfigError
            Naming every field that is wrong, its value, range and unit.
        Infeasible
            If the motor cannot follow the motion.
        """
        checked = self.read(request)
        return checked if self.planner is None else self.planner(checked, source)

    def run(self, plan: Any, progress: Progress) -> Any:
        """Carry a plan out; returns the plan itself if checking is all.

        Raises
        ------
        MotionLabError
            Failures found only by running it.
        """
        return plan

    def report(self, result: Any) -> str:
        """Return the document of a result as text."""
        from motionlab.reports.document_text import document_text

        return document_text(self.document(result))

    def excess(self, plan: Any, bounds: RequestLimits) -> list[FieldError]:
        """Return the limit that a plan exceeds, if any."""
        return []

    def kept(self, plan: Any) -> Any | None:
        """Return an earlier result of the same request, if stored."""
        return None

    def document(self, result: Any) -> Any:
        """Return the document of a result."""
        return result

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add the options of its command other than scenario, ``--set`` and ``--json``."""

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the command's options, with the changes of ``--set``."""
        return {"scenario": options.scenario, "set": changes}

    def before(self, plan: Any, options: argparse.Namespace) -> str | None:
        """Check options that do not belong to the request; return text to print instead of running.

        Raises
        ------
        ConfigError
            Such as for a file that could not be written.
        """
        if getattr(options, "out", None) is not None:
            self.check_target(options.out, *self.suffixes)
        return None

    def after(self, result: Any, options: argparse.Namespace) -> None:
        """Write the file of ``--out``."""
        if getattr(options, "out", None) is not None:
            self.write(result, options.out)

    def text(self, result: Any) -> str:
        """Return the document as JSON, as ``--json`` prints it."""
        return json.dumps(
            self.document(result).model_dump(mode="json", by_alias=True), allow_nan=False
        )

    def has_failed(self, result: Any) -> bool:
        """Return whether the command ends with exit code 1."""
        return False


def above(value: float, most: float, *, loc: str, message: str) -> list[FieldError]:
    """Return an error where a simulated time, s, is above a bound, else none."""
    if value <= most:
        return []
    shown = float(f"{value:.6g}")
    return [FieldError(loc=loc, message=message, value=shown, unit="s", bounds={"maximum": most})]
