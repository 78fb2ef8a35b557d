"""The kernels of batches are compiled by a process of their own, once, and waited for."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from motionlab.server import kernel_compiler
from motionlab.server.kernel_compiler import Kernels
from motionlab.simulation import precompile
from tests.server.live import until


@pytest.fixture
def mark(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "batches"
    monkeypatch.setattr(precompile, "mark", lambda: path)
    return path


def compile_by(monkeypatch: pytest.MonkeyPatch, code: str) -> None:
    monkeypatch.setattr(kernel_compiler, "COMMAND", (sys.executable, "-c", code))


def test_they_are_waited_for(mark: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compile_by(monkeypatch, "import time; time.sleep(60)")
    compiling = Kernels()
    assert not compiling.settled  # also before it is known who compiles them
    compiling.start()
    assert not compiling.settled
    mark.touch()
    assert compiling.settled
    compiling.close()


@pytest.mark.parametrize("code", ["import sys; sys.exit(1)", "pass"])
def test_nothing_is_waited_for_where_nothing_was_compiled(
    mark: Path, monkeypatch: pytest.MonkeyPatch, code: str
) -> None:
    compile_by(monkeypatch, code)
    compiling = Kernels()
    compiling.start()
    until(lambda: compiling.settled)
    compiling.close()
    assert not mark.exists()


def test_what_was_compiled_before_is_not_compiled_again(
    mark: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compile_by(monkeypatch, f"open({str(mark.parent / 'again')!r}, 'w')")
    mark.touch()
    compiling = Kernels()
    compiling.start()
    assert compiling.settled
    compiling.close()
    assert not (mark.parent / "again").exists()


def test_where_numba_compiles_nothing_nothing_is_waited_for(
    mark: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("numba.config.DISABLE_JIT", True)
    compiling = Kernels()
    compiling.start()
    assert compiling.settled
    assert compiling._process is None
