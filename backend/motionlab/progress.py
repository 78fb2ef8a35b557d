"""Progress on stderr."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator
from typing import Any

_LONG_RUN = 100_000  # ticks; shorter runs are over before a bar could be read


@contextlib.contextmanager
def tick_bar(ticks: int) -> Iterator[Callable[[int], Any] | None]:
    """Show a progress bar on stderr during a long run in a terminal."""
    if ticks < _LONG_RUN or not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    with tqdm(total=ticks, unit="tick", unit_scale=True, leave=False, file=sys.stderr) as bar:
        yield bar.update


@contextlib.contextmanager
def share_done(title: str) -> Iterator[Callable[[float], None]]:
    """Show the share of long work that is done on stderr: a bar, or a line every tenth."""
    if not sys.stderr.isatty():
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
    from tqdm import tqdm

    layout = "{desc}: {percentage:3.0f}%|{bar}| {elapsed}<{remaining}"
    with tqdm(total=1.0, desc=title, bar_format=layout, leave=False, file=sys.stderr) as bar:

        def move(share: float) -> None:
            bar.update(share - bar.n)

        yield move
