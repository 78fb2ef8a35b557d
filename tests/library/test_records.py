"""Records of jobs: kept, found, bounded in number and size."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from motionlab.errors import StoreError
from motionlab.library import job_records as records
from motionlab.library.job_records import RecordStore


def test_what_is_kept_is_found(tmp_path: Path) -> None:
    store = RecordStore(tmp_path / "jobs")
    assert store.summaries() == []
    assert store.read("A" * 12) is None
    store.keep("A" * 12, b'{"id": 1}', b'{"whole": 1}')
    assert store.summaries() == [b'{"id": 1}\n']
    assert store.read("A" * 12) == b'{"whole": 1}\n'
    store.keep("A" * 12, b'{"id": 2}', b'{"whole": 2}')
    assert store.summaries() == [b'{"id": 2}\n']
    store.drop("A" * 12)
    store.drop("A" * 12)
    assert store.summaries() == []


def test_a_pipe_is_no_record(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / f"{'A' * 12}.jsonl")
    store = RecordStore(tmp_path)
    assert store.summaries() == []
    assert store.read("A" * 12) is None


def test_a_link_to_itself_is_no_record(tmp_path: Path) -> None:
    link = tmp_path / f"{'A' * 12}.jsonl"
    link.symlink_to(link)
    assert RecordStore(tmp_path).summaries() == []


def test_the_oldest_go_first(tmp_path: Path) -> None:
    store = RecordStore(tmp_path, files_max=2)
    for age, letter in ((30, "C"), (20, "B"), (10, "A")):
        store.keep(letter * 12, letter.encode(), b"{}")
        path = tmp_path / f"{letter * 12}.jsonl"
        os.utime(path, (1e9 - age, 1e9 - age))
    assert store.summaries() == [b"B\n", b"A\n"]


def test_a_clock_set_back_costs_nothing_that_was_just_kept(tmp_path: Path) -> None:
    store = RecordStore(tmp_path, files_max=3)
    for letter in "ABC":
        store.keep(letter * 12, letter.encode(), b"{}")
        os.utime(tmp_path / f"{letter * 12}.jsonl", (4e9 + ord(letter), 4e9 + ord(letter)))
    for letter in "DE":
        store.keep(letter * 12, letter.encode(), b"{}")
        assert store.read(letter * 12) == b"{}\n"
    assert store.summaries() == [b"C\n", b"D\n", b"E\n"]


def test_a_damaged_record_is_read_in_bounds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(records, "SUMMARY_MAX", 10)
    store = RecordStore(tmp_path)
    with pytest.raises(StoreError, match="too large"):
        store.keep("A" * 12, b"x" * 10, b"{}")
    store.keep("B" * 12, b"{}", b"{}")
    (tmp_path / f"{'C' * 12}.jsonl").write_bytes(b"x" * 100_000)
    assert store.summaries() == [b"{}\n"]


def test_names_are_no_paths(tmp_path: Path) -> None:
    (tmp_path / "outside.jsonl").write_bytes(b"a\nb\n")
    store = RecordStore(tmp_path / "jobs")
    assert store.read("../outside") is None
    assert store.read("../../../etc") is None


def test_too_large_is_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(records, "SIZE_MAX", 10)
    store = RecordStore(tmp_path)
    with pytest.raises(StoreError, match="13 bytes is too large; 10 "):
        store.keep("A" * 12, b"{}", b"x" * 11)
    assert store.summaries() == []


def test_what_cannot_be_kept_is_said_without_the_path(tmp_path: Path) -> None:
    (tmp_path / "jobs").write_text("where the folder should be")
    store = RecordStore(tmp_path / "jobs")
    with pytest.raises(StoreError) as refused:
        store.keep("A" * 12, b"{}", b"{}")
    assert str(refused.value) == "the record cannot be written: File exists"
    store.drop("A" * 12)
