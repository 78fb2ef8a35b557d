"""Telemetry of runs: a Parquet file each, on local disk or any file system that pyarrow knows."""

from __future__ import annotations

import errno
import hashlib
import os
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

from motionlab.errors import ConfigError, FieldError, StoreError, Unknown
from motionlab.files import complete_file, failure, private_folder
from motionlab.library.run import is_id

if TYPE_CHECKING:
    from pyarrow import parquet

_PIECE = 1 << 20  # bytes that are copied at a time


class RunFiles:
    """The Parquet files of runs.

    Parameters
    ----------
    url : str
        A local folder, made when the first run is kept, or a URL of pyarrow such as
        ``s3://bucket/folder?region=eu-central-1``.
    """

    def __init__(self, url: str) -> None:
        from pyarrow import fs

        self._local = "://" not in url
        try:
            if self._local:
                self._system, self._folder = fs.LocalFileSystem(), str(Path(url).absolute())
            else:
                self._system, self._folder = fs.FileSystem.from_uri(url)
        except (OSError, ValueError, TypeError) as error:
            detail = "" if "@" in url else f": {error}"  # it may quote the address, with its key
            raise ConfigError(
                FieldError("MOTIONLAB_RUNS_URL", f"cannot be used{detail}", url.rpartition("@")[2])
            ) from None

    def path(self, run_id: str) -> str:
        """Return where the telemetry of a run lies in its file system."""
        if not is_id(run_id):
            raise StoreError(f"{run_id!r} is no run")
        return f"{self._folder}/{run_id}.parquet"

    def check(self) -> None:
        """Refuse a local folder that can never be one.

        Raises
        ------
        ConfigError
            If a file is in its place.
        """
        if self._local:
            folder = Path(self._folder)
            there = next(each for each in (folder, *folder.parents) if each.exists())
            if not there.is_dir():
                raise ConfigError(
                    FieldError("MOTIONLAB_RUNS_URL", f"{there} is no folder", self._folder)
                )

    def put(self, run_id: str, source: Path) -> int:
        """Store a complete Parquet file, which then appears as a whole, and remove `source`.

        Returns
        -------
        int
            Its size, bytes.

        Raises
        ------
        StoreError
            If it cannot be stored; `StoreFull` where there is no room. `source` is untouched then.
        """
        target = self.path(run_id)
        try:
            size = source.stat().st_size
            if self._local:
                private_folder(Path(self._folder))
                _move(source, Path(target))
            else:
                with (
                    source.open("rb") as file,
                    self._system.open_output_stream(target) as stream,  # appears when it is closed
                ):
                    shutil.copyfileobj(file, stream, _PIECE)
                source.unlink()
        except OSError as error:
            raise failure(f"the telemetry of {run_id} cannot be stored", error) from error
        return size

    def open(self, run_id: str) -> parquet.ParquetFile:
        """Open the telemetry of a run; close it after use.

        Raises
        ------
        StoreError
            If it is not there or damaged.
        """
        import pyarrow as pa
        from pyarrow import parquet

        try:
            return parquet.ParquetFile(self._system.open_input_file(self.path(run_id)))
        except (OSError, pa.ArrowInvalid) as error:
            raise _unreadable(run_id, error, self.path(run_id)) from error

    def digest(self, run_id: str) -> str:
        """Return the SHA-256 of the telemetry of a run.

        Raises
        ------
        StoreError
            If it cannot be read.
        """
        digest = hashlib.sha256()
        try:
            with self._system.open_input_stream(self.path(run_id)) as stream:
                while piece := stream.read(_PIECE):
                    digest.update(piece)
        except OSError as error:
            raise _unreadable(run_id, error, self.path(run_id)) from error
        return digest.hexdigest()

    def delete(self, run_id: str) -> None:
        """Delete the telemetry of a run, if there is any.

        Raises
        ------
        StoreError
            If it cannot be deleted.
        """
        try:
            self._system.delete_file(self.path(run_id))
        except FileNotFoundError:
            pass
        except OSError as error:
            raise failure(f"the telemetry of {run_id} cannot be deleted", error) from error

    def names(self) -> list[str]:
        """Return the runs whose telemetry lies here."""
        from pyarrow import fs

        selector = fs.FileSelector(self._folder, allow_not_found=True)
        names = (
            info.base_name.removesuffix(".parquet") for info in self._system.get_file_info(selector)
        )
        return sorted(name for name in names if is_id(name))


def runs_url(root: Path) -> str:
    """Return where telemetry lies: MOTIONLAB_RUNS_URL, or a folder of the data."""
    return os.environ.get("MOTIONLAB_RUNS_URL") or str(root / "runs")


def _move(source: Path, target: Path) -> None:
    """Move a file to where it appears as a whole, also from another file system."""
    with source.open("rb") as file:
        os.fsync(file.fileno())
        try:
            source.replace(target)
        except OSError as error:
            if error.errno != errno.EXDEV:
                raise
            with complete_file(str(target), mode=0o600) as part, part.open("wb") as copy:
                shutil.copyfileobj(file, copy, _PIECE)
            source.unlink()


def _unreadable(run_id: str, error: Exception, path: str) -> StoreError:
    message = f"the telemetry of {run_id} cannot be read"
    if isinstance(error, FileNotFoundError):  # whose text names the folder of the data
        return Unknown(f"{message}: its file is missing")
    return StoreError(f"{message}: {str(error).replace(path, 'its file')}")
