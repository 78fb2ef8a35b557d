"""Progress of long work on stderr: a bar in a terminal and in a notebook, else lines."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.progress import Progress

_LONG_RUN = 100_000  # ticks; shorter runs are over before a bar could be read

_NOTEBOOK_WIDTH = 80

_told = ContextVar("told", default=True)


@contextlib.contextmanager
def told(wanted: bool) -> Iterator[None]:
    """Show progress and notes while a block lasts, or do not."""
    before = _told.set(wanted)
    try:
        yield
    finally:
        _told.reset(before)


def is_told() -> bool:
    """Return whether progress and notes are shown."""
    return _told.get()


@contextlib.contextmanager
def tick_bar(ticks: int) -> Iterator[Callable[[int], Any] | None]:
    """Show a progress bar during a long run in a terminal or a notebook.

    Parameters
    ----------
    ticks : int
        Of the whole run.

    Yields
    ------
    callable or None
        Takes the number of ticks done since the last call; None where no bar is shown.
    """
    if ticks < _LONG_RUN or not is_told() or not has_bars():
        yield None
        return
    with _bar() as bar:
        task = bar.add_task("run", total=ticks)
        yield lambda done: bar.advance(task, done)


@contextlib.contextmanager
def share_done(title: str) -> Iterator[Callable[[float], None]]:
    """Show the share of long work that is done: a bar, or a line every tenth.

    Parameters
    ----------
    title : str
        What the work is called.

    Yields
    ------
    callable
        Takes the share done, 0 to 1.
    """
    if not is_told():
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
    with _bar() as bar:
        task = bar.add_task(title, total=1.0)
        yield lambda share: bar.update(task, completed=share)


def has_bars() -> bool:
    """Return whether a bar can be drawn: by a terminal that moves its cursor, or a notebook."""
    if _in_notebook():
        return True
    return sys.stderr.isatty() and os.environ.get("TERM") not in {"dumb", "unknown"}


def _in_notebook() -> bool:
    """Return whether this process is the kernel of a notebook."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return shell is not None and "IPKernelApp" in shell.config


def _bar() -> Progress:
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        TaskProgressColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        # A notebook's own bars need a further package, and its streams know how to go back.
        console=Console(
            stderr=True,
            force_jupyter=False,
            force_terminal=_in_notebook() or None,
            width=_NOTEBOOK_WIDTH if _in_notebook() else None,
        ),
        transient=True,
        redirect_stdout=False,
        redirect_stderr=False,
    )
