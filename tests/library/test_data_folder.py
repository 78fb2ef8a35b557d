"""Files of the folder of data: whose they are, what is left behind, where they may lie."""

from __future__ import annotations

import os
import shutil
import stat
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
import sqlalchemy as sa

from motionlab.cli import main
from motionlab.errors import StoreError
from motionlab.library.database import VERSION, index_url
from motionlab.library.index import Index
from motionlab.library.library import Library
from motionlab.server.http.download import temporary_folder
from tests.library.sample_runs import made_by, sample
from tests.library.served import API, PATIENCE, Served

MEASURED = "time [s],x_act [mm]\n" + "".join(f"{i / 2000},{i}\n" for i in range(8))


def open_to_others(root: Path) -> list[str]:
    """Return what a folder holds that others than its owner may read or write."""
    return sorted(
        str(path.relative_to(root))
        for path in (root, *root.rglob("*"))
        if stat.S_IMODE(path.lstat().st_mode) & 0o077 and not path.is_symlink()
    )


@pytest.fixture
def usual_umask() -> Iterator[None]:
    before = os.umask(0o022)
    yield
    os.umask(before)


@pytest.mark.usefixtures("usual_umask")
def test_what_is_written_is_its_owners_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    root = tmp_path / "new" / "data"
    monkeypatch.setenv("MOTIONLAB_DATA", str(root))
    file = tmp_path / "measured.csv"
    file.write_text(MEASURED)
    assert main(["import", str(file)]) == 0
    assert main(["run", "circle", "--keep", "--set", "trajectory.laps=1"]) == 0
    assert (root / "runs.sqlite").stat().st_size > 0
    assert len(list((root / "runs").iterdir())) == 2
    assert open_to_others(root) == []


@pytest.mark.usefixtures("usual_umask")
def test_a_server_writes_for_its_owner_and_mends_what_earlier_ones_wrote(tmp_path: Path) -> None:
    data = tmp_path / "data"
    library = Library(data)
    library.index.put(run := sample())
    library.close()
    (data / "runs").mkdir(exist_ok=True)
    (data / "runs" / f"{run.id}.parquet").write_bytes(b"")
    outside = tmp_path / "outside"
    outside.write_text("")
    (data / "runs" / "link.parquet").symlink_to(outside)
    for path in (data, *data.rglob("*")):
        if not path.is_symlink():
            path.chmod(0o755 if path.is_dir() else 0o644)
    served = Served(data)
    try:
        path = served.play()
        end = time.monotonic() + PATIENCE
        while not list(data.glob("recording/r-*")):
            assert time.monotonic() < end
            time.sleep(0.02)
        served.client.post(f"{path}/pause").raise_for_status()
        # stderr.txt is this test's, so the folder is not the lab's alone.
        assert open_to_others(data) == [".", "stderr.txt"]
        assert outside.stat().st_mode & 0o777 == 0o644
    finally:
        served.kill()


def test_leftovers_of_killed_servers_go_and_those_of_live_ones_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    served = Served(tmp_path / "data", TMPDIR=str(tmp_path))

    def upload() -> Iterator[bytes]:
        while True:
            yield b"time,a\n"
            time.sleep(0.01)

    def send() -> None:
        headers = {"content-type": "application/octet-stream"}
        with pytest.raises(httpx.HTTPError):
            served.client.post(f"{API}/runs/import", content=upload(), headers=headers)

    sending = threading.Thread(target=send)
    sending.start()
    end = time.monotonic() + PATIENCE
    while not (left := list(tmp_path.glob("motionlab-*/upload"))):
        assert time.monotonic() < end
        time.sleep(0.02)
    served.process.kill()
    served.process.wait()
    sending.join()
    long = tmp_path / "data" / "motionlab-scratch-long"  # of a download that is too long for memory
    long.mkdir()
    with temporary_folder() as in_use:
        again = Served(tmp_path / "data", TMPDIR=str(tmp_path))
        again.end()
        assert in_use.is_dir()
    assert not left[0].parent.exists()
    assert not long.exists()
    assert not in_use.exists()


@pytest.mark.parametrize(
    ("variable", "value"),
    [
        ("MOTIONLAB_DATABASE_URL", "mysql://user:secret@host/lab"),
        ("MOTIONLAB_DATABASE_URL", "http://host/lab"),
        ("MOTIONLAB_DATABASE_URL", "sqlite:///"),
        ("MOTIONLAB_DATABASE_URL", "sqlite:///:memory:"),
        ("MOTIONLAB_DATABASE_URL", "sqlite:////no/such/folder/runs.sqlite"),
        ("MOTIONLAB_DATABASE_URL", "postgresql://host:port/lab"),
        ("MOTIONLAB_RUNS_URL", "http://host/lab"),
        ("MOTIONLAB_RUNS_URL", "ftp://host/lab"),
        ("MOTIONLAB_RUNS_URL", f"{__file__}/runs"),
        ("MOTIONLAB_RUNS_MAX", "10 GB"),
    ],
)
def test_an_address_that_can_never_work_is_refused_at_start(
    variable: str,
    value: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    monkeypatch.setenv(variable, value)
    assert main(["serve", "--port", "0"]) == 2
    refusal = capfd.readouterr().err
    assert refusal.startswith(f"motionlab: {variable}: ")
    assert "secret" not in refusal


def test_an_index_that_is_removed_or_replaced_takes_no_run(tmp_path: Path) -> None:
    folder, away = tmp_path / "data", tmp_path / "away"
    folder.mkdir()
    index = Index(f"sqlite:///{folder / 'runs.sqlite'}")
    index.put(run := sample())
    folder.rename(away)
    for use in (lambda: index.put(sample()), lambda: index.change(run.id, {"note": "lost"})):
        with pytest.raises(StoreError, match="has been removed: put its folder back"):
            use()
    folder.mkdir()
    other = Index(f"sqlite:///{folder / 'runs.sqlite'}")
    with pytest.raises(StoreError, match="has been replaced by another file"):
        index.totals()
    other.close()
    shutil.rmtree(folder)
    away.rename(folder)
    assert index.change(run.id, {"note": "back"}) is not None
    index.close()


def test_the_index_is_copied_before_it_is_migrated(tmp_path: Path) -> None:
    Index(url := index_url(tmp_path)).close()
    assert list(tmp_path.glob("*.backup")) == []
    (tmp_path / "runs.sqlite").unlink()
    made_by(url, "0004", run := sample())
    for number in ("0001", "0002", "0003"):  # of earlier upgrades
        (tmp_path / f"runs.sqlite.{number}.backup").write_text("")
    index = Index(index_url(tmp_path))
    assert index.get(run.id) is not None
    index.close()
    copies = sorted(path.name for path in tmp_path.glob("*.backup"))
    assert copies == [f"runs.sqlite.{number}.backup" for number in ("0002", "0003", "0004")]
    copy = tmp_path / "runs.sqlite.0004.backup"
    assert copy.stat().st_mode & 0o777 == 0o600
    engine = sa.create_engine(f"sqlite:///{copy}")
    with engine.connect() as connection:
        version = connection.execute(sa.text("SELECT version_num FROM alembic_version"))
        assert version.scalar() == "0004" != VERSION
        assert connection.execute(sa.text("SELECT id FROM runs")).scalar() == run.id
    engine.dispose()
