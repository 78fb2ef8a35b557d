"""Compiled code that is kept between runs: damaged, or with no room for it."""

import importlib.util
import itertools
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core import config
from numba.core.dispatcher import Dispatcher

import motionlab.lanes  # noqa: F401 - has numba keep compiled code its way
from motionlab.executors import progress
from tests.paths import ROOT

_SOURCE = """\
import numba

@numba.njit(cache=True)
def double(number):
    return 2 * number
"""
_loads = itertools.count()


def _loaded(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Dispatcher:
    """Return the function as a new process would find it."""
    monkeypatch.setattr(config, "CACHE_DIR", str(folder / "kept"))
    source = folder / "doubling.py"
    folder.mkdir(exist_ok=True)
    if not source.exists():
        source.write_text(_SOURCE)
    found = importlib.util.spec_from_file_location(f"doubling{next(_loads)}", source)
    assert found is not None and found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module.double


def _hits(double: Dispatcher) -> int:
    assert double(21) == 42
    return sum(double.stats.cache_hits.values())


def test_compiled_code_is_found_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert _hits(_loaded(tmp_path, monkeypatch)) == 0
    assert _hits(_loaded(tmp_path, monkeypatch)) == 1


def test_a_first_use_says_that_it_compiles(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import motionlab.simulation.prepare  # noqa: F401 - whoever computes loads it

    monkeypatch.setattr(progress, "_notes_shown", set())
    monkeypatch.setattr(progress, "_LONG_COMPILATION", ("doubling",))
    _hits(_loaded(tmp_path / "server", monkeypatch))
    assert capsys.readouterr().err == ""
    for _ in range(2):
        with progress.first_use():
            _hits(_loaded(tmp_path, monkeypatch))
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("motionlab: compiling, once on this machine; `motionlab precompile`")


@pytest.mark.parametrize(
    ("module", "function", "said"),
    [
        ("loop.family", "_join", f"motionlab: {progress.COMPILING}\n"),
        ("kernel.law_calls", "on_rows(module.SHIPPED['off'])", ""),
    ],
)
def test_margins_alone_say_that_they_are_compiled_and_a_law_alone_does_not(
    module: str, function: str, said: str
) -> None:
    """In a process that loads little else, as `motionlab loop` does."""
    text = f"""
from motionlab.executors.progress import first_use
from motionlab.loop import family
import motionlab.{module} as module
from numba.core import event
data = {{"dispatcher": module.{function}}}
with first_use(), event.trigger_event("numba:compile", data=data):
    pass
"""
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    assert done.stderr == said


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize("damage", ["empty", "cut", "zeros", "text"])
def test_damaged_compiled_code_is_compiled_anew_and_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str, damage: str
) -> None:
    _hits(_loaded(tmp_path, monkeypatch))
    for path in tmp_path.rglob(f"*.{suffix}"):
        whole = path.read_bytes()
        damaged = {
            "empty": b"",
            "cut": whole[: len(whole) // 2],
            "zeros": bytes(len(whole)),
            "text": b"<html>",
        }
        path.write_bytes(damaged[damage])
    assert _hits(_loaded(tmp_path, monkeypatch)) == 0
    assert _hits(_loaded(tmp_path, monkeypatch)) == 1


def test_a_full_disk_does_not_keep_a_function_from_being_compiled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    double = _loaded(tmp_path, monkeypatch)
    monkeypatch.setattr("numba.core.caching.os.replace", full)
    assert _hits(double) == 0


def test_no_function_is_kept_elsewhere() -> None:
    """numba's own decorator, reached before the lanes are, would keep code beside the source."""
    package = ROOT / "backend" / "motionlab"
    kept = {
        path.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        if "cache=True" in path.read_text(encoding="utf-8")
    }
    assert kept == {"lanes/compiler/__init__.py", "drive/compile_cache.py"}
