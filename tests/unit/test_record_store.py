"""Records of jobs: kept, found, bounded in number and size."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from motionlab.store import records
from motionlab.store.records import RecordStore


def test_what_is_kept_is_found(tmp_path: Path) -> None:
    store = RecordStore(tmp_path / "jobs")
    assert store.summaries() == []
    assert store.read("A" * 12) is None
    assert store.keep("A" * 12, b'{"id": 1}', b'{"whole": 1}')
    assert store.summaries() == [b'{"id": 1}\n']
    assert store.read("A" * 12) == b'{"whole": 1}\n'


def test_the_oldest_go_first(tmp_path: Path) -> None:
    store = RecordStore(tmp_path, files_max=2)
    for age, letter in ((30, "C"), (20, "B"), (10, "A")):
        store.keep(letter * 12, letter.encode(), b"{}")
        path = tmp_path / f"{letter * 12}.jsonl"
        os.utime(path, (1e9 - age, 1e9 - age))
    assert store.summaries() == [b"B\n", b"A\n"]


def test_names_are_no_paths(tmp_path: Path) -> None:
    (tmp_path / "outside.jsonl").write_bytes(b"a\nb\n")
    store = RecordStore(tmp_path / "jobs")
    assert store.read("../outside") is None
    assert store.read("../../../etc") is None


def test_too_large_is_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(records, "SIZE_MAX", 10)
    store = RecordStore(tmp_path)
    assert not store.keep("A" * 12, b"{}", b"x" * 11)
    assert store.summaries() == []
