"""Serving the application with uvicorn."""

from __future__ import annotations

import contextlib
import ctypes
import errno
import fcntl
import ipaddress
import logging
import os
import re
import resource
import socket
import sys
import threading
from pathlib import Path
from types import FrameType

import uvicorn
from fastapi import FastAPI

from motionlab.config.drive import load_drive
from motionlab.config.shipped import data_root
from motionlab.errors import ConfigError, FieldError
from motionlab.executors.executor import executing
from motionlab.service.app import create_app
from motionlab.service.http.connection_limits import Socket, bounded
from motionlab.service.http.page import page_root
from motionlab.service.memory_budget import recordable
from motionlab.service.settings import LOOPBACK, Settings
from motionlab.store.files import remove_leftovers

_TOKEN_MIN = 16
_LOCK = ".server"  # of the folder of the data, while a server uses it
_VISIBLE = re.compile("[!-~]+")
_HOST_NAME = re.compile(r"[a-z0-9._-]+|\[[0-9a-f:.]+\]")
MESSAGE_MAX = 128 * 1024
"""Largest message of a stream's client, bytes; a subscription to every column has half of that."""

_SEND_BUFFER = 64 * 1024  # bytes: what a slow client can leave unread in the kernel
_FREED_KEPT = 64 * 1024 * 1024  # bytes of freed memory that the process keeps for what comes next
_MMAP_THRESHOLD = 16 * 1024 * 1024  # bytes from which an array is mapped on its own
_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD = -1, -3  # names of both for glibc's mallopt
_KEEP_ALIVE = 75  # s that an idle connection stays open; clients and proxies drop theirs sooner
_BACKLOG = 64  # connections that are accepted at once
_GRACE_SECONDS = 5  # from a signal to end until connections are closed
_CLOSING_SECONDS = 4.0  # from then until the process ends, whatever its threads do
_OTHER_FILES = 224  # files that are open beside the connections: pipes, maps, downloads
_SWITCH_SECONDS = 0.0005  # after which a thread gives way to the event loop, s
_PONG_SECONDS = 60.0  # after which a websocket that answers no ping is closed
_UNREAD_MAX = 60_000  # ms after which a client that reads nothing at all is disconnected


def serve(
    host: str,
    port: int,
    names: frozenset[str],
    scheduler: str | None = None,
    *,
    drive: str | None = None,
) -> None:
    """Serve until interrupted.

    Parameters
    ----------
    host : str
        Address to listen on.
    port : int
        Port; 0 takes a free one.
    names : frozenset of str
        Further host names under which clients may reach the server, beside those of
        MOTIONLAB_HOSTS.
    scheduler : str, optional
        Where jobs are computed; that of MOTIONLAB_SCHEDULER when left out.
    drive : str, optional
        File of a link to drives, or the name of a shipped one; MOTIONLAB_DRIVE when left out.

    Raises
    ------
    ConfigError
        If another address than loopback has no token, the token cannot serve as one, a name is
        none, another server uses the folder of the data, or the server cannot listen at the
        address.
    """
    token = os.environ.get("MOTIONLAB_TOKEN") or None
    if token is None and not _is_loopback(host):
        raise ConfigError(
            FieldError(
                loc="--host",
                message="is not loopback: set MOTIONLAB_TOKEN to what clients must present",
                value=host,
            )
        )
    if token is not None and len(token) < _TOKEN_MIN:
        raise ConfigError(
            FieldError("MOTIONLAB_TOKEN", "is too short", range=f">= {_TOKEN_MIN} characters")
        )
    if token is not None and not _VISIBLE.fullmatch(token):
        raise ConfigError(
            FieldError(
                "MOTIONLAB_TOKEN",
                "has a character that no header can carry",
                range="ASCII without blanks and line ends",
            )
        )
    with executing(scheduler):
        pass  # what is no scheduler is refused now
    drive = drive or os.environ.get("MOTIONLAB_DRIVE") or None
    link = None if drive is None else load_drive(drive)
    names |= _names_in(os.environ.get("MOTIONLAB_HOSTS", ""))
    with _alone(data_root()):
        listener = listen(host, port)
        address, taken = listener.getsockname()[:2]
        own = {f"[{address}]" if ":" in address else address}
        settings = Settings(
            token=token,
            hosts=LOOPBACK | own | {name.lower() for name in names},
            memory_max=recordable(Settings.memory_max),
            scheduler=scheduler,
            drive=link,
        )
        shown = f"[{address}]" if ":" in address else address
        page = "" if page_root() is not None else "docs"  # without the page built there is the API
        print(
            f"Serving http://{shown}:{taken}/{page} (Ctrl-C ends it)", file=sys.stderr, flush=True
        )
        _keep_freed_memory()
        _allow_connections(settings.connections_max)
        sys.setswitchinterval(_SWITCH_SECONDS)
        os.environ.pop("MOTIONLAB_TOKEN", None)  # child processes have no use for it
        remove_leftovers(data_root())
        logging.basicConfig(format="%(asctime)s %(levelname)s %(message)s")
        logging.getLogger("motionlab").setLevel(logging.INFO)
        with contextlib.suppress(KeyboardInterrupt):  # how it is meant to end
            _Server(configuration(create_app(settings))).run(sockets=[listener])


def _alone(root: Path) -> contextlib.AbstractContextManager[object]:
    """Return the lock of a folder of data, which ends with the process, however that ends.

    Raises
    ------
    ConfigError
        If another server holds it.
    """
    try:
        root.mkdir(parents=True, exist_ok=True)
        file = (root / _LOCK).open("wb")
    except OSError:  # a folder that cannot be written needs no lock
        return contextlib.nullcontext()
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.close()
        text = "another server uses this folder: end that one, or name another folder"
        raise ConfigError(FieldError("MOTIONLAB_DATA", text, str(root.absolute()))) from None
    except OSError:  # a file system without locks
        pass
    return file


def configuration(app: FastAPI, log_level: str = "warning") -> uvicorn.Config:
    """Return how uvicorn serves an application."""
    return uvicorn.Config(
        app,
        log_level=log_level,
        http=bounded(app.state.settings),
        ws=Socket,
        ws_ping_timeout=_PONG_SECONDS,
        backlog=_BACKLOG,
        server_header=False,
        ws_per_message_deflate=False,
        ws_max_size=MESSAGE_MAX,
        timeout_keep_alive=_KEEP_ALIVE,
        timeout_graceful_shutdown=_GRACE_SECONDS,
    )


class _Server(uvicorn.Server):
    """A uvicorn server that ends within its grace period despite busy threads and clients."""

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Begin to end; the first signal starts the last deadline too."""
        if not self.should_exit:
            last = threading.Timer(_GRACE_SECONDS + _CLOSING_SECONDS, os._exit, (128 + sig,))
            last.daemon = True
            last.start()
        super().handle_exit(sig, frame)


def _allow_connections(count: int) -> None:
    """Raise the process's limit of open files where connections need it."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = count + _OTHER_FILES
    if soft < wanted:
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (min(wanted, hard), hard))


def _keep_freed_memory() -> None:
    """Have glibc keep the memory of freed arrays instead of returning it to the system.

    A check or a what-if makes arrays of some hundred kB by the dozen; clearing fresh pages for them
    takes as long as filling them.
    """
    with contextlib.suppress(OSError, AttributeError, TypeError):  # another C library
        mallopt = ctypes.CDLL(None).mallopt
        mallopt(_M_MMAP_THRESHOLD, _MMAP_THRESHOLD)
        mallopt(_M_TRIM_THRESHOLD, _FREED_KEPT)


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _names_in(text: str) -> frozenset[str]:
    """Return the host names of a list with commas, as browsers write them."""
    found = frozenset(name for part in text.split(",") if (name := part.strip().lower()))
    wrong = [name for name in sorted(found) if not _HOST_NAME.fullmatch(name)]
    if wrong:
        rule = "names without scheme, port or path, comma between them"
        raise ConfigError(
            *(FieldError("MOTIONLAB_HOSTS", "is no host name", name, rule) for name in wrong)
        )
    return found


def listen(host: str, port: int) -> socket.socket:
    """Return a socket listening at an address; accepted sockets inherit its options.

    Raises
    ------
    ConfigError
        If the server cannot listen at the address.
    """
    with contextlib.ExitStack() as opened:
        try:
            family, kind, protocol, _, address = socket.getaddrinfo(
                host, port, type=socket.SOCK_STREAM
            )[0]
            listener = opened.enter_context(socket.socket(family, kind, protocol))
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
            if sys.platform == "linux":
                listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _UNREAD_MAX)
            listener.bind(address)
            listener.listen(socket.SOMAXCONN)
        except (OSError, UnicodeError) as error:  # also a name that no resolver takes
            reason = getattr(error, "strerror", None) or str(error)
            if getattr(error, "errno", None) == errno.EADDRINUSE:
                reason += " (--port 0 or make run PORT=0 takes a free port)"
            raise ConfigError(
                FieldError("--host, --port", f"cannot listen: {reason}", f"{host}:{port}")
            ) from None
        opened.pop_all()
    return listener
