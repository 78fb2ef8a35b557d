"""Results of tasks kept on disk, so that long work goes on where it ended.

Client, scheduler or worker may end: whoever asks for the same work again computes only the tasks
whose results are not there. A result is named by a hash of its task and of all code that decides
its bits, and so is never of other work.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from motionlab.config.named_configs import data_root
from motionlab.effects import SOURCES as EFFECT_SOURCES
from motionlab.errors import StoreError
from motionlab.executors.code import Code
from motionlab.executors.executor import Progress, current
from motionlab.files import complete_file, private_folder
from motionlab.laws import SOURCES as LAW_SOURCES

FOLDER = "tasks"
FOLDER_MOST = 200_000_000
"""Largest size of all that is kept, bytes; beyond it the oldest go. 1000 cases take 0.5 MB."""

Arrays = dict[str, NDArray[Any]]
TaskT = TypeVar("TaskT")
ResultT = TypeVar("ResultT")


@dataclass(frozen=True)
class Form(Generic[TaskT, ResultT]):
    """How tasks and results are written.

    Attributes
    ----------
    content : callable
        All of a task that decides its result, as what JSON can hold.
    arrays, result : callable
        A result as arrays, and back; the second raises KeyError or ValueError for others.
    """

    content: Callable[[TaskT], Any]
    arrays: Callable[[ResultT], Arrays]
    result: Callable[[Arrays, TaskT], ResultT]


def kept_map(
    function: Callable[[TaskT, Progress], ResultT],
    tasks: Sequence[TaskT],
    form: Form[TaskT, ResultT],
    progress: Progress | None = None,
) -> Iterator[ResultT]:
    """Yield the result of each task, in order, as `Executor.map` does; computed if not kept.

    Results are kept as they arrive. One that cannot be kept, or read, is computed again next time.
    """
    folder = data_root() / FOLDER
    paths = [folder / f"{_digest(function.__name__, form.content(task))}.npz" for task in tasks]
    missing = [index for index, path in enumerate(paths) if not path.is_file()]
    before = 1.0 - len(missing) / len(tasks) if tasks else 1.0

    def tell(share: float) -> None:
        if progress is not None:
            progress(before + (1.0 - before) * share)

    computed = current().map(function, [tasks[index] for index in missing], tell)
    due = iter(missing)
    next_due = next(due, None)
    for index, task in enumerate(tasks):
        if index == next_due:
            result = next(computed)
            _keep(paths[index], form.arrays(result))
            next_due = next(due, None)
            yield result
        else:
            result = _read(paths[index], task, form)
            if result is None:
                result = function(task, lambda _: None)
                _keep(paths[index], form.arrays(result))
            yield result
    _make_room(folder)


def _digest(name: str, content: Any) -> str:
    own = sorted((LAW_SOURCES | EFFECT_SOURCES).items())
    text = json.dumps([name, content, Code.here(), own], sort_keys=True, default=repr)
    return hashlib.sha256(text.encode()).hexdigest()


def _keep(path: Path, arrays: dict[str, Any]) -> None:
    with contextlib.suppress(OSError, StoreError):  # a full disk costs only the repetition
        private_folder(path.parent)
        with complete_file(str(path), mode=0o600) as part, part.open("wb") as file:
            np.savez_compressed(file, **arrays)


def _read(path: Path, task: TaskT, form: Form[TaskT, ResultT]) -> ResultT | None:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return form.result(dict(arrays), task)
    except Exception:  # bytes that are damaged raise what numpy, zipfile and zlib happen to
        return None


def _make_room(folder: Path) -> None:
    """Remove what was written first, until the rest takes less than `FOLDER_MOST`."""
    sizes: list[tuple[float, int, Path]] = []
    for path in folder.glob("*.npz"):
        with contextlib.suppress(OSError):
            status = path.stat()
            sizes.append((status.st_mtime, status.st_size, path))
    taken = sum(size for _, size, _ in sizes)
    for _, size, path in sorted(sizes):
        if taken <= FOLDER_MOST:
            return
        path.unlink(missing_ok=True)
        taken -= size
