"""docs/architecture.md has one row for each package, in the order in which imports may point."""

from __future__ import annotations

import re
import tomllib

from tests.paths import ROOT

PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")


def rows(head: str) -> list[str]:
    """Return the names in the first column of the table that begins with a head."""
    table = PAGE.partition(head)[2].partition("\n\n")[0]
    return re.findall(r"^\| `([\w/]+)` \|", table, re.MULTILINE)


def test_every_package_of_the_backend_has_a_row() -> None:
    package = ROOT / "backend" / "motionlab"
    found = {path.name for path in package.iterdir() if (path / "__init__.py").exists()}
    assert set(rows("| package |")) == found | {
        "errors",
        "problems",
        "plain_text",
        "progress",
        "tables",
        "units",
    }


def test_rows_stand_in_the_order_of_the_layers() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    (contract,) = settings["tool"]["importlinter"]["contracts"]
    level = {
        name: height
        for height, layer in enumerate(reversed(contract["layers"]))
        for name in re.findall(r"\w+", layer)
    }
    heights = [level[name] for name in rows("| package |")]
    assert heights == sorted(heights)


def test_every_folder_of_the_page_has_a_row() -> None:
    source = ROOT / "frontend" / "src"
    found = {path.name for path in source.iterdir() if path.is_dir()}
    named = {name.partition("/")[0] for name in rows("| folder of `frontend/src` |")}
    assert named == found
