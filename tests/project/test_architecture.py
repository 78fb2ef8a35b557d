"""docs/architecture.md has one row for each room, in the order in which imports may point."""

from __future__ import annotations

import re
import tomllib

from tests.paths import ROOT

PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")


def rows(head: str) -> list[str]:
    """Return the names in the first column of the table that begins with a head."""
    table = PAGE.partition(head)[2].partition("\n\n")[0]
    return re.findall(r"^\| `([\w/]+)` \|", table, re.MULTILINE)


def floors() -> list[set[str]]:
    """Return the rooms of each floor, from the bottom up, as the contract of imports has them."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    (contract,) = (each for each in contracts if each["type"] == "layers")
    return [set(re.findall(r"\w+", layer)) for layer in reversed(contract["layers"])]


def test_every_room_of_the_backend_has_a_row() -> None:
    package = ROOT / "backend" / "motionlab"
    rooms = {path.name for path in package.iterdir() if (path / "__init__.py").exists()}
    rooms |= {path.stem for path in package.glob("[a-z]*.py")}
    assert set(rows("| room |")) == rooms


def test_rows_stand_in_the_order_of_the_floors() -> None:
    level = {room: height for height, floor in enumerate(floors()) for room in floor}
    heights = [level[name] for name in rows("| room |")]
    assert heights == sorted(heights)


def test_the_picture_of_the_rooms_has_the_floors() -> None:
    picture = PAGE.partition("at the end.\n\n")[2].partition("\n\n")[0]
    drawn = [set(re.findall(r"\w+", line[:60])) for line in picture.splitlines()]
    assert drawn == floors()[::-1]


def test_every_folder_of_the_page_has_a_row() -> None:
    source = ROOT / "frontend" / "src"
    found = {path.name for path in source.iterdir() if path.is_dir()}
    named = {name.partition("/")[0] for name in rows("| folder of `frontend/src` |")}
    assert named == found
