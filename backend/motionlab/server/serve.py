"""Serving the application with uvicorn."""

from __future__ import annotations

import contextlib
import ctypes
import errno
import fcntl
import ipaddress
import logging
import os
import resource
import socket
import sys
import threading
import webbrowser
from pathlib import Path
from types import FrameType
from typing import Any

import uvicorn
from fastapi import FastAPI

from motionlab.config.drive import load_drive
from motionlab.config.named_configs import SERVER_LOCK, config_root, data_root
from motionlab.errors import ConfigError, FieldError
from motionlab.executors.executor import executing
from motionlab.files import (
    make_private,
    page_root,
    private_file,
    private_folder,
    remove_leftovers,
)
from motionlab.library.library import check_places
from motionlab.reports.plain_text import without_controls
from motionlab.server.app import create_app
from motionlab.server.http import access_log, download
from motionlab.server.http.connection_limits import protocols
from motionlab.server.settings import LOOPBACK, Bounds, Settings
from motionlab.server.settings_sources import Loaded

_DATA = (
    SERVER_LOCK,
    "runs",
    "runs.sqlite*",
    "recording",
    "trajectories",
    "motors",
    "maps",
    "jobs",
    "commissioning*",
)
"""What a folder of data holds."""

_EVERY_ADDRESS = {"0.0.0.0", "::", "[::]"}
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


def serve(loaded: Loaded, *, opens: bool = False) -> None:
    """Serve until interrupted.

    Raises
    ------
    ConfigError
        If another address than loopback has no token, another server uses the folder of the data,
        or the server cannot listen at the address.
    """
    configured = loaded.settings
    if configured.token is None and not _is_loopback(configured.host):
        raise ConfigError(
            FieldError(
                loc=loaded.origins.get("host", "--host"),
                message="is not loopback: set MOTIONLAB_TOKEN, or name a file by --token-file, to "
                "what clients must present",
                value=configured.host,
            )
        )
    if configured.edit_laws:
        _check_editing(loaded)
    loaded.export()
    with executing(configured.scheduler):
        pass  # what is no scheduler is refused now
    link = None if configured.drive is None else load_drive(configured.drive)
    config_root()  # or it is refused
    check_places(data_root())
    with _alone(data_root()), listen(configured.host, configured.port) as listener:
        address, taken = listener.getsockname()[:2]
        shown = f"[{address}]" if ":" in address else address
        settings = Settings(
            **configured.model_dump(include=set(Bounds.model_fields)),
            token=configured.token,
            hosts=LOOPBACK | {shown} | set(configured.hosts),
            proxies=frozenset(configured.proxies),
            scheduler=configured.scheduler,
            drive=link,
            edit_laws=configured.edit_laws,
        )
        served = f"http://{shown}:{taken}/"
        if page_root() is None:
            served += "openapi.json without the page, which is not in this installation"
        _say(f"Serving {served} (Ctrl-C ends it)")
        for warning in loaded.warnings:
            _say(f"motionlab: {warning}")
        _keep_freed_memory()
        settings = _within_open_files(settings)
        sys.setswitchinterval(_SWITCH_SECONDS)
        remove_leftovers(data_root())
        download.remove_leftovers(data_root())
        make_private(_ours(data_root()))
        _log_from(configured.log_level)
        app = create_app(settings)
        app.state.owns_process = True
        config = configuration(app, configured.log_level)
        local = "127.0.0.1" if configured.host in _EVERY_ADDRESS else shown
        with contextlib.suppress(KeyboardInterrupt):  # how it is meant to end
            _Server(config, f"http://{local}:{taken}/" if opens else None).run(sockets=[listener])


def _check_editing(loaded: Loaded) -> None:
    """Refuse to have laws edited where others than the owner of this machine's account might.

    What is saved runs as code of this process.

    Raises
    ------
    ConfigError
        Without a token, on another address than loopback, or under further names.
    """
    configured, origins = loaded.settings, loaded.origins
    message = ""
    if configured.token is None:
        message = "needs a token on loopback, too: set MOTIONLAB_TOKEN, or --token-file"
    elif not _is_loopback(configured.host):
        message = f"is possible on loopback only, not on {configured.host}"
    elif configured.hosts or configured.proxies:
        message = "is not possible where the server has further names or proxies"
    if message:
        raise ConfigError(FieldError(origins.get("edit_laws", "--edit-laws"), message))


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


class _PlainLines(logging.Formatter):
    """Log lines in which a text from outside begins no line of its own."""

    def formatMessage(self, record: logging.LogRecord) -> str:
        """Return one line."""
        record.message = record.message.replace("\r", "\\r").replace("\n", "\\n")
        return without_controls(super().formatMessage(record))

    def formatException(self, ei: Any) -> str:
        """Return a traceback, whose last lines may hold such a text."""
        return without_controls(super().formatException(ei))


def _log_from(level: str) -> None:
    """Log from a level on: text on stderr, and one JSON object a request on stdout."""
    handler = logging.StreamHandler()
    handler.setFormatter(_PlainLines("%(asctime)s %(levelname)s %(message)s"))
    logging.basicConfig(handlers=[handler])
    logging.getLogger("motionlab").setLevel(level.upper())
    access_log.install()


def _alone(root: Path) -> contextlib.AbstractContextManager[object]:
    """Return the lock of a folder of data, which ends with the process, however that ends.

    Raises
    ------
    ConfigError
        If another server holds it, or it is no folder and cannot be made.
    """
    try:
        private_folder(root)
    except OSError as error:
        text = f"cannot be made: {error.strerror}"
        raise ConfigError(FieldError("MOTIONLAB_DATA", text, str(root.absolute()))) from None
    try:
        private_file(root / SERVER_LOCK)
        file = (root / SERVER_LOCK).open("wb")
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


def _ours(root: Path) -> list[Path]:
    """Return what lies in a folder of data and is the lab's; the folder too if all of it is."""
    ours = [path for name in _DATA for path in root.glob(name)]
    return [root] if len(ours) == sum(1 for _ in root.iterdir()) else ours


def configuration(app: FastAPI, log_level: str = "warning") -> uvicorn.Config:
    """Return how uvicorn serves an application."""
    proxies = sorted(app.state.settings.proxies)
    http, ws = protocols(app.state.settings)
    return uvicorn.Config(
        app,
        proxy_headers=bool(proxies),
        forwarded_allow_ips=proxies,
        log_level=log_level,
        access_log=False,  # `access_log` has more to say
        http=http,
        ws=ws,
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

    def __init__(self, config: uvicorn.Config, page: str | None = None) -> None:
        super().__init__(config)
        self._page = page

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Begin to answer, and open the page."""
        await super().startup(sockets)
        if self._page is not None and self.started:
            threading.Thread(target=_open, args=(self._page,), daemon=True).start()

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Begin to end; the first signal starts the last deadline too."""
        if not self.should_exit:
            last = threading.Timer(_GRACE_SECONDS + _CLOSING_SECONDS, os._exit, (128 + sig,))
            last.daemon = True
            last.start()
        super().handle_exit(sig, frame)


def _open(page: str) -> None:
    """Open a page in the user's browser; say so where there is none."""
    try:
        opened = webbrowser.open(page)
    except (webbrowser.Error, OSError):
        opened = False
    if not opened:
        _say(f"There is no browser here: open {page} in one")


def _within_open_files(settings: Settings) -> Settings:
    """Raise the process's limit of open files for its connections, or lower their number to it.

    A connection beyond the limit could not be accepted: none would make place for it.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    needed = settings.connections_max + _OTHER_FILES
    limit = needed if hard == resource.RLIM_INFINITY else min(needed, hard)
    if soft < limit:
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (limit, hard))
            soft = limit
    if soft >= needed:
        return settings
    most = soft - min(_OTHER_FILES, soft // 2)
    _say(
        f"motionlab: {most} connections instead of {settings.connections_max} (connections_max): "
        f"the process may open {soft} files (ulimit -Hn), and {needed} are needed"
    )
    sockets = min(settings.websockets_max, most // 2)
    return settings.model_copy(update={"connections_max": most, "websockets_max": sockets})


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
