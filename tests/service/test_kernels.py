"""Work that needs the kernels of batches waits for the process that compiles them."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import pytest
from pydantic import BaseModel

from motionlab.service import kernels
from motionlab.service.kernels import Kernels


class Done(BaseModel):
    """What work returns."""

    at: float


def work(progress: kernels.Progress) -> Done:
    progress(1.0)
    return Done(at=time.monotonic())


@pytest.fixture
def mark(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "batches"
    monkeypatch.setattr(kernels, "mark", lambda: path)
    return path


def compile_by(monkeypatch: pytest.MonkeyPatch, code: str) -> None:
    monkeypatch.setattr(kernels, "COMMAND", (sys.executable, "-c", code))


def test_work_waits_for_the_kernels_and_can_be_cancelled_meanwhile(
    mark: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compile_by(monkeypatch, "import time; time.sleep(60)")
    compiling = Kernels()
    compiling.start()
    shares: list[float] = []

    def cancelled(share: float, partial: BaseModel | None = None) -> None:
        shares.append(share)
        if len(shares) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        compiling.before(work)(cancelled)
    assert shares == [0.0, 0.0, 0.0]
    mark.touch()
    shares.clear()
    compiling.before(work)(lambda share, partial=None: shares.append(share))
    assert shares == [1.0]
    compiling.close()


@pytest.mark.parametrize("code", ["import sys; sys.exit(1)", "pass"])
def test_work_goes_on_where_nothing_was_compiled(
    mark: Path, monkeypatch: pytest.MonkeyPatch, code: str
) -> None:
    compile_by(monkeypatch, code)
    compiling = Kernels()
    compiling.start()
    assert compiling.before(work)(lambda share, partial=None: None)
    compiling.close()
    assert not mark.exists()


def test_what_was_compiled_before_is_not_compiled_again(
    mark: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compile_by(monkeypatch, f"open({str(mark.parent / 'again')!r}, 'w')")
    mark.touch()
    compiling = Kernels()
    compiling.start()
    compiling.before(work)(lambda share, partial=None: None)
    compiling.close()
    assert not (mark.parent / "again").exists()
