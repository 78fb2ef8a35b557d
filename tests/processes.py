"""Processes that work for another, as /proc tells of them."""

from __future__ import annotations

from pathlib import Path


def workers_of(parent: int) -> list[int]:
    """Return the worker processes of a process."""
    return children_of(parent, "spawn_main")


def children_of(parent: int, command: str) -> list[int]:
    """Return the children of a process whose command has a word in it."""
    found = []
    for task in Path("/proc").glob("[0-9]*/stat"):
        try:
            ours = int(task.read_text().rsplit(")", 1)[1].split()[1]) == parent
            if ours and command in (task.parent / "cmdline").read_text():
                found.append(int(task.parent.name))
        except OSError:
            continue
    return found


def runs(process: int) -> bool:
    """Tell whether a process goes on; one that nobody has waited for does not."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except OSError:
        return False
    return state not in {"Z", "X"}
