"""Tasks on a Dask cluster.

A task's key is a hash of its content, so no result counts twice; what a lost worker held is
computed again. Access to a scheduler's port allows running code on all its workers, since Dask
unpickles what it receives: other machines are reached only through TLS with certificates of both
sides.
"""

from __future__ import annotations

import functools
import gc
import hashlib
import ipaddress
import logging
import pickle
import socket
import struct
import time
from asyncio import run_coroutine_threadsafe
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Any
from urllib.parse import urlsplit

from motionlab.errors import ConfigError, FieldError, needs
from motionlab.executors.code import Code, processor
from motionlab.executors.executor import Pool, WorkerLost

_SECONDS = 10.0  # until scheduler and a worker must have answered
_LOST_SECONDS = 15.0  # without an answer or any worker, after which a study ends
_LOOK_SECONDS = 1.0  # between questions for the workers
_GREETING_MAX = 1_000_000  # bytes; larger is no Dask's, which announces its length first
_RESULT_SECONDS = 0.5  # for which a result is waited for between looks at cancellation
_LENGTH = struct.Struct("<Q")
_LOGS = ("distributed", "tornado")
_CERTIFICATES = ("ca-file", "client.cert", "client.key")


class Cluster(Pool):
    """The workers of a Dask scheduler.

    Parameters
    ----------
    address : str
        ``tls://HOST:PORT``, or ``tcp://`` on loopback.

    Raises
    ------
    ConfigError
        If the address is none or not encrypted, certificates are missing, or Dask is.
    """

    def __init__(self, address: str) -> None:
        self._address = address
        _check_address(address)
        try:
            import distributed  # noqa: PLC0415, F401 - an extra
        except ImportError:
            raise ConfigError(FieldError("scheduler", needs("distributed"), address)) from None
        if address.startswith("tls:"):
            _check_certificates()
        _silence_dask()

    @functools.cached_property
    def _client(self) -> Any:
        """The connection; waits for the scheduler and one worker."""
        from distributed import Client, Security  # noqa: PLC0415 - an extra

        security = Security(require_encryption=True) if self._address.startswith("tls:") else None
        _check_greeting(self._address, security)
        client: Any = None
        reason = ""
        try:
            client = Client(
                self._address, security=security, timeout=_SECONDS, set_as_default=False
            )
        except Exception as error:  # of whatever only begins as a scheduler does
            reason = " ".join(str(error).split())
        if client is None:
            gc.collect()  # a client that failed ends its thread, which would lock while one starts
            raise WorkerLost(f"no Dask scheduler answers at {self._address}: {reason}")
        try:
            client.wait_for_workers(1, timeout=_SECONDS)
        except TimeoutError:
            client.close()
            raise WorkerLost(f"the scheduler {self._address} has no workers") from None
        return client

    @functools.cached_property
    def _code(self) -> Code:
        """Code and processor that all workers must share: our sources, and the first worker's."""
        expected = Code.here()
        future = self._client.submit(processor, pure=False)
        while True:
            try:
                return expected._replace(processor=self.result(future))
            except TimeoutError:
                self.check()

    @functools.cached_property
    def _watch(self) -> _Watch:
        return _Watch(self._client, self._address)

    @property
    def workers(self) -> int:
        """Threads of all workers."""
        return max(1, sum(self._client.nthreads().values()))

    def submit(self, function: Callable[..., Any], tasks: Sequence[Any]) -> list[Any]:
        """Return a future for each task, under a key that its content decides."""
        futures = []
        for task in tasks:
            content = pickle.dumps((function, task), pickle.HIGHEST_PROTOCOL)
            digest = hashlib.sha256(content + repr(self._code).encode()).hexdigest()
            key = f"motionlab-{function.__name__}-{digest}"
            futures.append(self._client.submit(carry_out, content, self._code, key=key))
        return futures

    def result(self, future: Any) -> Any:
        """Return a result; TimeoutError while what a lost worker held is computed again."""
        from distributed import KilledWorker  # noqa: PLC0415 - an extra
        from distributed.client import FutureCancelledError  # noqa: PLC0415
        from distributed.comm.core import CommClosedError  # noqa: PLC0415

        try:
            result = future.result(timeout=_RESULT_SECONDS)
        except KilledWorker as error:
            raise WorkerLost(
                f"a task was held by {error.allowed_failures + 1} workers that were lost; is there "
                "enough memory? (distributed.scheduler.allowed-failures of the scheduler)"
            ) from None
        except (FutureCancelledError, CommClosedError):
            raise WorkerLost(f"the scheduler {self._address} was lost") from None
        future.release()
        return result

    def check(self) -> None:
        """Raise WorkerLost after some seconds without a worker, or an answer of the scheduler."""
        self._watch.look()

    def abandon(self, futures: Sequence[Any]) -> None:
        """Release every future: the scheduler cancels tasks without another client."""
        for future in futures:
            future.release()

    def close(self) -> None:
        """Close the connection, if any; the scheduler drops its tasks."""
        client = vars(self).get("_client")
        if client is not None:
            client.close()


class _Watch:
    """Asks the scheduler for its workers now and then, without waiting for the answer."""

    def __init__(self, client: Any, address: str) -> None:
        self._client, self._address = client, address
        self._query: Future[dict[str, int]] | None = None
        self._query_at = self._looked_at = self._well_at = time.monotonic()
        self._answers = True

    def look(self) -> None:
        """Take an answer, if there is one, and ask again.

        Raises
        ------
        WorkerLost
            After `_LOST_SECONDS` without a worker, or without an answer.
        """
        now = time.monotonic()
        if now - self._looked_at > _LOST_SECONDS / 2:  # whoever takes the results was slow
            self._well_at = now
        self._looked_at = now
        if self._query is not None and self._query.done():
            self._answers = self._query.exception() is None
            if self._answers and self._query.result():
                self._well_at = now
            self._query = None
        if self._query is None and now - self._query_at >= _LOOK_SECONDS:
            question = self._client.scheduler.ncores()
            self._query = run_coroutine_threadsafe(question, self._client.loop.asyncio_loop)
            self._query_at = now
        if now - self._well_at > _LOST_SECONDS:
            silent = self._query is not None and now - self._query_at > _LOST_SECONDS / 2
            what = "has no workers left" if self._answers and not silent else "does not answer"
            raise WorkerLost(f"the scheduler {self._address} {what}")


def carry_out(content: bytes, expected: Code) -> Any:
    """Carry out a task in a worker that runs the expected code.

    Raises
    ------
    OtherCode
        Naming the worker.
    """
    from dask.context import thread_state  # noqa: PLC0415
    from distributed import get_worker  # noqa: PLC0415 - an extra

    worker, key = get_worker(), thread_state.key
    expected.check(worker.address, Code.here())

    def tell(_: float) -> None:
        task = worker.state.tasks.get(key)
        if task is None or task.state in {"cancelled", "released"}:
            raise _Released

    function, task = pickle.loads(content)
    return function(task, tell)


class _Released(Exception):
    """Raised in a task that was cancelled."""


def _check_address(address: str) -> None:
    try:
        parts = urlsplit(address)
        host, port = parts.hostname, parts.port
    except ValueError:
        parts = host = port = None
    if parts is None or not host or not port or address != f"{address[:3]}://{parts.netloc}":
        raise ConfigError(FieldError("scheduler", "needs host and port", address))
    if address.startswith("tcp:") and not _is_loopback(host):
        message = (
            "is not encrypted: whoever reaches a Dask scheduler runs code on all its workers; "
            "other machines are reached by tls://, docs/cluster.md"
        )
        allowed = "tls://HOST:PORT, or tcp://127.0.0.1:PORT"
        raise ConfigError(FieldError("scheduler", message, address, allowed))


def _is_loopback(host: str) -> bool:
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _check_greeting(address: str, security: Any) -> None:
    """Refuse a port that does not begin to speak as a Dask scheduler does.

    Dask's client would wait for a silent one for ever, and take other text for the length of what
    follows. A port that cannot be reached is left to it: it tries again for a while.
    """
    parts = urlsplit(address)
    try:
        connection = socket.create_connection((parts.hostname, parts.port), timeout=_SECONDS)
    except OSError:
        return
    with connection:
        try:
            if security is not None:
                context = security.get_connection_args("client")["ssl_context"]
                connection = context.wrap_socket(connection)
            with connection, connection.makefile("rb") as file:
                greeting = file.read(_LENGTH.size)
        except OSError as error:
            raise WorkerLost(f"no Dask scheduler answers at {address}: {error}") from None
    if len(greeting) < _LENGTH.size or _LENGTH.unpack(greeting)[0] > _GREETING_MAX:
        raise WorkerLost(f"no Dask scheduler answers at {address}")


def _silence_dask() -> None:
    """Turn off Dask's log: what it says when a scheduler is lost fits one line."""
    for name in [name for name in logging.root.manager.loggerDict if name.startswith(_LOGS)]:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)


def _check_certificates() -> None:
    from dask import config  # noqa: PLC0415 - an extra

    missing = [
        "DASK_DISTRIBUTED__COMM__TLS__" + name.upper().replace(".", "__").replace("-", "_")
        for name in _CERTIFICATES
        if not config.get(f"distributed.comm.tls.{name}", None)
    ]
    if missing:
        message = "tls needs certificates: set " + ", ".join(missing)
        raise ConfigError(FieldError("scheduler", message))
