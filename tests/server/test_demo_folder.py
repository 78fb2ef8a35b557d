"""The folder of a demo: what a new one replaces there, and what it refuses to touch."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from motionlab.errors import MotionLabError
from motionlab.server import demo


@pytest.fixture
def data(monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, bytes]]:
    """A page of one file, and the data that the next demo has."""
    data = {"lanes.js": b"one"}
    monkeypatch.setattr(demo, "page_root", Path)
    page = {"index.html": b"<title></title>", "assets/page.js": b""}
    monkeypatch.setattr(demo, "_page_files", lambda _: page)
    monkeypatch.setattr(demo, "_data_files", lambda: data)
    yield data


def names(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*"))


def test_a_demo_replaces_another_and_nothing_else(data: dict[str, bytes], tmp_path: Path) -> None:
    kept = {".git": "of version control", "CNAME": "of the host"}
    for name, text in kept.items():
        (tmp_path / name).write_text(text)
    demo.write_demo(tmp_path)
    first = names(tmp_path)
    (folder,) = tmp_path.glob("data-*")
    data["lanes.js"] = b"two"
    demo.write_demo(tmp_path)
    assert {name: (tmp_path / name).read_text() for name in kept} == kept
    assert not folder.exists()
    assert len(names(tmp_path)) == len(first)
    (folder,) = tmp_path.glob("data-*")
    assert (folder / "lanes.js").read_bytes() == b"two"
    assert f'content="{folder.name}/"' in (tmp_path / "index.html").read_text()


def test_a_folder_of_something_else_stays(data: dict[str, bytes], tmp_path: Path) -> None:
    other = tmp_path / "data" / "lanes.js"
    other.parent.mkdir()
    other.touch()
    with pytest.raises(MotionLabError, match=r"not empty, and data/lanes\.js is of no demo"):
        demo.write_demo(tmp_path)
    assert names(tmp_path) == ["data", "data/lanes.js"]
    with pytest.raises(MotionLabError, match="no folder"):
        demo.write_demo(other)


def test_a_file_beside_a_demo_stays(data: dict[str, bytes], tmp_path: Path) -> None:
    demo.write_demo(tmp_path)
    (tmp_path / "assets" / "thesis.tex").touch()
    before = names(tmp_path)
    with pytest.raises(MotionLabError, match="assets/thesis"):
        demo.write_demo(tmp_path)
    assert names(tmp_path) == before


def test_a_manifest_names_files_of_its_folder_only(data: dict[str, bytes], tmp_path: Path) -> None:
    other = tmp_path / "thesis.tex"
    other.touch()
    folder = tmp_path / "site"
    demo.write_demo(folder)
    (folder / "motionlab-demo.json").write_text('["motionlab-demo.json", "../thesis.tex"]')
    with pytest.raises(MotionLabError, match="is of no demo"):
        demo.write_demo(folder)
    assert other.exists()


def test_a_demo_stays_where_the_next_fails(
    data: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    demo.write_demo(tmp_path)
    before = names(tmp_path)

    def fail() -> dict[str, bytes]:
        raise MotionLabError("no memory")

    monkeypatch.setattr(demo, "_data_files", fail)
    with pytest.raises(MotionLabError, match="no memory"):
        demo.write_demo(tmp_path)
    assert names(tmp_path) == before


def test_a_link_to_a_demo_replaces_that_demo(data: dict[str, bytes], tmp_path: Path) -> None:
    folder, link = tmp_path / "site", tmp_path / "link"
    demo.write_demo(folder)
    link.symlink_to(folder)
    data["lanes.js"] = b"two"
    demo.write_demo(link)
    assert link.is_symlink()
    assert len([*folder.glob("data-*")]) == 1
