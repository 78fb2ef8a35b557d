"""Calls of a running server, for scripts and for commands that work on one."""

from __future__ import annotations

import http.client
import json
import os
import re
import threading
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Mapping, Sequence
from http import HTTPStatus
from pathlib import Path
from types import TracebackType
from typing import Any

from motionlab.errors import ConfigError, FieldError, MotionLabError

ADDRESS = "http://127.0.0.1:8000"
_TIMEOUT = 30.0  # s
_VISIBLE = re.compile("[!-~]+")
_BEATS = 4  # of a heartbeat, in the time after which a lease ends


class ServerRefused(MotionLabError):
    """A server does not answer, or refuses a call; the message says why.

    Parameters
    ----------
    message : str
        Why.
    kind : str
        Type of its problem document.
    """

    def __init__(self, message: str, kind: str = "unavailable") -> None:
        super().__init__(message)
        self.kind = kind


class LabServer:
    """A running server.

    Parameters
    ----------
    address : str
        Such as ``http://127.0.0.1:8000``.
    token : str, optional
        Its token; that of MOTIONLAB_TOKEN or MOTIONLAB_TOKEN_FILE when left out.
    loc : str
        Name of the address in errors.
    timeout : float
        Seconds to wait for an answer.

    Attributes
    ----------
    address : str
        Without a slash at its end.
    headers : dict of str to str
        Of every call: the token.
    """

    def __init__(
        self,
        address: str,
        token: str | None = None,
        *,
        loc: str = "--server",
        timeout: float = _TIMEOUT,
    ) -> None:
        if not _is_address(address):
            raise ConfigError(FieldError(loc, "is no address", address, f"as {ADDRESS}"))
        self.address = address.rstrip("/")
        self._timeout = timeout
        token = token or _token()
        if token is not None and not isinstance(token, str):
            raise ConfigError(FieldError("token", "must be text"))  # its value is not told
        if token is not None and not _VISIBLE.fullmatch(token):
            allowed = "ASCII without blanks and line ends"
            raise ConfigError(
                FieldError("token", "has a character that no header can carry", range=allowed)
            )
        self.headers = {"Authorization": f"Bearer {token}"} if token else {}

    def call(
        self,
        method: str,
        path: str,
        body: Mapping[str, Any] | Sequence[Any] | None = None,
        headers: Mapping[str, str] | None = None,
    ) -> Any:
        """Return the answer to a call below ``/api/v1``; None where it has no content.

        Raises
        ------
        ServerRefused
            If there is no answer, or the server refuses.
        ConfigError
            If it refuses a field.
        """
        text = self.fetch(method, path, body, headers)
        try:
            return json.loads(text or "null")
        except ValueError:
            raise ServerRefused(f"{self.address} does not answer as a lab does") from None

    def fetch(
        self,
        method: str,
        path: str,
        body: Mapping[str, Any] | Sequence[Any] | None = None,
        headers: Mapping[str, str] | None = None,
    ) -> bytes:
        """Return the bytes of the answer to a call below ``/api/v1``.

        Raises
        ------
        ServerRefused
            If there is no answer, or the server refuses.
        ConfigError
            If it refuses a field.
        """
        try:
            data = None if body is None else json.dumps(body).encode()
        except (TypeError, ValueError, RecursionError) as error:
            raise ConfigError(FieldError("body", f"cannot be sent as JSON: {error}")) from None
        kind = {} if data is None else {"Content-Type": "application/json"}
        request = urllib.request.Request(
            f"{self.address}/api/v1{path}",
            data,
            {**self.headers, **kind, **(headers or {})},
            method=method,
        )
        try:
            with urllib.request.urlopen(request, timeout=self._timeout) as answer:
                return answer.read()
        except urllib.error.HTTPError as error:
            raise _refusal(error) from None
        except (OSError, http.client.HTTPException) as error:
            reason = getattr(error, "reason", None) or error
            raise ServerRefused(f"{self.address} does not answer: {reason}") from None


def _is_address(text: object) -> bool:
    try:
        address = urllib.parse.urlsplit(text) if isinstance(text, str) else None
    except ValueError:
        return False
    return address is not None and address.scheme in ("http", "https") and bool(address.netloc)


class HeldLease:
    """The lease of a server's drives, kept by a heartbeat while a block lasts.

    Parameters
    ----------
    server : LabServer
        Which server.
    holder : str
        Name that others see.

    Attributes
    ----------
    headers : dict of str to str
        What commands need.
    """

    def __init__(self, server: LabServer, holder: str) -> None:
        self._server = server
        self._holder = holder
        self._over = threading.Event()
        self.headers: dict[str, str] = {}

    def __enter__(self) -> HeldLease:
        """Take it.

        Raises
        ------
        ServerRefused
            If somebody else holds it.
        """
        answer = self._server.call("POST", "/drive/lease", {"holder": self._holder})
        self.headers = {"Lease": answer["lease"]}
        self._beating = threading.Thread(target=self._beat, args=(answer["seconds"] / _BEATS,))
        self._beating.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Give it up: armed drives stop."""
        self._over.set()
        self._beating.join()
        try:
            self._server.call("DELETE", "/drive/lease", headers=self.headers)
        except ServerRefused:
            if error is None:
                raise

    def _beat(self, seconds: float) -> None:
        while not self._over.wait(seconds):
            try:
                self._server.call("PUT", "/drive/lease", headers=self.headers)
            except ServerRefused:  # the next command says so
                return


def _token() -> str | None:
    """Return what the server asks for: MOTIONLAB_TOKEN, or the content of MOTIONLAB_TOKEN_FILE.

    Raises
    ------
    ConfigError
        If that file cannot be read.
    """
    file = os.environ.get("MOTIONLAB_TOKEN_FILE")
    if not file or os.environ.get("MOTIONLAB_TOKEN"):
        return os.environ.get("MOTIONLAB_TOKEN")
    try:
        return Path(file).read_text(encoding="utf-8").strip("\r\n")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "is not UTF-8 text"
        raise ConfigError(
            FieldError("MOTIONLAB_TOKEN_FILE", f"cannot be read: {reason}", file)
        ) from None


def _refusal(error: urllib.error.HTTPError) -> MotionLabError:
    """Return what a problem document says."""
    try:
        problem = json.loads(error.read())
        detail, fields = str(problem["detail"]), problem["errors"]
        kind = str(problem["type"]).rpartition(":")[2]
    except (ValueError, KeyError, TypeError, OSError):
        return ServerRefused(f"{error.url}: {error.code} {error.reason}")
    if error.code == HTTPStatus.UNAUTHORIZED:
        return ServerRefused(f"{detail}: set MOTIONLAB_TOKEN or MOTIONLAB_TOKEN_FILE", kind)
    if error.code == HTTPStatus.UNPROCESSABLE_ENTITY and fields:
        known = ("loc", "message", "value", "range", "unit")
        return ConfigError(*(FieldError(**{name: each[name] for name in known}) for each in fields))
    return ServerRefused(detail, kind)
