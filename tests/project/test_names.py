"""Names say what they hold: participles without an object are refused."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from tests.paths import ROOT

PACKAGE = ROOT / "backend" / "motionlab"
REFUSED = {"found", "told", "asked", "said", "wanted", "given"}

SERVED = {
    "found": {
        "drive/commissioning/record.py",
        "drive/plug/status.py",
        "studies/identify/documents.py",
    }
}
"""Names of REST documents, and the files that declare them: they stay."""


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
    return sum(word in REFUSED and place not in SERVED.get(word, ()) for word in words)


def test_names_say_what_they_hold() -> None:
    files = PACKAGE.rglob("*.py")
    uses = Counter({file.relative_to(PACKAGE).as_posix(): refused(file) for file in files})
    assert +uses == {}


def test_files_of_the_page_say_what_they_hold() -> None:
    paths = (ROOT / "frontend" / "src").rglob("*.*")
    assert [path.name for path in paths if path.name.split(".")[0] in REFUSED] == []
