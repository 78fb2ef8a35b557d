"""Files: written atomically, summaries that are kept while they do not change; the built page."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import stat
import tempfile
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import BinaryIO, Generic, TypeVar

from motionlab.errors import ConfigError, FieldError, StoreError, StoreFull

T = TypeVar("T")

Stamp = tuple[int, int, int, int]

_PART = ".part"
_LOCKED_AFTER = 10.0  # s: a file is made an instant before its lock
_FULL = {errno.ENOSPC, errno.EDQUOT}


def page_root() -> Path | None:
    """Return the folder of the built page, in the package or the checkout, if it is there."""
    package = Path(__file__).resolve().parent
    for folder in (package / "page", package.parent.parent / "frontend" / "dist"):
        if (folder / "index.html").is_file():
            return folder
    return None


def opened(path: Path) -> BinaryIO:
    """Open a file to be read.

    Raises
    ------
    OSError
        If that fails, or it is no regular file: a pipe would wait for its writer.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise OSError(errno.EINVAL, "not a file", str(path))
    return os.fdopen(descriptor, "rb")


def replace(path: Path, content: bytes, *, mode: int | None = 0o600) -> None:
    """Write a file beside its place and move it there; makes its folder when it is missing.

    Its permissions are `mode`; with None, and of its folder too, those that the umask leaves.

    Raises
    ------
    OSError
        If that cannot be done; what was there is untouched.
    """
    if mode is None:
        path.parent.mkdir(parents=True, exist_ok=True)
    else:
        private_folder(path.parent)
    with _moved_to(path, _mode(path) if mode is None else mode) as part:
        part.write_bytes(content)


def private_folder(folder: Path) -> None:
    """Make a folder, and those above it that are missing, for its owner alone.

    Raises
    ------
    OSError
        If it cannot be made.
    """
    missing = [each for each in (folder, *folder.parents) if not each.exists()]
    for each in reversed(missing):
        each.mkdir(mode=0o700, exist_ok=True)
    if not missing:
        folder.mkdir(exist_ok=True)  # or it is no folder


def private_file(path: Path) -> None:
    """Make an empty file for its owner alone, where there is none.

    Raises
    ------
    OSError
        If it cannot be made.
    """
    # One that is there is not opened: closing it would end the locks that SQLite has on it.
    with contextlib.suppress(FileExistsError):
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC
        os.close(os.open(path.resolve(), flags, 0o600))


def make_private(paths: Iterable[Path]) -> None:
    """Take files and folders, with all inside, from everybody but their owner; no links.

    Folders of earlier versions were readable by all. What belongs to somebody else stays.
    """
    for path in paths:
        with contextlib.suppress(OSError):
            status = path.lstat()
            if status.st_uid != os.geteuid() or stat.S_ISLNK(status.st_mode):
                continue
            if others := status.st_mode & 0o077:
                path.chmod(stat.S_IMODE(status.st_mode) & ~others)
            if stat.S_ISDIR(status.st_mode):
                make_private(path.iterdir())


@contextlib.contextmanager
def complete_file(path: str, *, mode: int | None = None) -> Iterator[Path]:
    """Yield a file to write, which appears under the name `path` only when it is complete.

    Parameters
    ----------
    path : str
        The file's place.
    mode : int, optional
        Its permissions; those of the file that it replaces, or of any new one, when left out.

    Raises
    ------
    StoreError
        If the file cannot be written.
    """
    target = Path(path).resolve()  # the file that a link points to, not the link
    try:
        with _moved_to(target, _mode(target) if mode is None else mode) as part:
            yield part
    except OSError as error:
        raise failure(f"{path}: cannot be written", error) from error


@contextlib.contextmanager
def _moved_to(path: Path, mode: int) -> Iterator[Path]:
    descriptor, made = tempfile.mkstemp(dir=path.parent, prefix=".", suffix=_PART)
    part = Path(made)
    try:
        with os.fdopen(descriptor, "wb") as file:
            fcntl.flock(file, fcntl.LOCK_EX)  # until it is in its place: see remove_leftovers
            yield part
            os.fchmod(file.fileno(), mode)
            os.fsync(file.fileno())
            part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def _mode(target: Path) -> int:
    """Return the permissions of the file that is replaced, or those a new file gets."""
    if target.exists():
        return target.stat().st_mode & 0o777
    mask = os.umask(0o077)
    os.umask(mask)
    return 0o666 & ~mask


def check_target(path: str, *suffixes: str, loc: str = "--out") -> None:
    """Refuse a file that could not be written, before slow work begins.

    Raises
    ------
    ConfigError
        If its name ends in none of `suffixes`, or its folder is missing or read-only. A single
        one may be in capitals too.
    """
    target = Path(path)
    suffix = target.suffix.lower() if len(suffixes) == 1 else target.suffix
    if suffix not in suffixes:
        allowed = "names ending in " + " or ".join(suffixes)
        raise ConfigError(FieldError(loc, "unknown kind of file", path, allowed))
    folder = target.absolute().parent
    if not folder.is_dir():
        raise ConfigError(FieldError(loc, "its folder does not exist", path))
    try:
        if target.exists() and not target.is_file():
            raise ConfigError(FieldError(loc, "is there already and is no regular file", path))
    except OSError as error:
        raise ConfigError(FieldError(loc, f"cannot be: {error.strerror}", path)) from None
    try:  # permissions alone do not tell: a file system may be read-only, or take no files
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise ConfigError(FieldError(loc, f"cannot be written: {error.strerror}", path)) from None


def remove_leftovers(root: Path) -> None:
    """Remove files that a killed process did not finish, in a folder and those inside it.

    A live process, also one of another container, holds a lock on what it writes.
    """
    for path in [*root.glob(f".*{_PART}"), *root.glob(f"*/.*{_PART}")]:
        with contextlib.suppress(OSError), path.open("rb") as file:  # locked, or gone by now
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if abs(time.time() - path.stat().st_mtime) > _LOCKED_AFTER:
                path.unlink()


def failure(what: str, error: OSError) -> StoreError:
    """Return the error for a file that could not be written."""
    reason = f"{what}: {error.strerror or error}"
    return StoreFull(reason) if error.errno in _FULL else StoreError(reason)


def stamp(path: Path) -> Stamp:
    """Return a stamp that changes with a file, even if a copy keeps the modification time."""
    status = path.stat()
    return status.st_ino, status.st_mtime_ns, status.st_ctime_ns, status.st_size


class Summaries(Generic[T]):
    """A summary of each file, by path and stamp; the least recently used are evicted.

    Parameters
    ----------
    read : callable
        Returns the summary of a file; also of a damaged one, which else would be read each time.
    most : int
        Number of cached summaries.
    """

    def __init__(self, read: Callable[[Path], T], *, most: int) -> None:
        self._read = read
        self._most = most
        self._known: OrderedDict[Path, tuple[Stamp, T]] = OrderedDict()
        self._lock = threading.Lock()

    def of(self, path: Path) -> T:
        """Return the summary of a file.

        Raises
        ------
        FileNotFoundError
            If it is not there.
        """
        now = stamp(path)
        with self._lock:
            known = self._known.get(path)
            if known is not None and known[0] == now:
                self._known.move_to_end(path)
                return known[1]
        summary = self._read(path)
        with self._lock:
            self._known[path] = now, summary
            self._known.move_to_end(path)
            while len(self._known) > self._most:
                self._known.popitem(last=False)
        return summary
