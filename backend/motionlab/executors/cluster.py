"""Tasks on a Dask cluster.

A task's key is a hash of its content, so no result counts twice; what a lost worker held is
computed again. Access to a scheduler's port allows running code on all its workers, since Dask
unpickles what it receives: other machines are reached only through TLS with certificates of both
sides.
"""

from __future__ import annotations

import functools
import hashlib
import ipaddress
import pickle
from collections.abc import Callable, Sequence
from typing import Any
from urllib.parse import urlsplit

from motionlab.errors import ConfigError, FieldError
from motionlab.executors.code import Code, processor
from motionlab.executors.executor import Pool, WorkerLost

_SECONDS = 10.0  # until scheduler and a worker must have answered
_RESULT_SECONDS = 0.5  # for which a result is waited for between looks at cancellation
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
            message = "needs Dask: pip install 'motionlab[cluster]'"
            raise ConfigError(FieldError("scheduler", message, address)) from None
        if address.startswith("tls:"):
            _check_certificates()

    @functools.cached_property
    def _client(self) -> Any:
        """The connection; waits for the scheduler and one worker."""
        from distributed import Client, Security  # noqa: PLC0415 - an extra

        security = Security(require_encryption=True) if self._address.startswith("tls:") else None
        try:
            client = Client(
                self._address, security=security, timeout=_SECONDS, set_as_default=False
            )
        except (OSError, TimeoutError) as error:
            message = f"no scheduler answers at {self._address}: {error}"
            raise WorkerLost(message) from None
        try:
            client.wait_for_workers(1, timeout=_SECONDS)
        except TimeoutError:
            client.close()
            raise WorkerLost(f"the scheduler {self._address} has no workers") from None
        return client

    @functools.cached_property
    def _code(self) -> Code:
        """What every worker must run: our sources, on a processor like the first worker's."""
        expected = Code.here()
        future = self._client.submit(processor, pure=False)
        return expected._replace(processor=future.result())

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

        try:
            found = future.result(timeout=_RESULT_SECONDS)
        except KilledWorker as error:
            raise WorkerLost(
                f"a task was held by {error.allowed_failures + 1} workers that were lost; is there "
                "enough memory? (distributed.scheduler.allowed-failures of the scheduler)"
            ) from None
        except FutureCancelledError:
            raise WorkerLost(f"the scheduler {self._address} was lost") from None
        future.release()
        return found

    def abandon(self, futures: Sequence[Any]) -> None:
        """Release every future: the scheduler cancels tasks without another client."""
        for future in futures:
            future.release()

    def close(self) -> None:
        """Close the connection, if any; the scheduler drops its tasks."""
        client = vars(self).get("_client")
        if client is not None:
            client.close()


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
