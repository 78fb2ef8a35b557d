"""Saved trajectories: whole or not there, bounded, by name only."""

import errno
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from motionlab import files
from motionlab.config.named_configs import data_root
from motionlab.errors import ConfigError, Shipped, StoreError, StoreFull, Unknown
from motionlab.files import Summaries
from motionlab.library import trajectories
from motionlab.library.named_documents import SIZE_MAX
from motionlab.library.trajectories import Trajectories

TABLE = {"kind": "path", "points": [[0.0, 0.0], [0.01, 0.02]], "v_max": 0.1, "a_max": 1.0}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path / "data"))
    return tmp_path / "data" / "trajectories"


@pytest.fixture
def store(folder):
    return Trajectories(count_max=3)


def own(store):
    return [entry.name for entry in store.all() if not entry.shipped]


def kind(name):
    entry = Trajectories().entry(name, shipped=False)
    return None if entry is None else entry.kind


def test_what_is_saved_is_found_again(store):
    assert own(store) == []
    store.write("mine", TABLE)
    store.write("another", TABLE | {"v_max": 0.2})
    assert own(store) == ["another", "mine"]
    assert store.read("mine") == TABLE
    store.write("mine", TABLE | {"v_max": 0.3})
    assert store.read("mine")["v_max"] == 0.3
    store.delete("mine")
    with pytest.raises(Unknown, match="no trajectory 'mine'"):
        store.delete("mine")
    assert own(store) == ["another"]


def test_what_ships_is_read_and_not_changed(store, folder):
    assert store.get("rhombus").shipped
    for change in (store.delete, lambda name: store.put(name, TABLE)):
        with pytest.raises(Shipped, match="'rhombus' ships"):
            change("rhombus")
    assert not folder.exists()


@pytest.mark.parametrize("name", ["../etc", "a/b", "", "UP", "a" * 65, ".hidden", "a.b"])
def test_a_name_is_never_a_path(store, name):
    for call in (store.read, store.delete, lambda n: store.write(n, TABLE)):
        with pytest.raises(StoreError, match="is not a name"):
            call(name)


def test_count_and_size_are_bounded(store):
    for name in ("a", "b", "c"):
        store.write(name, TABLE)
    with pytest.raises(StoreFull, match="3 trajectories are saved already"):
        store.write("d", TABLE)
    store.write("a", TABLE | {"v_max": 0.5})
    with pytest.raises(StoreFull, match="bytes"):
        store.write("a", {"text": "x" * SIZE_MAX})
    assert store.read("a")["v_max"] == 0.5


def test_a_failed_write_leaves_what_was_there(store, folder, monkeypatch):
    store.write("mine", TABLE)

    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(StoreFull, match="No space left"):
        store.write("mine", TABLE | {"v_max": 0.9})
    assert store.read("mine") == TABLE
    assert [path.name for path in folder.iterdir()] == ["mine.toml"]


def test_a_folder_that_cannot_be_made_is_told(store, folder):
    folder.parent.write_text("a file")
    assert own(store) == []
    with pytest.raises(StoreError, match="mine cannot be saved: Not a directory"):
        store.write("mine", TABLE)


def test_a_folder_that_cannot_be_written_is_told(store, monkeypatch):
    store.write("mine", TABLE)

    def denied(*_, **__):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(tempfile, "mkstemp", denied)
    monkeypatch.setattr(Path, "unlink", denied)
    with pytest.raises(StoreError, match="cannot be saved: Permission denied"):
        store.write("mine", TABLE | {"v_max": 0.2})
    with pytest.raises(StoreError, match="cannot be deleted: Permission denied"):
        store.delete("mine")
    assert store.read("mine") == TABLE


def test_the_kind_is_read_without_the_points(store, monkeypatch):
    store.write("mine", TABLE)
    monkeypatch.setattr(trajectories, "parse_text", None)
    assert kind("mine") == "path"


def test_a_file_is_looked_at_once_until_it_changes(store, folder, monkeypatch):
    parsed = []
    parse = trajectories.parse_text
    monkeypatch.setattr(
        trajectories, "parse_text", lambda *a, **k: parsed.append(1) or parse(*a, **k)
    )
    store.write("mine", TABLE)
    path = folder / "mine.toml"
    for text, its_kind in (('# by hand\nkind = "line"', "line"), ("damaged", ""), ("x = 1", "")):
        path.write_text(text)
        parsed.clear()
        for _ in range(3):
            assert kind("mine") == its_kind
        assert len(parsed) == 1
    path.unlink()
    assert kind("mine") is None


def test_a_file_too_large_is_not_read(store, folder):
    store.write("mine", TABLE)
    (folder / "mine.toml").write_text('kind = "path"\n' + "#" * SIZE_MAX)
    assert kind("mine") == ""
    with pytest.raises(ConfigError, match="mine: is too large"):
        store.read("mine")


def test_a_pipe_or_a_link_to_itself_is_no_trajectory(store, folder):
    store.write("mine", TABLE)
    os.mkfifo(folder / "pipe.toml")
    (folder / "loop.toml").symlink_to(folder / "loop.toml")
    for name in ("pipe", "loop"):
        with pytest.raises(Unknown):
            store.read(name)
        assert kind(name) is None
    assert own(store) == ["mine"]


def test_an_index_is_bounded(tmp_path):
    read = []
    index = Summaries(lambda path: read.append(path.name) or path.name, most=2)
    for name in "abc":
        (tmp_path / name).write_text(name)
    for name in "abbcb":
        assert index.of(tmp_path / name) == name
    assert read == ["a", "b", "c"]
    index.of(tmp_path / "a")
    assert read == ["a", "b", "c", "a"]


def test_leftovers_of_a_killed_process_are_removed(tmp_path):
    """A process that writes holds a lock; one that was killed has left it."""
    writing = (
        "import os, signal, sys\nfrom pathlib import Path\nfrom motionlab import files\n"
        "os.fsync = lambda _: (print(flush=True), sys.stdin.read(1))\n"
        "files.replace(Path(sys.argv[1]) / 'jobs' / 'x', b'1')"
    )
    command = [sys.executable, "-c", writing, str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        [part] = (tmp_path / "jobs").iterdir()
        os.utime(part, (0, 0))
        files.remove_leftovers(tmp_path)
        assert part.exists()
        process.kill()
        process.wait()
    (tmp_path / "jobs" / "kept.jsonl").touch()
    files.remove_leftovers(tmp_path)
    assert [path.name for path in (tmp_path / "jobs").iterdir()] == ["kept.jsonl"]
    files.remove_leftovers(tmp_path / "not there")


def test_the_folder_of_data_is_a_setting(monkeypatch):
    monkeypatch.setenv("MOTIONLAB_DATA", "/somewhere")
    assert data_root() == Path("/somewhere")
    monkeypatch.delenv("MOTIONLAB_DATA")
    assert data_root() == Path("data")
