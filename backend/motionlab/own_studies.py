"""Files of studies and views of one's own: read, checked, and called with their errors placed.

They lie in folders that MOTIONLAB_STUDIES names, or are modules of installed packages with an entry
point of the group ``motionlab.studies``. A file declares a `STUDY`, a `VIEW`, or both.
"""

from __future__ import annotations

import contextlib
import functools
import json
import os
import signal
import threading
from collections.abc import Callable, Iterator
from types import ModuleType
from typing import TYPE_CHECKING, Any

from motionlab.declarations import NAME_MAX, DeclarationError
from motionlab.errors import FieldError, MotionLabError
from motionlab.own_files import OwnFile, own_files

if TYPE_CHECKING:
    from pydantic import BaseModel

VARIABLE = "MOTIONLAB_STUDIES"
"""Of the environment: folders and files of studies and views, joined as in PATH."""
ENTRY_POINTS = "motionlab.studies"
"""Group of entry points of packages that have studies or views."""
SECONDS = 10.0
"""Time that a file may take to be imported by a command, s."""
PROBLEMS: list[FieldError] = []
"""Why files are not taken."""


@functools.cache
def module_of(file: OwnFile) -> ModuleType:
    """Return what a file is, imported once.

    Raises
    ------
    DeclarationError
        If it cannot be run, or not within `SECONDS`.
    """
    with _bounded():
        return file.imported()


@contextlib.contextmanager
def _bounded() -> Iterator[None]:
    """Raise TimeoutError, in the line that then runs, after `SECONDS`."""
    if threading.current_thread() is not threading.main_thread():
        yield  # of a server, which has had the file checked
        return

    def late(*_: object) -> None:
        raise TimeoutError(f"has not ended within {SECONDS:g} s: an endless loop")

    former = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, former)


def declared(variable: str) -> Iterator[tuple[Any, OwnFile]]:
    """Yield what files declare in a variable, ``STUDY`` or ``VIEW``; note what cannot be run."""
    for file in own_files(os.environ.get(VARIABLE, ""), ENTRY_POINTS):
        names = [name for name in ("STUDY", "VIEW") if file.declares(name)]
        try:
            if not names and variable == "STUDY":  # noted once
                file.check_syntax()
                raise wrong(file, "STUDY", "is not declared by this file, nor is VIEW")
            if variable in names:
                yield getattr(module_of(file), variable, None), file
        except DeclarationError as error:
            note(error, file)


def note(error: DeclarationError, file: OwnFile) -> None:
    """Note why a file is not taken, once where two declarations of it fail alike."""
    problem = error.error.at(str(file.path))
    if problem not in PROBLEMS:
        PROBLEMS.append(problem)


def wrong(file: OwnFile, loc: str, message: str, *of_value: Any) -> DeclarationError:
    """Return the error about a declaration of a file."""
    return DeclarationError(FieldError(loc, message, *of_value, place=str(file.path)))


def check_name(file: OwnFile, loc: str, name: Any, taken: frozenset[str], hyphen: str) -> None:
    """Check a name: small letters, digits and a hyphen, a letter first, and not another's.

    Raises
    ------
    DeclarationError
        If it is something else.
    """
    letters = isinstance(name, str) and name.replace(hyphen, "")
    plain = letters and letters.isascii() and letters.isalnum() and letters.islower()
    if not plain or not name[0].isalpha() or len(name) > NAME_MAX:
        allowed = f"small letters, digits and {hyphen}, a letter first, {NAME_MAX} at most"
        raise wrong(file, loc, "is no name", name, allowed)
    if name in taken:
        raise wrong(file, loc, "is the name of another; choose another", name)


def check_model(file: OwnFile, loc: str, model: Any) -> None:
    """Check that a class is a pydantic model with a JSON schema.

    Raises
    ------
    DeclarationError
        If it is something else.
    """
    from pydantic import BaseModel  # noqa: PLC0415 - with files of one's own alone

    if not (isinstance(model, type) and issubclass(model, BaseModel)):
        raise wrong(file, loc, "is no class of pydantic.BaseModel", model)
    try:
        model.model_json_schema()
    except Exception as error:
        raise wrong(file, loc, f"has no JSON schema: {error}") from error


def placed(file: OwnFile, function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function of a file whose unexpected errors name the file and its line."""

    @functools.wraps(function)
    def call(*arguments: Any, **keywords: Any) -> Any:
        try:
            return function(*arguments, **keywords)
        except (MotionLabError, MemoryError):
            raise
        except (Exception, SystemExit) as error:
            raise DeclarationError(file.raised(error)) from error

    return call


def check_document(file: OwnFile, loc: str, document: Any, model: type[BaseModel]) -> Any:
    """Return a document that JSON can hold.

    Raises
    ------
    DeclarationError
        If it is of another class, or has a number that is not finite.
    """
    if not isinstance(document, model):
        raise wrong(file, loc, f"returns no {model.__name__}", type(document).__name__)
    try:
        json.dumps(document.model_dump(mode="json"), allow_nan=False)
    except ValueError as error:
        raise wrong(file, loc, f"returns what JSON cannot hold: {error}") from error
    return document
