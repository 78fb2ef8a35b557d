"""Progress of long work on stderr: a bar in a terminal and in a notebook, else lines."""

from __future__ import annotations

import contextlib
import functools
import math
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from typing import Any

_LONG_RUN = 100_000  # ticks; shorter runs are over before a bar could be read

_NOTEBOOK_BAR = 40  # characters
_PAUSE = 0.25  # s, between two updates in a notebook

_shown = ContextVar("shown", default=True)


@contextlib.contextmanager
def progress_shown(shown: bool) -> Iterator[None]:
    """Show progress and notes while a block lasts, or do not."""
    before = _shown.set(shown)
    try:
        yield
    finally:
        _shown.reset(before)


def shows_progress() -> bool:
    """Return whether progress and notes are shown."""
    return _shown.get()


@contextlib.contextmanager
def tick_bar(ticks: int) -> Iterator[Callable[[int], Any] | None]:
    """Show a progress bar during a long run in a terminal or a notebook.

    Yields
    ------
    callable or None
        Takes the number of ticks done since the last call; None where no bar is shown.
    """
    if ticks < _LONG_RUN or not shows_progress() or not has_bars():
        yield None
        return
    done = 0

    def advance(ticks_more: int) -> None:
        nonlocal done
        done += ticks_more
        show(done)

    with _bar("run", ticks) as show:
        yield advance


@contextlib.contextmanager
def share_done(title: str) -> Iterator[Callable[[float], None]]:
    """Show the share of long work that is done: a bar, or a line every tenth.

    Yields
    ------
    callable
        Takes the share done, 0 to 1.
    """
    if not shows_progress():
        yield lambda _: None
        return
    if not has_bars():
        tenths = -1

        def line(share: float) -> None:
            nonlocal tenths
            if int(share * 10) > tenths:
                tenths = int(share * 10)
                print(f"motionlab: {title} {tenths * 10} %", file=sys.stderr)

        yield line
        if tenths >= 0:
            line(1.0)
        return
    with _bar(title, 1.0) as show:
        yield show


def has_bars() -> bool:
    """Return whether a bar can be drawn: by a terminal that moves its cursor, or a notebook."""
    return _notebook() is not None or _has_cursor()


@contextlib.contextmanager
def first_use() -> Iterator[None]:
    """Have `compiling` say why the first call takes longer, in a notebook until the block ends."""
    with contextlib.ExitStack() as stack:
        before = _first_use.set(stack)
        try:
            yield
        finally:
            _first_use.reset(before)


@functools.cache
def watch_compilation() -> None:
    """Have numba tell `compiling`; loading what was compiled before is none."""
    from numba.core import event

    class Listener(event.Listener):
        def on_start(self, event: Any) -> None:
            dispatcher = (event.data or {}).get("dispatcher")
            module = getattr(getattr(dispatcher, "py_func", None), "__module__", None) or ""
            if module.startswith(_LONG_COMPILATION) and not module.startswith(_OF_ONE_LAW):
                compiling()

        def on_end(self, event: Any) -> None:
            pass

    event.register("numba:compile", Listener())


def compiling() -> None:
    """Say, once in a process, that the first use compiles; does nothing outside `first_use`."""
    stack = _first_use.get()
    if stack is None or not shows_progress() or COMPILING in _notes_shown:
        return
    _notes_shown.add(COMPILING)
    notebook = _notebook()
    if notebook is None:
        print(f"motionlab: {COMPILING}", file=sys.stderr, flush=True)
    else:
        stack.enter_context(_cell_line(notebook))(COMPILING)


COMPILING = "compiling, once on this machine; `motionlab precompile` compiles everything"
"""What a first use says."""
_LONG_COMPILATION = ("motionlab.kernel", "motionlab.loop", "motionlab.trajectories.time_optimal")
"""Modules whose functions take long enough to be worth a word."""
_OF_ONE_LAW = ("motionlab.kernel.law_calls", "motionlab.kernel.effect_calls")
"""Modules that compile a law or an effect by itself, a second or two for each version of one."""
_notes_shown: set[str] = set()
_first_use: ContextVar[contextlib.ExitStack | None] = ContextVar("first_use", default=None)


def _has_cursor() -> bool:
    return sys.stderr.isatty() and os.environ.get("TERM") not in {"dumb", "unknown"}


def _notebook() -> Any | None:
    """Return what shows and updates an output of a cell; None where this is no notebook."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if shell is None or "IPKernelApp" not in shell.config:
        return None
    from IPython.display import display

    return display


@contextlib.contextmanager
def _cell_line(display: Any) -> Iterator[Callable[[str], None]]:
    """Show a line below a cell, replaced by each further one; nothing of it is left at the end."""
    handle = display({"text/plain": ""}, raw=True, display_id=True)
    try:
        yield lambda text: handle.update({"text/plain": text}, raw=True)
    finally:
        handle.update({}, raw=True)


@contextlib.contextmanager
def _bar(title: str, total: float) -> Iterator[Callable[[float], None]]:
    """Show a bar that takes how much of the total is done."""
    notebook = _notebook()
    if notebook is not None:
        with _cell_line(notebook) as line:
            yield _throttled(lambda done: line(_drawn(title, done / total)))
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        TaskProgressColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        # It moves the cursor.
        console=Console(file=getattr(sys.stderr, "direct", sys.stderr), force_jupyter=False),
        transient=True,
        redirect_stdout=False,
        redirect_stderr=False,
    ) as bar:
        task = bar.add_task(title, total=total)
        yield lambda done: bar.update(task, completed=done)


def _throttled(show: Callable[[float], None]) -> Callable[[float], None]:
    """Pass on at most four updates a second, each of which is a message to the browser."""
    shown = -math.inf

    def update(done: float) -> None:
        nonlocal shown
        if time.monotonic() - shown >= _PAUSE:
            shown = time.monotonic()
            show(done)

    return update


def _drawn(title: str, share: float) -> str:
    full = round(_NOTEBOOK_BAR * min(share, 1.0))
    return f"{title} {'█' * full}{'░' * (_NOTEBOOK_BAR - full)} {share:.0%}"
