"""Names say what they hold: participles without an object are refused."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from tests.paths import ROOT

PACKAGE = ROOT / "backend" / "motionlab"
REFUSED = {"found", "told", "asked", "said", "wanted", "given"}

SERVED = {"found": "studies/identify/documents.py"}
"""Names of REST documents, and the files that declare them: they stay."""

LEFT = {
    "cli": 237,
    "control": 2,
    "drive": 147,
    "executors": 27,
    "files.py": 14,
    "force_sharing": 47,
    "kernel": 31,
    "lanes": 2,
    "library": 118,
    "motor_design": 6,
    "plant": 4,
    "scene3d": 19,
    "scripting": 62,
    "server": 230,
}
"""Uses left in the rooms that are not clean yet; a number may only fall."""


def names(tree: ast.AST) -> Iterator[str]:
    """Return what a module calls its variables, arguments, attributes, functions and classes."""
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name) | ast.arg(arg=name) | ast.Attribute(attr=name):
                yield name
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                yield name
            case ast.ClassDef(name=name):
                yield name
            case ast.MatchAs(name=str(name)) | ast.MatchStar(name=str(name)):
                yield name
            case ast.ExceptHandler(name=str(name)) | ast.alias(asname=str(name)):
                yield name
            case _:
                pass


def refused(path: Path) -> int:
    """Return the number of uses of refused names in a file, its own name among them."""
    place = path.relative_to(PACKAGE).as_posix()
    tree = ast.parse(path.read_text(encoding="utf-8"))
    words = [path.stem, *(name.strip("_") for name in names(tree))]
    return sum(word in REFUSED and SERVED.get(word) != place for word in words)


def test_names_say_what_they_hold() -> None:
    uses: Counter[str] = Counter()
    for path in PACKAGE.rglob("*.py"):
        uses[path.relative_to(PACKAGE).parts[0]] += refused(path)
    assert {room: count for room, count in uses.items() if count > LEFT.get(room, 0)} == {}


def test_no_room_is_listed_that_is_clean() -> None:
    assert all((PACKAGE / room).exists() and count > 0 for room, count in LEFT.items())
